//! The scene or volume that a command works on, and how its target is built.

use std::path::PathBuf;

use clap::Args;

use glam::{DAffine3, DVec3};

use super::CliError;
use super::loading::{ShownFiles, shown};
use super::overrides::positive;
use crate::scene::{Scene, VolumeLoader, is_scene_file};
use crate::volume::VoxelType;
use crate::volume::io::raw::RawLayout;
use crate::volume::io::{self, Budget, ByteOrder, Opened, ReadOptions};

/// What is read, and what is changed of how its target is built.
#[derive(Debug, Args)]
pub(super) struct SourceArgs {
    /// A scene file (.kdl), or a volume: a file or a folder of slices
    #[arg(value_name = "SCENE|VOLUME")]
    pub path: PathBuf,
    #[command(flatten)]
    read: ReadArgs,
    /// Distance between samples, millimetres
    #[arg(long, value_name = "MM", value_parser = positive)]
    spacing: Option<f64>,
    /// The most memory for target blocks
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..))]
    budget_mib: Option<u32>,
    /// Make a target beyond the budget coarser instead of refusing it
    #[arg(long)]
    coarsen: bool,
}

impl SourceArgs {
    /// Whether a volume is to be sampled on another lattice than its own.
    pub fn resamples(&self) -> bool {
        self.spacing.is_some()
    }

    /// Which volume of the file is meant.
    ///
    /// # Errors
    /// If it is said of a scene, whose volumes say it themselves.
    fn read_options(&self) -> Result<ReadOptions, CliError> {
        let options = self.read.options();
        match is_scene_file(&self.path) && options != ReadOptions::default() {
            true => Err(CliError::Usage(format!(
                "{}: which volume of a file is meant is said by the scene's `volume` nodes",
                self.path.display()
            ))),
            false => Ok(options),
        }
    }

    /// Where a scene's volumes come from.
    pub fn files(&self) -> ShownFiles {
        let budget = self.read.budget();
        ShownFiles { budget }
    }

    /// The volume that is named, opened.
    ///
    /// # Errors
    /// As [`io::open`].
    pub fn open_volume(&self) -> Result<Opened, CliError> {
        Ok(shown(io::open(&self.path, &self.volume_options()?)?))
    }

    /// All volumes of the file or folder that is named, opened.
    ///
    /// # Errors
    /// As [`io::open_all`].
    pub fn open_volumes(&self) -> Result<Vec<Opened>, CliError> {
        let volumes = io::open_all(&self.path, &self.volume_options()?)?;
        Ok(volumes.into_iter().map(shown).collect())
    }

    /// Which volume of a file is meant, and what reading may take.
    fn volume_options(&self) -> Result<ReadOptions, CliError> {
        Ok(ReadOptions {
            budget: self.read.budget(),
            ..self.read_options()?
        })
    }

    /// The scene, with the options that were given in place of its own.
    pub fn load(&self) -> Result<Scene, CliError> {
        self.load_with(&mut self.files())
    }

    /// The same, with volumes from `loader`.
    pub fn load_with(&self, loader: &mut dyn VolumeLoader) -> Result<Scene, CliError> {
        let mut scene = Scene::open(&self.path, &self.read_options()?, loader)?;
        self.apply(&mut scene);
        Ok(scene)
    }

    /// Sets in `scene` what was given.
    pub fn apply(&self, scene: &mut Scene) {
        scene.target.spacing_mm = self.spacing.or(scene.target.spacing_mm);
        scene.target.budget_mib = self.budget_mib.unwrap_or(scene.target.budget_mib);
        scene.target.coarsen |= self.coarsen;
    }
}

/// Which volume of a file is meant, and what a file without a header holds.
#[derive(Debug, Args)]
#[command(next_help_heading = "Volume files")]
pub(super) struct ReadArgs {
    /// The volume of a series in time, from 0 on
    #[arg(long = "volume-frame", value_name = "N")]
    frame: Option<usize>,
    /// The DICOM series: the end of its UID, or its description
    #[arg(long, value_name = "NAME")]
    series: Option<String>,
    /// The VTK array
    #[arg(long, value_name = "NAME")]
    array: Option<String>,
    /// The component of a voxel, or the channel, from 0 on; otherwise luminance, magnitude or the first channel
    #[arg(long, value_name = "N")]
    component: Option<usize>,
    /// Of an image stored at several resolutions, which: from 0, the finest, on
    #[arg(long, value_name = "N")]
    resolution: Option<usize>,
    /// Resample slices at uneven distances instead of refusing them
    #[arg(long)]
    resample: bool,
    /// Voxels along x, y, z of a file without a header
    #[arg(long, value_name = "X,Y,Z", value_parser = triple::<usize>, requires = "raw_type")]
    raw_dims: Option<[usize; 3]>,
    /// Their type: u8 i8 u16 i16 u32 i32 f32 f64
    #[arg(long, value_name = "TYPE", value_parser = voxel_type, requires = "raw_dims")]
    raw_type: Option<VoxelType>,
    /// Millimetres between them
    #[arg(long, value_name = "X,Y,Z", value_parser = spacing, default_value = "1,1,1", requires = "raw_dims")]
    raw_spacing: DVec3,
    /// Whether their bytes begin with the most significant one
    #[arg(long, requires = "raw_dims")]
    raw_big_endian: bool,
    /// Bytes before the first
    #[arg(long, value_name = "BYTES", default_value = "0", requires = "raw_dims")]
    raw_skip: u64,
    /// The most memory that reading a volume may take [default: half of what there is]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    read_budget_mib: Option<u64>,
}

impl ReadArgs {
    fn budget(&self) -> Budget {
        self.read_budget_mib
            .map_or_else(Budget::default, |mib| Budget::of_bytes(mib.saturating_mul(1 << 20)))
    }

    /// As the reader takes them.
    pub fn options(&self) -> ReadOptions {
        let layout = self.raw_dims.zip(self.raw_type).map(|(dims, voxel)| RawLayout {
            dims,
            voxel,
            order: if self.raw_big_endian {
                ByteOrder::Big
            } else {
                ByteOrder::Little
            },
            offset: self.raw_skip,
            world_from_index: DAffine3::from_scale(self.raw_spacing),
        });
        ReadOptions {
            frame: self.frame,
            series: self.series.clone(),
            array: self.array.clone(),
            component: self.component,
            resolution: self.resolution,
            resample: self.resample,
            raw: layout,
            budget: Budget::default(),
        }
    }
}

fn triple<T: std::str::FromStr>(text: &str) -> Result<[T; 3], String> {
    let numbers: Vec<T> = text
        .split([',', 'x'])
        .map_while(|word| word.trim().parse().ok())
        .collect();
    let wanted = || format!("`{text}` is not three numbers like 256,256,128");
    numbers.try_into().map_err(|_| wanted())
}

fn spacing(text: &str) -> Result<DVec3, String> {
    let [x, y, z] = text.split(',').map(positive).collect::<Result<Vec<_>, _>>()?[..] else {
        return Err(format!("`{text}` is not three numbers like 1,1,2.5"));
    };
    Ok(DVec3::new(x, y, z))
}

fn voxel_type(text: &str) -> Result<VoxelType, String> {
    let types = [
        VoxelType::U8,
        VoxelType::I8,
        VoxelType::U16,
        VoxelType::I16,
        VoxelType::U32,
        VoxelType::I32,
        VoxelType::F32,
        VoxelType::F64,
    ];
    let names = types.map(VoxelType::name).join(" ");
    (types.into_iter().find(|t| t.name() == text)).ok_or_else(|| format!("`{text}` is none of {names}"))
}
