//! Scene files: KDL text to a model and how it wants to be seen, and back (docs/SCENE.md is the language).
//!
//! ```
//! use vcsg::scene::{Scene, NoVolumes};
//!
//! let text = r#"
//! scene {
//!     subtract {
//!         sphere radius=20 value=100
//!         cut normal="0 1 0" { box min="-5 -5 -5" max="5 5 5" }
//!     }
//! }
//! view azimuth=30
//! "#;
//! let scene = Scene::parse("ball.kdl", text, ".".as_ref(), &mut NoVolumes)?;
//! assert_eq!(scene.model.nodes().len(), 4);
//! assert_eq!(scene.view.azimuth_deg, 30.0);
//! # Ok::<(), vcsg::scene::SceneError>(())
//! ```

mod animation;
mod appearance;
mod deform;
mod edit;
mod editor;
mod element;
mod error;
mod file;
mod grammar;
mod guard;
mod kinds;
mod leaves;
mod loader;
mod maps;
mod options;
mod primitives;
mod rearrange;
mod rules;
mod source;
mod suggest;
mod surface;
mod trace;
mod track;
mod transfer;
mod transforms;
mod tree;

use std::path::{Path, PathBuf};

pub use animation::Animation;
pub use appearance::parse_size;
pub use edit::{with_argument, with_property};
pub use editor::Editor;
pub use error::{Problem, SceneError};
pub use guard::{MAX_BYTES, MAX_DEPTH};
pub use loader::{MeshRequest, NoVolumes, Remembered, VolumeFiles, VolumeLoader, VolumeRequest};
pub use options::TargetOptions;
pub use rearrange::{with_node, with_node_moved, without_node};
pub use source::Source;
pub use surface::SurfaceSpec;
pub use trace::{ObjectSpec, TraceSpec};
pub use transfer::{TransferChoice, TransferSpec};

use crate::math::Interval;
use crate::model::{Kind, Model, Node, VolumeLeaf};
use crate::projection::{Mode, Projection, Settings, View};
use crate::volume::io::ReadOptions;
use appearance::Appearance;
use tree::{TreeBuilder, scene_element};

/// A model, and how it wants to be built and seen.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The VCSG tree, in world millimetres (LPS).
    pub model: Model,
    /// How its target is built.
    pub target: TargetOptions,
    /// The transfer function; one that suits the data when `None`.
    pub transfer: Option<TransferSpec>,
    /// The surfaces in its picture.
    pub surfaces: Vec<SurfaceSpec>,
    /// Where it is seen from.
    pub view: View,
    /// How it is drawn.
    pub settings: Settings,
    /// Width and height of the frame in pixels, if the scene says.
    pub frame_size: Option<[u32; 2]>,
    /// How it is traced.
    pub trace: TraceSpec,
    /// How it changes with time.
    pub animation: Option<Animation>,
    source: Source,
    origin: Origin,
}

/// Where a scene's text comes from.
#[derive(Clone, Debug, Default)]
struct Origin {
    /// Where its paths start.
    base_dir: PathBuf,
    /// Its file, if it has one.
    path: Option<PathBuf>,
}

impl Scene {
    /// The scene that `text` describes. Its paths are relative to `base_dir`; `name` stands for the file in messages.
    ///
    /// # Errors
    /// The first problem, with its place.
    pub fn parse(name: &str, text: &str, base_dir: &Path, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        let origin = Origin {
            base_dir: base_dir.to_owned(),
            path: None,
        };
        Self::build(Source::new(name, text), origin, loader)
    }

    /// The scene in the file at `path`.
    ///
    /// # Errors
    /// If the file cannot be read, or the first problem in it, with its place.
    pub fn load(path: &Path, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        let name = path.to_string_lossy();
        let text = file::read(path).map_err(|problem| SceneError::of_file(&name, problem))?;
        let origin = Origin {
            base_dir: path.parent().unwrap_or(Path::new("")).to_owned(),
            path: Some(path.to_owned()),
        };
        Self::build(Source::new(name, text), origin, loader)
    }

    /// The scene that `source` describes, in the place of this one's text.
    ///
    /// # Errors
    /// The first problem, with its place.
    pub fn reread(&self, source: Source, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        Self::build(source, self.origin.clone(), loader)
    }

