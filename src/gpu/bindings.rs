//! What shaders read besides vertices: one descriptor set, bindings 0, 1, 2, …

use std::sync::Arc;

use ash::vk;

use super::access::Use;
use super::{Buffer, BufferRole, Device, GpuError, Image, Sampler};

/// The sort of one binding, as a pipeline declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// `uniform sampler1D`, `sampler2D` or `sampler3D`.
    SampledImage,
    /// A `uniform` structure (std140).
    Uniform,
    /// A `readonly buffer` structure (std430).
    Storage,
    /// A `writeonly buffer` structure (std430) of fragment shaders; see [`Feature::FragmentStores`](super::Feature::FragmentStores).
    WrittenStorage,
}

/// One binding.
#[derive(Clone)]
pub enum Binding {
    /// An image and how it is sampled.
    SampledImage(Arc<Image>, Arc<Sampler>),
    /// A buffer read as uniform data, whole.
    Uniform(Arc<Buffer>),
    /// A buffer read as storage data, whole.
    Storage(Arc<Buffer>),
    /// A buffer written as storage data, whole.
    WrittenStorage(Arc<Buffer>),
}

impl Binding {
    /// Its sort.
    pub fn kind(&self) -> BindingKind {
        match self {
            Self::SampledImage(..) => BindingKind::SampledImage,
            Self::Uniform(_) => BindingKind::Uniform,
            Self::Storage(_) => BindingKind::Storage,
            Self::WrittenStorage(_) => BindingKind::WrittenStorage,
        }
    }

    /// A buffer may be larger than what shaders can see of it.
    fn require_size(&self, device: &Device) -> Result<(), GpuError> {
        let limits = &device.info().limits;
        let (buffer, what, limit) = match self {
            Self::SampledImage(..) => return Ok(()),
            Self::Uniform(buffer) => (buffer, "bytes of uniform data", limits.uniform_bytes),
            Self::Storage(buffer) | Self::WrittenStorage(buffer) => {
                (buffer, "bytes of storage data", limits.storage_bytes)
            }
        };
        let (label, asked, limit) = (buffer.label().to_owned(), buffer.bytes(), u64::from(limit));
        if asked > limit {
            Err(GpuError::TooLarge {
                label,
                what,
                asked,
                limit,
            })
        } else {
            Ok(())
        }
    }

    /// What the host writes, shaders only read.
    fn require_role(&self) -> Result<(), GpuError> {
        match self {
            Self::WrittenStorage(buffer) if buffer.role() == BufferRole::Upload => Err(GpuError::usage(
                buffer.label(),
                "an upload buffer cannot be written by shaders",
            )),
            _ => Ok(()),
        }
    }

    fn is_on(&self, device: &Device) -> bool {
        match self {
            Self::SampledImage(image, _) => image.is_on(device),
            Self::Uniform(buffer) | Self::Storage(buffer) | Self::WrittenStorage(buffer) => buffer.is_on(device),
        }
    }
}

impl BindingKind {
    fn descriptor(self) -> vk::DescriptorType {
        match self {
            Self::SampledImage => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Storage | Self::WrittenStorage => vk::DescriptorType::STORAGE_BUFFER,
        }
    }

    /// How shaders touch what is bound.
    pub(super) fn usage(self) -> Use {
        match self {
            Self::SampledImage => Use::Sample,
            Self::Uniform => Use::ReadUniform,
            Self::Storage => Use::ReadStorage,
            Self::WrittenStorage => Use::WriteStorage,
        }
    }
}

/// A descriptor set that holds what it binds. Fits every pipeline that declares the same kinds in the same order.
pub struct Bindings {
    device: Arc<Device>,
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    entries: Vec<Binding>,
}

