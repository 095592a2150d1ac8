//! Where packets are, in whole parts of a voxel.
//!
//! *Practice.* Whole numbers are soon taken apart into voxels and parts, and nothing in them depends on a block. The line of a packet's
//! low corner is in double precision; a stretch of planes begins where it is, and goes on by whole steps. Stretches are the frame's,
//! so a place is the same in whatever box a packet comes to it.

use super::simd::each;

/// Bits behind the point.
pub const BITS: u32 = 32;

/// Planes of a stretch.
pub const STRETCH: i32 = 32;

/// A place in lattice coordinates, in parts of 2⁻³² voxel.
pub type Place = [i64; 3];

/// A coordinate, rounded down.
#[inline(always)]
pub fn fixed(coordinate: f64) -> i64 {
    (coordinate * (1u64 << BITS) as f64).floor() as i64
}

/// The low corner of a packet from the first plane of a stretch on.
pub struct Stretch {
    first: i32,
    from: Place,
    step: Place,
}

impl Stretch {
    /// The one that `plane` is in, of a line that is at `line[axis][0] + k·line[axis][1]` at plane `k`.
    #[inline(always)]
    pub fn new(line: &[[f64; 2]; 3], plane: i32) -> Self {
        let first = plane - plane % STRETCH;
        Self {
            first,
            from: each!(axis of [0, 1, 2] => fixed(line[axis][0] + f64::from(first) * line[axis][1])),
            step: each!(axis of [0, 1, 2] => fixed(line[axis][1])),
        }
    }

    /// Where it is at a plane of the stretch.
    #[inline(always)]
    pub fn at(&self, plane: i32) -> Place {
        let planes = i64::from(plane - self.first);
        each!(axis of [0, 1, 2] => self.from[axis].wrapping_add(planes.wrapping_mul(self.step[axis])))
    }
}
