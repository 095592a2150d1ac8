//! 3D Slicer's volume properties: `.vp.json`, read and written, and the older `.vp`, read.
//!
//! *Practice.* What is taken of a file is its first component: colours and opacities, the length that opacities hold for, and whether
//! and how it is shaded. Colours and opacities have points of their own there and share them here; bends are made lines, within
//! [`BEND_ERROR`]. A specular power becomes the nearest power of two. Gradient opacity and surfaces of values are not taken, and
//! [`Reading::left_out`] says where a file has them. What was read and is written again is then read as the same.

mod curve;
mod json;
mod text;

use std::io::Write;
use std::path::Path;

pub use self::curve::BEND_ERROR;
use self::curve::{COLOR_BEND, Node, OPACITY_BEND, Polyline};
use super::presets::Look;
use super::{ControlPoint, Material, Mode, TransferFunction};
use crate::output::write_whole;

/// How a volume is seen, as far as a volume property says.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeProperty {
    /// Colours and opacities.
    pub function: TransferFunction,
    /// How it answers to light; `None` without shading.
    pub material: Option<Material>,
}

/// What was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// What was taken.
    pub property: VolumeProperty,
    /// What else the file says, in words for the user.
    pub left_out: Vec<&'static str>,
}

/// Why a volume property cannot be read or written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VolumePropertyError {
    /// The file as a whole.
    #[error("{path}: {reason}")]
    File {
        /// Which.
        path: String,
        /// Why.
        reason: String,
    },
    /// A line of it.
    #[error("{path}:{line}: {reason}")]
    Line {
        /// Which file.
        path: String,
        /// From 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
}

/// What went wrong, before the file is named: the line, if it is one's, and why.
struct Wrong {
    line: Option<usize>,
    reason: String,
}

impl Wrong {
    fn at(line: usize, reason: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            reason: reason.into(),
        }
    }

    fn whole(reason: impl Into<String>) -> Self {
        Self {
            line: None,
            reason: reason.into(),
        }
    }

    fn of(self, path: &Path) -> VolumePropertyError {
        let (path, reason) = (path.display().to_string(), self.reason);
        match self.line {
            Some(line) => VolumePropertyError::Line { path, line, reason },
            None => VolumePropertyError::File { path, reason },
        }
    }
}

impl VolumeProperty {
    /// How a scene is drawn with it: such a file names no mode, and is meant for the composite one.
    pub fn look(&self) -> Look {
        Look {
            mode: Mode::Composite,
            material: self.material,
        }
    }
}

/// The longest file that is read.
const MOST_BYTES: u64 = 16 << 20;

/// The most nodes that one of a file's functions may have.
const MOST_NODES: usize = 4096;

/// Whether `path` is named like a volume property: `.vp.json` or `.vp`.
pub fn is_volume_property(path: &Path) -> bool {
    is_json(path).is_some()
}

/// Whether the newer format is meant, or the older; `None` if neither is.
fn is_json(path: &Path) -> Option<bool> {
    let name = path.file_name()?.to_str()?.to_ascii_lowercase();
    if name.ends_with(".vp.json") {
        return Some(true);
    }
    name.ends_with(".vp").then_some(false)
}

/// Reads a `.vp.json` or `.vp` file.
///
/// # Errors
/// If the file cannot be read or means nothing.
pub fn read(path: &Path) -> Result<Reading, VolumePropertyError> {
    let fails = |reason: String| Wrong::whole(reason).of(path);
    let read = match is_json(path) {
        Some(true) => json::read,
        Some(false) => text::read,
        None => return Err(fails("a volume property is a .vp.json or a .vp file".into())),
    };
    let length = std::fs::metadata(path).map_err(|e| fails(e.to_string()))?.len();
    if length > MOST_BYTES {
        return Err(fails(format!("longer than {} MiB", MOST_BYTES >> 20)));
    }
    let text = std::fs::read_to_string(path).map_err(|e| fails(e.to_string()))?;
    read(&text).map_err(|wrong| wrong.of(path))
}