impl Bindings {
    /// Binds `entries` to the bindings 0, 1, 2, … of set 0.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for no entries, those of another device, or an upload buffer to be written; [`GpuError::TooLarge`]; or what
    /// Vulkan says.
    pub fn new(device: &Arc<Device>, label: &str, entries: &[Binding]) -> Result<Arc<Self>, GpuError> {
        if entries.is_empty() || !entries.iter().all(|entry| entry.is_on(device)) {
            return Err(GpuError::usage(label, "bindings need entries, all of the same device"));
        }
        entries.iter().try_for_each(|entry| entry.require_size(device))?;
        entries.iter().try_for_each(Binding::require_role)?;
        let kinds: Vec<_> = entries.iter().map(Binding::kind).collect();
        let mut bindings = Self {
            device: Arc::clone(device),
            layout: set_layout(device, label, &kinds)?,
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            entries: entries.to_vec(),
        };
        bindings.pool = pool(device, label, &kinds)?;
        bindings.allocate(label)?;
        bindings
            .entries
            .iter()
            .zip(0..)
            .for_each(|(entry, slot)| bindings.update(slot, entry));
        Ok(Arc::new(bindings))
    }

    fn allocate(&mut self, label: &str) -> Result<(), GpuError> {
        let layouts = [self.layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.pool)
            .set_layouts(&layouts);
        // SAFETY: pool and layout are of this device, and the pool has room for just this set.
        let sets =
            unsafe { self.device.raw().allocate_descriptor_sets(&info) }.map_err(GpuError::creating(label, 0))?;
        self.set = sets.first().copied().unwrap_or_default();
        self.device.name(self.set, label);
        Ok(())
    }

    fn update(&self, slot: u32, entry: &Binding) {
        let write = vk::WriteDescriptorSet::default().dst_set(self.set).dst_binding(slot);
        let write = write.descriptor_type(entry.kind().descriptor());
        let (image, buffer);
        let write = match entry {
            Binding::SampledImage(texture, sampler) => {
                let info = vk::DescriptorImageInfo::default()
                    .image_view(texture.view())
                    .sampler(sampler.raw());
                image = [info.image_layout(Use::Sample.layout())];
                write.image_info(&image)
            }
            Binding::Uniform(data) | Binding::Storage(data) | Binding::WrittenStorage(data) => {
                buffer = [vk::DescriptorBufferInfo::default()
                    .buffer(data.raw())
                    .range(vk::WHOLE_SIZE)];
                write.buffer_info(&buffer)
            }
        };
        // SAFETY: the set is new, so no command uses it; what it names is alive and of the declared kind.
        unsafe { self.device.raw().update_descriptor_sets(&[write], &[]) };
    }

    /// What is bound.
    pub fn entries(&self) -> &[Binding] {
        &self.entries
    }

    pub(super) fn set(&self) -> vk::DescriptorSet {
        self.set
    }

    pub(super) fn is_on(&self, device: &Device) -> bool {
        std::ptr::eq(&*self.device, device)
    }
}

impl Drop for Bindings {
    fn drop(&mut self) {
        // SAFETY: submissions hold their bindings, so the device is done with them; the set goes with its pool, and a null
        // pool is ignored.
        unsafe {
            self.device.raw().destroy_descriptor_pool(self.pool, None);
            self.device.raw().destroy_descriptor_set_layout(self.layout, None);
        }
    }
}

/// The layout of set 0 with these kinds, seen by vertex and fragment shaders.
pub(super) fn set_layout(
    device: &Device,
    label: &str,
    kinds: &[BindingKind],
) -> Result<vk::DescriptorSetLayout, GpuError> {
    let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
    let slot = |(kind, slot): (&BindingKind, u32)| {
        let binding = vk::DescriptorSetLayoutBinding::default()
            .binding(slot)
            .descriptor_type(kind.descriptor());
        binding.descriptor_count(1).stage_flags(stages)
    };
    let slots: Vec<_> = kinds.iter().zip(0..).map(slot).collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
    // SAFETY: the device is alive and the info whole.
    unsafe { device.raw().create_descriptor_set_layout(&info, None) }.map_err(GpuError::creating(label, 0))
}

fn pool(device: &Device, label: &str, kinds: &[BindingKind]) -> Result<vk::DescriptorPool, GpuError> {
    let size = |kind: &BindingKind| {
        vk::DescriptorPoolSize::default()
            .ty(kind.descriptor())
            .descriptor_count(1)
    };
    let sizes: Vec<_> = kinds.iter().map(size).collect();
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
    // SAFETY: the device is alive and the info whole.
    unsafe { device.raw().create_descriptor_pool(&info, None) }.map_err(GpuError::creating(label, 0))
}
