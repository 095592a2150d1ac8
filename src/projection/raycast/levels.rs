//! A frame of several levels by rays.

use std::time::Instant;

use super::caster::accumulate;
use super::rays::Depths;
use super::voxels::CastTarget;
use crate::projection::levels::{Zone, Zones};
use crate::projection::{DrawLevelsError, FrameSpec, LevelsFrame, LevelsSpec, ProjectError, ZonePicture};

/// Draws a frame of several levels, zone by zone.
///
/// # Errors
/// If the blocks of a zone exceed the budget, or as [`super::draw`].
pub fn draw_levels(spec: &LevelsSpec) -> Result<LevelsFrame, DrawLevelsError> {
    spec.draw(draw_zone)
}

fn draw_zone(spec: &FrameSpec, zone: &Zone, zones: &Zones) -> Result<ZonePicture, ProjectError> {
    let begin = Instant::now();
    let target = CastTarget::of(spec);
    let reconstruct = begin.elapsed();
    let depths = Depths {
        planes: zone.planes(&zones.comb),
        within_mm: [zone.near_mm, zone.far_mm],
        cue_mm: zones.cue_mm,
    };
    let begin = Instant::now();
    let samples = accumulate(spec, &target, &depths, None)?;
    Ok(ZonePicture {
        samples,
        slices: 0,
        reconstruct,
        upload: Default::default(),
        draw: begin.elapsed(),
    })
}
