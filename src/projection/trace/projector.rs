//! The tracer as a projector of one target.

use super::frame::{self, Sampling};
use super::light::Source;
use super::object::Object;
use super::world::{Look, World};
use crate::image::Frame;
use crate::projection::{Camera, FrameSpec, Mode, ProjectError, Projector, Settings};

/// Draws on the processor, all threads, a target as a medium with shadows.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayTracer {
    /// Samples and how far rays go.
    pub sampling: Sampling,
}

impl Projector for RayTracer {
    fn project(&mut self, spec: &FrameSpec) -> Result<Frame, ProjectError> {
        check_mode(spec.settings.mode)?;
        let object = Object::new(spec.target, spec.transfer, None);
        let world = World::of(vec![object], &[], spec.camera, spec.settings)?;
        frame::draw(&world, spec.camera, self.sampling, &|_| {})
    }
}

/// Refuses a mode that is not traced.
///
/// # Errors
/// If it is not [`Mode::Composite`].
pub fn check_mode(mode: Mode) -> Result<(), ProjectError> {
    match mode {
        Mode::Composite => Ok(()),
        mode => Err(ProjectError::NotTraced { mode }),
    }
}

impl World {
    /// Objects before the background and in the light of a frame's settings, and of `placed` lights.
    ///
    /// # Errors
    /// If there are too many objects, or a light cannot be.
    pub fn of(
        objects: Vec<Object>,
        placed: &[Source],
        camera: &Camera,
        settings: &Settings,
    ) -> Result<Self, ProjectError> {
        let world_from_eye = camera.eye_from_world.matrix3.transpose();
        let lights = settings.shading.iter().flat_map(|shading| &shading.lights);
        let far = lights.map(|light| Source::far(world_from_eye * light.towards, f64::from(light.intensity)));
        let sources = far.chain(placed.iter().map(|light| Ok(*light)));
        let [r, g, b, opacity] = settings.background.map(f64::from);
        let environment = (opacity > 0.0).then_some([r, g, b]);
        let look = Look::new(settings.shading.as_ref(), settings.samples_per_voxel, environment);
        let sources = sources.collect::<Result<_, _>>()?;
        Ok(Self::new(objects, sources, look)?)
    }
}
