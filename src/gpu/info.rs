//! What a device is, can do, and lacks.

use ash::vk;

use super::Instance;
use super::image::DEPTH_FORMAT;
use super::instance::version_text;

/// What a caller needs of a device beyond Vulkan 1.3's core.
#[derive(Clone, Copy, Debug, Default)]
pub struct Requirements<'a> {
    /// Formats of images that are filled by copies and sampled with linear filtering.
    pub sampled_linear: &'a [vk::Format],
    /// Formats of targets that are blended into and read back.
    pub blended: &'a [vk::Format],
    /// Optional features to require and turn on.
    pub features: &'a [Feature],
    /// The least edge of a 3D image, in texels.
    pub image_dimension_3d: u32,
}

/// An optional feature of the core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Each colour target of a pipeline may blend in its own way.
    IndependentBlend,
    /// Fragment shaders may write into buffers.
    FragmentStores,
}

/// The sort of a device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A card with its own memory.
    Discrete,
    /// Shares the host's memory.
    Integrated,
    /// A part of one, given to a virtual machine.
    Virtual,
    /// Runs on the host's processor.
    Cpu,
    /// Something else.
    Other,
}

/// The limits that callers plan with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceLimits {
    /// The longest edge of a 1D image, in texels.
    pub image_dimension_1d: u32,
    /// The longest edge of a 2D image, in texels.
    pub image_dimension_2d: u32,
    /// The longest edge of a 3D image, in texels.
    pub image_dimension_3d: u32,
    /// The most bytes of push constants.
    pub push_bytes: u32,
    /// The most colour targets of one pass.
    pub color_targets: u32,
    /// The most bytes of one uniform buffer.
    pub uniform_bytes: u32,
    /// The most bytes of one storage buffer.
    pub storage_bytes: u32,
    /// The most bytes of one allocation.
    pub allocation_bytes: u64,
    /// The bytes of the largest memory heap of the device.
    pub memory_bytes: u64,
    /// Fraction bits of a texture coordinate in linear filtering.
    pub sub_texel_bits: u32,
    /// Fraction bits of a vertex position on the screen.
    pub sub_pixel_bits: u32,
    /// Nanoseconds a timestamp tick, 0 where the device cannot time its work.
    pub timestamp_period_ns: f32,
}

/// One device.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceInfo {
    /// Its place in [`Instance::devices`].
    pub index: usize,
    /// Its name.
    pub name: String,
    /// The same for the same device and driver, over restarts.
    pub uuid: [u8; 16],
    /// Its sort.
    pub kind: DeviceKind,
    /// The driver's name.
    pub driver: String,
    /// The driver's version, in its own words.
    pub driver_version: String,
    /// The Vulkan version it supports.
    pub api_version: String,
    /// Its limits.
    pub limits: DeviceLimits,
    /// Each required thing that it lacks; empty if it can be opened.
    pub missing: Vec<String>,
}

impl DeviceInfo {
    /// Asks `device` what it is.
    pub(super) fn read(
        instance: &Instance,
        index: usize,
        device: vk::PhysicalDevice,
        requirements: &Requirements,
    ) -> Self {
        let mut ids = vk::PhysicalDeviceIDProperties::default();
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut all = vk::PhysicalDeviceProperties2::default();
        all = all
            .push_next(&mut ids)
            .push_next(&mut driver)
            .push_next(&mut maintenance);
        // SAFETY: `device` is of this instance.
        unsafe { instance.raw().get_physical_device_properties2(device, &mut all) };
        let properties = all.properties;
        let mut limits = limits(&properties.limits, maintenance.max_memory_allocation_size);
        limits.memory_bytes = memory_bytes(instance, device);
        Self {
            index,
            name: text(properties.device_name_as_c_str()),
            uuid: ids.device_uuid,
            kind: kind(properties.device_type),
            driver: text(driver.driver_name_as_c_str()),
            driver_version: text(driver.driver_info_as_c_str()),
            api_version: version_text(properties.api_version),
            limits,
            missing: missing(instance, device, &properties, requirements),
        }
    }

    /// The UUID as 8-4-4-4-12 hexadecimal digits.
    pub fn uuid_text(&self) -> String {
        let digits: String = self.uuid.iter().map(|byte| format!("{byte:02x}")).collect();
        [
            &digits[..8],
            &digits[8..12],
            &digits[12..16],
            &digits[16..20],
            &digits[20..],
        ]
        .join("-")
    }
}

