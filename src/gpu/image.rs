//! Images: textures to sample and targets to draw into.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;
use gpu_allocator::{MemoryLocation, vulkan::Allocation};

use super::access::State;
use super::memory::{Holds, allocate, free};
use super::{Device, GpuError, Region, texel_bytes};

/// The number of dimensions of an image and its edges in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Width.
    D1(u32),
    /// Width and height.
    D2(u32, u32),
    /// Width, height and depth.
    D3(u32, u32, u32),
}

impl Extent {
    /// The edges, absent ones as 1.
    pub fn edges(self) -> [u32; 3] {
        match self {
            Self::D1(width) => [width, 1, 1],
            Self::D2(width, height) => [width, height, 1],
            Self::D3(width, height, depth) => [width, height, depth],
        }
    }

    /// The number of texels.
    pub fn texels(self) -> u64 {
        self.edges()
            .iter()
            .fold(1, |product, &edge| product.saturating_mul(u64::from(edge)))
    }
}

/// What an image is for. What has colours is copied into and out of, and sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageRole {
    /// Sampled by shaders.
    Sampled,
    /// Also drawn into.
    ColorTarget,
    /// Depths to test against, and nothing else.
    DepthTarget,
}

/// The format of depths.
pub const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// An image with one level of detail.
pub struct Image {
    device: Arc<Device>,
    raw: vk::Image,
    view: vk::ImageView,
    allocation: Option<Allocation>,
    format: vk::Format,
    extent: Extent,
    role: ImageRole,
    label: String,
    state: Mutex<State>,
}

impl Image {
    /// An image with undefined content.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for an empty extent or a format that is unknown or cannot be used so, [`GpuError::TooLarge`],
    /// [`GpuError::OutOfMemory`], or what Vulkan says.
    pub fn new(
        device: &Arc<Device>,
        label: &str,
        role: ImageRole,
        format: vk::Format,
        extent: Extent,
    ) -> Result<Arc<Self>, GpuError> {
        let bytes = require_possible(device, label, role, format, extent)?;
        let info = create_info(role, format, extent);
        // SAFETY: the device supports images like this (just asked).
        let raw = unsafe { device.raw().create_image(&info, None) }.map_err(GpuError::creating(label, bytes))?;
        let mut image = Self {
            device: Arc::clone(device),
            raw,
            view: vk::ImageView::null(),
            allocation: None,
            format,
            extent,
            role,
            label: label.to_owned(),
            state: Mutex::default(),
        };
        image.bind(bytes)?;
        image.create_view(bytes)?;
        Ok(Arc::new(image))
    }

    fn bind(&mut self, bytes: u64) -> Result<(), GpuError> {
        // SAFETY: the image is this device's.
        let requirements = unsafe { self.device.raw().get_image_memory_requirements(self.raw) };
        let allocation = allocate(
            &self.device,
            &self.label,
            requirements,
            MemoryLocation::GpuOnly,
            Holds::Image,
        )?;
        // SAFETY: the allocation fulfils the image's requirements and lives as long; the image is bound once.
        let bound = unsafe {
            self.device
                .raw()
                .bind_image_memory(self.raw, allocation.memory(), allocation.offset())
        };
        self.allocation = Some(allocation);
        bound.map_err(GpuError::creating(&self.label, bytes))
    }

    fn create_view(&mut self, bytes: u64) -> Result<(), GpuError> {
        let kind = match self.extent {
            Extent::D1(..) => vk::ImageViewType::TYPE_1D,
            Extent::D2(..) => vk::ImageViewType::TYPE_2D,
            Extent::D3(..) => vk::ImageViewType::TYPE_3D,
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.format);
        let info = info.subresource_range(self.whole());
        // SAFETY: the image is bound and the view like it.
        let view = unsafe { self.device.raw().create_image_view(&info, None) };
        self.view = view.map_err(GpuError::creating(&self.label, bytes))?;
        self.device.name(self.raw, &self.label);
        self.device.name(self.view, &self.label);
        Ok(())
    }

    /// Its texel format.
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Its size in texels.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// What it is for.
    pub fn role(&self) -> ImageRole {
        self.role
    }

    /// Its name in messages.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Bytes a texel.
    pub fn texel_bytes(&self) -> u64 {
        texel_bytes(self.format).unwrap_or(0)
    }

    /// Bytes of all texels, tightly packed.
    pub fn bytes(&self) -> u64 {
        self.extent.texels().saturating_mul(self.texel_bytes())
    }

    /// All of it.
    pub fn region(&self) -> Region {
        Region {
            offset: [0; 3],
            extent: self.extent.edges(),
        }
    }

    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Its only level and layer.
    pub(super) fn whole(&self) -> vk::ImageSubresourceRange {
        let aspect = match self.role {
            ImageRole::Sampled | ImageRole::ColorTarget => vk::ImageAspectFlags::COLOR,
            ImageRole::DepthTarget => vk::ImageAspectFlags::DEPTH,
        };
        vk::ImageSubresourceRange::default()
            .aspect_mask(aspect)
            .level_count(1)
            .layer_count(1)
    }

