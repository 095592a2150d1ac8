//! `vcsg convert`: a volume in another format.

use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::source::ReadArgs;
use crate::scene::is_scene_file;
use crate::volume::io::{self, Encoding};

/// Write a volume in another format
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg convert head.nii.gz head.nrrd
  vcsg convert head.nrrd head.mhd --raw
  vcsg convert fmri.nii frame-12.nii --volume-frame 12
  vcsg formats                                      # what is read and written")]
pub(super) struct Convert {
    /// A volume: a file or a folder of slices
    #[arg(value_name = "VOLUME")]
    input: PathBuf,
    /// The file to write, in the format of its suffix
    #[arg(value_name = "OUTPUT")]
    output: PathBuf,
    /// Store the voxels as they are, not compressed
    #[arg(long)]
    raw: bool,
    #[command(flatten)]
    read: ReadArgs,
}

impl Convert {
    /// Reads and writes.
    pub fn run(&self) -> Result<(), CliError> {
        io::writer_of(&self.output)?;
        if is_scene_file(&self.input) {
            let what = format!("{}: a scene is sampled with `vcsg bake`", self.input.display());
            return Err(CliError::Usage(what));
        }
        let grid = io::open(&self.input, &self.read.options())?.grid()?;
        let encoding = if self.raw { Encoding::Raw } else { Encoding::Gzip };
        Ok(io::write(&self.output, &grid, encoding)?)
    }
}
