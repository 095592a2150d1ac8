//! 3D Slicer's lists of points, `.mrk.json`.

use glam::DVec3;
use serde::Deserialize;
use serde_json::json;

use super::{NamedPoint, Wrong, turned};

#[derive(Deserialize)]
struct File {
    markups: Vec<Markup>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Markup {
    #[serde(default)]
    coordinate_system: Option<String>,
    #[serde(default)]
    coordinate_units: Option<String>,
    #[serde(default)]
    control_points: Vec<ControlPoint>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct ControlPoint {
    #[serde(default)]
    label: String,
    #[serde(default)]
    position: Option<[f64; 3]>,
    /// `defined`, unless the point is still to be placed.
    #[serde(default)]
    position_status: Option<String>,
}

/// The points of the file's first list that are placed.
pub(super) fn read(text: &str) -> Result<Vec<NamedPoint>, Wrong> {
    let file: File = serde_json::from_str(text).map_err(|e| Wrong::at(e.line(), e.to_string()))?;
    let [markup, ..] = &file.markups[..] else {
        return Err(Wrong::whole("no markups in it"));
    };
    let ras = match markup.coordinate_system.as_deref() {
        None | Some("LPS") => false,
        Some("RAS") => true,
        Some(other) => {
            return Err(Wrong::whole(format!(
                "coordinate system {other:?}; RAS and LPS are known"
            )));
        }
    };
    let unit_mm = match markup.coordinate_units.as_deref() {
        None | Some("mm") => 1.0,
        Some("um") => 1e-3,
        Some("cm") => 10.0,
        Some("m") => 1e3,
        Some(other) => {
            return Err(Wrong::whole(format!(
                "coordinate unit {other:?}; um, mm, cm and m are known"
            )));
        }
    };
    let placed = |p: &&ControlPoint| p.position_status.as_deref().is_none_or(|status| status == "defined");
    let points = markup.control_points.iter().filter(placed).enumerate();
    points.map(|(n, point)| named(n, point, ras, unit_mm)).collect()
}

fn named(n: usize, point: &ControlPoint, ras: bool, unit_mm: f64) -> Result<NamedPoint, Wrong> {
    let name = match point.label.is_empty() {
        true => format!("{}", n + 1),
        false => point.label.clone(),
    };
    let unplaced = || Wrong::whole(format!("control point {name} has no position"));
    let place = DVec3::from(point.position.ok_or_else(unplaced)?) * unit_mm;
    Ok(NamedPoint {
        place: if ras { turned(place) } else { place },
        name,
    })
}

pub(super) fn written(points: &[NamedPoint]) -> String {
    let point = |(n, p): (usize, &NamedPoint)| {
        json!({
            "id": format!("{}", n + 1),
            "label": p.name,
            "position": p.place.to_array(),
            "positionStatus": "defined",
        })
    };
    let points: Vec<_> = points.iter().enumerate().map(point).collect();
    let schema = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";
    let list = json!({
        "type": "Fiducial",
        "coordinateSystem": "LPS",
        "coordinateUnits": "mm",
        "controlPoints": points,
    });
    format!("{:#}\n", json!({ "@schema": schema, "markups": [list] }))
}