fn text<E>(name: Result<&std::ffi::CStr, E>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn kind(device_type: vk::PhysicalDeviceType) -> DeviceKind {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

fn limits(limits: &vk::PhysicalDeviceLimits, allocation_bytes: u64) -> DeviceLimits {
    let timed = limits.timestamp_compute_and_graphics == vk::TRUE;
    DeviceLimits {
        image_dimension_1d: limits.max_image_dimension1_d,
        image_dimension_2d: limits.max_image_dimension2_d,
        image_dimension_3d: limits.max_image_dimension3_d,
        push_bytes: limits.max_push_constants_size,
        color_targets: limits.max_color_attachments,
        uniform_bytes: limits.max_uniform_buffer_range,
        storage_bytes: limits.max_storage_buffer_range,
        allocation_bytes,
        memory_bytes: 0,
        sub_texel_bits: limits.sub_texel_precision_bits,
        sub_pixel_bits: limits.sub_pixel_precision_bits,
        timestamp_period_ns: if timed { limits.timestamp_period } else { 0.0 },
    }
}

fn memory_bytes(instance: &Instance, device: vk::PhysicalDevice) -> u64 {
    // SAFETY: `device` is of this instance.
    let memory = unsafe { instance.raw().get_physical_device_memory_properties(device) };
    let local = |heap: &&vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
    memory
        .memory_heaps_as_slice()
        .iter()
        .filter(local)
        .map(|heap| heap.size)
        .max()
        .unwrap_or(0)
}

/// The first queue family that draws (and so copies), if any.
pub(super) fn graphics_family(instance: &Instance, device: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: `device` is of this instance.
    let families = unsafe { instance.raw().get_physical_device_queue_family_properties(device) };
    let draws = |family: &vk::QueueFamilyProperties| family.queue_flags.contains(vk::QueueFlags::GRAPHICS);
    families
        .iter()
        .position(draws)
        .and_then(|index| u32::try_from(index).ok())
}

fn missing(
    instance: &Instance,
    device: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
    requirements: &Requirements,
) -> Vec<String> {
    if properties.api_version < vk::API_VERSION_1_3 {
        return vec![format!("Vulkan 1.3 (it has {})", version_text(properties.api_version))];
    }
    let mut missing = missing_features(instance, device, requirements.features);
    if graphics_family(instance, device).is_none() {
        missing.push("a graphics queue".to_owned());
    }
    let (has, needed) = (
        properties.limits.max_image_dimension3_d,
        requirements.image_dimension_3d,
    );
    if has < needed {
        missing.push(format!("maxImageDimension3D {needed} (it has {has})"));
    }
    missing.extend(missing_formats(instance, device, requirements));
    missing
}

fn missing_features(instance: &Instance, device: vk::PhysicalDevice, features: &[Feature]) -> Vec<String> {
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut all = vk::PhysicalDeviceFeatures2::default()
        .push_next(&mut v12)
        .push_next(&mut v13);
    // SAFETY: `device` is of this instance and supports 1.3, to which the chained structures belong.
    unsafe { instance.raw().get_physical_device_features2(device, &mut all) };
    let (independent, stores) = (all.features.independent_blend, all.features.fragment_stores_and_atomics);
    let core = [
        ("timelineSemaphore", v12.timeline_semaphore),
        ("dynamicRendering", v13.dynamic_rendering),
        ("maintenance4", v13.maintenance4),
        ("synchronization2", v13.synchronization2),
    ];
    let asked = features.iter().map(|feature| match feature {
        Feature::IndependentBlend => ("independentBlend", independent),
        Feature::FragmentStores => ("fragmentStoresAndAtomics", stores),
    });
    let absent = core.into_iter().chain(asked).filter(|&(_, has)| has == vk::FALSE);
    absent.map(|(name, _)| format!("the feature {name}")).collect()
}

fn missing_formats(instance: &Instance, device: vk::PhysicalDevice, requirements: &Requirements) -> Vec<String> {
    use vk::FormatFeatureFlags as F;
    let sampled = [
        (F::SAMPLED_IMAGE_FILTER_LINEAR, "linear filtering"),
        (F::TRANSFER_DST, "copies into"),
    ];
    let blended = [(F::COLOR_ATTACHMENT_BLEND, "blending"), (F::TRANSFER_SRC, "copies out")];
    let lacks = |format: vk::Format, needs: [(F, &'static str); 2]| {
        // SAFETY: `device` is of this instance.
        let has = unsafe { instance.raw().get_physical_device_format_properties(device, format) };
        let absent = needs
            .into_iter()
            .filter(move |need| !has.optimal_tiling_features.contains(need.0));
        absent.map(move |(_, what)| format!("{what} of {format:?}"))
    };
    let depth = lacks(DEPTH_FORMAT, [(F::DEPTH_STENCIL_ATTACHMENT, "depth tests"); 2]).take(1);
    let sampled = requirements
        .sampled_linear
        .iter()
        .flat_map(|&format| lacks(format, sampled));
    sampled
        .chain(requirements.blended.iter().flat_map(|&format| lacks(format, blended)))
        .chain(depth)
        .collect()
}
