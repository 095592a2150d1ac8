//! Key frames: values of a scene that change with time.
//!
//! *Practice.* A frame of an animation is the scene's text with some values replaced, and so a scene like any other: whatever can
//! be written can be animated, every check holds for every frame, and a frame is the same whichever frames were drawn before.

use kdl::{KdlDocument, KdlValue};

use super::edit::{with_argument, with_property};
use super::element::Element;
use super::error::{Problem, SceneError};
use super::source::Source;
use super::track::Track;

type Result<T> = std::result::Result<T, SceneError>;

/// A scene's `animation` node.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// How many frames there are; they count from 0.
    pub frames: u32,
    /// Frames a second of its video.
    pub fps: f64,
    tracks: Vec<Placed>,
}

/// A track and the value that it moves.
#[derive(Clone, Debug, PartialEq)]
struct Placed {
    path: Vec<usize>,
    /// A property, or the node's first argument.
    property: Option<String>,
    track: Track,
    moves_model: bool,
}

impl Animation {
    /// The most frames.
    pub const MAX_FRAMES: u32 = 1_000_000;

    /// Reads the node `animation` of a document.
    pub(super) fn read(element: &Element, document: &KdlDocument) -> Result<Self> {
        let placed = |track: Result<Element>| Placed::read(&track?, document);
        Ok(Self {
            frames: element.require("frames")?.whole(1, Self::MAX_FRAMES)?,
            fps: element.get("fps").map_or(Ok(25.0), |v| v.within(0.01, 1000.0))?,
            tracks: element.children().map(placed).collect::<Result<_>>()?,
        })
    }

    /// Whether frames differ in more than in how the scene is seen.
    pub fn moves_model(&self) -> bool {
        self.tracks.iter().any(|placed| placed.moves_model)
    }

    /// The text of frame `frame` of the scene that has this animation.
    ///
    /// # Errors
    /// If the text is not that scene's.
    pub(super) fn source_at(&self, source: &Source, frame: u32) -> Result<Source> {
        let mut edited = Source::new(format!("{} at frame {frame}", source.name()), source.text());
        for placed in &self.tracks {
            let value = placed.track.at(f64::from(frame));
            edited = placed.set(&edited, value)?;
        }
        Ok(edited)
    }
}

impl Placed {
    fn read(element: &Element, document: &KdlDocument) -> Result<Self> {
        let path = find(element, document)?;
        let top = document.nodes()[path[0]].name().value();
        if top == "animation" || (top == "scene" && path.len() == 1) {
            let why = "how the target is built, and the animation itself, are the same in all frames";
            return Err(element.error_of_argument(0, Problem::Conflict(why)));
        }
        let property = element.get("property").map(|v| v.string()).transpose()?;
        Ok(Self {
            moves_model: top == "scene",
            path,
            property: property.map(str::to_owned),
            track: Track::read(element)?,
        })
    }

    fn set(&self, source: &Source, value: KdlValue) -> Result<Source> {
        match &self.property {
            Some(key) => with_property(source, &self.path, key, Some(value)),
            None => with_argument(source, &self.path, 0, value),
        }
    }
}

/// The node that a track's argument names, like `scene/subtract/cylinder[2]`: names from the top down, and which of several, from 1.
fn find(track: &Element, document: &KdlDocument) -> Result<Vec<usize>> {
    let mut path = Vec::new();
    let mut nodes = document.nodes();
    for step in track.argument(0).string()?.split('/') {
        let (name, which) = named(step);
        let of_name = nodes.iter().enumerate().filter(|(_, node)| node.name().value() == name);
        let Some((place, node)) = which.and_then(|which| of_name.into_iter().nth(which)) else {
            let there = nodes.iter().map(|node| node.name().value().to_owned()).collect();
            let wanted = step.to_owned();
            return Err(track.error_of_argument(0, Problem::NotThere { wanted, there }));
        };
        path.push(place);
        nodes = node.children().map_or(&[], KdlDocument::nodes);
    }
    Ok(path)
}

/// A name and which of the nodes with it is meant, from 0.
fn named(step: &str) -> (&str, Option<usize>) {
    match step.strip_suffix(']').and_then(|step| step.split_once('[')) {
        Some((name, which)) => (name, which.parse::<usize>().ok().and_then(|n| n.checked_sub(1))),
        None => (step, Some(0)),
    }
}
