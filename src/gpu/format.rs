//! Sizes of the texel formats that images may have.

use ash::vk::Format;

/// Bytes a texel of `format`, or `None` for a format that this module does not make images of.
pub fn texel_bytes(format: Format) -> Option<u64> {
    Some(match format {
        Format::R8_UNORM | Format::R8_SNORM | Format::R8_UINT => 1,
        Format::R8G8_UNORM | Format::R8G8_SNORM => 2,
        Format::R16_UNORM | Format::R16_SNORM | Format::R16_SFLOAT | Format::R16_UINT => 2,
        Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SNORM | Format::R8G8B8A8_SRGB | Format::B8G8R8A8_UNORM => 4,
        Format::R16G16_UNORM | Format::R16G16_SNORM | Format::R16G16_SFLOAT => 4,
        Format::R32_SFLOAT | Format::R32_UINT | Format::D32_SFLOAT => 4,
        Format::R16G16B16A16_UNORM | Format::R16G16B16A16_SNORM | Format::R16G16B16A16_SFLOAT => 8,
        Format::R32G32_SFLOAT => 8,
        Format::R32G32B32A32_SFLOAT => 16,
        _ => return None,
    })
}
