//! A volume file that is open: what its header declares, and its voxels still to come.
//!
//! *Practice.* A reader checks its header and hands the voxels over in the order of the grid, chunk by chunk, when they are asked
//! for. So who only lists files reads no voxel, and who keeps a volume in another form than the file's never has it twice.

use std::path::PathBuf;

use glam::DAffine3;

use super::VolumeInfo;
use super::error::{Problem, ReadError};
use super::raw::RawLayout;
use crate::math::affine;
use crate::volume::bricks::Bricks;
use crate::volume::grid::{Grid, Stats, Tally, Voxels, voxel_count};
use crate::volume::voxel::VoxelType;

/// Which volume of a file is meant, where it may hold several. What is not said is the file's first, or the only one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// The volume of a series in time, from 0 on.
    pub frame: Option<usize>,
    /// The DICOM series, by the end of its UID or by its description.
    pub series: Option<String>,
    /// The VTK array, by its name.
    pub array: Option<String>,
    /// The component of a voxel or the channel of a microscope, from 0 on. Unless it is said, colours are read as their luminance,
    /// complex numbers and vectors as their magnitude, and of channels the first.
    pub component: Option<usize>,
    /// Of an image stored at several resolutions, which: from 0, the finest, on.
    pub resolution: Option<usize>,
    /// Whether slices at uneven distances are resampled to even ones instead of refused.
    pub resample: bool,
    /// What the file holds, where it has no header of its own.
    pub raw: Option<RawLayout>,
}

/// A volume's voxels in the order of the grid, x fastest, any number at a time, all of the declared type.
pub(super) type Chunks = Box<dyn Iterator<Item = Result<Voxels, ReadError>> + Send>;

/// What a header declares of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Declared {
    /// The format's name.
    pub format: &'static str,
    /// Which volume of the file it is, as [`ReadOptions`] would name it; empty where there is but one.
    pub name: String,
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// The type of the voxels that are handed over: after slope and intercept, and of one number each.
    pub voxel: VoxelType,
    /// World LPS millimetres of a voxel's index.
    pub world_from_index: DAffine3,
    /// How many volumes in time the file holds.
    pub frames: usize,
    /// Numbers a voxel in the file.
    pub components: usize,
    /// What a user should know of how it was read: a line each.
    pub notes: Vec<String>,
}

/// A volume whose header is read and whose voxels are not.
pub struct Opened {
    declared: Declared,
    /// For messages.
    path: PathBuf,
    chunks: Chunks,
}

impl std::fmt::Debug for Opened {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Opened").field(&self.path).field(&self.declared).finish()
    }
}

impl Opened {
    /// What `chunks` will give, of the file at `path`.
    pub(super) fn new(path: PathBuf, declared: Declared, chunks: Chunks) -> Result<Self, ReadError> {
        voxel_count(declared.dims).map_err(|e| ReadError::new(&path, e))?;
        Ok(Self { declared, path, chunks })
    }

    /// What the header declares.
    pub fn declared(&self) -> &Declared {
        &self.declared
    }

    /// Reads the voxels into a grid.
    ///
    /// # Errors
    /// Whatever [`ReadError`] can say of the voxels.
    pub fn grid(self) -> Result<Grid, ReadError> {
        let Self { declared, path, chunks } = self;
        let mut voxels = Voxels::none(declared.voxel);
        for chunk in chunks {
            let chunk = chunk?;
            assert_eq!(chunk.voxel_type(), declared.voxel, "a chunk of the declared type");
            voxels
                .append(chunk)
                .map_err(|bytes| ReadError::new(&path, Problem::Memory(bytes)))?;
        }
        Grid::new(declared.dims, declared.world_from_index, voxels).map_err(|e| ReadError::new(&path, e))
    }

    /// Reads the voxels into sparse bricks.
    ///
    /// # Errors
    /// As [`Self::grid`].
    pub fn bricks(self) -> Result<Bricks, ReadError> {
        Ok(Bricks::new(&self.grid()?))
    }

    /// Reads the voxels to tell their statistics, and keeps none.
    ///
    /// # Errors
    /// As [`Self::grid`].
    pub fn info(self) -> Result<VolumeInfo, ReadError> {
        let mut tally = Tally::NONE;
        for chunk in self.chunks {
            tally = tally.join(chunk?.tally());
        }
        Ok(self.declared.info(&tally.stats()))
    }
}

impl Declared {
    /// The description of a volume of which this is declared and whose voxels have `stats`.
    pub(super) fn info(&self, stats: &Stats) -> VolumeInfo {
        let spacing = affine::spacing(&self.world_from_index);
        let axes = self.world_from_index.matrix3.transpose();
        let rows = [axes.x_axis, axes.y_axis, axes.z_axis].map(|row| (row / spacing).to_array());
        VolumeInfo {
            format: self.format,
            name: self.name.clone(),
            dims: self.dims,
            frames: self.frames,
            components: self.components,
            voxel: self.voxel,
            spacing: spacing.to_array(),
            origin: self.world_from_index.translation.to_array(),
            direction: std::array::from_fn(|i| rows[i / 3][i % 3]),
            min: stats.min,
            max: stats.max,
            mean: stats.mean,
            non_finite: stats.non_finite,
            notes: self.notes.clone(),
        }
    }
}
