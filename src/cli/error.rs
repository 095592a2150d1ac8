//! What can go wrong in a command, and how it is shown.

use std::io::{self, Write};

use crate::gpu::GpuError;
use crate::image::EncodeError;
use crate::projection::volume_property::VolumePropertyError;
use crate::projection::{DrawLevelsError, ProjectError};
use crate::render::DeviceMeshError;
use crate::scene::SceneError;
use crate::surface::ExtractError;
use crate::surface::io::MeshWriteError;
use crate::target::TargetError;
use crate::volume::io::{ReadError, WriteError};

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CliError {
    /// The scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A volume file.
    #[error(transparent)]
    Volume(#[from] ReadError),
    /// A volume that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The target.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The drawing.
    #[error(transparent)]
    Project(#[from] ProjectError),
    /// The drawing of several levels.
    #[error(transparent)]
    Levels(#[from] DrawLevelsError),
    /// The picture file.
    #[error(transparent)]
    Picture(#[from] EncodeError),
    /// The surface.
    #[error(transparent)]
    Surface(#[from] ExtractError),
    /// A mesh on the device.
    #[error(transparent)]
    DeviceMesh(#[from] DeviceMeshError),
    /// The mesh file.
    #[error(transparent)]
    Mesh(#[from] MeshWriteError),
    /// A file of 3D Slicer's.
    #[error(transparent)]
    VolumeProperty(#[from] VolumePropertyError),
    /// Options that do not go together, or name nothing.
    #[error("{0}")]
    Usage(String),
    /// The validation layer complained.
    #[error("the validation layer has {} message(s); the first: {}", .0.len(), .0[0])]
    Validation(Vec<String>),
    /// Not enough memory.
    #[error("{mib} MiB of memory for {what} cannot be had; use a larger --spacing")]
    Memory {
        /// What for.
        what: &'static str,
        /// How much.
        mib: usize,
    },
    /// The video.
    #[error("{0}")]
    Video(String),
    /// Standard output.
    #[error("cannot write to standard output: {0}")]
    Stdout(io::Error),
}

impl CliError {
    /// Writes the error to stderr. A reader of stdout that went away needs no message.
    pub(super) fn show(self) {
        let text = match self {
            Self::Stdout(error) if error.kind() == io::ErrorKind::BrokenPipe => return,
            Self::Scene(error) => {
                let report = format!("{:?}", miette::Report::new(error));
                format!("error: {}\n", report.trim())
            }
            error => format!("error: {error}\n"),
        };
        // Nothing is left to be done where stderr cannot be written.
        let _ = io::stderr().write_all(text.as_bytes());
    }
}
