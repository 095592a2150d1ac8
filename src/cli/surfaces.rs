//! A scene's surfaces, from its target to what draws them.

use std::sync::Arc;

use serde_json::json;

use super::CliError;
use super::console::{Stages, note_empty, progress};
use crate::gpu::Device;
use crate::render::{DeviceMesh, DeviceMeshError, ShownMesh};
use crate::scene::SurfaceSpec;
use crate::surface::{Mesh, MeshLook, extract_target};
use crate::target::Target;

/// An extracted surface.
pub(super) struct Surface {
    spec: SurfaceSpec,
    mesh: Mesh,
}

impl Surface {
    /// The surfaces of `target` that `specs` name.
    ///
    /// # Errors
    /// If one has too many triangles.
    pub fn extract_all(specs: &[SurfaceSpec], target: &Target, stages: &mut Stages) -> Result<Vec<Self>, CliError> {
        if specs.is_empty() {
            return Ok(Vec::new());
        }
        let bar = progress("extract", (specs.len() * target.lattice.dims[2]) as u64);
        let extract = |spec: &SurfaceSpec| Self::extract(*spec, target, &mut |n| bar.inc(n as u64));
        let surfaces = stages.time("extract", || specs.iter().map(extract).collect());
        bar.finish_and_clear();
        surfaces
    }

    fn extract(spec: SurfaceSpec, target: &Target, done: &mut dyn FnMut(usize)) -> Result<Self, CliError> {
        let mesh = extract_target(target, spec.iso, spec.topology, done)?;
        if mesh.is_empty() {
            let values = target.value_range;
            note_empty(spec.iso, f64::from(values.lo), f64::from(values.hi));
        }
        Ok(Self { spec, mesh })
    }

    /// For `--json`.
    pub fn description(&self) -> serde_json::Value {
        json!({ "iso": self.spec.iso, "triangles": self.mesh.triangles.len() })
    }
}

/// Surfaces as they are drawn on the processor.
pub(super) fn shown(surfaces: &[Surface]) -> Vec<(&Mesh, MeshLook)> {
    surfaces
        .iter()
        .map(|surface| (&surface.mesh, surface.spec.look))
        .collect()
}

/// Surfaces on a device.
pub(super) struct DeviceSurfaces(Vec<(DeviceMesh, MeshLook)>);

impl DeviceSurfaces {
    /// Brings `surfaces` to `device`.
    ///
    /// # Errors
    /// If the device has not enough memory, or is lost.
    pub fn new(device: &Arc<Device>, surfaces: &[Surface]) -> Result<Self, DeviceMeshError> {
        let bring = |surface: &Surface| Ok((DeviceMesh::new(device, &surface.mesh)?, surface.spec.look));
        surfaces.iter().map(bring).collect::<Result<_, _>>().map(Self)
    }

    /// As a renderer takes them.
    pub fn shown(&self) -> Vec<ShownMesh<'_>> {
        let meshes = self.0.iter();
        meshes.map(|(mesh, look)| ShownMesh { mesh, look: *look }).collect()
    }
}
