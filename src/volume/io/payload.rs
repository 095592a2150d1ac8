//! The voxels in a file, once its header has told where and how they lie.

use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::components::Components;
use super::error::ReadError;
use super::open::{Chunks, ReadOptions};
use super::source::{Source, Stretch, section};
use super::stored::{ByteOrder, Stored, decode};
use crate::volume::grid::Voxels;
use crate::volume::voxel::{Voxel, VoxelType, for_type};

/// What a header declares of the voxels of one volume.
pub(super) struct Payload {
    /// The scalars' type in the file.
    pub stored: Stored,
    /// The scalars' byte order in the file.
    pub order: ByteOrder,
    /// How many voxels.
    pub voxels: usize,
    /// How many scalars a voxel has, and what is made of them.
    pub components: Components,
    /// Slope and intercept of the scalars, where they change anything.
    pub rescaling: Option<[f64; 2]>,
}

/// Bytes of a file's scalars that are handed over at a time: what they take stays in a cache until it is put to use.
const CHUNK: usize = 1 << 20;

impl Payload {
    /// Its bytes, decoded.
    pub(super) fn bytes(&self) -> u64 {
        let scalars = (self.voxels as u64).saturating_mul(self.components.count() as u64);
        scalars.saturating_mul(self.stored.bytes() as u64)
    }

    /// Bytes of a run of all components.
    fn run_bytes(&self) -> u64 {
        let scalars = (self.components.run() as u64).saturating_mul(self.components.count() as u64);
        scalars.saturating_mul(self.stored.bytes() as u64)
    }

    /// The type of the voxels that are handed over.
    pub(super) fn voxel(&self) -> VoxelType {
        let scalar = match (self.rescaling, self.stored.voxel()) {
            (None, scalar) | (Some(_), scalar @ VoxelType::F64) => scalar,
            (Some(_), _) => VoxelType::F32,
        };
        self.components.voxel(scalar)
    }

    /// The voxels of volume `frame`, of those that follow each other in `stretches`. The file at `path` is the one to name.
    pub(super) fn chunks(
        self,
        path: &Path,
        stretches: &[Stretch],
        frame: usize,
        budget: Budget,
    ) -> Result<Chunks, ReadError> {
        let from = self.bytes().saturating_mul(frame as u64);
        match self.components.chosen() {
            Some(component) if self.components.run() == self.voxels => {
                // One run is the whole volume: the others need not be read.
                let alone = Self {
                    components: Components::SCALAR,
                    ..self
                };
                let before = alone.bytes().saturating_mul(component as u64);
                let own = section(stretches, from.saturating_add(before), alone.bytes());
                alone.chunks_in(path, stretches, own, budget)
            }
            _ => {
                let own = section(stretches, from, self.bytes());
                self.chunks_in(path, stretches, own, budget)
            }
        }
    }

    /// The voxels in `own`, which are parts of `all`: a series that is cut off is not taken for whole. All components of a run are in
    /// memory together, which has to be within the budget.
    pub(super) fn chunks_in(
        self,
        path: &Path,
        all: &[Stretch],
        own: Vec<Stretch>,
        budget: Budget,
    ) -> Result<Chunks, ReadError> {
        all.iter().try_for_each(Stretch::check)?;
        budget.check(path, self.run_bytes())?;
        Ok(Box::new(Reader {
            path: path.to_owned(),
            left: self.voxels,
            source: Source::new(own),
            payload: self,
        }))
    }
}

/// Which volume is meant of the `frames` of the file at `path`.
pub(super) fn chosen_frame(path: &Path, frames: usize, options: &ReadOptions) -> Result<usize, ReadError> {
    match options.frame {
        Some(frame) if frame >= frames => {
            let what = format!("there is no volume {frame}: it holds {frames}, from 0 on");
            Err(ReadError::unsupported(path, what).hint("say another --volume-frame"))
        }
        frame => Ok(frame.unwrap_or(0)),
    }
}

/// A payload that is being read.
struct Reader {
    path: PathBuf,
    payload: Payload,
    source: Source,
    /// Voxels still to come.
    left: usize,
}

impl Reader {
    /// How many voxels come next: whole runs, of all components.
    fn next_voxels(&self) -> usize {
        let run = self.payload.components.run();
        let runs = CHUNK as u64 / self.payload.run_bytes().max(1);
        run.saturating_mul((runs as usize).max(1)).min(self.left)
    }

    fn read(&mut self, voxels: usize) -> Result<Voxels, ReadError> {
        let Payload {
            stored,
            order,
            components,
            rescaling,
            ..
        } = self.payload;
        let count = voxels.saturating_mul(components.count());
        let scalars = decode(&self.path, stored, order, count, |bytes| self.source.fill(bytes))?;
        Ok(components.one(match rescaling {
            Some(by) => rescaled(scalars, by),
            None => scalars,
        }))
    }
}

impl Iterator for Reader {
    type Item = Result<Voxels, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.left == 0 {
            return None;
        }
        let voxels = self.next_voxels();
        let read = self.read(voxels);
        // Nothing follows an error.
        self.left = if read.is_ok() { self.left - voxels } else { 0 };
        Some(read)
    }
}

/// The scalars after slope and intercept, as `f32` unless they are `f64`.
fn rescaled(scalars: Voxels, [slope, intercept]: [f64; 2]) -> Voxels {
    match scalars {
        Voxels::F64(v) => Voxels::F64(v.into_iter().map(|v| v * slope + intercept).collect()),
        scalars => Voxels::F32(for_type!(Voxels, scalars, v => {
            v.into_iter().map(|v| (v.to_f64() * slope + intercept) as f32).collect()
        })),
    }
}
