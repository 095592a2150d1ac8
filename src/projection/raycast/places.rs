//! Where packets are, in whole parts of a voxel.
//!
//! *Practice.* Whole numbers are soon taken apart into voxels and parts, and nothing in them depends on a block. The line of a packet's
//! low corner is in double precision; a stretch of planes begins where it is, and goes on by whole steps. Stretches are the frame's,
//! so a place is the same in whatever box a packet comes to it.

use super::simd::{EDGE, each};

/// Bits behind the point.
pub const BITS: u32 = 32;

/// Planes of a stretch.
pub const STRETCH: i32 = 128;

/// A place counted from a lattice's first voxel, or from another, in parts of 2⁻³² voxel.
pub type Place = [i64; 3];

/// A coordinate, rounded down.
#[inline(always)]
pub fn fixed(coordinate: f64) -> i64 {
    (coordinate * (1u64 << BITS) as f64).floor() as i64
}

/// The line that a packet's low corner is on.
#[derive(Clone, Copy, Default)]
pub struct Line {
    /// Where it is at plane 0 along each axis, and how far it goes from plane to plane, voxels.
    at: [[f64; 2]; 3],
    step: Place,
}

impl Line {
    /// At `at[axis][0] + k·at[axis][1]` at plane `k`, in lattice coordinates.
    #[inline(always)]
    pub fn new(at: [[f64; 2]; 3]) -> Self {
        let step = each!(axis of [0, 1, 2] => fixed(at[axis][1]));
        Self { at, step }
    }
}

/// The low corner of a packet on its way from plane to plane, counted from a voxel.
pub struct Way {
    pub at: Place,
    step: Place,
}

impl Way {
    /// On a line from `plane` on, counted from the lattice's voxel `first`.
    #[inline(always)]
    pub fn new(line: &Line, plane: i32, first: &[i32; 3]) -> Self {
        let planes = plane % STRETCH;
        let from = f64::from(plane - planes);
        let mut way = Self {
            at: each!(axis of [0, 1, 2] => {
                let [origin, step] = line.at[axis];
                fixed(origin + from * step).wrapping_sub(i64::from(first[axis]) << BITS)
            }),
            step: line.step,
        };
        way.go_on(planes);
        way
    }

    /// Goes on by some planes, all of them of one stretch.
    #[inline(always)]
    pub fn go_on(&mut self, planes: i32) {
        let planes = i64::from(planes);
        self.at = each!(axis of [0, 1, 2] => self.at[axis].wrapping_add(planes.wrapping_mul(self.step[axis])));
    }

    /// Which row and which plane of few voxels it comes to next.
    #[inline(always)]
    pub fn last(&self) -> [usize; 2] {
        each!(axis of [1, 2] => if self.step[axis] < 0 { 0 } else { EDGE - 1 })
    }
}