/// Writes a `.vp.json` file, whole or not at all.
///
/// # Errors
/// If it is named otherwise, or cannot be written.
pub fn write(path: &Path, property: &VolumeProperty) -> Result<(), VolumePropertyError> {
    let fails = |reason: String| Wrong::whole(reason).of(path);
    if is_json(path) != Some(true) {
        return Err(fails(
            "a volume property is written as .vp.json: let the name end so".into(),
        ));
    }
    let text = json::written(property);
    write_whole(path, |out| out.write_all(text.as_bytes())).map_err(|e| fails(e.to_string()))
}

/// The parts of a volume property, as both formats have them.
struct Parts {
    color: Vec<Node<3>>,
    opacity: Vec<Node<1>>,
    unit_mm: f64,
    material: Option<Material>,
    left_out: Vec<&'static str>,
}

impl Parts {
    fn reading(self) -> Result<Reading, Wrong> {
        let color = Polyline::through(self.color, COLOR_BEND);
        let opacity = Polyline::through(self.opacity, OPACITY_BEND);
        let points = control_points(&color, &opacity);
        let function = TransferFunction::new(points, self.unit_mm).map_err(|e| Wrong::whole(e.to_string()))?;
        Ok(Reading {
            property: VolumeProperty {
                function,
                material: self.material,
            },
            left_out: self.left_out,
        })
    }
}

/// One point wherever either function has a knot, two where one of them has a step.
fn control_points(color: &Polyline<3>, opacity: &Polyline<1>) -> Vec<ControlPoint> {
    let mut values: Vec<f32> = color.places().chain(opacity.places()).collect();
    values.sort_unstable_by(f32::total_cmp);
    values.dedup();
    let mut points = Vec::new();
    for value in values {
        let (colors, opacities) = (color.around(value), opacity.around(value));
        let point = |side: usize| ControlPoint {
            value,
            color: colors[side].map(|c| c as f32),
            opacity: opacities[side][0] as f32,
        };
        points.push(point(0));
        if point(0) != point(1) {
            points.push(point(1));
        }
    }
    points
}

/// What both formats demand of a node.
fn check<const N: usize>(what: &str, number: usize, node: &Node<N>) -> Result<(), String> {
    let fails = |found: f64, wanted: &str| Err(format!("{what}, point {number}: {found} is not {wanted}"));
    if !(node.x as f32).is_finite() {
        return fails(node.x, "a value of single precision");
    }
    let parts = node.y.iter().chain([&node.midpoint, &node.sharpness]);
    match parts.copied().find(|part| !(0.0..=1.0).contains(part)) {
        Some(found) => fails(found, "in 0..1"),
        None => Ok(()),
    }
}

/// How many nodes a function may have.
fn check_count(what: &str, found: usize) -> Result<(), String> {
    match found {
        0 => Err(format!("{what} has no point")),
        n if n > MOST_NODES => Err(format!("{what} has {n} points; at most {MOST_NODES} are taken")),
        _ => Ok(()),
    }
}

/// A material of VTK's numbers.
fn material([ambient, diffuse, specular, power]: [f64; 4]) -> Result<Material, String> {
    let factors = [("ambient", ambient), ("diffuse", diffuse), ("specular", specular)];
    if let Some((name, found)) = factors.iter().find(|(_, f)| !(0.0..=10.0).contains(f)) {
        return Err(format!("{name} is {found}, not in 0..10"));
    }
    if !(power.is_finite() && power >= 0.0) {
        return Err(format!("the specular power is {power}, not a number of at least 0"));
    }
    Ok(Material {
        ambient: ambient as f32,
        diffuse: diffuse as f32,
        specular: specular as f32,
        shininess_log2: power.max(1.0).log2().round().min(10.0) as u32,
    })
}

/// Whether a gradient opacity changes anything: it is not 1 everywhere.
fn changes(gradient_opacity: &[Node<1>]) -> bool {
    gradient_opacity.iter().any(|node| node.y[0] != 1.0)
}

const GRADIENT_OPACITY: &str =
    "gradient opacity: opacities are taken as they are where nothing changes, so inner parts show more";
