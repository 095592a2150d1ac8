//! Samples side by side, as arrays that compilers turn into vectors.

/// Samples of a ray that are taken together.
pub const LANES: usize = 8;

/// A number of each sample.
pub type Lanes = [f32; LANES];

/// What `f` makes of each lane.
#[inline(always)]
pub fn each(f: impl Fn(usize) -> f32) -> Lanes {
    let mut lanes = [0.0; LANES];
    for (n, lane) in lanes.iter_mut().enumerate() {
        *lane = f(n);
    }
    lanes
}

/// Lane by lane from `a` to `b`. Between equal numbers it is that number.
#[inline(always)]
pub fn lerp(a: &Lanes, b: &Lanes, t: &Lanes) -> Lanes {
    each(|n| a[n] + t[n] * (b[n] - a[n]))
}
