//! The images of a frame that is drawn in bands, and how bands come together.
//!
//! A band is drawn into a layer of its own, over nothing; then it is blended under what is accumulated. Before the next
//! one, pixels that hide all behind them are closed: they hold the nearest depth, which no slice passes. See
//! [`bands`](crate::projection::bands). Where there are meshes, depths begin with theirs, so slices stop at them too, in one band
//! or in several.

use std::sync::Arc;

use super::pipelines::Whole;
use super::slices::{SliceRenderer, TARGET_FORMAT};
use crate::gpu::{
    Binding, Bindings, DEPTH_FORMAT, DepthTarget, Device, Draw, Elements, Extent, GpuError, Image, ImageRole, Load,
    Push, RenderPass, Target,
};

/// What all bands are put together in.
pub struct Layers {
    /// All bands so far.
    pub accumulated: Arc<Image>,
    /// What slices stop at, if there is anything: meshes, and closed pixels.
    stops: Option<Stops>,
    /// Where bands are drawn, if there are several.
    band: Option<Band>,
}

/// Depths to stop at.
struct Stops {
    depth: Arc<Image>,
    /// What they begin with.
    first: Load<f32>,
}

/// What a band is drawn with.
struct Band {
    layer: Arc<Image>,
    /// Blends the layer under what is accumulated.
    merge: Draw,
    /// Closes pixels.
    close: Draw,
}

impl Layers {
    /// Images for a frame of `width` by `height` pixels, in one band or in several, among meshes of depths `meshes`.
    pub fn new(
        renderer: &mut SliceRenderer,
        [width, height]: [u32; 2],
        several: bool,
        meshes: Option<&Arc<Image>>,
    ) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let extent = Extent::D2(width, height);
        let accumulated = color(&device, "frame", extent)?;
        let stops = match meshes {
            Some(depth) => Some(Stops {
                depth: Arc::clone(depth),
                first: Load::Keep,
            }),
            None if several => Some(Stops {
                depth: depths(&device, extent)?,
                first: Load::Clear(1.0),
            }),
            None => None,
        };
        let band = several.then(|| Band::new(renderer, &accumulated, extent)).transpose()?;
        Ok(Self {
            accumulated,
            stops,
            band,
        })
    }

    /// Whether there are depths that slices stop at.
    pub fn stop(&self) -> bool {
        self.stops.is_some()
    }

    /// Makes the frame transparent.
    pub fn clear(&self) -> RenderPass {
        RenderPass {
            targets: vec![target(&self.accumulated, Load::Clear([0.0; 4]))],
            depth: None,
            draws: Vec::new(),
        }
    }

    /// Begins band `n`, counted from the nearest, with `draws`.
    pub fn begin(&self, n: usize, draws: Vec<Draw>) -> RenderPass {
        let Some(band) = &self.band else {
            return self.go_on(draws);
        };
        let close = (n > 0).then(|| band.close.clone());
        RenderPass {
            targets: vec![target(&band.layer, Load::Clear([0.0; 4]))],
            depth: self.stops.as_ref().map(|stops| {
                let load = if n == 0 { stops.first } else { Load::Keep };
                depth(&stops.depth, load)
            }),
            draws: close.into_iter().chain(draws).collect(),
        }
    }

    /// Goes on with the band at hand.
    pub fn go_on(&self, draws: Vec<Draw>) -> RenderPass {
        let image = self.band.as_ref().map_or(&self.accumulated, |band| &band.layer);
        RenderPass {
            targets: vec![target(image, Load::Keep)],
            depth: self.stops.as_ref().map(|stops| depth(&stops.depth, Load::Keep)),
            draws,
        }
    }

    /// Puts the band at hand behind those before it.
    pub fn end(&self) -> Option<RenderPass> {
        let band = self.band.as_ref()?;
        Some(RenderPass {
            targets: vec![target(&self.accumulated, Load::Keep)],
            depth: None,
            draws: vec![band.merge.clone()],
        })
    }
}

impl Band {
    fn new(renderer: &mut SliceRenderer, accumulated: &Arc<Image>, extent: Extent) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let layer = color(&device, "band", extent)?;
        let merge = whole(renderer, Whole::Merge, &layer)?;
        Ok(Self {
            layer,
            merge,
            close: whole(renderer, Whole::Close, accumulated)?,
        })
    }
}

/// A draw of the whole frame that reads `image` pixel by pixel.
fn whole(renderer: &mut SliceRenderer, what: Whole, image: &Arc<Image>) -> Result<Draw, GpuError> {
    let entry = Binding::SampledImage(Arc::clone(image), Arc::clone(&renderer.nearest));
    Ok(Draw {
        bindings: Some(Bindings::new(&renderer.device, image.label(), &[entry])?),
        pipeline: renderer.pipelines.whole(&renderer.device, what)?,
        push: Push::NONE,
        stream: None,
        elements: Elements::Vertices(0..4),
        instances: 0..1,
    })
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
