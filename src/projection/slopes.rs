//! How steeply a lattice of heights rises at its voxels: half the difference of neighbours along each axis, smoothed across it.
//!
//! *Theory.* Let the heights be f(n·x), a wave of any profile in the direction n. Half the difference of neighbours along axis a is,
//! to the third order, `f′ nₐ + f‴ nₐ³/6`: less steep, where f bends, along the axes that n is near to. Smoothing across by weights
//! of variance σ² adds `f‴ nₐ (1 − nₐ²) σ²/2`. With σ² = ⅓ both together are `nₐ (f′ + f‴/6)`: too flat still, and in the right
//! direction. The weights ⅙, ⅔, ⅙ have that variance.
//! *Changes from the paper.* WK94 takes central differences alone, and says that looking farther around would be better. For a plane
//! face under a filter of two voxels' radius they turn the normal by up to 3.5°, these by up to 0.35°. Noise is smoothed too.
//! *Practice.* [`half_differences`] is what is meant, [`Slopes`] the same of a row in single precision. Both look one voxel around.

use glam::{DVec3, Vec3};

/// The weight of each neighbour across; the middle has what is left.
const ASIDE: f64 = 1.0 / 6.0;

/// Half the differences along the three axes, where `height` is asked for the height so many voxels away.
pub fn half_differences(height: impl Fn([i64; 3]) -> f64) -> DVec3 {
    let weight = |by: i64| if by == 0 { 1.0 - 2.0 * ASIDE } else { ASIDE };
    let along = |axis: usize| {
        let mut sum = 0.0;
        for n in 0..9 {
            let [b, c] = [n % 3 - 1, n / 3 - 1];
            let at = |by: i64| {
                let mut at = [0; 3];
                (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (by, b, c);
                height(at)
            };
            sum += weight(b) * weight(c) * 0.5 * (at(1) - at(-1));
        }
        sum
    };
    DVec3::new(along(0), along(1), along(2))
}

/// [`half_differences`] of rows of voxels, one row after another.
#[derive(Clone, Debug, Default)]
pub struct Slopes {
    /// Of each voxel of a row and of one more at both ends: the height smoothed along y and z, the difference along y smoothed
    /// along z, and the difference along z smoothed along y.
    across: [Vec<f32>; 3],
}

impl Slopes {
    /// Those of the row that begins at voxel `begin` of `heights`, a lattice of `dims` voxels, in which the row has neighbours on
    /// all sides.
    pub fn of_row(&mut self, heights: &[f32], dims: [usize; 3], begin: usize, slopes: &mut [Vec3]) {
        self.cross(heights, dims, begin - 1, slopes.len() + 2);
        let [height, along_y, along_z] = &self.across;
        let rows = height.windows(3).zip(along_y.windows(3)).zip(along_z.windows(3));
        for (slope, ((h, y), z)) in slopes.iter_mut().zip(rows) {
            *slope = 0.5 * Vec3::new(h[2] - h[0], smoothed(y[0], y[1], y[2]), smoothed(z[0], z[1], z[2]));
        }
    }

    fn cross(&mut self, heights: &[f32], dims: [usize; 3], begin: usize, len: usize) {
        let (y, z) = (dims[0], dims[0] * dims[1]);
        let row = |dy: usize, dz: usize| &heights[begin + dy * y + dz * z - y - z..][..len];
        let [[a, b, c], [d, e, f], [g, h, i]] = [0, 1, 2].map(|dz| [0, 1, 2].map(|dy| row(dy, dz)));
        self.across.iter_mut().for_each(|across| across.resize(len, 0.0));
        let [height, along_y, along_z] = &mut self.across;
        let (height, along_y, along_z) = (&mut height[..len], &mut along_y[..len], &mut along_z[..len]);
        // (By index, of rows of one length: compilers take several voxels at once.)
        for n in 0..len {
            let low = smoothed(a[n], b[n], c[n]);
            let high = smoothed(g[n], h[n], i[n]);
            height[n] = smoothed(low, smoothed(d[n], e[n], f[n]), high);
            along_y[n] = smoothed(c[n] - a[n], f[n] - d[n], i[n] - g[n]);
            along_z[n] = high - low;
        }
    }
}

#[inline(always)]
fn smoothed(low: f32, middle: f32, high: f32) -> f32 {
    const SIDE: f32 = ASIDE as f32;
    const MIDDLE: f32 = (1.0 - 2.0 * ASIDE) as f32;
    SIDE * (low + high) + MIDDLE * middle
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMS: [usize; 3] = [9, 7, 5];

    fn noise() -> Vec<f32> {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..DIMS.iter().product()).map(|_| random()).collect()
    }

    fn index([x, y, z]: [usize; 3]) -> usize {
        x + DIMS[0] * (y + DIMS[1] * z)
    }

    /// A row in single precision is what is meant: heights are up to 1, and seven sums and three weights are rounded.
    #[test]
    fn rows_are_as_meant() {
        let (heights, mut rows) = (noise(), Slopes::default());
        let mut found = [Vec3::ZERO; DIMS[0] - 2];
        for (y, z) in (1..DIMS[1] - 1).flat_map(|y| (1..DIMS[2] - 1).map(move |z| (y, z))) {
            rows.of_row(&heights, DIMS, index([1, y, z]), &mut found);
            for (x, found) in found.iter().enumerate() {
                let meant = half_differences(|by| {
                    let at = [x + 1, y, z];
                    let at = std::array::from_fn(|a| (at[a] as i64 + by[a]) as usize);
                    f64::from(heights[index(at)])
                });
                let error = (found.as_dvec3() - meant).abs().max_element();
                assert!(
                    error <= 10.0 * 2f64.powi(-24),
                    "{found} instead of {meant} at {x}, {y}, {z}"
                );
            }
        }
    }

    #[test]
    fn a_ramp_has_its_slope() {
        let slope = DVec3::new(0.25, -3.0, 11.0);
        let found = half_differences(|by| slope.dot(DVec3::from_array(by.map(|n| n as f64))));
        assert!((found - slope).abs().max_element() < 1e-14, "{found}");
    }

    /// A cubic profile, in any direction, is seen in that direction: nothing is left out of the module's theory.
    #[test]
    fn a_bent_wave_keeps_its_direction() {
        for n in [DVec3::new(3.0, 2.0, -1.0), DVec3::new(0.1, 5.0, 0.7), DVec3::ONE] {
            let n = n.normalize();
            let wave = |by: [i64; 3]| {
                let t = n.dot(DVec3::from_array(by.map(|n| n as f64)));
                t - 0.1 * t * t * t
            };
            let plain = DVec3::from_array([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(wave));
            let smoothed = half_differences(wave);
            let turned = |found: DVec3| found.normalize().cross(n).length();
            assert!(turned(smoothed) < 1e-14, "{n}: {}", turned(smoothed));
            assert!(
                n == DVec3::ONE.normalize() || turned(plain) > 0.005,
                "{n}: {}",
                turned(plain)
            );
        }
    }
}
