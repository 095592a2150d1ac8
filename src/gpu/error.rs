//! What can go wrong on the way to and on a device, and what the user can do.

use ash::vk;

/// An error from Vulkan or from asking it for something impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The Vulkan loader library is missing.
    #[error("Vulkan cannot be loaded: {0}; install libvulkan1 and a driver, such as mesa-vulkan-drivers")]
    NoLoader(String),
    /// The loader is older than Vulkan 1.3.
    #[error("the Vulkan loader supports version {0}, at least 1.3 is needed; install a newer libvulkan1")]
    OldLoader(String),
    /// Validation was asked for, but its layer is not installed.
    #[error("the layer VK_LAYER_KHRONOS_validation is missing; install vulkan-validationlayers or turn validation off")]
    NoValidationLayer,
    /// There is no Vulkan device at all.
    #[error("no Vulkan device found; install a driver, such as mesa-vulkan-drivers")]
    NoDevice,
    /// No device fits the selector.
    #[error("no Vulkan device is {asked}; there are: {found}")]
    NoSuchDevice {
        /// The selector.
        asked: String,
        /// The devices there are.
        found: String,
    },
    /// The text does not say which device.
    #[error("{0:?} does not name a device; give an index, `uuid:` and 32 hexadecimal digits, or a part of its name")]
    BadSelector(String),
    /// The device lacks something that is required.
    #[error("the device {device} lacks {}", missing.join(", "))]
    Lacking {
        /// The device's name.
        device: String,
        /// Each thing it lacks.
        missing: Vec<String>,
    },
    /// The device or the host has not enough memory.
    #[error("out of memory: {}{label}", amount(*bytes))]
    OutOfMemory {
        /// What the memory was for.
        label: String,
        /// How much was asked for, in bytes; 0 if that is not known.
        bytes: u64,
    },
    /// A size is beyond what the device can do.
    #[error("{label} is too large: {what} {asked}, and the device's limit is {limit}")]
    TooLarge {
        /// The object.
        label: String,
        /// Which size.
        what: &'static str,
        /// The size asked for.
        asked: u64,
        /// The device's limit.
        limit: u64,
    },
    /// The device stopped working; every object made on it is lost.
    #[error("the Vulkan device was lost")]
    DeviceLost,
    /// A request that contradicts itself or the objects it names.
    #[error("{label}: {problem}")]
    Usage {
        /// The object.
        label: String,
        /// What is wrong.
        problem: String,
    },
    /// Any other error from Vulkan.
    #[error("Vulkan failed to {doing}: {result}")]
    Vulkan {
        /// What was being done.
        doing: String,
        /// Vulkan's result.
        result: vk::Result,
    },
}

impl GpuError {
    /// Turns Vulkan's `result` into an error that says what was being done.
    pub(super) fn vulkan(doing: &str) -> impl FnOnce(vk::Result) -> Self + '_ {
        move |result| match result {
            vk::Result::ERROR_DEVICE_LOST => Self::DeviceLost,
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => Self::OutOfMemory {
                label: doing.to_owned(),
                bytes: 0,
            },
            _ => Self::Vulkan {
                doing: doing.to_owned(),
                result,
            },
        }
    }

    /// As [`Self::vulkan`], for an object whose size in bytes is known.
    pub(super) fn creating(label: &str, bytes: u64) -> impl FnOnce(vk::Result) -> Self + '_ {
        move |result| match Self::vulkan(label)(result) {
            Self::OutOfMemory { label, .. } => Self::OutOfMemory { label, bytes },
            Self::Vulkan { doing, result } => Self::Vulkan {
                doing: format!("create {doing}"),
                result,
            },
            other => other,
        }
    }

    /// A request for `label` that cannot be granted.
    pub(super) fn usage(label: &str, problem: impl Into<String>) -> Self {
        Self::Usage {
            label: label.to_owned(),
            problem: problem.into(),
        }
    }
}

/// `N bytes for `, or nothing where the number is not known.
fn amount(bytes: u64) -> String {
    match bytes {
        0 => String::new(),
        _ => format!("{bytes} bytes for "),
    }
}
