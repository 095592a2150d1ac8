//! Colours from values (LC87 §5.2, texture mapping).
//!
//! *Changes from the paper.* It maps a scan on a cut by the lengths of normals; here vertices have colours.
//! *Practice.* Vertices on a cut carry the scan's values. Where parts share vertices, the part that is painted last has them;
//! [`Creases::Sharp`](super::Creases::Sharp) keeps parts apart.

use super::mesh::Mesh;
use crate::projection::TransferFunction;

/// Colours the vertices of part `part` of a mesh with values by these; others stay as they are, or white.
///
/// ```
/// use vcsg::surface::{Mesh, Part, gray_window, paint};
///
/// let mut mesh = Mesh {
///     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into(),
///     values: vec![0.0, 50.0, 900.0],
///     triangles: vec![[0, 1, 2]].into(),
///     parts: vec![Part { label: 1, iso: None, triangles: 0..1 }],
///     ..Mesh::default()
/// };
/// paint(&mut mesh, 0, gray_window(0.0, 100.0));
/// assert_eq!(mesh.colors, [[0, 0, 0, 255], [128, 128, 128, 255], [255; 4]]);
/// ```
pub fn paint(mesh: &mut Mesh, part: usize, color: impl Fn(f32) -> [u8; 4]) {
    mesh.colors.resize(mesh.positions.len(), [u8::MAX; 4]);
    let triangles = mesh
        .parts
        .get(part)
        .and_then(|part| mesh.triangles.get(part.triangles.clone()));
    for v in triangles.unwrap_or_default().iter().flatten().map(|v| *v as usize) {
        if let (Some(place), Some(value)) = (mesh.colors.get_mut(v), mesh.values.get(v)) {
            *place = color(*value);
        }
    }
}

/// Opaque greys: black up to the value `low`, and where there is no value; white from `high` on.
pub fn gray_window(low: f32, high: f32) -> impl Fn(f32) -> [u8; 4] {
    move |value| {
        let fraction = ((value - low) / (high - low)).clamp(0.0, 1.0);
        let gray = (fraction * 255.0).round() as u8;
        [gray, gray, gray, u8::MAX]
    }
}

/// The colours of a transfer function, opaque.
pub fn transfer_colors(function: &TransferFunction) -> impl Fn(f32) -> [u8; 4] {
    move |value| {
        let (rgb, _) = function.evaluate(value);
        let [r, g, b] = rgb.map(|c| (c * 255.0).round() as u8);
        [r, g, b, u8::MAX]
    }
}
