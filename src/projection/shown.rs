//! Which cells of a target show, counted so that any box of them is asked at once.
//!
//! *Practice.* How many shown cells lie before each along all three axes is summed up once a frame (a summed-area table, Crow 1984, of
//! three dimensions). Whether anything in a box shows then takes eight numbers, so large parts that do not are passed over whole.

use rayon::prelude::*;

use super::VisibleValues;
use crate::target::{CellRanges, Lattice, VoxelBox};

/// The cells of each block of a target in which something shows.
pub struct ShownCells<'a> {
    blocks: Vec<BlockCells<'a>>,
}

struct BlockCells<'a> {
    cells: &'a CellRanges,
    /// One more than cells along each axis.
    dims: [usize; 3],
    /// The shown cells before each place.
    before: Vec<u32>,
}

impl<'a> ShownCells<'a> {
    /// Of blocks with such `cells`, of which `values` show.
    pub fn new(cells: &'a [CellRanges], values: &VisibleValues) -> Self {
        Self {
            blocks: cells.par_iter().map(|cells| BlockCells::new(cells, values)).collect(),
        }
    }

    /// Whether any cell of a block that meets some of its voxels shows.
    pub fn any_in(&self, block: u32, lattice: &Lattice, voxels: &VoxelBox) -> bool {
        self.blocks[block as usize].any_in(lattice, voxels)
    }
}

impl<'a> BlockCells<'a> {
    fn new(cells: &'a CellRanges, values: &VisibleValues) -> Self {
        let dims = cells.dims.map(|n| n + 1);
        let plane = dims[0] * dims[1];
        let mut before = vec![0; plane * dims[2]];
        // Each plane by itself, and then each upon those before it.
        let planes = before[plane..].par_chunks_exact_mut(plane).enumerate();
        planes.for_each(|(z, before)| count_plane(cells, values, z, before));
        for z in 2..dims[2] {
            let (done, rest) = before.split_at_mut(z * plane);
            let pairs = rest[..plane].iter_mut().zip(&done[(z - 1) * plane..]);
            pairs.for_each(|(here, before)| *here += before);
        }
        Self { cells, dims, before }
    }

    fn any_in(&self, lattice: &Lattice, voxels: &VoxelBox) -> bool {
        let [x, y, z] = self.cells.meeting(lattice, voxels);
        let before = |z: usize, y: usize, x: usize| self.before[x + self.dims[0] * (y + self.dims[1] * z)];
        let in_rows = |z: usize, y: usize| before(z, y, x.end).wrapping_sub(before(z, y, x.start));
        let in_planes = |z: usize| in_rows(z, y.end).wrapping_sub(in_rows(z, y.start));
        in_planes(z.end) != in_planes(z.start)
    }
}

/// Counts the shown cells of plane `z` before each place in it.
fn count_plane(cells: &CellRanges, values: &VisibleValues, z: usize, before: &mut [u32]) {
    let [width, height, _] = cells.dims;
    let across = width + 1;
    for y in 0..height {
        let mut in_row = 0;
        for x in 0..width {
            in_row += u32::from(values.any_in(cells.range([x, y, z])));
            before[(y + 1) * across + x + 1] = before[y * across + x + 1] + in_row;
        }
    }
}