    /// Frame `frame` of the scene's animation, or the scene itself if it has none.
    ///
    /// # Errors
    /// If a track makes something of a value that it cannot be.
    pub fn at_frame(&self, frame: u32, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        match &self.animation {
            Some(animation) => self.reread(animation.source_at(&self.source, frame)?, loader),
            None => Ok(self.clone()),
        }
    }

    /// The scene of the volume that `options` name in the file at `path`, and nothing else.
    ///
    /// # Errors
    /// If the volume cannot be loaded.
    pub fn of_volume(path: &Path, options: &ReadOptions, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        let request = VolumeRequest {
            path: path.to_owned(),
            options: options.clone(),
        };
        let fails = |reason| SceneError::of_file(&path.to_string_lossy(), Problem::Volume(reason));
        let bricks = loader.load(&request).map_err(fails)?;
        let mut model = Model::default();
        model.push(Node::Volume(VolumeLeaf {
            bricks,
            window: Interval::ALL,
        }));
        let source = Source::new("scene.kdl", leaves::volume_text(&request));
        let mut scene = Self::assembled(model, Appearance::default(), source, Origin::default());
        scene.set_view(Self::BARE_VIEW)?;
        Ok(scene)
    }

    /// How a bare volume is seen: from the front, a little from the left and above.
    const BARE_VIEW: View = View {
        azimuth_deg: 30.0,
        elevation_deg: 15.0,
        roll_deg: 0.0,
        zoom: 1.2,
        focus: None,
        projection: Projection::Orthographic,
    };

    /// The scene at `path`: a scene file if it ends in `.kdl`, else a bare volume, the one that `options` name.
    ///
    /// # Errors
    /// Those of [`Scene::load`] and [`Scene::of_volume`].
    pub fn open(path: &Path, options: &ReadOptions, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        if is_scene_file(path) {
            Self::load(path, loader)
        } else {
            Self::of_volume(path, options, loader)
        }
    }

    fn build(source: Source, origin: Origin, loader: &mut dyn VolumeLoader) -> Result<Self, SceneError> {
        let document = file::parse(&source)?;
        let mut appearance = Appearance::read(&document, &source, &origin.base_dir)?;
        // Volumes that objects share are loaded once.
        let loader: &mut dyn VolumeLoader = &mut Remembered::new(loader);
        let root = origin.path.as_deref();
        let tree = TreeBuilder::new(&mut *loader, root);
        let model = tree.build(scene_element(&document, &source)?, &origin.base_dir)?;
        appearance.trace.objects = trace::objects(&document, &source, &origin.base_dir, root, loader)?;
        if model.kind_of_root() == Some(Kind::Color) {
            Appearance::check_colors(&document, &source)?;
        }
        Ok(Self::assembled(model, appearance, source, origin))
    }

    fn assembled(model: Model, appearance: Appearance, source: Source, origin: Origin) -> Self {
        Self {
            model,
            target: appearance.target,
            transfer: appearance.transfer,
            surfaces: appearance.surfaces,
            view: appearance.view,
            settings: appearance.settings,
            frame_size: appearance.frame_size,
            trace: appearance.trace,
            animation: appearance.animation,
            source,
            origin,
        }
    }

    /// Whether samples are colours, by classifying nodes, and need no transfer function.
    pub fn has_colors(&self) -> bool {
        self.model.kind_of_root() == Some(Kind::Color)
    }

    /// Whether samples of the volume are in the picture: always but where it has surfaces, and neither colours, nor a transfer
    /// function, nor a mode that says how samples are seen.
    pub fn shows_samples(&self) -> bool {
        self.surfaces.is_empty()
            || self.has_colors()
            || self.transfer.is_some()
            || self.settings.mode != Mode::Composite
    }

    /// The scene's text, comments and layout as they were.
    pub fn to_text(&self) -> &str {
        self.source.text()
    }

    /// Sets the view, in the scene and in its text.
    ///
    /// # Errors
    /// If the edited text would be too long.
    pub fn set_view(&mut self, view: View) -> Result<(), SceneError> {
        self.source = edit::with_view(&self.source, &view)?;
        self.view = view;
        Ok(())
    }

    /// The scene's text and name.
    pub fn source(&self) -> &Source {
        &self.source
    }
}

/// Whether `path` is named like a scene file: it ends in `.kdl`.
pub fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("kdl"))
}
