//! `vcsg info`: what a scene or a volume holds.

use clap::Args;
use serde_json::json;

use super::CliError;
use super::console::{print, print_json};
use super::job::model_bounds;
use super::source::SourceArgs;
use crate::model::Node;
use crate::model::deform::{Morph, WarpReport};
use crate::scene::Scene;
use crate::target::Target;
use crate::volume::io::{Opened, VolumeInfo};

/// Describe a scene or a volume
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg info head.nii.gz
  vcsg info scene.kdl
  vcsg info --json head.nrrd
  vcsg formats                                      # what is read and written")]
pub(super) struct Info {
    #[command(flatten)]
    source: SourceArgs,
    /// Describe it as JSON on stdout
    #[arg(long)]
    json: bool,
}

impl Info {
    /// Prints the description.
    pub fn run(&self) -> Result<(), CliError> {
        if crate::scene::is_scene_file(&self.source.path) {
            self.scene()
        } else {
            self.volumes()
        }
    }

    fn volumes(&self) -> Result<(), CliError> {
        let volumes = self.source.open_volumes()?;
        let volumes: Vec<_> = volumes.into_iter().map(Opened::info).collect::<Result<_, _>>()?;
        if self.json {
            print_json(&json!({ "volumes": volumes }))
        } else {
            let texts: Vec<_> = volumes.iter().map(volume_text).collect();
            print(&texts.join("\n\n"))
        }
    }

    fn scene(&self) -> Result<(), CliError> {
        let scene = self.source.load()?;
        let target = scene.target.build(&scene.model)?;
        let summary = summary(&scene, &target);
        if self.json {
            print_json(&json!({ "scene": summary }))
        } else {
            print(&scene_text(&summary))
        }
    }
}

fn volume_text(info: &VolumeInfo) -> String {
    let [nx, ny, nz] = info.dims;
    let [sx, sy, sz] = info.spacing;
    let [ox, oy, oz] = info.origin;
    let [dx, dy, dz] = [0, 3, 6].map(|i| format!("{:?}", &info.direction[i..i + 3]));
    let name = match info.name.as_str() {
        "" => String::new(),
        name => format!("volume     {name}\n"),
    };
    let missing = match info.non_finite {
        0 => String::new(),
        n => format!("\nnot finite {n} voxels"),
    };
    let notes: String = info.notes.iter().map(|note| format!("\nnote       {note}")).collect();
    format!(
        "{name}format     {}\nsize       {nx} x {ny} x {nz} voxels of {}, {} frame(s)\nspacing    {sx} x {sy} x {sz} mm\norigin     {ox} {oy} {oz} mm (LPS)\ndirection  {dx} {dy} {dz}\nvalues     {} to {}, mean {:.4}{missing}{notes}",
        info.format,
        info.voxel.name(),
        info.frames,
        info.min,
        info.max,
        info.mean,
    )
}

fn summary(scene: &Scene, target: &Target) -> serde_json::Value {
    let bounds = model_bounds(scene);
    let volumes = scene
        .model
        .nodes()
        .iter()
        .filter(|n| matches!(n, Node::Volume(_)))
        .count();
    let mut summary = json!({
        "nodes": scene.model.nodes().len(),
        "volume_nodes": volumes,
        "bounds_mm": [bounds.min.to_array(), bounds.max.to_array()],
        "lattice": target.lattice.dims,
        "spacing_mm": target.lattice.spacing_mm().to_array(),
        "blocks": target.blocks.len(),
        "paths": target.paths.len(),
        "value_range": [target.value_range.lo, target.value_range.hi],
    });
    let deformations: Vec<_> = target.tree.deformations().map(deformation).collect();
    if !deformations.is_empty() {
        summary["deformations"] = deformations.into();
    }
    summary
}

fn deformation((morph, report): (&Morph, &WarpReport)) -> serde_json::Value {
    let spline = morph.spline();
    json!({
        "landmarks": spline.landmarks(),
        "dimensions_spanned": spline.rank(),
        "largest_residual_mm": spline.residual_mm(),
        "smallest_det_j": morph.smallest_stretch(),
        "cells": report.cells,
        "measured_error_voxels": report.measured_voxels,
    })
}

fn scene_text(summary: &serde_json::Value) -> String {
    let line = |(name, value): (&String, &serde_json::Value)| format!("{:<13} {value}", name.replace('_', " "));
    let lines: Vec<_> = summary.as_object().into_iter().flatten().map(line).collect();
    lines.join("\n")
}
