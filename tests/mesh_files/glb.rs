//! GLB: what is stored, bit for bit; what it means in glTF's frame; and the document.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use vcsg::surface::Mesh;
use vcsg::surface::io::write_mesh;

use crate::oracle::{assert_same, bits, read, vectors};
use crate::sample;

/// The JSON chunk, and how long the arrays are.
fn document(path: &Path) -> (Value, usize) {
    let file = fs::read(path).expect("a file");
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
    let end = 20 + word(12);
    assert_eq!((&file[16..20], end % 4), (&b"JSON"[..], 0));
    let json = serde_json::from_slice(&file[20..end]).expect("JSON");
    if end == file.len() {
        return (json, 0);
    }
    assert_eq!(
        (&file[end + 4..end + 8], end + 8 + word(end)),
        (&b"BIN\0"[..], file.len())
    );
    (json, word(end))
}

#[test]
fn primitives_are_parts_as_they_are_stored() {
    let mesh = sample::torus();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    write_mesh(&path, &mesh).expect("written");
    let [found] = read([("trimesh", &path)]);
    assert_eq!(found.as_array().map(Vec::len), Some(mesh.parts.len()));
    // Left is +X, superior +Y, anterior +Z; 1 mm is 0.001 m.
    let rows = json!([
        [0.001, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.001, 0.0],
        [0.0, -0.001, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0]
    ]);
    for (n, part) in mesh.parts.iter().enumerate() {
        assert_same("position", &found[n]["positions"], &bits(&mesh.positions));
        assert_same("normal", &found[n]["normals"], &bits(&mesh.normals));
        assert_same(
            "triangle",
            &found[n]["triangles"],
            &mesh.triangles[part.triangles.clone()],
        );
        assert_eq!(found[n]["matrix"], rows);
    }
}

#[test]
fn vtk_sees_metres_with_y_upwards() {
    let mesh = sample::torus();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    write_mesh(&path, &mesh).expect("written");
    let [found] = read([("vtk", &path)]);
    for part in 0..mesh.parts.len() {
        let positions = vectors(&found[part]["positions"]);
        // 0.001 and the product are rounded to f32, each by at most 2⁻²⁴ of itself; the sum's other terms are zero.
        assert_turned(&positions, &mesh.positions, 0.001, |x| {
            2.0 * 2.0_f64.powi(-24) * x.abs() * 1.000_001
        });
        // VTK turns normals by the inverse's transpose and divides by their length, all in f32: the matrix's entry, its
        // inverse, the product, three squares and two sums under the root (half of them), the root and the quotient are
        // at most 8 roundings of 2⁻²⁴; the length that was written is 1 but for 2 roundings.
        let normals = vectors(&found[part]["normals"]);
        assert_turned(&normals, &mesh.normals, 1.0, |x| {
            10.0 * 2.0_f64.powi(-24) * x.abs() * 1.000_001
        });
        assert_colors(&found[part]["points"]["COLOR_0"], &mesh.colors);
    }
}

/// Fails unless `found` is `scale` times `written`, left on X, superior on Y, anterior on Z, up to `bound` of it.
fn assert_turned(found: &[[f32; 3]], written: &[[f32; 3]], scale: f64, bound: impl Fn(f64) -> f64) {
    assert_eq!(found.len(), written.len());
    for (n, (found, lps)) in found.iter().zip(written).enumerate() {
        let [left, posterior, superior] = lps.map(|x| f64::from(x) * scale);
        for (found, expected) in found.iter().zip([left, superior, -posterior]) {
            let off = (f64::from(*found) - expected).abs();
            assert!(off <= bound(expected), "{n}: {found} instead of {expected}");
        }
    }
}

/// Fails unless linear fractions, coded as sRGB, are `colors`.
fn assert_colors(found: &Value, colors: &[[u8; 4]]) {
    let found: Vec<[u32; 4]> = serde_json::from_value(found.clone()).expect("four numbers a vertex");
    let coded = |light: f64| match light <= 0.003_130_8 {
        true => light * 12.92,
        false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    };
    let codes: Vec<[u8; 4]> = found
        .iter()
        .map(|color| {
            let [r, g, b, alpha] = color.map(|bits| f64::from(f32::from_bits(bits)));
            [coded(r), coded(g), coded(b), alpha].map(|x| (x * 255.0).round() as u8)
        })
        .collect();
    assert!(codes == colors, "colours differ");
}

#[test]
fn the_document_says_what_there_is() {
    let mesh = sample::torus();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    write_mesh(&path, &mesh).expect("written");
    let (document, bytes) = document(&path);
    assert_eq!(document["buffers"], json!([{ "byteLength": bytes }]));
    let primitives = &document["meshes"][0]["primitives"];
    assert_eq!(primitives[0]["extras"], json!({ "label": 1, "iso": 80.5 }));
    assert_eq!(primitives[1]["extras"], json!({ "label": 7, "iso": null }));
    assert_eq!(primitives[0]["attributes"], primitives[1]["attributes"]);
    let position = &document["accessors"][primitives[0]["attributes"]["POSITION"].as_u64().expect("a number") as usize];
    for axis in 0..3 {
        let coordinates = mesh.positions.iter().map(|p| p[axis]);
        let stored = |bound: &str| position[bound][axis].as_f64().map(|x| x as f32);
        assert_eq!(stored("min"), coordinates.clone().reduce(f32::min));
        assert_eq!(stored("max"), coordinates.reduce(f32::max));
    }
}

#[test]
fn only_normals_of_length_1_are_stored() {
    let mut mesh = sample::torus();
    // The last vertex loses its triangles, the other one keeps them.
    let last = mesh.positions.len() as u32 - 1;
    mesh.triangles
        .iter_mut()
        .flatten()
        .filter(|v| **v == last)
        .for_each(|v| *v = 0);
    for vertex in [5, last as usize] {
        mesh.normals[vertex] = [0.0; 3];
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    write_mesh(&path, &mesh).expect("written");
    let [found] = read([("trimesh", &path)]);
    let normals = vectors(&found[0]["normals"]);
    let outwards = dot(normals[5], sample::torus().normals[5]);
    assert!(outwards > 0.9, "{:?}", normals[5]);
    assert_eq!(normals[last as usize], [0.0, 0.0, 1.0]);
    assert_eq!(normals[..5], mesh.normals[..5]);
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn without_triangles_there_is_a_scene_without_meshes() {
    let points = Mesh {
        positions: vec![[1.0, 2.0, 3.0]].into(),
        ..Mesh::default()
    };
    let folder = tempfile::tempdir().expect("a folder");
    for (name, mesh) in [("none.glb", Mesh::default()), ("points.glb", points)] {
        let path = folder.path().join(name);
        write_mesh(&path, &mesh).expect("written");
        assert_eq!(read([("trimesh", &path)]), [json!([])]);
        let (document, bytes) = document(&path);
        let absent = ["nodes", "meshes", "accessors", "bufferViews", "buffers"];
        assert!(absent.iter().all(|name| document.get(name).is_none()), "{document}");
        assert_eq!(bytes, 0);
    }
}

#[test]
fn an_empty_part_has_no_primitive() {
    let mut mesh = sample::torus();
    let all = mesh.triangles.len();
    mesh.parts = sample::parts(&[(1, 0), (2, all), (3, 0)]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    write_mesh(&path, &mesh).expect("written");
    let (document, _) = document(&path);
    let primitives = document["meshes"][0]["primitives"].as_array().expect("a list");
    assert_eq!(primitives.len(), 1);
    assert_eq!(primitives[0]["extras"]["label"], 2);
}
