//! PLY, STL, OBJ and VTP, bit for bit.

use std::fs;
use std::path::PathBuf;

use serde_json::json;
use tempfile::TempDir;
use vcsg::surface::Mesh;
use vcsg::surface::io::write_mesh;

use crate::oracle::{assert_same, bits, read, vectors};
use crate::sample::{self, Torus};

/// `mesh` in files of these suffixes, in a folder that lives as long as it is held.
fn written<const N: usize>(mesh: &Mesh, suffixes: [&str; N]) -> (TempDir, [PathBuf; N]) {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = suffixes.map(|suffix| folder.path().join(format!("a.{suffix}")));
    for path in &paths {
        write_mesh(path, mesh).expect("written");
    }
    (folder, paths)
}

fn labels(mesh: &Mesh) -> Vec<u32> {
    let of_part = |part: &vcsg::surface::Part| vec![part.label; part.triangles.len()];
    mesh.parts.iter().flat_map(of_part).collect()
}

fn value_bits(mesh: &Mesh) -> Vec<u32> {
    mesh.values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn ply_holds_everything() {
    let mesh = sample::torus();
    let (_folder, [path]) = written(&mesh, ["ply"]);
    let [found, vtk] = read([("trimesh", &path), ("vtk", &path)]);
    assert_same("position", &found["positions"], &bits(&mesh.positions));
    assert_same("normal", &found["normals"], &bits(&mesh.normals));
    assert_same("value", &found["values"], &value_bits(&mesh));
    assert_same("color", &found["colors"], &mesh.colors);
    assert_same("triangle", &found["triangles"], &mesh.triangles);
    assert_same("label", &found["labels"], &labels(&mesh));
    assert_same("position", &vtk["positions"], &bits(&mesh.positions));
    assert_same("normal", &vtk["normals"], &bits(&mesh.normals));
    assert_same("color", &vtk["points"]["RGBA"], &mesh.colors);
    assert_same("triangle", &vtk["triangles"], &mesh.triangles);
}

#[test]
fn stl_holds_facets() {
    let mesh = sample::torus();
    let (_folder, [path]) = written(&mesh, ["stl"]);
    let corners: Vec<_> = (0..mesh.triangles.len()).flat_map(|n| bits(&mesh.corners(n))).collect();
    let [found, vtk] = read([("trimesh", &path), ("vtk", &path)]);
    assert_same("corner", &vtk["positions"], &corners);
    assert_same("corner", &found["positions"], &corners);
    for (n, normal) in vectors(&found["facet_normals"]).iter().enumerate() {
        let [a, b, c] = mesh.corners(n).map(|corner| corner.map(f64::from));
        let [u, v] = [b, c].map(|corner| [0, 1, 2].map(|axis| corner[axis] - a[axis]));
        let cross = [0, 1, 2].map(|axis: usize| {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            u[next] * v[last] - u[last] * v[next]
        });
        let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        for axis in 0..3 {
            // Rounding to f32 moves a number below 1 by 2⁻²⁵. What both sides round in f64 is far below as much again,
            // since no triangle is thin: |u × v| is above |u| |v| / 2⁸.
            let off = (f64::from(normal[axis]) - cross[axis] / length).abs();
            assert!(off <= 2.0_f64.powi(-24), "facet {n}: {normal:?}, {off:e} off");
        }
    }
}

#[test]
fn obj_holds_normals_colors_and_groups() {
    let mesh = sample::torus();
    let (_folder, [path]) = written(&mesh, ["obj"]);
    let [found, vtk] = read([("trimesh", &path), ("vtk", &path)]);
    // VTK numbers the groups, in f32.
    let group = |label: &u32| f32::from(u8::from(*label == 7)).to_bits();
    let groups: Vec<_> = labels(&mesh).iter().map(group).collect();
    let colors: Vec<_> = mesh.colors.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let opaque: Vec<_> = colors.iter().map(|[r, g, b]| [*r, *g, *b, 255]).collect();
    for reader in [&found, &vtk] {
        assert_same("position", &reader["positions"], &bits(&mesh.positions));
        assert_same("normal", &reader["normals"], &bits(&mesh.normals));
        assert_same("triangle", &reader["triangles"], &mesh.triangles);
    }
    assert_same("color", &vtk["points"]["RGB"], &colors);
    assert_same("color", &found["colors"], &opaque);
    assert_same("group", &vtk["cells"]["GroupIds"], &groups);
    let text = fs::read_to_string(&path).expect("text");
    assert!(text.contains("\ng label_1\n") && text.contains("\ng label_7\n"));
}

#[test]
fn obj_holds_every_finite_number() {
    let extremes = [
        [f32::MAX, f32::MIN_POSITIVE / 8.0, -0.0],
        [1.0e-7, 16_777_217.0, -1.1],
        [0.1 + 0.2, 1.0 / 3.0, 1e9],
    ];
    let mesh = Mesh {
        positions: extremes.to_vec().into(),
        triangles: vec![[0, 1, 2]].into(),
        parts: sample::parts(&[(0, 1)]),
        ..Mesh::default()
    };
    let (_folder, [path]) = written(&mesh, ["obj"]);
    let [found] = read([("vtk", &path)]);
    assert_same("position", &found["positions"], &bits(&extremes));
}

#[test]
fn vtp_holds_everything() {
    let mesh = sample::torus();
    let (_folder, [path]) = written(&mesh, ["vtp"]);
    let [found] = read([("vtk", &path)]);
    assert_same("position", &found["positions"], &bits(&mesh.positions));
    assert_same("normal", &found["normals"], &bits(&mesh.normals));
    assert_same("value", &found["points"]["Value"], &value_bits(&mesh));
    assert_same("color", &found["points"]["Colors"], &mesh.colors);
    assert_same("triangle", &found["triangles"], &mesh.triangles);
    assert_same("label", &found["cells"]["Label"], &labels(&mesh));
}

#[test]
fn what_is_optional_is_left_out() {
    let mesh = sample::bare();
    let (_folder, paths) = written(&mesh, ["ply", "obj", "vtp"]);
    for found in read(paths.each_ref().map(|path| ("vtk", path))) {
        assert_same("position", &found["positions"], &bits(&mesh.positions));
        assert_same("triangle", &found["triangles"], &mesh.triangles);
        assert_eq!(found["points"], json!({}));
    }
}

#[test]
fn every_file_names_its_frame() {
    let (_folder, paths) = written(&sample::bare(), ["ply", "stl", "obj", "vtp"]);
    for found in read(paths.each_ref().map(|path| ("vtk", path))) {
        let space = found["space"].as_str().expect("text");
        assert!(space.contains("SPACE=LPS"), "{space}");
    }
}

#[test]
fn numbers_that_are_none_are_kept_in_binary() {
    let mut mesh = sample::torus();
    mesh.positions[5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let (_folder, paths) = written(&mesh, ["ply", "vtp"]);
    for found in read(paths.each_ref().map(|path| ("vtk", path))) {
        assert_same("position", &found["positions"], &bits(&mesh.positions));
    }
}

#[test]
fn a_mesh_without_triangles_is_a_file() {
    let points = Mesh {
        positions: vec![[1.0, 2.0, 3.0]].into(),
        ..Mesh::default()
    };
    let suffixes = ["ply", "stl", "obj", "vtp"];
    let (_empty, empty) = written(&Mesh::default(), suffixes);
    for found in read(empty.each_ref().map(|path| ("vtk", path))) {
        let held = [&found["positions"], &found["triangles"]];
        assert_eq!(held, [&json!([]), &json!([])]);
    }
    let (_points, points) = written(&points, suffixes);
    for found in read(points.each_ref().map(|path| ("vtk", path))) {
        assert_eq!(found["triangles"], json!([]));
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    // Several chunks a thread.
    let mesh = Torus { around: [400, 300] }.mesh();
    let on_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        let (_folder, paths) = pool
            .expect("threads")
            .install(|| written(&mesh, ["ply", "stl", "obj", "glb", "vtp"]));
        paths.map(|path| fs::read(path).expect("read"))
    };
    for (one, three) in on_threads(1).iter().zip(&on_threads(3)) {
        assert!(one == three, "{}", String::from_utf8_lossy(&one[..80]));
    }
}
