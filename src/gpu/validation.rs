//! The validation layer, with synchronization validation, and the messages it gives.

use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

use ash::{Entry, ext::debug_utils, vk};

use super::GpuError;

/// Whether Vulkan's validation layer watches every call. It costs time; tests run with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Validation {
    /// Nobody watches.
    #[default]
    Off,
    /// The layer and its synchronization validation watch; messages are collected.
    On,
}

pub(super) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The messages so far. Boxed, so that the messenger's pointer to it stays good when the owner moves.
pub(super) type Messages = Box<Mutex<Vec<String>>>;

/// Is the layer installed?
pub(super) fn require_layer(entry: &Entry) -> Result<(), GpuError> {
    // SAFETY: the loader is loaded; the call has no other precondition.
    let layers = unsafe { entry.enumerate_instance_layer_properties() };
    let layers = layers.map_err(GpuError::vulkan("list the layers"))?;
    let found = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER));
    found.then_some(()).ok_or(GpuError::NoValidationLayer)
}

/// How warnings and errors reach `messages`, which must outlive every messenger made with this.
pub(super) fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Kind};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Kind::VALIDATION | Kind::PERFORMANCE)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(&**messages).cast_mut().cast())
}

/// The messenger's callback: keeps the text.
///
/// # Safety
/// Called by Vulkan alone, with its own callback data and the pointer that [`messenger_info`] was given.
unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid callback data, whose message is null or a C string.
    let text = unsafe { data.as_ref() }.and_then(|data| (!data.p_message.is_null()).then_some(data.p_message));
    // SAFETY: as above.
    let text = text.map(|text| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned());
    // SAFETY: `user` is the pointer given in `messenger_info`, to a mutex that outlives the messenger.
    let messages = unsafe { user.cast::<Mutex<Vec<String>>>().as_ref() };
    if let (Some(messages), Some(text)) = (messages, text) {
        messages
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(format!("{severity:?}: {text}"));
    }
    vk::FALSE
}

/// A live messenger and the functions that go with it.
pub(super) struct Messenger {
    functions: debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
}

impl Messenger {
    /// Starts to collect into `messages`, which must live longer than the messenger.
    pub(super) fn new(entry: &Entry, instance: &ash::Instance, messages: &Messages) -> Result<Self, GpuError> {
        let functions = debug_utils::Instance::new(entry, instance);
        // SAFETY: the extension was enabled on `instance`; the info's pointers are good (see `messenger_info`).
        let handle = unsafe { functions.create_debug_utils_messenger(&messenger_info(messages), None) };
        let handle = handle.map_err(GpuError::vulkan("create the debug messenger"))?;
        Ok(Self { functions, handle })
    }
}

impl Drop for Messenger {
    fn drop(&mut self) {
        // SAFETY: made by these functions, destroyed once, before its instance (see `Instance::drop`).
        unsafe { self.functions.destroy_debug_utils_messenger(self.handle, None) };
    }
}

#[cfg(test)]
mod tests {
    use ash::vk;

    use crate::gpu::{Buffer, BufferRole, Device, DeviceSelector, GpuError, Instance, Requirements, Validation};

    /// Records two writes of one buffer, with or without a barrier between them, and returns the messages.
    fn messages_of_two_writes(barrier: Option<vk::MemoryBarrier2>) -> Result<Vec<String>, GpuError> {
        let instance = Instance::new(Validation::On)?;
        let device = Device::open(&instance, &DeviceSelector::Default, &Requirements::default())?;
        let buffer = Buffer::new(&device, "written twice", BufferRole::Device, 64)?;
        let (raw, failed) = (device.raw(), GpuError::vulkan("record"));
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(device.family());
        // SAFETY: one thread records into one command buffer of one pool, which goes before the buffer and the device.
        let recorded = unsafe {
            let pool = raw
                .create_command_pool(&pool, None)
                .map_err(GpuError::vulkan("record"))?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .command_buffer_count(1);
            let recorded = raw.allocate_command_buffers(&info).and_then(|commands| {
                raw.begin_command_buffer(commands[0], &vk::CommandBufferBeginInfo::default())?;
                raw.cmd_fill_buffer(commands[0], buffer.raw(), 0, 64, 1);
                let barriers: Vec<_> = barrier.into_iter().collect();
                let info = vk::DependencyInfo::default().memory_barriers(&barriers);
                raw.cmd_pipeline_barrier2(commands[0], &info);
                raw.cmd_fill_buffer(commands[0], buffer.raw(), 0, 64, 2);
                raw.end_command_buffer(commands[0])
            });
            raw.destroy_command_pool(pool, None);
            recorded
        };
        recorded.map_err(failed)?;
        Ok(instance.messages())
    }

    #[test]
    fn a_missing_barrier_is_noticed() {
        let messages = messages_of_two_writes(None).expect("a device: run `make setup`");
        assert!(
            messages.iter().any(|text| text.contains("SYNC-HAZARD-WRITE")),
            "{messages:?}"
        );
        assert!(
            messages.iter().any(|text| text.contains("written twice")),
            "objects have names: {messages:?}"
        );
    }

    #[test]
    fn a_barrier_silences_it() {
        let (stage, access) = (vk::PipelineStageFlags2::ALL_TRANSFER, vk::AccessFlags2::TRANSFER_WRITE);
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(stage)
            .src_access_mask(access);
        let barrier = barrier.dst_stage_mask(stage).dst_access_mask(access);
        let messages = messages_of_two_writes(Some(barrier)).expect("a device: run `make setup`");
        assert_eq!(messages, Vec::<String>::new());
    }
}
