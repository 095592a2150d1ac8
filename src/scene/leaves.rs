//! Volume nodes, and planes.

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::element::{Element, Value};
use super::error::{Problem, SceneError};
use super::loader::{MeshRequest, VolumeRequest};
use crate::math::{Interval, Plane, affine};
use crate::model::Admitted;
use crate::volume::VoxelType;
use crate::volume::io::raw::RawLayout;
use crate::volume::io::{Budget, ByteOrder, ReadOptions};

type Result<T> = std::result::Result<T, SceneError>;

/// The plane of a cut or a half-space: through `point` (the origin unless said), `normal` outwards.
pub(super) fn plane(element: &Element) -> Result<Plane> {
    let point = element.get("point").map_or(Ok(DVec3::ZERO), |v| v.vector())?;
    let normal = element.require("normal")?;
    Plane::through(point, normal.direction()?).ok_or_else(|| normal.bad("of a plane at a finite distance"))
}

/// The file that a volume node names, in the folder `base_dir` unless its path is absolute.
pub(super) fn volume_request(element: &Element, base_dir: &Path) -> Result<VolumeRequest> {
    Ok(VolumeRequest {
        path: base_dir.join(element.argument(0).string()?),
        options: read_options(element)?,
    })
}

/// The text of a scene of what `request` asks for, and nothing else.
pub(super) fn volume_text(request: &VolumeRequest) -> String {
    let mut node = kdl::KdlNode::new("volume");
    node.push(kdl::KdlEntry::new(request.path.to_string_lossy().into_owned()));
    let options = &request.options;
    let indices = [
        ("frame", options.frame),
        ("component", options.component),
        ("resolution", options.resolution),
    ];
    for (key, index) in indices {
        index.map(|n| node.insert(key, n as i128));
    }
    for (key, name) in [("series", &options.series), ("array", &options.array)] {
        name.clone().map(|name| node.insert(key, name));
    }
    if options.resample {
        node.insert("resample", true);
    }
    if let Some(layout) = &options.raw {
        insert_layout(&mut node, layout);
    }
    let mut scene = kdl::KdlNode::new("scene");
    scene.ensure_children().nodes_mut().push(node);
    let mut document = kdl::KdlDocument::new();
    document.nodes_mut().push(scene);
    document.autoformat();
    document.to_string()
}

/// The properties of a file without a header. Of its place only the spacing is said: a scene has no other property for it.
fn insert_layout(node: &mut kdl::KdlNode, layout: &RawLayout) {
    let words = |numbers: [String; 3]| numbers.join(" ");
    let spacing = affine::spacing(&layout.world_from_index).to_array();
    node.insert("dims", words(layout.dims.map(|n| n.to_string())));
    node.insert("type", layout.voxel.name());
    node.insert("spacing", words(spacing.map(|mm| mm.to_string())));
    node.insert(
        "endian",
        if layout.order == ByteOrder::Little {
            "little"
        } else {
            "big"
        },
    );
    node.insert("skip", i128::from(layout.offset));
}

/// Which volume of its file a node means, and what a file without a header holds.
fn read_options(element: &Element) -> Result<ReadOptions> {
    let index = |key| {
        element
            .get(key)
            .map(|v| v.whole(0, u32::MAX).map(|n| n as usize))
            .transpose()
    };
    let name = |key| element.get(key).map(|v| v.string().map(str::to_owned)).transpose();
    Ok(ReadOptions {
        frame: index("frame")?,
        series: name("series")?,
        array: name("array")?,
        component: index("component")?,
        resolution: index("resolution")?,
        resample: element.get("resample").map_or(Ok(false), |v| v.boolean())?,
        raw: raw_layout(element)?,
        budget: Budget::default(),
    })
}

/// Which voxels of a mask are in it: those that `label` says, or all but 0.
pub(super) fn admitted(element: &Element) -> Result<Admitted> {
    let Some(label) = element.get("label") else {
        return Ok(Admitted::NotZero);
    };
    Ok(Admitted::Within(match label.single() {
        Ok(number) => Interval::point(number),
        Err(_) => parse_window(label).map_err(|_| label.bad("a number, or a window like \"3..5\""))?,
    }))
}

