//! The ray caster as a projector.

use rayon::prelude::*;

use super::boxes;
use super::classify::Classifier;
use super::light::Cue;
use super::rays::{Depths, Rays, TILE};
use super::tile::{Scene, Tile};
use super::voxels::CastTarget;
use crate::image::Frame;
use crate::projection::{FrameSpec, ProjectError, Projector, composite};

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
    let frame = accumulate(spec, target, &Depths::of(spec), surfaces_mm)?;
    let range = spec.target.value_range;
    Ok(composite::resolve(spec.settings.mode, &frame, range, spec.transfer))
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
    check(spec)?;
    let [width, height] = spec.camera.size;
    let rays = Rays::new(spec, depths)?;
    let [first_mm, step_mm] = rays.depth_mm();
    let planes = rays.planes;
    let stop = |x: u32, y: u32| {
        let surface_mm = surfaces_mm.and_then(|depths| depths.get(y as usize * width as usize + x as usize));
        surface_mm.map_or(planes, |&mm| {
            (((f64::from(mm) - first_mm) / step_mm).ceil() as i32).min(planes)
        })
    };
    let scene = Scene {
        target,
        boxes: &boxes::front_to_back(spec, target, &depths.planes),
        classifier: Classifier::new(spec, Cue::new(&spec.settings.depth_cue, depths, &rays)),
        rays,
        blending: spec.settings.mode.blending(),
        size: spec.camera.size,
        paths: &|x, y| spec.camera.path_per_depth(x, y) as f32,
        stops: &stop,
    };
    let mut frame = Frame::transparent(width, height);
    let band = TILE * width as usize;
    let bands = frame.pixels_mut().par_chunks_mut(band).enumerate();
    bands.for_each(|(n, band)| cast_band(&scene, (n * TILE) as u32, band));
    Ok(frame)
}

/// Casts the tiles of the rows of `band`, the first of which is `top`.
fn cast_band(scene: &Scene, top: u32, band: &mut [[f32; 4]]) {
    let width = scene.size[0] as usize;
    for left in (0..width).step_by(TILE) {
        let tile = Tile::cast(scene, [left as u32, top]);
        for (pixels, row) in tile.pixels.chunks_exact(TILE).zip(band.chunks_exact_mut(width)) {
            let columns = &mut row[left..width.min(left + TILE)];
            columns.copy_from_slice(&pixels[..columns.len()]);
        }
    }
}
