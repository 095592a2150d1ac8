//! `vcsg mesh`: the surface of a scene or a volume as a triangle mesh.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::CliError;
use super::console::{Stages, note, print, print_json, progress};
use super::source::SourceArgs;
use crate::surface::io::{check_suffix, write_mesh};
use crate::surface::{Mesh, Topology, extract, extract_target};
use crate::volume::io;

/// Extract the surface of a scene or a volume
#[derive(Debug, Args)]
#[command(
    after_help = "A volume's surface is vtkMarchingCubes'. A scene's is closed: where the model is cut, on the cut itself.

Examples:
  vcsg mesh head.nii.gz --iso 60 -o skin.ply
  vcsg mesh ct.nrrd --iso -300 --iso 200 -o skin-and-bone.glb
  vcsg mesh scene.kdl --iso 80 --spacing 0.5 -o solid.stl --topology trilinear --json"
)]
pub(super) struct MeshCommand {
    #[command(flatten)]
    source: SourceArgs,
    /// The value whose surface is extracted; several make a part of the mesh each
    #[arg(long, value_name = "V", required = true, allow_negative_numbers = true)]
    iso: Vec<f64>,
    /// The mesh, as .ply, .stl, .obj, .glb or .vtp
    #[arg(short, long, value_name = "MESH")]
    output: PathBuf,
    /// How the surface runs where corners of a cell leave it open
    #[arg(long, value_enum, default_value = "vtk")]
    topology: TopologyName,
    /// Print how long each stage took
    #[arg(long)]
    timings: bool,
    /// Describe the mesh as JSON on stdout
    #[arg(long)]
    json: bool,
}

/// What `--topology` takes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum TopologyName {
    /// As vtkMarchingCubes
    Vtk,
    /// As the trilinear interpolant: always a manifold
    Trilinear,
}

impl From<TopologyName> for Topology {
    fn from(name: TopologyName) -> Self {
        match name {
            TopologyName::Vtk => Self::Vtk,
            TopologyName::Trilinear => Self::Trilinear,
        }
    }
}

impl MeshCommand {
    /// Loads, extracts, writes.
    pub fn run(&self) -> Result<(), CliError> {
        check_suffix(&self.output)?;
        let mut stages = Stages::default();
        let mesh = self.surfaces(&mut stages)?;
        stages.time("write", || write_mesh(&self.output, &mesh))?;
        if self.timings {
            stages.show();
        }
        self.describe(&mesh, &stages)
    }

    /// The surfaces of all isovalues, each with a label of its own.
    fn surfaces(&self, stages: &mut Stages) -> Result<Mesh, CliError> {
        if crate::scene::is_scene_file(&self.source.path) || self.source.resamples() {
            self.of_scene(stages)
        } else {
            self.of_volume(stages)
        }
    }

    fn of_volume(&self, stages: &mut Stages) -> Result<Mesh, CliError> {
        let volume = stages.time("load", || io::read(&self.source.path))?;
        let mut all = Mesh::default();
        for iso in &self.iso {
            let mesh = stages.time("extract", || extract(&volume.grid, *iso, self.topology.into()))?;
            if mesh.is_empty() {
                let stats = volume.grid.stats();
                note_empty(*iso, stats.min, stats.max);
            }
            all.append(mesh)?;
        }
        Ok(all)
    }

    fn of_scene(&self, stages: &mut Stages) -> Result<Mesh, CliError> {
        let scene = stages.time("load", || self.source.load())?;
        let target = stages.time("subdivide", || scene.target.build(&scene.model))?;
        let mut all = Mesh::default();
        for iso in &self.iso {
            let bar = progress("extract", target.lattice.dims[2] as u64);
            let mut done = |n: usize| bar.inc(n as u64);
            let mesh = stages.time("extract", || {
                extract_target(&target, *iso, self.topology.into(), &mut done)
            })?;
            bar.finish_and_clear();
            if mesh.is_empty() {
                note_empty(*iso, f64::from(target.value_range.lo), f64::from(target.value_range.hi));
            }
            all.append(mesh)?;
        }
        Ok(all)
    }

    fn describe(&self, mesh: &Mesh, stages: &Stages) -> Result<(), CliError> {
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        if self.json {
            return print_json(&json!({
                "mesh": self.output,
                "vertices": vertices,
                "triangles": triangles,
                "milliseconds": stages.to_json(),
            }));
        }
        print(&format!("vertices   {vertices}\ntriangles  {triangles}"))
    }
}

/// Says that nothing was found, and where something might be.
fn note_empty(iso: f64, min: f64, max: f64) {
    note(&format!("the surface at {iso} is empty: values go from {min} to {max}"));
}
