//! A frame of several levels on a device: a target for each zone, drawn one after the other and put together.
//!
//! *Practice.* One zone at a time is reconstructed and on the device, so the budget of blocks holds for each alone.

use std::sync::Arc;
use std::time::Duration;

use super::pages::PagedTarget;
use super::slices::{SliceRenderer, Timings, device_error, plan_on, soft_normals};
use crate::image::Frame;
use crate::projection::levels::{Zone, Zones, footprint};
use crate::projection::{Camera, FrameSpec, Mode, ProjectError, Settings, TransferFunction, bands, composite};
use crate::target::{Levels, Subdivision, TargetError};

/// What a frame of several levels shows.
#[derive(Clone, Copy, Debug)]
pub struct LevelsSpec<'a> {
    /// The model.
    pub levels: &'a Levels<'a>,
    /// How the target of each zone is subdivided.
    pub subdivision: &'a Subdivision,
    /// Values to colour and opacity.
    pub transfer: &'a TransferFunction,
    /// The eye and the frame's size.
    pub camera: &'a Camera,
    /// The mode, light and sampling.
    pub settings: &'a Settings,
}

/// A zone as it was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneDrawn {
    /// Its level and depths.
    pub zone: Zone,
    /// Voxels of its lattice along each axis.
    pub dims: [usize; 3],
    /// Blocks of its target.
    pub blocks: usize,
    /// Voxels that its blocks store, aprons included.
    pub stored_voxels: usize,
    /// Slices that were drawn of it.
    pub slices: usize,
}

/// A frame of several levels.
#[derive(Clone, Debug)]
pub struct LevelsFrame {
    /// Premultiplied, without background.
    pub frame: Frame,
    /// What it is made of, the nearest first.
    pub zones: Vec<ZoneDrawn>,
    /// Subdividing and reconstructing all zones.
    pub reconstruct: Duration,
    /// Bringing them to the device.
    pub upload: Duration,
    /// Drawing them.
    pub draw: Duration,
}

/// Why a frame of several levels cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DrawLevelsError {
    /// A zone has no target.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The device failed, or the frame is impossible.
    #[error(transparent)]
    Project(#[from] ProjectError),
}

impl SliceRenderer {
    /// Draws one frame of several levels.
    ///
    /// # Errors
    /// If the blocks of a zone exceed the budget, or as [`Self::draw`].
    pub fn draw_levels(&mut self, spec: &LevelsSpec) -> Result<LevelsFrame, DrawLevelsError> {
        let zones = Zones::new(spec.levels, spec.camera, spec.settings.samples_per_voxel);
        let [width, height] = spec.camera.size;
        let mut drawn = LevelsFrame {
            frame: Frame::transparent(width, height),
            zones: Vec::new(),
            reconstruct: Duration::ZERO,
            upload: Duration::ZERO,
            draw: Duration::ZERO,
        };
        for zone in zones.zones.iter().rev() {
            self.draw_zone(spec, &zones, zone, &mut drawn)?;
        }
        drawn.zones.reverse();
        let range = spec.levels.value_range;
        drawn.frame = composite::resolve(spec.settings.mode, &drawn.frame, range, spec.transfer);
        Ok(drawn)
    }

    /// Draws one zone and puts it before what is drawn already.
    fn draw_zone(
        &mut self,
        spec: &LevelsSpec,
        zones: &Zones,
        zone: &Zone,
        drawn: &mut LevelsFrame,
    ) -> Result<(), DrawLevelsError> {
        let levels = spec.levels;
        let sides = zone.sides(spec.camera, levels.voxel_mm(zone.level));
        let begin = std::time::Instant::now();
        let target = levels.part(zone.level, &footprint(spec.camera), &sides, spec.subdivision)?;
        let Some(target) = target.filter(|target| !target.blocks.is_empty()) else {
            return Ok(());
        };
        let frame_spec = FrameSpec {
            target: &target,
            transfer: spec.transfer,
            camera: spec.camera,
            settings: &zone.settings(spec.settings, &zones.comb, &levels.base, &target.lattice),
        };
        drawn.reconstruct += begin.elapsed();
        let device = Arc::clone(self.device());
        let normals = soft_normals(&frame_spec);
        let paged = PagedTarget::new(&device, &target, normals.as_ref(), &mut |_| {}).map_err(device_error)?;
        drawn.reconstruct += paged.reconstruct;
        drawn.upload += paged.upload;
        let plan = zone.part_of(plan_on(zone.planes(&zones.comb), &frame_spec, &paged), zones);
        let plan = bands::cut(plan, &frame_spec);
        let (accumulated, times) = self.accumulate(&frame_spec, &paged, &plan, &[])?;
        drawn.draw += drawing(&times);
        put_before(spec.settings.mode, zone, &accumulated.samples, &mut drawn.frame);
        drawn.zones.push(ZoneDrawn {
            zone: *zone,
            dims: target.lattice.dims,
            blocks: target.blocks.len(),
            stored_voxels: target.blocks.iter().map(|block| block.stored_len()).sum(),
            slices: plan.slices.len(),
        });
        Ok(())
    }
}

fn drawing(times: &Timings) -> Duration {
    times.prepare + times.draw + times.read_back
}

/// `nearer`, which is of `zone`, before what is `behind` it. A mean counts millimetres, and a slab of a coarser level has more.
fn put_before(mode: Mode, zone: &Zone, nearer: &Frame, behind: &mut Frame) {
    let slabs = match mode {
        Mode::Average => 2f64.powi(zone.level as i32),
        _ => 1.0,
    };
    let blending = mode.blending();
    for (pixel, source) in behind.pixels_mut().iter_mut().zip(nearer.pixels()) {
        let source = source.map(|c| f64::from(c) * slabs);
        *pixel = blending.blend(source, pixel.map(f64::from)).map(|c| c as f32);
    }
}
