//! A volume file that is open: what its header declares, and its voxels still to come.
//!
//! *Practice.* A reader checks its header and hands the voxels over in the order of the grid, chunk by chunk, when they are asked
//! for. So who only lists files reads no voxel, and who keeps a volume in another form than the file's never has it twice.

use std::path::PathBuf;
use std::sync::mpsc;
use std::thread;

use glam::DAffine3;

use super::VolumeInfo;
use super::budget::Budget;
use super::error::ReadError;
use super::part::{Part, Parts, joined};
use super::raw::RawLayout;
use crate::math::affine;
use crate::volume::bricks::{BrickBuilder, Bricks, BuildError};
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
    /// The most memory that reading may take.
    pub budget: Budget,
}

/// How many parts are read ahead of the one in hand.
const PARTS_AHEAD: usize = 2;

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
    parts: Parts,
    budget: Budget,
}

impl std::fmt::Debug for Opened {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Opened").field(&self.path).field(&self.declared).finish()
    }
}

impl Opened {
    /// What `chunks` will give, of the file at `path`.
    pub(super) fn new(path: PathBuf, declared: Declared, chunks: Chunks) -> Result<Self, ReadError> {
        Self::in_parts(path, declared, Box::new(chunks.map(|chunk| chunk.map(Part::Next))))
    }

    /// What `parts` will give.
    pub(super) fn in_parts(path: PathBuf, declared: Declared, parts: Parts) -> Result<Self, ReadError> {
        voxel_count(declared.dims).map_err(|e| ReadError::new(&path, e))?;
        Ok(Self {
            declared,
            path,
            parts,
            budget: Budget::default(),
        })
    }

    /// The same, within `budget`.
    pub(super) fn within(self, budget: Budget) -> Self {
        Self { budget, ..self }
    }

    /// The same, of which `seen` is told how many voxels have come, each time that some have.
    pub fn watched(self, mut seen: impl FnMut(u64) + Send + 'static) -> Self {
        let parts = self.parts.inspect(move |part| seen(part.as_ref().map_or(0, Part::len)));
        Self {
            parts: Box::new(parts),
            ..self
        }
    }

    /// What the header declares.
    pub fn declared(&self) -> &Declared {
        &self.declared
    }

    /// Reads the voxels into a grid.
    ///
    /// # Errors
    /// Whatever [`ReadError`] can say of the voxels; if they take more memory than they may.
    pub fn grid(self) -> Result<Grid, ReadError> {
        let Self {
            declared,
            path,
            parts,
            budget,
            ..
        } = self;
        let parts = parts.map(|part| part.and_then(|part| budget.check(&path, declared.bytes()).map(|()| part)));
        let voxels = joined(&path, declared.dims, declared.voxel, parts)?;
        Grid::new(declared.dims, declared.world_from_index, voxels).map_err(|e| ReadError::new(&path, e))
    }

    /// Reads the voxels into sparse bricks. Beside them no more is held than the part in hand and the next ones.
    ///
    /// # Errors
    /// Whatever [`ReadError`] can say of the voxels; if their bricks take more memory than they may.
    pub fn bricks(self) -> Result<Bricks, ReadError> {
        let refused = |e: BuildError| ReadError::new(&self.path, e);
        let Declared {
            dims,
            world_from_index,
            voxel,
            ..
        } = self.declared;
        let mut builder = BrickBuilder::new(dims, world_from_index, voxel, self.budget.bytes()).map_err(refused)?;
        read_ahead(self.parts, |part| part.put_in_bricks(&mut builder).map_err(refused))?;
        builder.finish().map_err(refused)
    }

    /// Reads the voxels to tell their statistics, and keeps none.
    ///
    /// # Errors
    /// Whatever [`ReadError`] can say of the voxels.
    pub fn info(self) -> Result<VolumeInfo, ReadError> {
        let mut tally = Tally::NONE;
        for part in self.parts {
            tally = tally.join(part?.tally());
        }
        Ok(self.declared.info(&tally.stats()))
    }
}

/// Hands `parts` over to `put`, while the next are read on a thread of their own.
fn read_ahead(mut parts: Parts, mut put: impl FnMut(Part) -> Result<(), ReadError>) -> Result<(), ReadError> {
    let (sender, receiver) = mpsc::sync_channel(PARTS_AHEAD);
    thread::scope(|scope| {
        // Who takes no more of them after an error lets the thread end.
        scope.spawn(move || parts.try_for_each(|part| sender.send(part)).ok());
        receiver.into_iter().try_for_each(|part| put(part?))
    })
}

impl Declared {
    /// Bytes of the voxels.
    pub fn bytes(&self) -> u64 {
        let voxels = self.dims.iter().map(|n| *n as u64);
        voxels.fold(self.voxel.bytes() as u64, u64::saturating_mul)
    }

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
