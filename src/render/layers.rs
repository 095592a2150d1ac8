//! The images that a frame is drawn into.
//!
//! Slices are blended into one image, whatever band they are in. Before the next band, pixels that hide all behind them are
//! closed: they hold the nearest depth, which no slice passes. See [`bands`](crate::projection::bands). Where there are meshes,
//! depths begin with theirs, so slices stop at them too, in one band or in several.

use std::sync::Arc;

use glam::DVec2;

use super::slices::{SliceRenderer, TARGET_FORMAT};
use crate::gpu::{
    Binding, Bindings, Blend, DEPTH_FORMAT, DepthTarget, Device, Draw, Elements, Extent, GpuError, GraphicsPipeline,
    Image, ImageRole, Load, Push, RenderPass, Target,
};
use crate::interface::RectData;
use crate::projection::composite::Blending;
use crate::projection::{FrameSpec, SlicePlan};

/// What slices are drawn into.
pub struct Layers {
    /// All slices so far.
    pub accumulated: Arc<Image>,
    /// What slices stop at, if there is anything: meshes, and closed pixels.
    depth: Option<Arc<Image>>,
    /// Closes pixels, if there are several bands.
    close: Option<Close>,
}

/// What closes pixels.
struct Close {
    pipeline: Arc<GraphicsPipeline>,
    /// With what is accumulated.
    bindings: Arc<Bindings>,
}

/// The order that slices are drawn in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// From the farthest to the nearest.
    FromBack,
    /// From the nearest on, in bands between which pixels are closed.
    InBands,
}

impl Order {
    /// That of the slices of `plan`.
    pub fn of(plan: &SlicePlan) -> Self {
        if plan.is_cut() { Self::InBands } else { Self::FromBack }
    }
}

/// How slices meet what is drawn already.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Meeting {
    /// Colours.
    pub blend: Blend,
    /// Whether there are depths to stop at.
    pub stops: bool,
}

impl Meeting {
    /// Of slices that are drawn in bands or from back to front, with or without depths to stop at.
    pub fn new(spec: &FrameSpec, layers: &Layers) -> Self {
        Self {
            blend: match spec.settings.mode.blending() {
                Blending::Over if layers.close.is_some() => Blend::Under,
                Blending::Over => Blend::Over,
                Blending::Add => Blend::Add,
                Blending::Max => Blend::Max,
            },
            stops: layers.depth.is_some(),
        }
    }
}

impl Close {
    fn new(renderer: &mut SliceRenderer, accumulated: &Arc<Image>) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let entry = Binding::SampledImage(Arc::clone(accumulated), Arc::clone(&renderer.nearest));
        Ok(Self {
            pipeline: renderer.pipelines.close(&device)?,
            bindings: Bindings::new(&device, "close", &[entry])?,
        })
    }
}

impl Layers {
    /// Images for a frame of `width` by `height` pixels, in which pixels are closed if `order` says so, among meshes of depths `meshes`.
    pub fn new(
        renderer: &mut SliceRenderer,
        [width, height]: [u32; 2],
        order: Order,
        meshes: Option<&Arc<Image>>,
    ) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let extent = Extent::D2(width, height);
        let accumulated = color(&device, "frame", extent)?;
        let depth = match meshes {
            Some(depth) => Some(Arc::clone(depth)),
            None if order == Order::InBands => Some(depths(&device, extent)?),
            None => None,
        };
        let close = match order {
            Order::InBands => Some(Close::new(renderer, &accumulated)?),
            Order::FromBack => None,
        };
        Ok(Self {
            accumulated,
            depth,
            close,
        })
    }

    /// Makes the frame transparent, and its depths the farthest unless they are those of `meshes`.
    pub fn clear(&self, meshes: Option<&Arc<Image>>) -> RenderPass {
        let far = if meshes.is_some() { Load::Keep } else { Load::Clear(1.0) };
        RenderPass {
            targets: vec![target(&self.accumulated, Load::Clear([0.0; 4]))],
            depth: self.depth.as_ref().map(|image| depth(image, far)),
            draws: Vec::new(),
        }
    }

    /// Goes on with `draws`.
    pub fn go_on(&self, draws: Vec<Draw>) -> RenderPass {
        RenderPass {
            targets: vec![target(&self.accumulated, Load::Keep)],
            depth: self.kept_depth(),
            draws,
        }
    }

    /// Closes what hides all behind it between two places (columns and rows in pixels), if pixels are closed at all.
    pub fn close(&self, [least, greatest]: [DVec2; 2]) -> Option<RenderPass> {
        let close = self.close.as_ref()?;
        let [width, height, _] = self.accumulated.extent().edges().map(f64::from);
        let size = DVec2::new(width, height);
        let [a, b] = [least / size, greatest / size].map(|end| end.as_vec2());
        let ends = [a.x, a.y, b.x, b.y];
        Some(RenderPass {
            targets: Vec::new(),
            depth: self.kept_depth(),
            draws: vec![rectangle(&close.pipeline, Arc::clone(&close.bindings), ends)],
        })
    }

    fn kept_depth(&self) -> Option<DepthTarget> {
        self.depth.as_ref().map(|image| depth(image, Load::Keep))
    }
}

/// A rectangle of a frame (its left, top, right and bottom, in parts of width and height), drawn by a pipeline of close.vert.
pub fn rectangle(pipeline: &Arc<GraphicsPipeline>, bindings: Arc<Bindings>, ends: [f32; 4]) -> Draw {
    Draw {
        pipeline: Arc::clone(pipeline),
        bindings: Some(bindings),
        push: Push::of(&RectData { ends }),
        stream: None,
        elements: Elements::Vertices(0..4),
        instances: 0..1,
    }
}

/// An image of colours.
pub fn color(device: &Arc<Device>, label: &str, extent: Extent) -> Result<Arc<Image>, GpuError> {
    Image::new(device, label, ImageRole::ColorTarget, TARGET_FORMAT, extent)
}

/// An image of depths.
pub fn depths(device: &Arc<Device>, extent: Extent) -> Result<Arc<Image>, GpuError> {
    Image::new(device, "depths", ImageRole::DepthTarget, DEPTH_FORMAT, extent)
}

/// `image` to draw into.
pub fn target(image: &Arc<Image>, load: Load) -> Target {
    Target {
        image: Arc::clone(image),
        load,
    }
}

/// `image` to test against.
pub fn depth(image: &Arc<Image>, load: Load<f32>) -> DepthTarget {
    DepthTarget {
        image: Arc::clone(image),
        load,
    }
}
