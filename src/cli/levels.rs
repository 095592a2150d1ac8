//! From a scene of several levels to a frame.

use serde_json::json;

use super::CliError;
use super::console::Stages;
use super::job::{Renderer, transfer_function};
use crate::image::Frame;
use crate::projection::{Camera, LevelsSpec, ZoneDrawn};
use crate::scene::Scene;
use crate::target::{Levels, Target};

/// Refuses what levels do not go together with; scene files are checked when they are read.
pub(super) fn check(scene: &Scene) -> Result<(), CliError> {
    let why = if scene.target.coarsen {
        "a scene with `levels` is not coarsened: use a larger --spacing or --budget-mib"
    } else if !scene.surfaces.is_empty() {
        "surfaces are extracted from one level: set `levels` to 1, or leave --surface out"
    } else {
        return Ok(());
    };
    Err(CliError::Usage(why.into()))
}

/// The frame of `scene` that `camera` sees, and the zones that it is made of.
pub(super) fn draw(
    scene: &Scene,
    camera: &Camera,
    renderer: &mut Renderer,
    stages: &mut Stages,
) -> Result<(Frame, Vec<ZoneDrawn>), CliError> {
    check(scene)?;
    let options = &scene.target;
    let subdivision = options.subdivision();
    let levels = Levels::new(&scene.model, options.spacing_mm, options.levels)?;
    // Statistics of the values are those of the whole model, wherever the eye is; the coarsest level is the cheapest to look at.
    let transfer = stages.time("transfer", || {
        let coarsest = levels.whole(levels.count - 1)?;
        let whole = Target::on_lattice(&scene.model, coarsest, &subdivision)?;
        Ok::<_, CliError>(transfer_function(scene, &whole))
    })?;
    let spec = LevelsSpec {
        levels: &levels,
        subdivision: &subdivision,
        transfer: &transfer,
        camera,
        settings: &scene.settings,
    };
    let drawn = renderer.draw_levels(&spec)?;
    stages.add("reconstruct", drawn.reconstruct);
    stages.add("upload", drawn.upload);
    stages.add("draw", drawn.draw);
    Ok((drawn.frame, drawn.zones))
}

/// For `--json`.
pub(super) fn description(zones: &[ZoneDrawn]) -> serde_json::Value {
    let zone = |drawn: &ZoneDrawn| {
        json!({
            "level": drawn.zone.level,
            "depths_mm": [drawn.zone.near_mm, drawn.zone.far_mm],
            "lattice": drawn.dims,
            "blocks": drawn.blocks,
            "stored_voxels": drawn.stored_voxels,
            "slices": drawn.slices,
        })
    };
    json!({ "levels": zones.iter().map(zone).collect::<Vec<_>>() })
}
