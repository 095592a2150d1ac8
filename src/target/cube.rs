//! Cubes of the octree, and what of them lies in a lattice.
//!
//! *Practice.* The edges of cubes lie where the grid says that the lattice is a box of, whichever box. So cubes at the lattice's
//! faces may be cut on any side, and a lattice that grows or shrinks leaves the others as they are.

use std::array::from_fn;

use glam::DVec3;

use super::Lattice;
use crate::math::Aabb;

/// An octree cube: its first voxel and its edge in voxels. It may reach beyond the lattice on all sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cube {
    /// First voxel, in lattice coordinates.
    pub origin: [i64; 3],
    /// Edge, a power of two.
    pub size: usize,
}

impl Cube {
    /// The smallest cube that holds a lattice and has an edge of `least` or more. One of that edge begins where the lattice does. Octants
    /// of others lie at multiples of their size on the grid, and so do they where they can: no such cube, however large, has a multiple
    /// of all sizes inside.
    pub(super) fn around(lattice: &Lattice, least: usize) -> Self {
        let longest = lattice.dims.iter().copied().max().unwrap_or(1);
        if longest <= least.max(1) {
            return Self {
                origin: [0; 3],
                size: least.max(1),
            };
        }
        let first = lattice.first().to_array();
        // From a multiple of half its size on, a cube of twice the longest edge or more holds all.
        let mut size = longest.next_power_of_two();
        loop {
            let origins: [Option<i64>; 3] = from_fn(|a| start(first[a], lattice.dims[a], size));
            if let [Some(x), Some(y), Some(z)] = origins {
                let origin = [x - first[0], y - first[1], z - first[2]];
                return Self { origin, size };
            }
            size *= 2;
        }
    }

    /// Octant `index`; bit `a` says that it lies on the high side of axis `a`.
    pub fn octant(&self, index: usize) -> Self {
        let half = self.size / 2;
        Self {
            origin: from_fn(|a| self.origin[a] + (half * (index >> a & 1)) as i64),
            size: half,
        }
    }

    /// The octant that holds voxel `at` of the cube.
    pub fn octant_with(&self, at: [i64; 3]) -> usize {
        let half = (self.size / 2) as i64;
        (0..3).fold(0, |o, a| o | usize::from(at[a] >= self.origin[a] + half) << a)
    }

    /// Whether all of `other` lies in it.
    pub fn holds(&self, other: &Self) -> bool {
        let end = |cube: &Self, a: usize| cube.origin[a] + cube.size as i64;
        (0..3).all(|a| self.origin[a] <= other.origin[a] && end(other, a) <= end(self, a))
    }

    /// The point where the octants meet, in lattice coordinates (cells begin half a voxel before their voxel).
    pub fn center(&self) -> DVec3 {
        DVec3::from_array(self.origin.map(|o| o as f64)) + (self.size as f64 * 0.5 - 0.5)
    }

    /// What of the cube lies in a lattice of `dims`.
    pub fn voxels(&self, dims: [usize; 3]) -> VoxelBox {
        VoxelBox::clipped(self.origin, [self.size; 3], dims)
    }
}

/// Where a range of `size` can begin on the grid that holds `len` points from `first` on: at a multiple of its size, or else of its half.
fn start(first: i64, len: usize, size: usize) -> Option<i64> {
    let steps = [size, size.div_ceil(2)].map(|n| n as i64);
    let starts = steps.map(|step| first.div_euclid(step) * step);
    starts
        .into_iter()
        .find(|start| first + len as i64 <= start + size as i64)
}

/// A box of voxels of the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VoxelBox {
    /// First voxel.
    pub origin: [usize; 3],
    /// Voxels along each axis.
    pub extent: [usize; 3],
}

impl VoxelBox {
    /// What of a box with these edges lies in a lattice of `dims`.
    pub fn clipped(origin: [i64; 3], edges: [usize; 3], dims: [usize; 3]) -> Self {
        let within = |a: usize, at: i64| at.clamp(0, dims[a] as i64) as usize;
        let first: [usize; 3] = from_fn(|a| within(a, origin[a]));
        Self {
            origin: first,
            extent: from_fn(|a| within(a, origin[a] + edges[a] as i64) - first[a]),
        }
    }

    /// Whether it has no voxel.
    pub fn is_empty(&self) -> bool {
        self.extent.contains(&0)
    }

    /// Voxels in all.
    pub fn len(&self) -> usize {
        self.extent.iter().product()
    }

    /// Whether voxel `at` lies in it.
    pub fn holds(&self, at: [usize; 3]) -> bool {
        (0..3).all(|a| (self.origin[a]..self.origin[a] + self.extent[a]).contains(&at[a]))
    }

    /// The box of its voxels' cells, in lattice coordinates.
    pub fn bounds(&self) -> Aabb {
        let [origin, extent] = [self.origin, self.extent].map(|n| DVec3::from_array(n.map(|n| n as f64)));
        Aabb::new(origin - 0.5, origin + extent - 0.5)
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use proptest::prelude::*;

    use super::*;

    /// A lattice that begins at `first` on a grid.
    fn lattice(first: [i32; 3], dims: [usize; 3]) -> Lattice {
        Lattice::new([1; 3], DAffine3::IDENTITY).moved(first.map(i64::from).into(), dims)
    }

    fn ranges() -> impl Strategy<Value = ([i32; 3], [usize; 3])> {
        (prop::array::uniform3(-60i32..60), prop::array::uniform3(2usize..60))
    }

    proptest! {
        #[test]
        fn the_root_holds_the_lattice_and_its_octants_lie_on_the_grid((first, dims) in ranges(), bits in 0u32..5) {
            let lattice = lattice(first, dims);
            prop_assert_eq!(lattice.first().to_array(), first.map(i64::from));
            let root = Cube::around(&lattice, 1 << bits);
            prop_assert_eq!(root.voxels(dims), VoxelBox { origin: [0; 3], extent: dims });
            let longest = dims.into_iter().max().unwrap_or(1).max(1 << bits);
            prop_assert!(root.size >= 1 << bits && root.size < 4 * longest, "{:?}", root);
            // A root of the least size is not split.
            for n in (0..8).filter(|_| root.size > 1 << bits) {
                let octant = root.octant(n);
                let on_grid = |a: usize| (octant.origin[a] + i64::from(first[a])).rem_euclid(octant.size as i64) == 0;
                prop_assert!((0..3).all(on_grid), "{:?} of {:?}", octant, root);
                prop_assert!(root.holds(&octant) && !octant.holds(&root));
                prop_assert_eq!(root.octant_with(octant.origin), n);
            }
        }

        #[test]
        fn what_lies_in_a_lattice_is_what_each_voxel_says(
            origin in prop::array::uniform3(-9i64..9),
            edges in prop::array::uniform3(0usize..9),
            dims in prop::array::uniform3(0usize..9),
        ) {
            let clipped = VoxelBox::clipped(origin, edges, dims);
            for n in 0..729 {
                let at: [usize; 3] = [n % 9, n / 9 % 9, n / 81];
                let within = (0..3).all(|a| {
                    let from_origin = at[a] as i64 - origin[a];
                    at[a] < dims[a] && (0..edges[a] as i64).contains(&from_origin)
                });
                prop_assert_eq!(clipped.holds(at), within);
            }
        }
    }
}
