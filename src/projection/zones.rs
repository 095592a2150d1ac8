//! A frame of several levels: a target for each zone, drawn one after the other and put together.
//!
//! *Practice.* One zone at a time is reconstructed, so the budget of blocks holds for each alone.

use std::time::{Duration, Instant};

use super::levels::{Zone, Zones, footprint};
use super::{Camera, FrameSpec, Mode, ProjectError, Settings, TransferFunction, composite};
use crate::image::Frame;
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
    /// Slices that were drawn of it, if it was drawn in slices.
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
    /// Bringing them to the device, if there is one.
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
    /// A device failed, or the frame is impossible.
    #[error(transparent)]
    Project(#[from] ProjectError),
}

/// What a projector made of a zone.
#[derive(Clone, Debug)]
pub struct ZonePicture {
    /// What its samples accumulate: see [`composite::resolve`].
    pub samples: Frame,
    /// Slices, if it was drawn in slices.
    pub slices: usize,
    /// Reconstructing it.
    pub reconstruct: Duration,
    /// Bringing it to the device, if there is one.
    pub upload: Duration,
    /// Drawing it.
    pub draw: Duration,
}

impl LevelsSpec<'_> {
    /// The frame, of whose zones `project` draws each.
    ///
    /// # Errors
    /// If the blocks of a zone exceed the budget, or `project` fails.
    pub fn draw(
        &self,
        mut project: impl FnMut(&FrameSpec, &Zone, &Zones) -> Result<ZonePicture, ProjectError>,
    ) -> Result<LevelsFrame, DrawLevelsError> {
        let zones = Zones::new(self.levels, self.camera, self.settings.samples_per_voxel);
        let [width, height] = self.camera.size;
        let mut drawn = LevelsFrame {
            frame: Frame::transparent(width, height),
            zones: Vec::new(),
            reconstruct: Duration::ZERO,
            upload: Duration::ZERO,
            draw: Duration::ZERO,
        };
        for zone in zones.zones.iter().rev() {
            self.draw_zone(&zones, zone, &mut drawn, &mut project)?;
        }
        drawn.zones.reverse();
        let range = self.levels.value_range;
        let frame = composite::resolve(self.settings.mode, drawn.frame, range, self.transfer);
        Ok(LevelsFrame { frame, ..drawn })
    }

    /// Draws one zone and puts it before what is drawn already.
    fn draw_zone(
        &self,
        zones: &Zones,
        zone: &Zone,
        drawn: &mut LevelsFrame,
        project: &mut impl FnMut(&FrameSpec, &Zone, &Zones) -> Result<ZonePicture, ProjectError>,
    ) -> Result<(), DrawLevelsError> {
        let levels = self.levels;
        let sides = zone.sides(self.camera, levels.voxel_mm(zone.level));
        let begin = Instant::now();
        let target = levels.part(zone.level, &footprint(self.camera), &sides, self.subdivision)?;
        let Some(target) = target.filter(|target| !target.blocks.is_empty()) else {
            return Ok(());
        };
        let spec = FrameSpec {
            target: &target,
            transfer: self.transfer,
            camera: self.camera,
            settings: &zone.settings(self.settings, &zones.comb, &levels.base, &target.lattice),
        };
        drawn.reconstruct += begin.elapsed();
        let picture = project(&spec, zone, zones)?;
        drawn.reconstruct += picture.reconstruct;
        drawn.upload += picture.upload;
        drawn.draw += picture.draw;
        put_before(self.settings.mode, zone, &picture.samples, &mut drawn.frame);
        drawn.zones.push(ZoneDrawn {
            zone: *zone,
            dims: target.lattice.dims,
            blocks: target.blocks.len(),
            stored_voxels: target.blocks.iter().map(|block| block.stored_len()).sum(),
            slices: picture.slices,
        });
        Ok(())
    }
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
