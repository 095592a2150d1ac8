//! How a shader reads between texels.

use std::sync::Arc;

use ash::vk;

use super::{Device, GpuError};

/// Interpolation between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The texel that contains the point.
    Nearest,
    /// Linear between the nearest texel centres in each dimension.
    Linear,
}

/// A sampler that clamps to the edge texels.
pub struct Sampler {
    device: Arc<Device>,
    raw: vk::Sampler,
}

impl Sampler {
    /// A sampler.
    ///
    /// # Errors
    /// What Vulkan says.
    pub fn new(device: &Arc<Device>, filter: Filter) -> Result<Arc<Self>, GpuError> {
        let filter = match filter {
            Filter::Nearest => vk::Filter::NEAREST,
            Filter::Linear => vk::Filter::LINEAR,
        };
        let edge = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let info = vk::SamplerCreateInfo::default().mag_filter(filter).min_filter(filter);
        // No least detailed level is named: lavapipe then sees at once that there is but one, and looks for none at each fetch.
        let info = info.max_lod(vk::LOD_CLAMP_NONE);
        let info = info.address_mode_u(edge).address_mode_v(edge).address_mode_w(edge);
        // SAFETY: the device is alive and the info whole.
        let raw = unsafe { device.raw().create_sampler(&info, None) }.map_err(GpuError::vulkan("create a sampler"))?;
        Ok(Arc::new(Self {
            device: Arc::clone(device),
            raw,
        }))
    }

    pub(super) fn raw(&self) -> vk::Sampler {
        self.raw
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: bindings hold their samplers, and submissions their bindings; destroyed once.
        unsafe { self.device.raw().destroy_sampler(self.raw, None) };
    }
}
