//! Masks: where something is, said by the voxels of a volume (VCSG §2: the S of an irregular subvolume).
//!
//! *Theory.* A volumetric object is an irregular subset of a regular volume, often one that a segmentation tells.
//! *Changes from the paper.* The subset is a leaf of its own: intersected with a scan it is the scan's S, and united, subtracted or
//! moved it is a crisp object like any other. Scan and mask may have lattices of their own.
//! *Practice.* A mask holds its voxels by reference, so that each label of a label volume is a leaf and none a copy.

use std::sync::Arc;

use glam::DVec3;

use crate::math::{Aabb, Interval};
use crate::volume::{Bricks, Sample, SampleRange};

/// Which voxels of a mask are in it. Missing ones (NaN) never are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admitted {
    /// All but 0.
    NotZero,
    /// A window of values: one label, or several in a row.
    Within(Interval),
}

/// A mask as a leaf.
#[derive(Clone, Debug)]
pub struct MaskLeaf {
    /// The voxels; shared by all leaves that use them.
    pub bricks: Arc<Bricks>,
    /// Which of them are in the mask.
    pub admitted: Admitted,
    /// The value of every point in it.
    pub value: f32,
}

impl Admitted {
    fn holds(self, voxel: f32) -> bool {
        match self {
            Self::NotZero => voxel != 0.0 && !voxel.is_nan(),
            Self::Within(window) => window.contains(voxel),
        }
    }

    /// Whether some and whether all voxels in `range`, which may be wider than they are, are admitted.
    fn some_and_all(self, range: Interval) -> [bool; 2] {
        match self {
            Self::NotZero => [range != Interval::point(0.0), !range.contains(0.0)],
            Self::Within(window) => [!window.intersect(range).is_empty(), window.encloses(range)],
        }
    }
}

impl MaskLeaf {
    /// The mask at `local`, a point of its index space in its box: what the nearest voxel says. Half way between two the higher
    /// one counts.
    #[inline]
    pub fn sample(&self, local: DVec3) -> Sample {
        let nearest = (local + 0.5).floor().max(DVec3::ZERO).to_array();
        let dims = self.bricks.dims();
        let [i, j, k]: [usize; 3] = std::array::from_fn(|a| (nearest[a] as usize).min(dims[a] - 1));
        if self.admitted.holds(self.bricks.voxel(i, j, k)) {
            Sample::solid(self.value)
        } else {
            Sample::EMPTY
        }
    }

    /// What the mask can be at points of `local`, a box of its index space, that lie in its own. The nearest voxel is one of those
    /// that a trilinear sample would be made of, so their range holds it.
    pub(super) fn range(&self, local: &Aabb) -> SampleRange {
        let voxels = self.bricks.range_index(&local.intersect(&self.bricks.index_bounds()));
        let [some, all] = self.admitted.some_and_all(voxels);
        if voxels.is_empty() || !some {
            return SampleRange::EMPTY;
        }
        let least = if all && !self.bricks.has_missing() { 1.0 } else { 0.0 };
        SampleRange {
            value: Interval::point(self.value),
            coverage: Interval::new(least, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Grid, Voxels};
    use glam::DAffine3;

    fn labels(values: Vec<f32>) -> Arc<Bricks> {
        let grid = Grid::new([values.len(), 1, 1], DAffine3::IDENTITY, Voxels::F32(values)).expect("a grid");
        Arc::new(Bricks::new(&grid))
    }

    fn covered(mask: &MaskLeaf, x: f64) -> bool {
        mask.sample(DVec3::X * x) == Sample::solid(mask.value)
    }

    #[test]
    fn the_nearest_voxel_tells() {
        let mask = |admitted| MaskLeaf {
            bricks: labels(vec![0.0, 3.0, f32::NAN, -1.0]),
            admitted,
            value: 7.0,
        };
        let three = mask(Admitted::Within(Interval::point(3.0)));
        for (x, inside) in [
            (-0.5, false),
            (0.49, false),
            (0.5, true),
            (1.49, true),
            (1.5, false),
            (3.5, false),
        ] {
            assert_eq!(covered(&three, x), inside, "{x}");
        }
        let any = mask(Admitted::NotZero);
        for (x, inside) in [(0.0, false), (1.0, true), (2.0, false), (3.0, true), (3.5, true)] {
            assert_eq!(covered(&any, x), inside, "{x}");
        }
    }
}
