//! An open device: its queue, its memory, and the count of work it has finished.

use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::{ext::debug_utils, vk};
use gpu_allocator::AllocationSizes;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::info::graphics_family;
use super::{DeviceInfo, DeviceSelector, Feature, GpuError, Instance, Requirements};

/// An open device. Every object made on it holds it.
pub struct Device {
    raw: ash::Device,
    /// Freed before the device is destroyed.
    allocator: ManuallyDrop<Mutex<Allocator>>,
    queue: Mutex<Queue>,
    timeline: vk::Semaphore,
    family: u32,
    names: Option<debug_utils::Device>,
    physical: vk::PhysicalDevice,
    info: DeviceInfo,
    /// Declared last: the instance goes after everything of the device.
    instance: Arc<Instance>,
}

/// The queue, and the timeline value of the last submission to it.
pub(super) struct Queue {
    pub(super) raw: vk::Queue,
    pub(super) submitted: u64,
}

impl Device {
    /// Opens the device that `selector` chooses.
    ///
    /// # Errors
    /// [`GpuError::NoDevice`], [`GpuError::NoSuchDevice`], [`GpuError::Lacking`], or what Vulkan says.
    pub fn open(
        instance: &Arc<Instance>,
        selector: &DeviceSelector,
        needs: &Requirements,
    ) -> Result<Arc<Self>, GpuError> {
        let devices = instance.devices(needs)?;
        let info = selector.choose(&devices)?.clone();
        let physical = instance
            .physical_devices()?
            .get(info.index)
            .copied()
            .ok_or(GpuError::NoDevice)?;
        let family = graphics_family(instance, physical);
        let (true, Some(family)) = (info.missing.is_empty(), family) else {
            return Err(GpuError::Lacking {
                device: info.name,
                missing: info.missing,
            });
        };
        let raw = create(instance, physical, family, needs)?;
        Self::assemble(instance, info, physical, family, raw).map(Arc::new)
    }

    fn assemble(
        instance: &Arc<Instance>,
        info: DeviceInfo,
        physical: vk::PhysicalDevice,
        family: u32,
        raw: ash::Device,
    ) -> Result<Self, GpuError> {
        // SAFETY: the device was made with one queue of this family.
        let queue = unsafe { raw.get_device_queue(family, 0) };
        let made = allocator(instance, physical, &raw).and_then(|memory| Ok((memory, timeline(&raw)?)));
        // SAFETY: on failure nothing of the device is left but itself.
        let (memory, timeline) = made.inspect_err(|_| unsafe { raw.destroy_device(None) })?;
        Ok(Self {
            names: instance
                .validates()
                .then(|| debug_utils::Device::new(instance.raw(), &raw)),
            raw,
            allocator: ManuallyDrop::new(Mutex::new(memory)),
            queue: Mutex::new(Queue {
                raw: queue,
                submitted: 0,
            }),
            timeline,
            family,
            physical,
            info,
            instance: Arc::clone(instance),
        })
    }

    /// What the device is.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// The instance it is of.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Waits until all that was submitted is done.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], or what Vulkan says.
    pub fn wait_idle(&self) -> Result<(), GpuError> {
        let submitted = self.queue().submitted;
        self.wait_for(submitted, Duration::MAX).map(drop)
    }

    /// Waits until the timeline has reached `value`; false if `timeout` passes first.
    pub(super) fn wait_for(&self, value: u64, timeout: Duration) -> Result<bool, GpuError> {
        let (semaphores, values) = ([self.timeline], [value]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        let nanoseconds = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
        // SAFETY: the semaphore is this device's.
        match unsafe { self.raw.wait_semaphores(&info, nanoseconds) } {
            Ok(()) => Ok(true),
            Err(vk::Result::TIMEOUT) => Ok(false),
            Err(result) => Err(GpuError::vulkan("wait for the device")(result)),
        }
    }

    pub(super) fn raw(&self) -> &ash::Device {
        &self.raw
    }

    pub(super) fn physical(&self) -> vk::PhysicalDevice {
        self.physical
    }

    pub(super) fn family(&self) -> u32 {
        self.family
    }

    pub(super) fn timeline(&self) -> vk::Semaphore {
        self.timeline
    }

    pub(super) fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Names `handle` in validation messages; nothing without validation.
    pub(super) fn name<H: vk::Handle>(&self, handle: H, label: &str) {
        let (Some(names), Ok(label)) = (&self.names, std::ffi::CString::new(label)) else {
            return;
        };
        let info = vk::DebugUtilsObjectNameInfoEXT::default()
            .object_handle(handle)
            .object_name(&label);
        // SAFETY: `handle` is a live object of this device. A name is a help only, so a failure is of no concern.
        let _ = unsafe { names.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: every object and submission holds the device, so nothing of it is in use; the allocator is dropped once,
        // here, before the device. A lost device may fail to wait, and has nothing running either.
        unsafe {
            let _ = self.raw.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_semaphore(self.timeline, None);
            self.raw.destroy_device(None);
        }
    }
}

fn create(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    family: u32,
    needs: &Requirements,
) -> Result<ash::Device, GpuError> {
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(family)
        .queue_priorities(&[1.0])];
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default().timeline_semaphore(true);
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .maintenance4(true)
        .synchronization2(true);
    let needed = |feature| needs.features.contains(&feature);
    // Robust access makes an index beyond its buffer harmless, so that callers need no `unsafe`.
    let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
    let features = features
        .independent_blend(needed(Feature::IndependentBlend))
        .fragment_stores_and_atomics(needed(Feature::FragmentStores));
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features);
    let info = info.push_next(&mut v12).push_next(&mut v13);
    // SAFETY: `physical` is of this instance and has the features (it lacks nothing of `needs`).
    let device = unsafe { instance.raw().create_device(physical, &info, None) };
    device.map_err(GpuError::vulkan("open the device"))
}

fn allocator(instance: &Instance, physical: vk::PhysicalDevice, raw: &ash::Device) -> Result<Allocator, GpuError> {
    let desc = AllocatorCreateDesc {
        instance: instance.raw().clone(),
        device: raw.clone(),
        physical_device: physical,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: AllocationSizes::new(16 << 20, 16 << 20)
            .with_max_device_memblock_size(256 << 20)
            .with_max_host_memblock_size(64 << 20),
    };
    Allocator::new(&desc).map_err(|error| GpuError::usage("the memory allocator", error.to_string()))
}

fn timeline(raw: &ash::Device) -> Result<vk::Semaphore, GpuError> {
    let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
    let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
    // SAFETY: the feature was enabled.
    unsafe { raw.create_semaphore(&info, None) }.map_err(GpuError::vulkan("create the timeline"))
}
