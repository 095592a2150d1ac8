//! Smaller slices (LC87 §5.1).
//!
//! *Theory.* Averaging four pixels of a slice into one leaves a quarter of the data and a smoother surface of fewer triangles,
//! with some loss of detail.
//! *Practice.* The new voxel lies in the middle of the four. Where the number of rows or columns is odd, the last one is taken
//! as if it were there twice, so that the new slices still cover the old; an axis of one voxel stays as it is.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use super::grid::{Grid, GridError, Voxels};
use super::voxel::{Voxel, map_type};
use crate::math::affine;

/// `grid` with each 2 × 2 voxels of its slices (x and y) averaged into one, rounded to the voxels' type: of two equally near
/// integers to the even one, so that there is no drift. Voxels that are not finite are left out of averages; a voxel of which
/// all four are not finite is NaN.
///
/// # Errors
/// That of [`Grid::new`], if the new voxels are too large for `world_from_index` to be finite.
pub fn averaged_slices(grid: &Grid) -> Result<Grid, GridError> {
    let [nx, ny, nz] = grid.dims();
    let [step_x, step_y] = [nx, ny].map(|n| n.min(2));
    let dims = [nx.div_ceil(step_x), ny.div_ceil(step_y), nz];
    let average = Average {
        dims: [nx, ny],
        steps: [step_x, step_y],
    };
    let voxels = map_type!(Voxels, grid.voxels(), Voxels, v => average.all(v));
    let world_from_index = spread(grid.world_from_index(), DVec3::new(step_x as f64, step_y as f64, 1.0));
    Grid::new(dims, world_from_index, voxels)
}

/// The map of a lattice of which each voxel takes the place of `steps` voxels of that of `world_from_index`.
fn spread(world_from_index: &DAffine3, steps: DVec3) -> DAffine3 {
    let m = &world_from_index.matrix3;
    DAffine3 {
        matrix3: DMat3::from_cols(m.x_axis * steps.x, m.y_axis * steps.y, m.z_axis * steps.z),
        translation: affine::point(world_from_index, (steps - 1.0) / 2.0),
    }
}

/// How slices are averaged.
#[derive(Clone, Copy)]
struct Average {
    /// Voxels of a slice along x and y.
    dims: [usize; 2],
    /// How many of them go into one.
    steps: [usize; 2],
}

impl Average {
    fn all<T: Voxel>(self, voxels: &[T]) -> Vec<T> {
        let [nx, ny] = self.dims;
        let slices = voxels.par_chunks(nx * ny);
        let rows = slices.flat_map(|slice| slice.par_chunks(nx * self.steps[1]));
        rows.flat_map_iter(|rows| self.row(rows)).collect()
    }

    /// The averages of `rows`, of which there are two, or one at the border.
    fn row<T: Voxel>(self, rows: &[T]) -> impl Iterator<Item = T> {
        let [nx, step] = [self.dims[0], self.steps[0]];
        (0..nx).step_by(step).map(move |i| {
            let columns = i..nx.min(i + step);
            let block = rows.chunks(nx).flat_map(|row| &row[columns.clone()]);
            mean(block.map(|v| v.to_f64()))
        })
    }
}

/// The mean of the finite `values`; each is there once, which of a border is the same as twice.
fn mean<T: Voxel>(values: impl Iterator<Item = f64>) -> T {
    let finite = values.filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    T::nearest(sum / count)
}
