//! Which of a NRRD array's axes lie in space, count components, or count volumes.

use std::path::Path;

use super::components::{Components, Rule};
use super::error::ReadError;
use super::nrrd_header::Header;
use super::open::ReadOptions;

/// Kinds of axes along which voxels follow each other in space.
const SPATIAL_KINDS: [&str; 4] = ["domain", "space", "???", "none"];

/// What the axes of an array are.
pub(super) struct Axes {
    /// Voxels along the volume's axes; 1 for missing ones.
    pub dims: [usize; 3],
    /// The volume's axes among the array's.
    pub spatial: Vec<usize>,
    /// How many axes the array has.
    pub count: usize,
    /// Volumes along the axes of time, and along axes beyond the third of no kind.
    pub frames: usize,
    /// Voxels before the axis of components, or of frames where that is not the slowest: how long runs are.
    run: usize,
    /// The axis that counts components.
    components: Option<Counted>,
    /// Whether a faster axis than the slowest counts frames.
    frames_in_runs: bool,
}

/// An axis that counts something.
struct Counted {
    size: usize,
    kind: String,
}

impl Axes {
    pub(super) fn new(path: &Path, header: &Header) -> Result<Self, ReadError> {
        let field = header.need("sizes")?;
        let sizes: Vec<usize> = header.numbers("sizes")?.unwrap_or_default();
        if sizes.len() != header.number("dimension", sizes.len())? || sizes.is_empty() {
            let what = format!("`sizes` has {} numbers, `dimension` says another", sizes.len());
            return Err(ReadError::header(path, what).line(field.line));
        }
        if sizes.contains(&0) {
            return Err(ReadError::header(path, "an axis cannot have no samples").line(field.line));
        }
        let spatial = spatial_axes(header, sizes.len())?;
        let mut axes = Self {
            dims: [1; 3],
            count: sizes.len(),
            frames: 1,
            run: 1,
            components: None,
            frames_in_runs: false,
            spatial,
        };
        for (dim, &axis) in axes.dims.iter_mut().zip(&axes.spatial) {
            *dim = sizes[axis];
        }
        axes.count_others(path, header, &sizes)?;
        Ok(axes)
    }

    /// Finds what the axes out of space count.
    fn count_others(&mut self, path: &Path, header: &Header, sizes: &[usize]) -> Result<(), ReadError> {
        let kinds = header.words("kinds");
        let others = (0..sizes.len()).filter(|axis| !self.spatial.contains(axis) && sizes[*axis] != 1);
        for axis in others.collect::<Vec<_>>() {
            let (size, kind) = (sizes[axis], kinds.get(axis).map_or("none", String::as_str));
            let is_behind_all = self.spatial.iter().all(|&spatial| spatial < axis);
            let counts_frames = kind == "time" || is_behind_all && SPATIAL_KINDS.contains(&kind);
            match (counts_frames, is_behind_all) {
                (true, true) if !self.frames_in_runs => self.frames = self.frames.saturating_mul(size),
                (counts_frames, _) if !self.frames_in_runs && self.components.is_none() && self.frames == 1 => {
                    let before = self.spatial.iter().filter(|&&spatial| spatial < axis);
                    self.run = before.fold(1, |n: usize, &spatial| n.saturating_mul(sizes[spatial]));
                    self.frames_in_runs = counts_frames;
                    match counts_frames {
                        true => self.frames = size,
                        false => {
                            let kind = kind.to_owned();
                            self.components = Some(Counted { size, kind });
                        }
                    }
                }
                _ => {
                    let what = "it has several axes of components, or components behind frames";
                    return Err(ReadError::unsupported(path, what).hint("split it first, as with `unu slice`"));
                }
            }
        }
        Ok(())
    }

    /// How the scalars of one volume lie, and what is made of them.
    pub(super) fn components(&self, path: &Path, frame: usize, options: &ReadOptions) -> Result<Components, ReadError> {
        match &self.components {
            _ if self.frames_in_runs => Ok(Components::new(path, self.frames, Some(frame))?.in_runs(self.run)),
            Some(counted) => {
                let components = Components::new(path, counted.size, options.component)?;
                Ok(components.as_rule(usual_rule(counted)).in_runs(self.run))
            }
            None => Components::new(path, 1, options.component),
        }
    }

    /// How many numbers a voxel has.
    pub(super) fn components_count(&self) -> usize {
        self.components.as_ref().map_or(1, |counted| counted.size)
    }

    /// Which of the volumes that follow each other is number `frame`, and how many there are.
    pub(super) fn slowest_frames(&self, frame: usize) -> (usize, usize) {
        match self.frames_in_runs {
            true => (0, 1),
            false => (frame, self.frames),
        }
    }
}

/// What is made of the numbers along an axis of components.
fn usual_rule(counted: &Counted) -> Rule {
    match counted.kind.as_str() {
        "RGB-color" | "RGBA-color" | "3-color" | "4-color" if counted.size >= 3 => Rule::Luminance,
        kind if kind.contains("list") || kind.contains("point") || SPATIAL_KINDS.contains(&kind) => Rule::Component(0),
        _ => Rule::Length,
    }
}

/// The array's axes that lie in space: those with a direction, or of a spatial kind; at most three.
fn spatial_axes(header: &Header, count: usize) -> Result<Vec<usize>, ReadError> {
    let kinds = header.words("kinds");
    let directions = header.vectors("spacedirections")?;
    let is_spatial = |axis: &usize| match &directions {
        Some(directions) => directions.get(*axis).is_some_and(Option::is_some),
        None => kinds
            .get(*axis)
            .is_none_or(|kind| SPATIAL_KINDS.contains(&kind.as_str())),
    };
    Ok((0..count).filter(is_spatial).take(3).collect())
}
