//! A frame drawn from the nearest slab of depth on, each planned when it is known what is still open.
//!
//! *Practice.* While the device draws one slab, the next is planned, by what could be seen when the one before was done. Nobody then
//! waits for the other, and boxes are left out one slab later than they might be; closed pixels are not drawn on in any case.

use std::time::{Duration, Instant};

use super::job::Job;
use super::layers::Order;
use super::look::{Look, Looks};
use super::mesh::ShownMesh;
use super::pages::PagedTarget;
use super::slices::{Accumulated, SliceRenderer, Timings, visibility};
use crate::gpu::{GpuError, Submission};
use crate::projection::bands::{self, Sweep};
use crate::projection::{BoxView, FrameSpec, OpenTiles, Planner, Remaining, ShownCells, SlicePlan, VisibleValues};

/// A slab that the device is at work on.
struct Underway {
    look: Look,
    /// Held until they are done.
    _submissions: Vec<Submission>,
}

impl SliceRenderer {
    /// Draws what `spec` shows of a target and meshes, as far as it is not hidden; the last step apart. What was drawn is returned as
    /// one plan.
    pub(super) fn sweep(
        &mut self,
        spec: &FrameSpec,
        paged: &PagedTarget,
        meshes: &[ShownMesh],
    ) -> Result<(Accumulated, SlicePlan, Timings), GpuError> {
        let begin = Instant::now();
        let mut timings = Timings::default();
        let shown = timed(&mut timings.plan, || {
            ShownCells::new(&paged.cells, &VisibleValues::in_frame(spec, &spec.table()))
        });
        let view = BoxView::new(&spec.target.lattice, spec.camera);
        let mut planner = Planner::new(&spec.target.lattice, spec.camera, spec.planes());
        let mut whole = planner.empty();
        let mut job = timed(&mut timings.prepare, || {
            Job::new(self, spec, meshes, Order::InBands, &whole)
        })?;
        let looks = Looks::new(self, &job.layers.accumulated)?;
        let mut sweep = Sweep::new(&spec.target.lattice, spec.planes(), &view);
        let mut open = OpenTiles::all(spec.camera.size);
        let mut underway: Option<Underway> = None;
        while let Some(depths_mm) = sweep.next(&open) {
            let slab = timed(&mut timings.plan, || {
                let remaining = Remaining {
                    view: &view,
                    depths_mm,
                    open: &open,
                };
                let mut slab = planner.plan(&visibility(spec, &shown, Some(remaining)));
                slab.slices.reverse();
                slab
            });
            if slab.slices.is_empty() {
                continue;
            }
            let next = timed(&mut timings.prepare, || {
                job.add(self, spec, paged, &slab)?;
                let (draw, look) = looks.look(self)?;
                job.close(bands::seen_px(&slab, 0..slab.slices.len()), Some(draw));
                let _submissions = job.submissions.start(&self.device)?;
                Ok::<_, GpuError>(Underway { look, _submissions })
            })?;
            if let Some(before) = underway.replace(next) {
                open = before.look.open()?;
            }
            whole.append(depths_mm[0], slab);
        }
        job.submissions.run(&self.device)?;
        drop(underway);
        timings.draw = begin.elapsed().saturating_sub(timings.plan + timings.prepare);
        let drawn = Instant::now();
        let accumulated = job.accumulated(&self.device)?;
        timings.read_back = drawn.elapsed();
        Ok((accumulated, whole, timings))
    }
}

/// What `action` gives; what it takes is added to `time`.
fn timed<T>(time: &mut Duration, action: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let result = action();
    *time += begin.elapsed();
    result
}
