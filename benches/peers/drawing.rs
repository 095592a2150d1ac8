//! A model on the device, ready to be drawn.

use std::sync::Arc;

use glam::DVec2;
use serde::Serialize;
use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
use vcsg::image::Frame;
use vcsg::math::affine;
use vcsg::model::Model;
use vcsg::projection::FrameSpec;
use vcsg::render::{PagedTarget, SliceRenderer, Timings, soft_normals};
use vcsg::target::{Subdivision, Target};

use crate::Outcome;
use crate::runs::{Run, timed};
use crate::scene::Look;

/// Mesa's driver for processors, which VTK is given too.
const DEVICE: &str = "llvmpipe";

/// Opens the device.
pub fn open_device() -> Outcome<Arc<Device>> {
    let instance = Instance::new(Validation::Off)?;
    let selector = DeviceSelector::Name(DEVICE.to_owned());
    Ok(Device::open(&instance, &selector, &SliceRenderer::REQUIREMENTS)?)
}

/// A subdivided model on the device.
pub struct Drawing {
    /// The model on its lattice.
    pub target: Target,
    /// The same on the device.
    pub paged: PagedTarget,
    /// What subdividing took.
    pub subdivide: Run,
    /// What reconstructing and uploading took.
    pub upload: Run,
    look: Look,
}

impl Drawing {
    /// Subdivides `model` and brings it to `device`.
    pub fn new(device: &Arc<Device>, model: &Model, subdivision: &Subdivision, look: Look) -> Outcome<Self> {
        let (target, subdivide) = timed(|| Target::build(model, None, subdivision));
        let target = target?;
        let (paged, upload) = timed(|| {
            let normals = soft_normals(&spec(&target, &look));
            PagedTarget::new(device, &target, normals.as_ref(), &mut |_| {})
        });
        Ok(Self {
            paged: paged?,
            target,
            subdivide,
            upload,
            look,
        })
    }

    /// Draws and reads back a frame; nothing of an earlier one is used but its pipelines.
    pub fn draw(&self, renderer: &mut SliceRenderer) -> Outcome<(Frame, Timings, Run)> {
        let (drawn, run) = timed(|| renderer.draw(&spec(&self.target, &self.look), &self.paged, &[]));
        let (frame, timings) = drawn?;
        Ok((frame, timings, run))
    }

    /// What a frame draws.
    pub fn work(&self, renderer: &mut SliceRenderer) -> Outcome<Work> {
        let plan = renderer
            .draw_told(&spec(&self.target, &self.look), &self.paged, &[])?
            .plan;
        let pixel = |p| {
            let eye = affine::point(&plan.eye_from_lattice, p);
            self.look.camera.project(eye)
        };
        let polygon = |slice| -> Vec<DVec2> { plan.polygon(slice).into_iter().map(pixel).collect() };
        Ok(Work {
            boxes: plan.boxes.len(),
            polygons: plan.slices.len(),
            fragments: plan.slices.iter().map(|slice| area(&polygon(slice))).sum(),
        })
    }
}

/// How much a frame draws.
#[derive(Clone, Copy, Serialize)]
pub struct Work {
    /// Boxes of all bands.
    pub boxes: usize,
    /// Slices of all of them.
    pub polygons: usize,
    /// The area of all polygons in pixels, cut off by no edge of the frame.
    pub fragments: f64,
}

fn spec<'a>(target: &'a Target, look: &'a Look) -> FrameSpec<'a> {
    FrameSpec {
        target,
        transfer: &look.transfer,
        camera: &look.camera,
        settings: &look.settings,
    }
}

/// The area of a polygon.
fn area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let doubled: f64 = corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum();
    0.5 * doubled.abs()
}
