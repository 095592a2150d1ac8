//! How a scene gets its volumes.

use std::path::PathBuf;
use std::sync::Arc;

use crate::volume::Bricks;
use crate::volume::io::{self, raw};

/// A volume that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeRequest {
    /// The file.
    pub path: PathBuf,
    /// What it holds, when it has no header of its own.
    pub raw: Option<raw::RawLayout>,
}

/// Reads volumes for a scene. A scene asks for each request once, however many nodes use it.
pub trait VolumeLoader {
    /// The volume that `request` names.
    ///
    /// # Errors
    /// Why it cannot be had, in words for the user, the path among them.
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String>;
}

/// A loader for scenes of primitives: it has no volume.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoVolumes;

impl VolumeLoader for NoVolumes {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        Err(format!("{}: volumes are not available here", request.path.display()))
    }
}

/// Reads volumes from files.
#[derive(Clone, Copy, Debug, Default)]
pub struct VolumeFiles;

impl VolumeLoader for VolumeFiles {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        let volume = match &request.raw {
            Some(layout) => raw::read(&request.path, layout),
            None => io::read(&request.path),
        };
        volume
            .map(|volume| Arc::new(Bricks::new(&volume.grid)))
            .map_err(|error| error.to_string())
    }
}
