//! A frame of several levels on a device.
//!
//! *Practice.* One zone at a time is on the device.

use std::sync::Arc;

use super::pages::PagedTarget;
use super::slices::{SliceRenderer, Timings, device_error, plan_on, soft_normals};
use crate::projection::levels::{Zone, Zones};
use crate::projection::{DrawLevelsError, FrameSpec, LevelsFrame, LevelsSpec, ProjectError, ZonePicture, bands};

impl SliceRenderer {
    /// Draws one frame of several levels.
    ///
    /// # Errors
    /// If the blocks of a zone exceed the budget, or as [`Self::draw`].
    pub fn draw_levels(&mut self, spec: &LevelsSpec) -> Result<LevelsFrame, DrawLevelsError> {
        spec.draw(|spec, zone, zones| self.draw_zone(spec, zone, zones))
    }

    fn draw_zone(&mut self, spec: &FrameSpec, zone: &Zone, zones: &Zones) -> Result<ZonePicture, ProjectError> {
        let device = Arc::clone(self.device());
        let normals = soft_normals(spec);
        let paged = PagedTarget::new(&device, spec.target, normals.as_ref(), &mut |_| {}).map_err(device_error)?;
        let plan = zone.part_of(plan_on(zone.planes(&zones.comb), spec, &paged), zones);
        let plan = bands::cut(plan, spec);
        let (accumulated, times) = self.accumulate(spec, &paged, &plan, &[])?;
        Ok(ZonePicture {
            samples: accumulated.samples,
            slices: plan.slices.len(),
            reconstruct: paged.reconstruct,
            upload: paged.upload,
            draw: drawing(&times),
        })
    }
}

fn drawing(times: &Timings) -> std::time::Duration {
    times.prepare + times.draw + times.read_back
}
