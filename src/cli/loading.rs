//! Volumes that are shown to be loading.

use std::sync::Arc;

use super::console::loading_progress;
use crate::scene::{MeshRequest, VolumeFiles, VolumeLoader, VolumeRequest};
use crate::volume::Bricks;
use crate::volume::io::{self, Budget, Opened};
use crate::voxelize::mesh::TriangleSolid;

/// Reads volumes and meshes from files, with a bar on stderr for each volume.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShownFiles {
    /// The most memory that reading a volume may take.
    pub budget: Budget,
}

impl VolumeLoader for ShownFiles {
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        let mut options = request.options.clone();
        options.budget = self.budget;
        io::open(&request.path, &options)
            .and_then(|opened| shown(opened).bricks())
            .map(Arc::new)
            .map_err(|error| error.to_string())
    }

    fn load_mesh(&mut self, request: &MeshRequest) -> Result<Arc<TriangleSolid>, String> {
        VolumeFiles.load_mesh(request)
    }
}

/// `opened`, with a bar on stderr while its voxels come.
pub(super) fn shown(opened: Opened) -> Opened {
    let voxel = opened.declared().voxel.bytes() as u64;
    let bar = loading_progress(opened.declared().bytes());
    opened.watched(move |voxels| {
        bar.inc(voxels.saturating_mul(voxel));
        if Some(bar.position()) == bar.length() {
            bar.finish_and_clear();
        }
    })
}
