//! The ray caster as a projector.

use rayon::prelude::*;

use super::boxes;
use super::classify::Classifier;
use super::gaps::{MARGIN, hops};
use super::kind::{Any, Few, FewPlain, Plain};
use super::light::Cue;
use super::pixels::Parts;
use super::rays::{Depths, Rays};
use super::shown::edge_for;
use super::template::FEW;
use super::tile::{self, Cast, Scene, tile};
use super::voxels::{CastBlock, CastTarget};
use crate::image::Frame;
use crate::projection::{FrameSpec, Lens, ProjectError, Projector, composite};

/// The longest side of a frame, pixels.
const LONGEST_SIDE: u32 = 1 << 15;

/// Draws on the processor, all threads, what slices draw on a device.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCaster;

impl Projector for RayCaster {
    fn project(&mut self, spec: &FrameSpec) -> Result<Frame, ProjectError> {
        check(spec)?;
        draw(spec, &CastTarget::of(spec), None)
    }
}

/// Draws what [`RayCaster`] draws, bit by bit, without what only some processors have.
#[derive(Clone, Copy, Debug, Default)]
pub struct PortableRayCaster;

impl Projector for PortableRayCaster {
    fn project(&mut self, spec: &FrameSpec) -> Result<Frame, ProjectError> {
        check(spec)?;
        let frame = accumulate_by(&BY_ARRAYS, spec, &CastTarget::of(spec), &Depths::of(spec), None)?;
        Ok(resolved(spec, frame))
    }
}

fn resolved(spec: &FrameSpec, accumulated: Frame) -> Frame {
    composite::resolve(spec.settings.mode, accumulated, spec.target.value_range, spec.transfer)
}

fn check(spec: &FrameSpec) -> Result<(), ProjectError> {
    require_size(spec.camera.size)?;
    spec.check()
}

/// Requires that a frame has pixels, and none of its sides too many, to be drawn on the processor.
///
/// # Errors
/// If it is not so.
pub fn require_size([width, height]: [u32; 2]) -> Result<(), ProjectError> {
    if [width, height].iter().any(|side| !(1..=LONGEST_SIDE).contains(side)) {
        let limit = LONGEST_SIDE;
        return Err(ProjectError::FrameSize { width, height, limit });
    }
    Ok(())
}

/// Draws a target that is ready, [`CastTarget::of`] the same spec but for camera, transfer function, and settings that no normals
/// are made by. Rays end at `surfaces_mm`, the depths of opaque surfaces at each pixel, if there are any: what shows of those is
/// for [`composite::over_surfaces`].
///
/// # Errors
/// If the frame's size is impossible, its mode shows values where there are colours, or samples are too close.
pub fn draw(spec: &FrameSpec, target: &CastTarget, surfaces_mm: Option<&[f32]>) -> Result<Frame, ProjectError> {
    Ok(resolved(
        spec,
        accumulate(spec, target, &Depths::of(spec), surfaces_mm)?,
    ))
}

/// Likewise in a part of the frame's depths, what its mode accumulates there: see [`composite::resolve`].
///
/// # Errors
/// As [`draw`].
pub fn accumulate(
    spec: &FrameSpec,
    target: &CastTarget,
    depths: &Depths,
    surfaces_mm: Option<&[f32]>,
) -> Result<Frame, ProjectError> {
    accumulate_by(&BY_WIDEST, spec, target, depths, surfaces_mm)
}

/// Ways to cast a tile of each kind, of any frames and of plain ones: in packets of one vector, of one that has few voxels, and of four.
type Casts = [[Cast; 3]; 2];

const BY_WIDEST: Casts = [
    [
        tile::by_widest::<Any, 1>,
        tile::by_widest::<Few, 1>,
        tile::by_widest::<Few, 4>,
    ],
    [
        tile::by_widest::<Plain, 1>,
        tile::by_widest::<FewPlain, 1>,
        tile::by_widest::<FewPlain, 4>,
    ],
];
const BY_ARRAYS: Casts = [[
    tile::by_arrays::<Any, 1>,
    tile::by_arrays::<Any, 1>,
    tile::by_arrays::<Few, 4>,
]; 2];

fn accumulate_by(
    casts: &Casts,
    spec: &FrameSpec,
    target: &CastTarget,
    depths: &Depths,
    surfaces_mm: Option<&[f32]>,
) -> Result<Frame, ProjectError> {
    check(spec)?;
    let [width, height] = spec.camera.size;
    let rays = Rays::new(spec, depths)?;
    let [first_mm, step_mm] = rays.depth_mm();
    let planes = rays.planes;
    let stops = surfaces_mm.map(|depths| {
        move |[x, y]: [u32; 2]| {
            let plane = |&mm: &f32| ((f64::from(mm) - first_mm) / step_mm).ceil() as i32;
            let surface = depths.get(y as usize * width as usize + x as usize);
            surface.map_or(planes, |mm| plane(mm).min(planes))
        }
    });
    let path = |[x, y]: [u32; 2]| spec.camera.path_per_depth(x, y) as f32;
    let parallel = matches!(spec.camera.lens, Lens::Orthographic { .. });
    // Packets are as large as they may be for their voxels to be few.
    let all_have_few = target.blocks.iter().all(CastBlock::has_few);
    let extents = [rays.packet_extent::<1>(), rays.packet_extent::<4>()];
    let (size, tile, extent) = match extents {
        [_, extent] if all_have_few && extent <= FEW => (2, tile(4), extent),
        [extent, _] => (usize::from(all_have_few && extent <= FEW), tile(1), extent),
    };
    let cell = edge_for(extent + 4.0 * MARGIN);
    let shown = target.shown(spec, cell);
    let classifier = Classifier::new(spec, &shown.table, Cue::new(&spec.settings.depth_cue, depths, &rays));
    let all_covered = target.blocks.iter().all(|block| block.coverage.is_empty());
    let is_plain = parallel && all_covered && classifier.is_plain();
    let cast = casts[usize::from(is_plain)][size];
    let scene = Scene {
        target,
        boxes: &boxes::front_to_back(spec, &shown.blocks),
        classifier,
        hops: hops(
            cell,
            rays.planes_per_voxel([width, height].map(|n| n.next_multiple_of(tile as u32))),
        ),
        rays,
        blending: spec.settings.mode.blending(),
        paths: (!parallel).then_some(&path),
        stops: stops.as_ref().map(|stops| stops as _),
    };
    let mut frame = Frame::transparent(width, height);
    let parts = Parts::of(&mut frame, tile);
    let threads = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1);
    threads.for_each(|_| cast(&scene, &parts));
    Ok(frame)
}
