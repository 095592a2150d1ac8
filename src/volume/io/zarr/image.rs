//! What an image's axes are, where it lies, and at which resolutions it is stored.
//!
//! Format: OME-NGFF 0.1 to 0.5, `multiscales`. Of an array without it, the last three axes are space.

use std::path::{Component, Path, PathBuf};

use glam::{DAffine3, DVec3};
use serde::Deserialize;
use serde_json::Value;

use super::array::Array;
use super::chunks::Selection;
use super::json::Document;
use crate::volume::io::error::ReadError;
use crate::volume::io::geometry::{from_axes, millimetres};

/// What images of the first versions have for axes, and what those of an array are taken for.
const AXES: [&str; 5] = ["t", "c", "z", "y", "x"];

/// An image, or an array as one.
#[derive(Debug)]
pub(super) struct Image {
    /// The array's axes, the fastest last.
    pub axes: Vec<Axis>,
    /// Its resolutions, the finest first.
    pub levels: Vec<Level>,
    /// What a user should know of how it was read.
    pub notes: Vec<String>,
}

/// What lies along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Places.
    Space,
    /// Times.
    Time,
    /// Channels.
    Channel,
    /// Something else.
    Other,
}

/// An axis of an image.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// What lies along it.
    pub kind: Kind,
    /// Where it points: to the left, to the back, up.
    direction: DVec3,
    /// Millimetres of its unit.
    millimetres: f64,
}

/// An image at one resolution.
#[derive(Debug)]
pub(super) struct Level {
    /// Where its array is.
    pub path: PathBuf,
    /// Units between elements, and where the first is, along each axis.
    scale: Vec<f64>,
    translation: Vec<f64>,
}

#[derive(Deserialize)]
struct Multiscale {
    axes: Option<Vec<NameOrAxis>>,
    datasets: Vec<Dataset>,
    #[serde(default, rename = "coordinateTransformations")]
    transformations: Vec<Transformation>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum NameOrAxis {
    Name(String),
    Axis {
        name: String,
        #[serde(rename = "type")]
        kind: Option<String>,
        unit: Option<String>,
    },
}

#[derive(Deserialize)]
struct Dataset {
    path: String,
    #[serde(default, rename = "coordinateTransformations")]
    transformations: Vec<Transformation>,
}

#[derive(Deserialize)]
struct Transformation {
    #[serde(rename = "type")]
    kind: String,
    scale: Option<Vec<f64>>,
    translation: Option<Vec<f64>>,
}

impl Image {
    /// The image that the attributes of a group describe; `None` where they describe none.
    pub fn of_group(document: &Document) -> Result<Option<Self>, ReadError> {
        let attributes = document.get("attributes").unwrap_or(document.value());
        let attributes = attributes.get("ome").unwrap_or(attributes);
        if attributes.get("plate").is_some() {
            return Err(document
                .unsupported("a plate of many wells")
                .hint("name the folder of a field of view in it"));
        }
        let Some(Value::Array(multiscales)) = attributes.get("multiscales") else {
            return Ok(None);
        };
        let Some(first) = multiscales.first() else {
            return Ok(None);
        };
        let first: Multiscale = document.parse_value(first.clone())?;
        let axes: Vec<Axis> = match first.axes {
            None => AXES.iter().map(|name| Axis::new(name, None, None)).collect(),
            Some(axes) => axes.into_iter().map(Axis::from).collect(),
        };
        check_axes(document, &axes)?;
        let levels = first.datasets.into_iter().map(|dataset| {
            let transformations = dataset.transformations.iter().chain(&first.transformations);
            Level::new(document, &dataset.path, transformations, axes.len())
        });
        let levels = levels.collect::<Result<_, _>>()?;
        let notes = match multiscales.len() {
            1 => Vec::new(),
            n => vec![format!("the first of {n} `multiscales`")],
        };
        Ok(Some(Self { axes, levels, notes }))
    }

    /// An array as an image: with the axes that its names say, else with space last.
    pub fn of_array(document: &Document, array: &Array) -> Result<Self, ReadError> {
        let count = array.shape.len();
        let usual = |axis: usize| (axis + AXES.len()).checked_sub(count).map_or("", |at| AXES[at]);
        let axis = |axis: usize| Axis::new(array.names[axis].as_deref().unwrap_or(usual(axis)), None, None);
        let axes: Vec<Axis> = match array.names.iter().all(|name| name.as_deref().is_some_and(is_known)) {
            true => (0..count).map(axis).collect(),
            false => (0..count).map(|axis| Axis::new(usual(axis), None, None)).collect(),
        };
        check_axes(document, &axes)?;
        let level = Level {
            path: PathBuf::new(),
            scale: vec![1.0; count],
            translation: vec![0.0; count],
        };
        Ok(Self {
            axes,
            levels: vec![level],
            notes: vec!["nothing says how far voxels are apart: it is taken as 1 mm".to_owned()],
        })
    }

