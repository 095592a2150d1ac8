//! Random ways to look at a random scene.

use proptest::prelude::*;
use vcsg::image::Frame;
use vcsg::projection::{Camera, FrameSpec, Lens, Projector, Settings, raycast::RayCaster};
use vcsg::target::Target;

use crate::support::views::{Eye, Look, eye, look, settings};

#[derive(Clone, Debug)]
pub struct Picture {
    eye: Eye,
    look: Look,
    pub settings: Settings,
}

pub fn picture() -> impl Strategy<Value = Picture> {
    (eye(), look(), settings()).prop_map(|(eye, look, settings)| Picture { eye, look, settings })
}

impl Picture {
    /// Gives `draw` the frame to draw of `target`; colours are seen in a mode that shows colours.
    pub fn of<T>(&self, target: &Target, draw: impl FnOnce(&FrameSpec) -> T) -> T {
        let mut settings = self.settings.clone();
        if target.tree.has_colors() && !settings.mode.classifies() {
            settings.mode = Default::default();
        }
        draw(&FrameSpec {
            target,
            transfer: &self.look.transfer(target.value_range),
            camera: &self.eye.camera(&target.lattice.world_bounds()),
            settings: &settings,
        })
    }

    pub fn cast(&self, target: &Target) -> Frame {
        self.of(target, |spec| RayCaster.project(spec).expect("a frame"))
    }
}

/// The camera of `spec`, of which everything is so many times as large in the frame.
pub fn nearer(spec: &FrameSpec, times: f64) -> Camera {
    let mut camera = *spec.camera;
    match &mut camera.lens {
        Lens::Orthographic { pixels_per_mm } => *pixels_per_mm *= times,
        Lens::Perspective { focal_px, .. } => *focal_px *= times,
    }
    camera
}

/// Whether two frames have the same bits, NaN apart.
pub fn same(a: &Frame, b: &Frame) -> Result<(), String> {
    let channels = |frame: &Frame| frame.pixels().as_flattened().to_vec();
    let (a, b) = (channels(a), channels(b));
    match a.iter().zip(&b).position(|(a, b)| a.to_bits() != b.to_bits()) {
        Some(n) => Err(format!("channel {n} is {} and {}", a[n], b[n])),
        None if a.len() != b.len() => Err("sizes differ".into()),
        None => Ok(()),
    }
}
