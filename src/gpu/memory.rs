//! Memory for buffers and images, from the device's allocator.

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};

use super::{Device, GpuError};

/// Whether the memory holds a buffer or an image; the two must not share a page on some devices.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Holds {
    Buffer,
    Image,
}

/// Memory that fulfils `requirements`, or an error that says how much was asked for and what for.
pub(super) fn allocate(
    device: &Device,
    label: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    holds: Holds,
) -> Result<Allocation, GpuError> {
    let bytes = requirements.size;
    let limit = device.info().limits.allocation_bytes;
    if bytes > limit {
        return Err(GpuError::TooLarge {
            label: label.to_owned(),
            what: "bytes",
            asked: bytes,
            limit,
        });
    }
    let desc = AllocationCreateDesc {
        name: label,
        requirements,
        location,
        linear: holds == Holds::Buffer,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    device.allocator().allocate(&desc).map_err(|error| match error {
        AllocationError::OutOfMemory => GpuError::OutOfMemory {
            label: label.to_owned(),
            bytes,
        },
        other => GpuError::usage(label, format!("{bytes} bytes of memory: {other}")),
    })
}

/// Gives memory back.
pub(super) fn free(device: &Device, allocation: Allocation) {
    // Only a foreign allocation fails, and there is none.
    let _ = device.allocator().free(allocation);
}
