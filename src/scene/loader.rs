//! How a scene gets its volumes.

use std::path::PathBuf;
use std::sync::Arc;

use crate::volume::Bricks;
use crate::volume::io::{self, Opened, ReadOptions};
use crate::voxelize::mesh::{TriangleSolid, read};

/// A volume that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeRequest {
    /// The file.
    pub path: PathBuf,
    /// Which volume of the file, and what a file without a header holds.
    pub options: ReadOptions,
}

/// A mesh that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshRequest {
    /// The file.
    pub path: PathBuf,
    /// How many times as large it is as the file says.
    pub unit_mm: f64,
}

/// Reads volumes and meshes for a scene. A scene asks for each request once, however many nodes use it.
pub trait VolumeLoader {
    /// The volume that `request` names.
    ///
    /// # Errors
    /// Why it cannot be had, in words for the user, the path among them.
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String>;

    /// The solid within the mesh that `request` names. A loader has none unless it says otherwise.
    ///
    /// # Errors
    /// Why it cannot be had, in words for the user, the path among them.
    fn load_mesh(&mut self, request: &MeshRequest) -> Result<Arc<TriangleSolid>, String> {
        Err(format!("{}: meshes are not available here", request.path.display()))
    }
}

impl VolumeLoader for &mut dyn VolumeLoader {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        (**self).load(request)
    }

    fn load_mesh(&mut self, request: &MeshRequest) -> Result<Arc<TriangleSolid>, String> {
        (**self).load_mesh(request)
    }
}

/// A loader for scenes of primitives: it has no volume.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoVolumes;

impl VolumeLoader for NoVolumes {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        Err(format!("{}: volumes are not available here", request.path.display()))
    }
}

/// A loader that asks another one for each volume and mesh once, and remembers them: what is unchanged between two versions of a
/// scene is then the same data, and not loaded again.
pub struct Remembered<L> {
    loader: L,
    volumes: Vec<(VolumeRequest, Arc<Bricks>)>,
    meshes: Vec<(MeshRequest, Arc<TriangleSolid>)>,
}

impl<L> Remembered<L> {
    /// Nothing yet.
    pub fn new(loader: L) -> Self {
        Self {
            loader,
            volumes: Vec::new(),
            meshes: Vec::new(),
        }
    }
}

impl<L: VolumeLoader> VolumeLoader for Remembered<L> {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        if let Some((_, bricks)) = self.volumes.iter().find(|(known, _)| known == request) {
            return Ok(Arc::clone(bricks));
        }
        let bricks = self.loader.load(request)?;
        self.volumes.push((request.clone(), Arc::clone(&bricks)));
        Ok(bricks)
    }

    fn load_mesh(&mut self, request: &MeshRequest) -> Result<Arc<TriangleSolid>, String> {
        if let Some((_, solid)) = self.meshes.iter().find(|(known, _)| known == request) {
            return Ok(Arc::clone(solid));
        }
        let solid = self.loader.load_mesh(request)?;
        self.meshes.push((request.clone(), Arc::clone(&solid)));
        Ok(solid)
    }
}

/// Reads volumes and meshes from files.
#[derive(Clone, Copy, Debug, Default)]
pub struct VolumeFiles;

impl VolumeLoader for VolumeFiles {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        io::open(&request.path, &request.options)
            .and_then(Opened::bricks)
            .map(Arc::new)
            .map_err(|error| error.to_string())
    }

    fn load_mesh(&mut self, request: &MeshRequest) -> Result<Arc<TriangleSolid>, String> {
        let mesh = read::read(&request.path).map_err(|error| error.to_string())?;
        let solid = TriangleSolid::new(&mesh.scaled(request.unit_mm));
        solid
            .map(Arc::new)
            .map_err(|error| format!("{}: {error}", request.path.display()))
    }
}
