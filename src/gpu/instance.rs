//! Vulkan itself, loaded at run time.

use std::ffi::CStr;
use std::sync::{Arc, PoisonError};

use ash::{Entry, ext, vk};

use super::validation::{LAYER, Messages, Messenger, messenger_info, require_layer};
use super::{DeviceInfo, GpuError, Requirements, Validation};

/// The connection to Vulkan. The first thing made, the last thing gone.
pub struct Instance {
    /// `None` without validation. Dropped before the instance is destroyed.
    messenger: Option<Messenger>,
    raw: ash::Instance,
    messages: Messages,
    /// Keeps the loader's library open; declared last, so it is dropped last.
    _entry: Entry,
}

impl Instance {
    /// Loads Vulkan and makes an instance.
    ///
    /// # Errors
    /// [`GpuError::NoLoader`], [`GpuError::OldLoader`], [`GpuError::NoValidationLayer`], or what Vulkan says.
    pub fn new(validation: Validation) -> Result<Arc<Self>, GpuError> {
        // SAFETY: loading the system's Vulkan library runs its initialisers, which are trusted as the system is.
        let entry = unsafe { Entry::load() }.map_err(|error| GpuError::NoLoader(error.to_string()))?;
        require_version(&entry)?;
        let messages = Messages::default();
        let raw = create(&entry, validation, &messages)?;
        let mut instance = Self {
            messenger: None,
            raw,
            messages,
            _entry: entry,
        };
        if validation == Validation::On {
            instance.messenger = Some(Messenger::new(&instance._entry, &instance.raw, &instance.messages)?);
        }
        Ok(Arc::new(instance))
    }

    /// Every device, in Vulkan's order, and what each lacks of `requirements`.
    ///
    /// # Errors
    /// What Vulkan says.
    pub fn devices(&self, requirements: &Requirements) -> Result<Vec<DeviceInfo>, GpuError> {
        let physical = self.physical_devices()?;
        Ok(physical
            .iter()
            .enumerate()
            .map(|(index, &device)| DeviceInfo::read(self, index, device, requirements))
            .collect())
    }

    /// The warnings and errors of the validation layer so far; empty without validation.
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Takes the messages out, so that a test can look at its own.
    pub fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut self.messages.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(super) fn physical_devices(&self) -> Result<Vec<vk::PhysicalDevice>, GpuError> {
        // SAFETY: the instance is alive.
        unsafe { self.raw.enumerate_physical_devices() }.map_err(GpuError::vulkan("list the devices"))
    }

    pub(super) fn raw(&self) -> &ash::Instance {
        &self.raw
    }

    pub(super) fn validates(&self) -> bool {
        self.messenger.is_some()
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.messenger = None;
        // SAFETY: every device holds an `Arc` of this, so none is left; the messenger is gone.
        unsafe { self.raw.destroy_instance(None) };
    }
}

fn require_version(entry: &Entry) -> Result<(), GpuError> {
    // SAFETY: the loader is loaded.
    let version = unsafe { entry.try_enumerate_instance_version() }.map_err(GpuError::vulkan("read the version"))?;
    let version = version.unwrap_or(vk::API_VERSION_1_0);
    if version < vk::API_VERSION_1_3 {
        return Err(GpuError::OldLoader(version_text(version)));
    }
    Ok(())
}

fn create(entry: &Entry, validation: Validation, messages: &Messages) -> Result<ash::Instance, GpuError> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"vcsg")
        .api_version(vk::API_VERSION_1_3);
    let mut messenger = messenger_info(messages);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let layers = [LAYER.as_ptr()];
    let extensions: [&CStr; 2] = [ext::debug_utils::NAME, ext::validation_features::NAME];
    let extensions = extensions.map(CStr::as_ptr);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    if validation == Validation::On {
        require_layer(entry)?;
        info = info.enabled_layer_names(&layers).enabled_extension_names(&extensions);
        info = info.push_next(&mut messenger).push_next(&mut features);
    }
    // SAFETY: everything `info` points to lives until the call returns, `messages` longer than the instance.
    unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => GpuError::NoDevice,
        _ => GpuError::vulkan("create an instance")(result),
    })
}

/// `1.3.239` of Vulkan's packed version.
pub(super) fn version_text(version: u32) -> String {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    format!("{major}.{minor}.{}", vk::api_version_patch(version))
}