    /// World LPS millimetres of a voxel's index of a level. Nothing is known of the anatomy: x, y and z are taken for L, P and S.
    pub fn world_from_index(&self, level: usize, selection: &Selection) -> DAffine3 {
        let Level { scale, translation, .. } = &self.levels[level];
        let of = |axis: usize, units: f64| self.axes[axis].direction * (units * self.axes[axis].millimetres);
        let column = |a: usize| selection.spatial.get(a).map(|axis| of(*axis, scale[*axis]));
        let origin = selection.spatial.iter().map(|axis| of(*axis, translation[*axis])).sum();
        from_axes([column(0), column(1), column(2)], origin)
    }
}

/// Whether an axis of this name is known by it.
fn is_known(name: &str) -> bool {
    AXES.contains(&name.to_ascii_lowercase().as_str())
}

/// Whether there are one to three axes in space, and no two of what is chosen by a number.
fn check_axes(document: &Document, axes: &[Axis]) -> Result<(), ReadError> {
    let count = |kind: Kind| axes.iter().filter(|axis| axis.kind == kind).count();
    let directions = axes
        .iter()
        .filter(|axis| axis.kind == Kind::Space)
        .map(|axis| axis.direction);
    let sum: DVec3 = directions.sum();
    if !(1..=3).contains(&count(Kind::Space)) || sum.max_element() > 1.0 {
        return Err(document.wrong("its axes in space are not some of x, y and z, each once"));
    }
    match count(Kind::Time) > 1 || count(Kind::Channel) > 1 {
        true => Err(document.wrong("it has two axes of time or of channels")),
        false => Ok(()),
    }
}

impl Axis {
    fn new(name: &str, kind: Option<&str>, unit: Option<&str>) -> Self {
        let name = name.to_ascii_lowercase();
        let direction = match name.as_str() {
            "x" => DVec3::X,
            "y" => DVec3::Y,
            "z" => DVec3::Z,
            _ => DVec3::ZERO,
        };
        let kind = match (kind, name.as_str()) {
            (Some("time"), _) | (None, "t") => Kind::Time,
            (Some("channel"), _) | (None, "c") => Kind::Channel,
            (Some("space") | None, "x" | "y" | "z") => Kind::Space,
            _ => Kind::Other,
        };
        Self {
            kind,
            direction,
            millimetres: unit.map_or(1.0, length_unit),
        }
    }
}

impl From<NameOrAxis> for Axis {
    fn from(axis: NameOrAxis) -> Self {
        match axis {
            NameOrAxis::Name(name) => Self::new(&name, None, None),
            NameOrAxis::Axis { name, kind, unit } => Self::new(&name, kind.as_deref(), unit.as_deref()),
        }
    }
}

/// Millimetres of a unit of UDUNITS-2, as OME-NGFF names them.
fn length_unit(unit: &str) -> f64 {
    match unit {
        "angstrom" => 1e-7,
        "picometer" => 1e-9,
        "centimeter" => 10.0,
        "decimeter" => 100.0,
        "kilometer" => 1e6,
        "inch" => 25.4,
        "foot" => 304.8,
        other => millimetres(other),
    }
}

impl Level {
    /// The level of `path`, on whose indices the transformations work one after the other.
    fn new<'a>(
        document: &Document,
        path: &str,
        transformations: impl Iterator<Item = &'a Transformation>,
        axes: usize,
    ) -> Result<Self, ReadError> {
        let mut level = Self {
            path: inner_path(path)
                .ok_or_else(|| document.wrong(format!("`{path}` is no path in the image's folder")))?,
            scale: vec![1.0; axes],
            translation: vec![0.0; axes],
        };
        for transformation in transformations {
            let (scale, translation) = match (transformation.kind.as_str(), transformation) {
                ("identity", _) => continue,
                ("scale", Transformation { scale: Some(by), .. }) => (by.clone(), vec![0.0; axes]),
                (
                    "translation",
                    Transformation {
                        translation: Some(by), ..
                    },
                ) => (vec![1.0; axes], by.clone()),
                (kind, _) => return Err(document.unsupported(format!("a coordinate transformation `{kind}`"))),
            };
            let is_usable = scale.iter().all(|n| n.is_normal()) && translation.iter().all(|n| n.is_finite());
            if scale.len() != axes || translation.len() != axes || !is_usable {
                return Err(document.wrong("a coordinate transformation has not one usable number for each axis"));
            }
            for axis in 0..axes {
                level.scale[axis] *= scale[axis];
                level.translation[axis] = level.translation[axis] * scale[axis] + translation[axis];
            }
        }
        Ok(level)
    }
}

/// A path that stays in its folder.
fn inner_path(path: &str) -> Option<PathBuf> {
    let stays = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    let inner = Path::new(path);
    inner.components().all(stays).then(|| inner.to_owned())
}
