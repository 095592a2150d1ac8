//! Solid modelling with surfaces: cutting and capping (LC87 §5.2, figures 6 and 7).
//!
//! *Theory.* A cell lies inside, on or outside the scan's surface S, and so with the cutter's surface P. The truth table of the
//! nine cases says what it contributes: triangles of S, triangles of P, or, where it is on both, triangles of each clipped by
//! the other.
//! *Changes from the paper.* Triangles clipped by triangles leave cracks: the two surfaces, each approximate within its cell,
//! meet their neighbours at different points. Here the triangles of S are clipped by P's function, which is interpolated along
//! their sides; so are the polygons in which the solid meets the cell's faces. Together these bound the solid within the cell;
//! where they are cut, the cuts make closed loops, and the cap is what fills the loops. A line shared by two polygons is cut
//! once, so everything fits by construction, ties and rounding included: every side of a triangle has its opposite. A plane's
//! cap is flat. Union and difference have truth tables of their own. Solids that reach the lattice's border can be closed there
//! too, in the border's plane.
//! *Practice.* Cells on one of the surfaces only are told apart by the bits of rows of voxels, and make the triangles of marching
//! cubes. Layers of cells are worked on at once; vertices they share have the same names, by which they are put together.

mod cap;
mod cell;
mod clip;
mod cutter;
mod join;
mod layer;
mod table;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::assemble::Assembly;
use super::extract::{ExtractError, Topology};
use super::inside::{Classifier, InsideRows, Ties};
use super::mesh::Mesh;
use super::slices::Slices;
use super::vertices::Level;
use crate::volume::{Grid, Voxel, Voxels, for_type};
use cell::Vertex;
pub use cutter::Cutter;
use cutter::Sampler;
pub use table::Operation;

/// How a solid is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolidOptions {
    /// What becomes of the solid at the lattice's border.
    pub border: Border,
    /// What becomes of normals where two parts meet.
    pub creases: Creases,
}

/// What becomes of a solid at the border of the scan's lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// The mesh has a hole there, as from marching cubes.
    #[default]
    Open,
    /// The mesh is closed by flat faces in the border's plane, through the outermost voxels, with the scan's values.
    Closed,
}

/// Whether parts share the vertices where they meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Creases {
    /// They do: the mesh is closed. A shared vertex has the normal of the part that comes first.
    #[default]
    Shared,
    /// Each has its own, with its own normals, so that edges are drawn sharp. Only by position is the mesh closed.
    Sharp,
}

/// The solid where the values of `grid` are not below `iso`, combined with a cutter, as a mesh.
///
/// Its parts are the scan's surface (label 0, values `iso`), the cap, which is the cutter's surface (label 1, the scan's
/// trilinear values), and, with [`Border::Closed`], the faces in the lattice's border (label 2, likewise). The mesh is closed,
/// but at the border where that is open. Only what lies in the scan's lattice is made.
///
/// The cutter is sampled at the scan's voxels and linear between them: details smaller than a voxel are lost. Where the scan is
/// NaN it is outside, and vertices next to it are as from [`marching_cubes`](super::marching_cubes).
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use vcsg::surface::{Cutter, Operation, SolidOptions, combine};
/// use vcsg::volume::{Grid, Voxels};
///
/// // A voxel, and a plane through it: half an octahedron.
/// let mut voxels = vec![0; 27];
/// voxels[13] = 2;
/// let grid = Grid::new([3, 3, 3], DAffine3::IDENTITY, Voxels::U8(voxels))?;
/// let plane = Cutter::half_space(DVec3::splat(1.0), DVec3::X);
/// let mesh = combine(&grid, 1.0, Operation::Intersection, plane, SolidOptions::default())?;
/// assert_eq!(mesh.parts[0].triangles.len(), 4);
/// assert!(mesh.parts[1].triangles.clone().all(|n| mesh.corners(n).iter().all(|at| at[0] == 1.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If `iso` is not finite, or the mesh has more vertices or triangles than `u32` counts.
pub fn combine(
    grid: &Grid,
    iso: f64,
    operation: Operation,
    cutter: Cutter<'_>,
    options: SolidOptions,
) -> Result<Mesh, ExtractError> {
    let mut surface = Assembly::new(Level::new(iso, *grid.world_from_index())?, grid.dims(), Topology::Vtk);
    if grid.dims().iter().any(|n| *n < 2) {
        return Ok(Mesh::default());
    }
    for_type!(Voxels, grid.voxels(), voxels => {
        surface.add(&classifier(voxels, grid.dims(), iso), 0..grid.dims()[2])
    })?;
    let task = Task {
        grid,
        iso,
        operation,
        cutter: cutter.on(grid.world_from_index()),
        border: options.border,
        surface,
    };
    let layers = (0..grid.dims()[2] - 1).into_par_iter();
    let pieces = layers.map(|k| layer::march(&task, k)).collect();
    join::join(&task, pieces, options.creases)
}

fn classifier<T: Voxel>(voxels: &[T], dims: [usize; 3], iso: f64) -> Classifier<'_, T> {
    let slices = Slices {
        voxels,
        first_slice: 0,
        dims,
    };
    Classifier::new(slices, iso, Ties::OneVertex)
}

/// All that a layer of cells is made from.
struct Task<'a> {
    grid: &'a Grid,
    iso: f64,
    operation: Operation,
    cutter: Sampler<'a>,
    border: Border,
    /// The scan's surface, in which vertices are still numbered by the edges they lie on.
    surface: Assembly,
}

impl Task<'_> {
    /// The bits of the scan's voxels in slices `k` and `k + 1`, and in those round them.
    fn rows_round(&self, k: usize) -> InsideRows {
        let dims = self.grid.dims();
        let held = k.saturating_sub(1)..(k + 4).min(dims[2]);
        for_type!(Voxels, self.grid.voxels(), voxels => {
            InsideRows::of(&classifier(voxels, dims, self.iso), held)
        })
    }
}

/// What triangles belong to: 0 is the scan's surface, 1 the cap, and the rest are the faces of the lattice's border.
type Group = u8;

const SURFACE: Group = 0;
const CAP: Group = 1;
const FIRST_FACE: Group = 2;

/// What is known of a vertex besides its name.
#[derive(Clone, Copy, Debug)]
struct Point {
    position: Vec3,
    value: f32,
    /// That of the scan's surface; zero off it.
    normal: DVec3,
}

/// What a layer of cells makes.
#[derive(Default)]
struct Pieces {
    /// Whole triangles of the scan's surface.
    surface: Vec<[u32; 3]>,
    /// All others.
    triangles: Vec<(Group, [Vertex; 3])>,
    /// Their vertices but for those of the scan's surface, each once, in the order of their names.
    points: Vec<(Vertex, Point)>,
}
