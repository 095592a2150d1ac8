//! A part of a volume's voxels, as a reader hands it over.

use std::path::Path;

use super::error::{Problem, ReadError};
use crate::volume::bricks::{BrickBuilder, BuildError};
use crate::volume::grid::{Region, Tally, Voxels, voxel_count};
use crate::volume::voxel::VoxelType;

/// Some of a volume's voxels, of the declared type.
pub(super) enum Part {
    /// Those that come next in the grid's order.
    Next(Voxels),
    /// Those of a region.
    Box(Region, Voxels),
    /// Those of a region, which all have this value; the type has it.
    Same(Region, f64),
}

/// All of a volume's voxels, each once: either in the grid's order or in regions.
pub(super) type Parts = Box<dyn Iterator<Item = Result<Part, ReadError>> + Send>;

impl Part {
    /// How many voxels it has.
    pub fn len(&self) -> u64 {
        match self {
            Self::Next(voxels) | Self::Box(_, voxels) => voxels.len() as u64,
            Self::Same(region, _) => region.size.iter().map(|n| *n as u64).product(),
        }
    }

    /// The statistics of its voxels.
    pub fn tally(&self) -> Tally {
        match self {
            Self::Next(voxels) | Self::Box(_, voxels) => voxels.tally(),
            Self::Same(_, value) => Tally::of_equal(*value, self.len() as usize),
        }
    }

    /// Puts it into bricks.
    pub fn put_in_bricks(&self, builder: &mut BrickBuilder) -> Result<(), BuildError> {
        match self {
            Self::Next(voxels) => builder.append(voxels),
            Self::Box(region, voxels) => builder.put(region, voxels),
            Self::Same(region, value) => builder.fill(region, *value),
        }
    }
}

/// The voxels of a grid of `dims`, all of which come in `parts`; the file at `path` is named where there is no memory for them.
pub(super) fn joined(
    path: &Path,
    dims: [usize; 3],
    voxel: VoxelType,
    parts: impl Iterator<Item = Result<Part, ReadError>>,
) -> Result<Voxels, ReadError> {
    let memory = |bytes| ReadError::new(path, Problem::Memory(bytes));
    let count = voxel_count(dims).map_err(|e| ReadError::new(path, e))?;
    let mut all = Voxels::none(voxel);
    for part in parts {
        match part? {
            Part::Next(voxels) => all.append(voxels).map_err(memory)?,
            Part::Box(region, voxels) => {
                all.grow_to(count).map_err(memory)?;
                all.put(dims, &region, &voxels);
            }
            Part::Same(region, value) => {
                all.grow_to(count).map_err(memory)?;
                all.fill(dims, &region, value);
            }
        }
    }
    Ok(all)
}
