//! `vcsg bake`: a scene's target as one volume file.

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use serde_json::json;

use super::CliError;
use super::console::{Stages, print_json, progress};
use super::overrides;
use super::source::SourceArgs;
use crate::scene::Scene;
use crate::target::{Block, BlockVoxels, Levels, Target};
use crate::volume::io::{self, Encoding, VolumeBeside};
use crate::volume::{Grid, Voxels};

/// Sample a scene into one volume file
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg bake scene.kdl -o scene.nrrd
  vcsg bake scene.kdl -o coarse.nrrd --spacing 2
  vcsg bake scene.kdl -o level.nrrd --levels 4      # level-0.nrrd … level-3.nrrd
  vcsg bake ct-cut.kdl -o ct-cut.nrrd --outside -1024")]
pub(super) struct Bake {
    #[command(flatten)]
    source: SourceArgs,
    /// The volume, in the format of its suffix: see `vcsg formats`
    #[arg(short, long, value_name = "VOLUME")]
    output: PathBuf,
    /// The value where the scene holds nothing
    #[arg(long, value_name = "V", default_value = "0", value_parser = overrides::single, allow_negative_numbers = true)]
    outside: f32,
    /// Write so many levels, OUTPUT-0.nrrd and so on: each with voxels and filters twice as wide as the one before
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Levels::MAX)))]
    levels: Option<u32>,
    /// Store the voxels as they are, not compressed
    #[arg(long)]
    raw: bool,
    /// Print how long each stage took
    #[arg(long)]
    timings: bool,
    /// Describe the volume as JSON on stdout
    #[arg(long)]
    json: bool,
}

impl Bake {
    /// Loads, samples, writes.
    pub fn run(&self) -> Result<(), CliError> {
        io::writer_of(&self.output)?;
        let mut stages = Stages::default();
        let scene = stages.time("load", || self.source.load())?;
        let volumes = match self.levels {
            Some(count) => self.levels(&scene, count, &mut stages)?,
            None => {
                let target = stages.time("subdivide", || scene.target.build(&scene.model))?;
                vec![self.volume(&target, self.output.clone(), &mut stages)?]
            }
        };
        let mut described = Vec::new();
        for volume in volumes {
            stages.time("write", || volume.beside.put())?;
            described.push(volume.description);
        }
        if self.timings {
            stages.show();
        }
        if !self.json {
            return Ok(());
        }
        let milliseconds = stages.to_json();
        print_json(&match described.as_mut_slice() {
            [volume] if self.levels.is_none() => {
                volume["milliseconds"] = milliseconds;
                volume.take()
            }
            _ => json!({ "levels": described, "milliseconds": milliseconds }),
        })
    }

    /// All levels, each beside its place: none is put there before all are written.
    fn levels(&self, scene: &Scene, count: u32, stages: &mut Stages) -> Result<Vec<Volume>, CliError> {
        let paths = (0..count).map(|level| self.level_path(level));
        if let Some(folder) = paths.clone().find(|path| path.is_dir()) {
            return Err(CliError::Usage(format!("{}: it is a folder", folder.display())));
        }
        if scene.target.coarsen {
            let why = "levels are not coarsened: use a larger --spacing or --budget-mib";
            return Err(CliError::Usage(why.into()));
        }
        let levels = Levels::new(&scene.model, scene.target.spacing_mm, count)?;
        let mut volumes = Vec::new();
        for (level, path) in (0..count).zip(paths) {
            let lattice = levels.whole(level)?;
            let target = stages.time("subdivide", || {
                Target::on_lattice(&scene.model, lattice, &scene.target.subdivision())
            })?;
            volumes.push(self.volume(&target, path, stages)?);
        }
        Ok(volumes)
    }

    /// The file of a level: its number before the suffix.
    fn level_path(&self, level: u32) -> PathBuf {
        let name = self.output.file_name().unwrap_or_default().to_string_lossy();
        let start = name
            .to_ascii_lowercase()
            .strip_suffix(".gz")
            .map_or(name.len(), str::len);
        let (stem, suffix) = name.split_at(name[..start].rfind('.').unwrap_or(start));
        self.output.with_file_name(format!("{stem}-{level}{suffix}"))
    }

    /// Samples and writes, beside `path`.
    fn volume(&self, target: &Target, path: PathBuf, stages: &mut Stages) -> Result<Volume, CliError> {
        let grid = stages.time("reconstruct", || baked(target, self.outside))?;
        let encoding = if self.raw { Encoding::Raw } else { Encoding::Gzip };
        let description = json!({
            "volume": path,
            "dims": grid.dims(),
            "spacing_mm": target.lattice.spacing_mm().to_array(),
        });
        let beside = stages.time("write", || VolumeBeside::write(&path, &grid, encoding))?;
        Ok(Volume { beside, description })
    }
}

/// A volume that is written but not yet in its place.
struct Volume {
    beside: VolumeBeside,
    description: serde_json::Value,
}

/// Blocks that are reconstructed before they are copied.
const BATCH: usize = 16;

/// The target's values on its lattice, weighted by coverage against `outside`.
fn baked(target: &Target, outside: f32) -> Result<Grid, CliError> {
    let lattice = &target.lattice;
    let mut voxels = Vec::new();
    let what = "the volume";
    voxels.try_reserve_exact(lattice.len()).map_err(|_| CliError::Memory {
        what,
        mib: lattice.len() >> 18,
    })?;
    voxels.resize(lattice.len(), outside);
    let bar = progress("reconstruct", target.blocks.len() as u64);
    for batch in target.blocks.chunks(BATCH) {
        let done: Vec<_> = batch
            .par_iter()
            .map(|block| BlockVoxels::reconstruct(target, block, 0))
            .collect();
        for (block, values) in batch.iter().zip(&done) {
            copy(&mut voxels, lattice.dims, block, values);
        }
        bar.inc(batch.len() as u64);
    }
    bar.finish_and_clear();
    let grid = Grid::new(lattice.dims, lattice.world_from_lattice, Voxels::F32(voxels));
    grid.map_err(|error| CliError::Usage(error.to_string()))
}

/// Writes the covered voxels of a block to their place in the volume.
fn copy(voxels: &mut [f32], [nx, ny, _]: [usize; 3], block: &Block, values: &BlockVoxels) {
    let [width, height, depth] = block.extent;
    for (n, (j, k)) in (0..depth).flat_map(|k| (0..height).map(move |j| (j, k))).enumerate() {
        let first = block.origin[0] + nx * (block.origin[1] + j + ny * (block.origin[2] + k));
        let row = n * width..(n + 1) * width;
        let out = &mut voxels[first..first + width];
        match &values.coverage {
            None => out.copy_from_slice(&values.premultiplied[row]),
            Some(coverage) => {
                let samples = values.premultiplied[row.clone()].iter().zip(&coverage[row]);
                // What is `outside` shows as far as nothing covers it, so that soft surfaces stay soft.
                out.iter_mut()
                    .zip(samples)
                    .filter(|(_, (_, c))| **c > 0.0)
                    .for_each(|(out, (premultiplied, c))| *out = premultiplied + (1.0 - c) * *out);
            }
        }
    }
}