/// The file of the property `mask`, a volume with a header, in the folder `base_dir` unless its path is absolute.
pub(super) fn mask_request(element: &Element, base_dir: &Path) -> Result<Option<VolumeRequest>> {
    match (element.get("mask"), element.get("label")) {
        (None, Some(label)) => Err(label.error(Problem::Conflict("`label` says which part of a `mask` is meant"))),
        (None, None) => Ok(None),
        (Some(mask), _) => Ok(Some(VolumeRequest {
            path: base_dir.join(mask.string()?),
            options: ReadOptions::default(),
        })),
    }
}

/// The file that a mesh node names, and its unit, 1 unless said.
pub(super) fn mesh_request(element: &Element, base_dir: &Path) -> Result<MeshRequest> {
    Ok(MeshRequest {
        path: base_dir.join(element.argument(0).string()?),
        unit_mm: element.get("unit-mm").map_or(Ok(1.0), |v| v.positive())?,
    })
}

/// The value window `inside`; all values unless said.
pub(super) fn window(element: &Element) -> Result<Interval> {
    element.get("inside").map_or(Ok(Interval::ALL), parse_window)
}

/// `"lo..hi"`, either end of which may be missing.
pub(super) fn parse_window(value: Value) -> Result<Interval> {
    let bad = || value.bad("a window like \"80..\", \"..200\" or \"80..200\"");
    let (lo, hi) = value.string()?.split_once("..").ok_or_else(bad)?;
    let end = |text: &str, missing| match text.trim() {
        "" => Ok(missing),
        number => number.parse().ok().filter(|n: &f32| n.is_finite()).ok_or_else(bad),
    };
    let (lo, hi) = (end(lo, f32::NEG_INFINITY)?, end(hi, f32::INFINITY)?);
    if lo <= hi { Ok(Interval { lo, hi }) } else { Err(bad()) }
}

const RAW_VOXELS: &[(&str, VoxelType)] = &[
    ("u8", VoxelType::U8),
    ("i8", VoxelType::I8),
    ("u16", VoxelType::U16),
    ("i16", VoxelType::I16),
    ("u32", VoxelType::U32),
    ("i32", VoxelType::I32),
    ("f32", VoxelType::F32),
    ("f64", VoxelType::F64),
];

/// The layout of a headerless file: all of it or nothing is said.
fn raw_layout(element: &Element) -> Result<Option<RawLayout>> {
    let Some(dims) = element.get("dims") else {
        let stray = ["type", "spacing", "endian", "skip"]
            .into_iter()
            .find(|key| element.get(key).is_some());
        return match stray {
            Some(key) => Err(element.error_of(
                key,
                Problem::Conflict("`type`, `spacing`, `endian` and `skip` go with `dims`, for files without a header"),
            )),
            None => Ok(None),
        };
    };
    let orders = [("little", ByteOrder::Little), ("big", ByteOrder::Big)];
    Ok(Some(RawLayout {
        dims: raw_dims(dims)?,
        voxel: element.require("type")?.one_of(RAW_VOXELS)?,
        order: element
            .get("endian")
            .map_or(Ok(ByteOrder::Little), |v| v.one_of(&orders))?,
        offset: element.get("skip").map_or(Ok(0), |v| v.whole(0, u32::MAX))?.into(),
        world_from_index: DAffine3::from_scale(raw_spacing(element)?),
    }))
}

/// Distances between voxels, millimetres; 1 unless said.
fn raw_spacing(element: &Element) -> Result<DVec3> {
    let Some(value) = element.get("spacing") else {
        return Ok(DVec3::ONE);
    };
    let spacing = value.vector()?;
    if spacing.cmpgt(DVec3::ZERO).all() {
        Ok(spacing)
    } else {
        Err(value.bad("above 0 on each axis"))
    }
}

fn raw_dims(value: Value) -> Result<[usize; 3]> {
    let numbers: [f64; 3] = value.numbers()?;
    if numbers.iter().all(|&n| n.fract() == 0.0 && (1.0..=1e9).contains(&n)) {
        Ok(numbers.map(|n| n as usize))
    } else {
        Err(value.bad("a string of three whole numbers above 0"))
    }
}
