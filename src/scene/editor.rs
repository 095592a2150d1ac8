//! A scene that is edited: every edit can be undone, and saved with comments and layout as they were.
//!
//! *Practice.* An edit is a function from text to text. What was before it is kept as text, so undoing restores it to the byte,
//! whatever the edit did; and an edit that leaves no valid scene is refused before anything has changed.

use std::io::Write;
use std::path::Path;

use super::loader::{Remembered, VolumeLoader};
use super::{Scene, SceneError, Source};
use crate::output::{OutputError, write_whole};

/// A scene with its history.
///
/// ```
/// use vcsg::scene::{Editor, NoVolumes, Scene, with_property};
///
/// let text = "scene { sphere radius=20 } // a ball\n";
/// let scene = Scene::parse("ball.kdl", text, ".".as_ref(), &mut NoVolumes)?;
/// let mut editor = Editor::new(&scene, NoVolumes)?;
/// editor.edit(|source| with_property(source, &[0, 0], "radius", Some(12.into())))?;
/// assert_eq!(editor.scene().to_text(), "scene { sphere radius=12 } // a ball\n");
/// editor.undo()?;
/// assert_eq!(editor.scene().to_text(), text);
/// # Ok::<(), vcsg::scene::SceneError>(())
/// ```
pub struct Editor<L> {
    scene: Scene,
    loader: Remembered<L>,
    undone: Vec<Source>,
    done: Vec<Source>,
}

impl<L: VolumeLoader> Editor<L> {
    /// Begins to edit `scene`; what edits need of volumes and meshes comes from `loader`, once each.
    ///
    /// # Errors
    /// If a volume cannot be loaded.
    pub fn new(scene: &Scene, loader: L) -> Result<Self, SceneError> {
        let mut loader = Remembered::new(loader);
        Ok(Self {
            scene: scene.reread(scene.source().clone(), &mut loader)?,
            loader,
            undone: Vec::new(),
            done: Vec::new(),
        })
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Makes of the scene what `change` makes of its text, and forgets what had been undone.
    ///
    /// # Errors
    /// If `change` fails, or what it makes is not a scene; nothing has changed then.
    pub fn edit(&mut self, change: impl FnOnce(&Source) -> Result<Source, SceneError>) -> Result<(), SceneError> {
        let before = self.scene.source().clone();
        self.show(change(&before)?)?;
        self.done.push(before);
        self.undone.clear();
        Ok(())
    }

    /// Takes the last edit back; `false` if there is none.
    ///
    /// # Errors
    /// If a file that the scene includes is no longer what it was.
    pub fn undo(&mut self) -> Result<bool, SceneError> {
        let Some(before) = self.done.last().cloned() else {
            return Ok(false);
        };
        let now = self.scene.source().clone();
        self.show(before)?;
        self.done.pop();
        self.undone.push(now);
        Ok(true)
    }

    /// Does the edit that was undone last once more; `false` if there is none.
    ///
    /// # Errors
    /// As [`Self::undo`].
    pub fn redo(&mut self) -> Result<bool, SceneError> {
        let Some(after) = self.undone.last().cloned() else {
            return Ok(false);
        };
        let now = self.scene.source().clone();
        self.show(after)?;
        self.undone.pop();
        self.done.push(now);
        Ok(true)
    }

    /// Writes the scene's text to `path`, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        write_whole(path, |out| out.write_all(self.scene.to_text().as_bytes()))
    }

    fn show(&mut self, source: Source) -> Result<(), SceneError> {
        self.scene = self.scene.reread(source, &mut self.loader)?;
        Ok(())
    }
}
