//! Samples side by side, as arrays that compilers turn into vectors: those of a few neighbouring rays at a few planes in turn.

/// Rays of a bundle: neighbours in a row of pixels.
pub const RAYS: usize = 4;

/// Planes of a bundle, the first of which has a number that is a multiple of it.
pub const STEPS: usize = 8;

/// Samples of a bundle. The sample of ray `r` at plane `s` is number `s · RAYS + r`.
pub const SAMPLES: usize = RAYS * STEPS;

/// A number of each sample.
pub type Lanes = [f32; SAMPLES];

/// What `f` makes of each sample.
#[inline(always)]
pub fn each(f: impl Fn(usize) -> f32) -> Lanes {
    let mut lanes = [0.0; SAMPLES];
    for (n, lane) in lanes.iter_mut().enumerate() {
        *lane = f(n);
    }
    lanes
}

/// The whole number nearest to `x`, less than 2²², as an integer. Vectors have no conversion that saturates as `as` does.
#[inline(always)]
pub fn whole_f32(x: f32) -> i32 {
    const FIRST: f32 = 1.5 * (1 << 23) as f32;
    ((x + FIRST).to_bits() as i32).wrapping_sub(FIRST.to_bits() as i32)
}

/// The whole number nearest to `x`, less than 2³¹, as an integer.
#[inline(always)]
pub fn whole_f64(x: f64) -> i32 {
    const FIRST: f64 = 1.5 * (1u64 << 52) as f64;
    (x + FIRST).to_bits() as i32
}