    pub(super) fn raw(&self) -> vk::Image {
        self.raw
    }

    pub(super) fn view(&self) -> vk::ImageView {
        self.view
    }

    pub(super) fn is_on(&self, device: &Device) -> bool {
        std::ptr::eq(&*self.device, device)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: submissions hold what they use, so the device is done with both; each is destroyed once, and a null view
        // is ignored.
        unsafe {
            self.device.raw().destroy_image_view(self.view, None);
            self.device.raw().destroy_image(self.raw, None);
        }
        if let Some(allocation) = self.allocation.take() {
            free(&self.device, allocation);
        }
    }
}

fn usage(role: ImageRole) -> vk::ImageUsageFlags {
    use vk::ImageUsageFlags as U;
    let common = U::SAMPLED | U::TRANSFER_SRC | U::TRANSFER_DST;
    match role {
        ImageRole::Sampled => common,
        ImageRole::ColorTarget => common | U::COLOR_ATTACHMENT,
        ImageRole::DepthTarget => U::DEPTH_STENCIL_ATTACHMENT,
    }
}

fn image_type(extent: Extent) -> vk::ImageType {
    match extent {
        Extent::D1(..) => vk::ImageType::TYPE_1D,
        Extent::D2(..) => vk::ImageType::TYPE_2D,
        Extent::D3(..) => vk::ImageType::TYPE_3D,
    }
}

fn create_info(role: ImageRole, format: vk::Format, extent: Extent) -> vk::ImageCreateInfo<'static> {
    let [width, height, depth] = extent.edges();
    vk::ImageCreateInfo::default()
        .image_type(image_type(extent))
        .format(format)
        .extent(vk::Extent3D { width, height, depth })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(usage(role))
}

/// Checks a wish against the device before it is asked for, and returns its size in bytes.
fn require_possible(
    device: &Device,
    label: &str,
    role: ImageRole,
    format: vk::Format,
    extent: Extent,
) -> Result<u64, GpuError> {
    let bytes = require_sensible(label, role, format, extent)?;
    // SAFETY: the physical device is of this instance.
    let possible = unsafe {
        device.instance().raw().get_physical_device_image_format_properties(
            device.physical(),
            format,
            image_type(extent),
            vk::ImageTiling::OPTIMAL,
            usage(role),
            vk::ImageCreateFlags::empty(),
        )
    };
    let possible = possible.map_err(|result| match result {
        vk::Result::ERROR_FORMAT_NOT_SUPPORTED => {
            GpuError::usage(label, format!("the device cannot use {format:?} as {role:?}"))
        }
        other => GpuError::vulkan("ask about an image format")(other),
    })?;
    // Some devices' answer for a format exceeds the limit they state for all.
    let edge = u64::from(longest_edge(device, extent));
    let limits = [
        possible.max_extent.width,
        possible.max_extent.height,
        possible.max_extent.depth,
    ];
    let limits = limits.map(|limit| edge.min(u64::from(limit)));
    let asked = extent.edges().map(u64::from);
    let sizes = ["width", "height", "depth"].into_iter().zip(asked).zip(limits);
    let sizes = sizes.map(|((what, asked), limit)| (what, asked, limit));
    match sizes
        .chain([("bytes", bytes, possible.max_resource_size)])
        .find(|(_, asked, limit)| asked > limit)
    {
        Some((what, asked, limit)) => Err(GpuError::TooLarge {
            label: label.to_owned(),
            what,
            asked,
            limit,
        }),
        None => Ok(bytes),
    }
}

/// Checks what no device could do, and returns the size in bytes.
fn require_sensible(label: &str, role: ImageRole, format: vk::Format, extent: Extent) -> Result<u64, GpuError> {
    let texel =
        texel_bytes(format).ok_or_else(|| GpuError::usage(label, format!("the format {format:?} is not known")))?;
    if extent.texels() == 0 {
        return Err(GpuError::usage(label, format!("an image without texels: {extent:?}")));
    }
    if (role == ImageRole::DepthTarget) != (format == DEPTH_FORMAT) {
        let problem = format!("{format:?} as {role:?}: depths are {DEPTH_FORMAT:?}, and nothing else is");
        return Err(GpuError::usage(label, problem));
    }
    if role != ImageRole::Sampled && matches!(extent, Extent::D3(..)) {
        return Err(GpuError::usage(label, "a 3D image cannot be drawn into"));
    }
    Ok(extent.texels().saturating_mul(texel))
}

/// The device's limit for images of as many dimensions.
fn longest_edge(device: &Device, extent: Extent) -> u32 {
    let limits = &device.info().limits;
    match extent {
        Extent::D1(..) => limits.image_dimension_1d,
        Extent::D2(..) => limits.image_dimension_2d,
        Extent::D3(..) => limits.image_dimension_3d,
    }
}
