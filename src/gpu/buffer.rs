//! Linear memory that host and device share or copy between.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::vk;
use gpu_allocator::{MemoryLocation, vulkan::Allocation};

use super::access::State;
use super::memory::{Holds, allocate, free};
use super::{Device, GpuError};

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferRole {
    /// The host writes; the device copies from it, or reads vertices, indices, uniform or storage data.
    Upload,
    /// The device copies into it, or shaders write storage data; the host reads.
    Readback,
    /// The device's own: filled by copies, then read as vertices, indices, uniform or storage data.
    Device,
}

/// A buffer. The host waits by itself for the device where both touch it.
pub struct Buffer {
    device: Arc<Device>,
    raw: vk::Buffer,
    bytes: u64,
    role: BufferRole,
    label: String,
    host: Mutex<Host>,
    state: Mutex<State>,
}

/// The memory, and the timeline value of the last submission that uses it.
pub(super) struct Host {
    /// `None` only while the buffer is made and dropped.
    allocation: Option<Allocation>,
    pub(super) last_use: u64,
}

impl Buffer {
    /// A buffer of `bytes` bytes, with undefined content.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for 0 bytes, [`GpuError::TooLarge`], [`GpuError::OutOfMemory`], or what Vulkan says.
    pub fn new(device: &Arc<Device>, label: &str, role: BufferRole, bytes: u64) -> Result<Arc<Self>, GpuError> {
        if bytes == 0 {
            return Err(GpuError::usage(label, "a buffer of 0 bytes"));
        }
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage(role));
        // SAFETY: the device is alive and the info whole.
        let raw = unsafe { device.raw().create_buffer(&info, None) }.map_err(GpuError::creating(label, bytes))?;
        let host = Mutex::new(Host {
            allocation: None,
            last_use: 0,
        });
        let (device, label) = (Arc::clone(device), label.to_owned());
        let buffer = Self {
            device,
            raw,
            bytes,
            role,
            label,
            host,
            state: Mutex::default(),
        };
        buffer.bind()?;
        buffer.device.name(raw, &buffer.label);
        Ok(Arc::new(buffer))
    }

    /// An upload buffer that holds `data`.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn with_data<T: bytemuck::Pod>(device: &Arc<Device>, label: &str, data: &[T]) -> Result<Arc<Self>, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = Self::new(device, label, BufferRole::Upload, bytes.len() as u64)?;
        buffer.write(0, bytes)?;
        Ok(buffer)
    }

    fn bind(&self) -> Result<(), GpuError> {
        // SAFETY: the buffer is this device's.
        let requirements = unsafe { self.device.raw().get_buffer_memory_requirements(self.raw) };
        let allocation = allocate(
            &self.device,
            &self.label,
            requirements,
            location(self.role),
            Holds::Buffer,
        )?;
        // SAFETY: the allocation fulfils the buffer's requirements and lives as long; the buffer is bound once.
        let bound = unsafe {
            self.device
                .raw()
                .bind_buffer_memory(self.raw, allocation.memory(), allocation.offset())
        };
        self.host().allocation = Some(allocation);
        bound.map_err(GpuError::creating(&self.label, self.bytes))
    }

    /// Writes `data` from byte `offset` on, after waiting for submissions that use the buffer.
    ///
    /// # Errors
    /// [`GpuError::Usage`] if it does not fit or the host cannot write here; [`GpuError::DeviceLost`].
    pub fn write(&self, offset: u64, data: &[u8]) -> Result<(), GpuError> {
        self.fill(|bytes| {
            let start = usize::try_from(offset).ok();
            let room = start.and_then(|start| bytes.get_mut(start..start.checked_add(data.len())?));
            room.map(|room| room.copy_from_slice(data))
        })?
        .ok_or_else(|| GpuError::usage(&self.label, format!("{} bytes at {offset} do not fit", data.len())))
    }

    /// Lets `fill` write all of the buffer, after waiting for submissions that use it. `fill` must not submit work that
    /// uses this buffer.
    ///
    /// # Errors
    /// [`GpuError::Usage`] if the host cannot write here; [`GpuError::DeviceLost`].
    pub fn fill<R>(&self, fill: impl FnOnce(&mut [u8]) -> R) -> Result<R, GpuError> {
        let mut host = self.idle_host(BufferRole::Upload)?;
        let size = usize::try_from(self.bytes).unwrap_or(usize::MAX);
        let bytes = host
            .allocation
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .and_then(|all| all.get_mut(..size));
        bytes.map(fill).ok_or_else(|| self.unmapped())
    }

    /// Lets `read` see all of the buffer, after waiting for submissions that use it.
    ///
    /// # Errors
    /// [`GpuError::Usage`] if the host cannot read here; [`GpuError::DeviceLost`].
    pub fn read<R>(&self, read: impl FnOnce(&[u8]) -> R) -> Result<R, GpuError> {
        // The allocator maps coherent memory only, so there is nothing to invalidate.
        let host = self.idle_host(BufferRole::Readback)?;
        let size = usize::try_from(self.bytes).unwrap_or(usize::MAX);
        let bytes = host
            .allocation
            .as_ref()
            .and_then(Allocation::mapped_slice)
            .and_then(|all| all.get(..size));
        bytes.map(read).ok_or_else(|| self.unmapped())
    }

    /// A copy of the content as values of `T`; a remainder shorter than one value is left out.
    ///
    /// # Errors
    /// As [`Buffer::read`].
    pub fn read_vec<T: bytemuck::Pod>(&self) -> Result<Vec<T>, GpuError> {
        let size = std::mem::size_of::<T>().max(1);
        self.read(|bytes| bytes.chunks_exact(size).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Its size in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What it is for.
    pub fn role(&self) -> BufferRole {
        self.role
    }

    /// Its name in messages.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The memory, once no submission uses it, if the role is `role`.
    fn idle_host(&self, role: BufferRole) -> Result<MutexGuard<'_, Host>, GpuError> {
        if self.role != role {
            return Err(self.unmapped());
        }
        let host = self.host();
        self.device.wait_for(host.last_use, Duration::MAX)?;
        Ok(host)
    }

    fn unmapped(&self) -> GpuError {
        GpuError::usage(
            &self.label,
            format!("the host cannot do this to a {:?} buffer", self.role),
        )
    }

    pub(super) fn host(&self) -> MutexGuard<'_, Host> {
        self.host.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn raw(&self) -> vk::Buffer {
        self.raw
    }

    pub(super) fn is_on(&self, device: &Device) -> bool {
        std::ptr::eq(&*self.device, device)
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submissions hold what they use, so the device is done with it; destroyed once.
        unsafe { self.device.raw().destroy_buffer(self.raw, None) };
        let allocation = self.host().allocation.take();
        if let Some(allocation) = allocation {
            free(&self.device, allocation);
        }
    }
}

fn usage(role: BufferRole) -> vk::BufferUsageFlags {
    use vk::BufferUsageFlags as U;
    let shader = U::VERTEX_BUFFER | U::INDEX_BUFFER | U::UNIFORM_BUFFER | U::STORAGE_BUFFER;
    match role {
        BufferRole::Upload => U::TRANSFER_SRC | shader,
        BufferRole::Readback => U::TRANSFER_DST | U::STORAGE_BUFFER,
        BufferRole::Device => U::TRANSFER_SRC | U::TRANSFER_DST | shader,
    }
}

fn location(role: BufferRole) -> MemoryLocation {
    match role {
        BufferRole::Upload => MemoryLocation::CpuToGpu,
        BufferRole::Readback => MemoryLocation::GpuToCpu,
        BufferRole::Device => MemoryLocation::GpuOnly,
    }
}
