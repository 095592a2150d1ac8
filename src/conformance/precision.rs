//! What a device promises about its arithmetic: the only source of every bound.
//!
//! *Theory.* Vulkan states fraction bits of vertex positions (`subPixelPrecisionBits`) and of texture coordinates
//! (`subTexelPrecisionBits`), an accuracy of "about 1 part in 10⁵" for floating point outside shaders (Fundamentals), and units
//! in the last place for each operation of a shader (Precision and Operation of SPIR-V Instructions). It states none for
//! the weighted sum of texels; three successive linear interpolations rounded either way at the format's bits are the
//! coarsest thing that filters at those bits, so a sum may be off by three steps of the format.
//! *Practice.* [`Precision::least`] is that minimum. [`Precision::single`] is what a unit computing in single precision
//! keeps: a device outside it but within the minimum is coarse, not wrong.

use crate::gpu::DeviceLimits;

/// One rounding of a single-precision result, either way, relative to it.
pub const ULP: f64 = 1.0 / (1u32 << 23) as f64;

/// The precision of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// The most that a vertex moves in x and in y when it is put on the rasteriser's grid, pixels.
    pub vertex_px: f64,
    /// The most that a weight of linear filtering is off.
    pub weight: f64,
    /// Error of an interpolated value, relative to the largest of a polygon.
    pub interpolated: f64,
    /// Error of a texture coordinate on its way to texels, relative to it.
    pub coordinate: f64,
    /// Error of a weighted sum of texels in steps of the format, for fixed-point formats.
    pub sum_steps: f64,
    /// Error of a weighted sum of texels relative to the largest of them, for all formats.
    pub sum: f64,
    /// The most that a part of a normal is off beside that.
    pub normals: f64,
}

impl Precision {
    /// What no device is: nothing beside the roundings of single precision that bounds have by themselves.
    pub const EXACT: Self = Self {
        vertex_px: 0.0,
        weight: 0.0,
        interpolated: 0.0,
        coordinate: 0.0,
        sum_steps: 0.0,
        sum: 0.0,
        normals: 0.0,
    };

    /// The least that Vulkan lets a device of these limits do.
    pub fn least(limits: &DeviceLimits) -> Self {
        // A product and a sum for each of the two edges along which a triangle is interpolated.
        const INTERPOLATION_STEPS: f64 = 4.0;
        const FIXED_FUNCTION: f64 = 1e-5;
        Self {
            interpolated: INTERPOLATION_STEPS * FIXED_FUNCTION,
            coordinate: FIXED_FUNCTION,
            sum_steps: 3.0,
            // Three interpolations of a product, a product and a sum each, in single precision at least.
            sum: 12.0 * ULP,
            ..Self::single(limits)
        }
    }

    /// What a device of these limits does that computes in single precision throughout.
    pub fn single(limits: &DeviceLimits) -> Self {
        let fraction = |bits: u32| 0.5f64.powi(bits.min(52) as i32);
        Self {
            vertex_px: fraction(limits.sub_pixel_bits),
            weight: fraction(limits.sub_texel_bits),
            // Two gradients, each a quotient of differences of products: eight roundings.
            interpolated: 8.0 * ULP,
            coordinate: 2.0 * ULP,
            sum_steps: 0.0,
            sum: 8.0 * ULP,
            normals: 0.0,
        }
    }
}
