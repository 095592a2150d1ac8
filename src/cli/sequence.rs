//! Frames of one animation after the other, on one target that follows them.
//!
//! *Practice.* What all frames share is found from all of them, whichever are drawn: the lattice, the range of values, the box that
//! the camera fits, and what a preset is fitted to. So a frame is the same alone as in its turn, and nothing flickers.

use super::CliError;
use super::console::Stages;
use super::job::{Renderer, draw_paged, statistics};
use super::levels;
use super::loading::ShownFiles;
use super::render::{DEFAULT_SIZE, Render, over_background};
use super::surfaces::Surface;
use super::trace;
use crate::image::Frame;
use crate::math::{Aabb, Interval};
use crate::model::Model;
use crate::projection::presets::DataStatistics;
use crate::projection::{Camera, FrameSpec, SoftNormals, TransferFunction};
use crate::render::{PagedTarget, soft_normals};
use crate::scene::{Remembered, Scene, TransferSpec};
use crate::target::{Lattice, Target, TargetError, Update};

/// A scene whose frames are drawn.
pub(super) struct Sequence<'a> {
    render: &'a Render,
    scene: &'a Scene,
    loader: Remembered<ShownFiles>,
    renderer: Renderer,
    shared: Shared,
    target: Option<Target>,
    paged: Option<(PagedTarget, Option<SoftNormals>)>,
}

/// What all frames have in common.
struct Shared {
    bounds: Aabb,
    lattice: Lattice,
    value_range: Interval,
    data: DataStatistics,
}

impl<'a> Sequence<'a> {
    /// Nothing drawn yet of `scene`, which has an animation.
    pub fn new(
        render: &'a Render,
        scene: &'a Scene,
        mut loader: Remembered<ShownFiles>,
        stages: &mut Stages,
    ) -> Result<Self, CliError> {
        let first = frame_scene(render, scene, 0, &mut loader)?;
        let models = stages.time("animate", || models(scene, &first, &mut loader))?;
        Ok(Self {
            renderer: stages.time("device", || render.renderer(scene))?,
            shared: stages.time("subdivide", || Shared::of(&first, &models))?,
            render,
            scene,
            loader,
            target: None,
            paged: None,
        })
    }

    /// Draws frame `number`.
    pub fn frame(&mut self, number: u32, stages: &mut Stages) -> Result<Frame, CliError> {
        let scene = frame_scene(self.render, self.scene, number, &mut self.loader)?;
        let size = scene.frame_size.unwrap_or(DEFAULT_SIZE);
        let camera = scene.view.camera(&self.shared.bounds, size);
        let frame = if let Renderer::Tracer(sampling) = &self.renderer {
            trace::draw(&scene, &camera, *sampling, stages, &mut |_| Ok(()))?.0
        } else if scene.target.levels > 1 {
            levels::draw(&scene, &camera, &mut self.renderer, stages)?.0
        } else {
            self.draw(&scene, &camera, stages)?
        };
        Ok(over_background(frame, &scene))
    }

    fn draw(&mut self, scene: &Scene, camera: &Camera, stages: &mut Stages) -> Result<Frame, CliError> {
        let update = stages.time("subdivide", || self.shared.update(self.target.as_ref(), scene))?;
        let surfaces = Surface::extract_all(&scene.surfaces, &update.target, stages)?;
        let frame = if scene.shows_samples() {
            let transfer = self.shared.transfer_function(scene);
            let spec = FrameSpec {
                target: &update.target,
                transfer: &transfer,
                camera,
                settings: &scene.settings,
            };
            self.draw_samples(&spec, &update, &surfaces, stages)?
        } else {
            // The pages would no longer be those of the target before.
            self.paged = None;
            self.renderer
                .draw_surfaces(camera, &scene.settings, &surfaces, stages)?
        };
        self.target = Some(update.target);
        Ok(frame)
    }

    fn draw_samples(
        &mut self,
        spec: &FrameSpec,
        update: &Update,
        surfaces: &[Surface],
        stages: &mut Stages,
    ) -> Result<Frame, CliError> {
        let Renderer::Slices(renderer) = &mut self.renderer else {
            return self.renderer.draw(spec, surfaces, stages);
        };
        let device = std::sync::Arc::clone(renderer.device());
        let normals = soft_normals(spec);
        let silent = &mut |_| {};
        let paged = match (self.paged.take(), &self.target) {
            (Some((paged, of)), Some(before)) if of == normals => {
                paged.updated(&device, before, update, normals.as_ref(), silent)?
            }
            _ => PagedTarget::new(&device, spec.target, normals.as_ref(), silent)?,
        };
        stages.add("reconstruct", paged.reconstruct);
        stages.add("upload", paged.upload);
        let frame = draw_paged(renderer, spec, &paged, surfaces, stages);
        self.paged = Some((paged, normals));
        frame
    }
}

/// Frame `number` with the options of the command line.
fn frame_scene(
    render: &Render,
    scene: &Scene,
    number: u32,
    loader: &mut Remembered<ShownFiles>,
) -> Result<Scene, CliError> {
    let mut frame = scene.at_frame(number, loader)?;
    render.source.apply(&mut frame);
    render.overrides.apply(&mut frame)?;
    Ok(frame)
}

/// The models of all frames, each that may differ from the others.
fn models(scene: &Scene, first: &Scene, loader: &mut Remembered<ShownFiles>) -> Result<Vec<Model>, CliError> {
    let mut models = vec![first.model.clone()];
    if let Some(animation) = scene.animation.as_ref().filter(|animation| animation.moves_model()) {
        for frame in 1..animation.frames {
            models.push(scene.at_frame(frame, loader)?.model);
        }
    }
    Ok(models)
}

impl Shared {
    fn of(first: &Scene, models: &[Model]) -> Result<Self, CliError> {
        let options = &first.target;
        let all = Model::united(models);
        let (lattice, value_range) = options.lattice_and_range(&all)?;
        let target = Target::on_lattice(&first.model, lattice, &options.subdivision())?;
        let bounds = |model: &Model| model.root().map_or(Aabb::EMPTY, |root| model.bounds()[root.index()]);
        let objects = first.trace.objects.iter().map(|object| &object.model);
        Ok(Self {
            bounds: (models.iter().chain(objects).map(bounds)).fold(Aabb::EMPTY, |all, b| all.hull(&b)),
            lattice,
            value_range,
            data: statistics(&target),
        })
    }

    /// The target of a frame, from that of another if there is one.
    fn update(&self, before: Option<&Target>, scene: &Scene) -> Result<Update, TargetError> {
        let subdivision = scene.target.subdivision();
        let mut update = match before {
            Some(before) => before.updated(&scene.model, self.lattice, &subdivision)?,
            None => Update::anew(Target::on_lattice(&scene.model, self.lattice, &subdivision)?),
        };
        update.target.value_range = self.value_range;
        Ok(update)
    }

    fn transfer_function(&self, scene: &Scene) -> TransferFunction {
        let spec = scene.transfer.as_ref().unwrap_or(&TransferSpec::AUTOMATIC);
        spec.function(&self.data, self.bounds.size().length())
    }
}
