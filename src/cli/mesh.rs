//! `vcsg mesh`: the surface of a scene or a volume as a triangle mesh.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;
use serde_json::json;

use super::CliError;
use super::console::{Stages, note, note_empty, print, print_json, progress};
use super::overrides;
use super::source::SourceArgs;
use crate::surface::io::{check_suffix, write_mesh};
use crate::surface::{Border, Creases, Cutter, Operation, SolidOptions, combine, gray_window, paint};
use crate::surface::{
    Measures, Mesh, SimplifyGoal, Topology, extract, extract_target, keep_largest, keep_touching, simplify,
};
use crate::volume::{Grid, averaged_slices};

/// Extract the surface of a scene or a volume
#[derive(Debug, Args)]
#[command(
    after_help = "A volume's surface is vtkMarchingCubes'. A scene's is closed: where the model is cut, on the cut itself.

Examples:
  vcsg mesh head.nii.gz --iso 60 -o skin.ply
  vcsg mesh head.nii.gz --iso 60 --cut 0,0,20 0,0,1 -o cut.glb
  vcsg mesh ct.nrrd --iso -300 --iso 200 -o skin-and-bone.glb
  vcsg mesh head.nii.gz --iso 60 --largest 1 --simplify 100000 -o skin.stl
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
    /// Average four pixels of a slice into one first; of a volume on its own lattice
    #[arg(long)]
    average: bool,
    /// Cut what NORMAL points to off at a plane, and close the mesh with the values there in grey; of a volume on its own lattice
    #[arg(long, num_args = 2, value_names = ["X,Y,Z", "NX,NY,NZ"], value_parser = overrides::point, allow_hyphen_values = true,
          conflicts_with = "topology")]
    cut: Vec<DVec3>,
    /// Keep the N largest pieces, by area
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    largest: Option<u32>,
    /// Keep the piece nearest to a point, LPS millimetres; of several, the pieces nearest to any
    #[arg(long, value_name = "X,Y,Z", value_parser = overrides::point, allow_hyphen_values = true, conflicts_with = "largest")]
    seed: Vec<DVec3>,
    /// Merge triangles until there are no more than N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    simplify: Option<u32>,
    /// Merge triangles as long as the error is no more than MM
    #[arg(long, value_name = "MM", value_parser = overrides::positive, conflicts_with = "simplify")]
    simplify_error: Option<f64>,
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
        let mesh = self.kept(mesh, &mut stages);
        let mesh = self.simplified(mesh, &mut stages);
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
        let opened = self.source.open_volume()?;
        let mut grid = stages.time("load", || opened.grid())?;
        if self.average {
            let averaged = stages.time("average", || averaged_slices(&grid));
            grid = averaged.map_err(|error| CliError::Usage(error.to_string()))?;
        }
        let mut all = Mesh::default();
        for iso in &self.iso {
            let mesh = stages.time("extract", || self.of_grid(&grid, *iso))?;
            if mesh.is_empty() {
                let stats = grid.stats();
                note_empty(*iso, stats.min, stats.max);
            }
            all.append(mesh)?;
        }
        Ok(all)
    }

    /// The surface of a grid, cut if that was asked for.
    fn of_grid(&self, grid: &Grid, iso: f64) -> Result<Mesh, CliError> {
        let [through, normal] = self.cut[..] else {
            return Ok(extract(grid, iso, self.topology.into())?);
        };
        if normal == DVec3::ZERO {
            return Err(CliError::Usage("--cut: the normal is 0,0,0".to_owned()));
        }
        let options = SolidOptions {
            border: Border::Closed,
            creases: Creases::Shared,
        };
        let plane = Cutter::half_space(through, normal);
        let mut mesh = combine(grid, iso, Operation::Intersection, plane, options)?;
        for cap in 1..mesh.parts.len() {
            let [low, high] = window(&mesh, cap);
            paint(&mut mesh, cap, gray_window(low, high));
        }
        Ok(mesh)
    }

    fn of_scene(&self, stages: &mut Stages) -> Result<Mesh, CliError> {
        if self.average || !self.cut.is_empty() {
            let why = "--average and --cut need a volume on its own lattice; use a larger --spacing, or cut nodes in the scene";
            return Err(CliError::Usage(why.to_owned()));
        }
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

    /// The pieces that were asked for.
    fn kept(&self, mesh: Mesh, stages: &mut Stages) -> Mesh {
        match self.largest {
            Some(n) => stages.time("connect", || keep_largest(&mesh, n as usize)),
            None if !self.seed.is_empty() => stages.time("connect", || keep_touching(&mesh, &self.seed)),
            None => mesh,
        }
    }

    fn simplified(&self, mesh: Mesh, stages: &mut Stages) -> Mesh {
        let goal = match (self.simplify, self.simplify_error) {
            (Some(n), _) => SimplifyGoal::Triangles(n as usize),
            (None, Some(mm)) => SimplifyGoal::ErrorMm(mm as f32),
            (None, None) => return mesh,
        };
        let simplified = stages.time("simplify", || simplify(&mesh, goal));
        note(&format!("simplified with an error of {:.3} mm", simplified.error_mm));
        simplified.mesh
    }

    fn describe(&self, mesh: &Mesh, stages: &Stages) -> Result<(), CliError> {
        let measures = Measures::of(mesh);
        if self.json {
            return print_json(&json!({
                "mesh": self.output,
                "measures": measures,
                "milliseconds": stages.to_json(),
            }));
        }
        print(&text(&measures))
    }
}

/// Where a part's values lie, but for one in fifty below and above.
fn window(mesh: &Mesh, part: usize) -> [f32; 2] {
    let corners = mesh.triangles[mesh.parts[part].triangles.clone()].iter().flatten();
    let mut values: Vec<f32> = corners
        .map(|v| mesh.values[*v as usize])
        .filter(|v| v.is_finite())
        .collect();
    values.sort_by(f32::total_cmp);
    let at = |n: usize| values.get(n).copied().unwrap_or(0.0);
    [
        at(values.len() / 50),
        at(values.len().saturating_sub(1 + values.len() / 50)),
    ]
}

/// The figures of a mesh, one a line.
fn text(m: &Measures) -> String {
    let volume = match m.volume_mm3 {
        Some(volume) => format!("{volume:.1} mm³"),
        None => "not closed".to_owned(),
    };
    let mut text = format!(
        "vertices            {}\ntriangles           {}\narea                {:.1} mm²\nvolume              {volume}\n\
         components          {}\nboundary edges      {}\nnon-manifold edges  {}",
        m.vertices, m.triangles, m.area_mm2, m.components, m.boundary_edges, m.non_manifold_edges
    );
    if m.non_finite_vertices > 0 {
        text += &format!("\nnot finite          {} vertices", m.non_finite_vertices);
    }
    text
}
