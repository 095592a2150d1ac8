//! vtkMarchingCubes, in a process of its own.

#[path = "../oracle/process.rs"]
mod process;

use std::io::Read;

use glam::{DAffine3, DMat3, DVec3};
use process::Process;
use serde_json::json;
use vcsg::surface::Mesh;
use vcsg::volume::{Grid, Voxels};

/// Where a lattice lies, as VTK says it: an orthonormal direction matrix, a spacing and an origin.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub direction: DMat3,
    pub spacing: DVec3,
    pub origin: DVec3,
}

impl Place {
    pub const UNIT: Self = Self {
        direction: DMat3::IDENTITY,
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
    };

    /// The same as one map.
    pub fn world_from_index(&self) -> DAffine3 {
        let [x, y, z] = self.spacing.to_array();
        let d = &self.direction;
        DAffine3 {
            matrix3: DMat3::from_cols(d.x_axis * x, d.y_axis * y, d.z_axis * z),
            translation: self.origin,
        }
    }
}

/// Which points of equal coordinates VTK merges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Merging {
    /// Those that its default locator finds: not always those whose 64-bit coordinates lie on both sides of a bucket's border.
    Usual,
    /// All; slow.
    Thorough,
}

pub struct Oracle(Process);

impl Oracle {
    /// Starts VTK.
    pub fn start() -> Self {
        Self(Process::start("tests/oracle/marching_cubes.py"))
    }

    /// The surface of `grid`, which lies at `place`, as VTK makes it, merging points as `merging` says.
    pub fn mesh(&mut self, grid: &Grid, place: &Place, iso: f64, merging: Merging) -> Mesh {
        assert_eq!(*grid.world_from_index(), place.world_from_index());
        let request = json!({
            "type": grid.voxel_type().name(),
            "dims": grid.dims(),
            "spacing": place.spacing.to_array(),
            "origin": place.origin.to_array(),
            "direction": place.direction.transpose().to_cols_array(),
            "iso": iso,
            "one_bucket": merging == Merging::Thorough,
        });
        self.0.send(&request, &[bytes(grid.voxels())]);
        let [points, triangles] = self.read::<u64>(2).try_into().expect("two counts");
        Mesh {
            positions: self.triples(points).into(),
            normals: self.triples(points).into(),
            triangles: self.triples(triangles).into(),
            ..Mesh::default()
        }
    }

    fn triples<T: bytemuck::Pod>(&mut self, count: u64) -> Vec<[T; 3]> {
        let flat = self.read::<T>(3 * count as usize);
        flat.as_chunks::<3>().0.to_vec()
    }

    fn read<T: bytemuck::Pod>(&mut self, count: usize) -> Vec<T> {
        let mut values = vec![T::zeroed(); count];
        let bytes = bytemuck::cast_slice_mut(&mut values);
        self.0
            .answers
            .read_exact(bytes)
            .expect("the oracle answers; see its message above");
        values
    }
}

fn bytes(voxels: &Voxels) -> &[u8] {
    match voxels {
        Voxels::U8(v) => v,
        Voxels::I8(v) => bytemuck::cast_slice(v),
        Voxels::U16(v) => bytemuck::cast_slice(v),
        Voxels::I16(v) => bytemuck::cast_slice(v),
        Voxels::U32(v) => bytemuck::cast_slice(v),
        Voxels::I32(v) => bytemuck::cast_slice(v),
        Voxels::F32(v) => bytemuck::cast_slice(v),
        Voxels::F64(v) => bytemuck::cast_slice(v),
    }
}
