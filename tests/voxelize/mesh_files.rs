//! Readers of mesh files: what our writers and others write, what is refused and where, and that nothing makes them panic.

use std::fmt::Write;
use std::path::Path;

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use vcsg::surface::io::write_mesh;
use vcsg::surface::{Mesh, Part};
use vcsg::voxelize::TriangleMesh;
use vcsg::voxelize::mesh::read::{parse, read};

use crate::mesh_shapes::{solid, torus};

fn parsed(name: &str, bytes: &[u8]) -> TriangleMesh {
    parse(Path::new(name), bytes).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let error = parse(Path::new(name), bytes.as_ref()).expect_err("a refusal");
    error.to_string()
}

/// The corners of each triangle.
fn corners(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    let corner = |v: u32| mesh.positions[v as usize];
    mesh.triangles.iter().map(|t| t.map(corner)).collect()
}

/// A mesh with all that the formats have a place for, in two parts.
fn surface() -> Mesh {
    let mesh = torus(7, 5, [6.0, 2.5]);
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let part = |label, triangles| Part {
        label,
        iso: None,
        triangles,
    };
    Mesh {
        normals: positions
            .iter()
            .map(|p| Vec3::from(*p).normalize().to_array())
            .collect(),
        values: positions.iter().map(|p| p[0]).collect(),
        colors: positions.iter().map(|p| [p[0] as u8, 7, 9, 255]).collect(),
        parts: vec![part(1, 0..20), part(4, 20..mesh.triangles.len())],
        triangles: mesh.triangles.into(),
        positions: positions.into(),
    }
}

/// The bytes of a file of `mesh`, by its suffix.
fn written(mesh: &Mesh, suffix: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(format!("mesh.{suffix}"));
    write_mesh(&path, mesh).expect("written");
    std::fs::read(path).expect("readable")
}

#[test]
fn what_is_written_comes_back() {
    let mesh = surface();
    let bare = Mesh {
        normals: vec![].into(),
        values: vec![],
        colors: vec![],
        ..mesh.clone()
    };
    for mesh in [&mesh, &bare] {
        let expected: Vec<_> = (0..mesh.triangles.len()).map(|n| mesh.corners(n)).collect();
        for suffix in ["ply", "stl", "obj", "glb"] {
            let back = parsed(&format!("mesh.{suffix}"), &written(mesh, suffix));
            // Text has as many digits as single precision needs.
            let single = |corner: DVec3| corner.as_vec3().to_array();
            let back_single: Vec<_> = corners(&back).into_iter().map(|t| t.map(single)).collect();
            assert!(back_single == expected, "{suffix}");
            let is_exact = back.positions.iter().all(|p| p.as_vec3().as_dvec3() == *p);
            assert!(is_exact || suffix == "obj", "{suffix}");
            assert_eq!(solid(&back).triangle_count(), 70, "{suffix}");
        }
    }
}

/// A tetrahedron in text, one corner a line.
const CORNERS: &str = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

fn tetrahedron() -> TriangleMesh {
    TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: FACES.to_vec(),
    }
}

fn text_stl() -> String {
    let mut text = String::from("solid a\n");
    for corners in corners(&tetrahedron()) {
        text += " facet normal 0 0 0\n  outer loop\n";
        for p in corners {
            writeln!(text, "   vertex {} {} {:e}", p.x, p.y, p.z).expect("text");
        }
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid a\n"
}

fn text_ply() -> String {
    let faces: String = FACES.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty double x\nproperty float y\nproperty float z\n\
         element face 4\nproperty list uchar int vertex_index\nend_header\n{CORNERS}{faces}"
    )
}

/// With an element and lists that nobody asks for.
fn big_endian_ply() -> Vec<u8> {
    let header = "ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty short y\nproperty list uchar ushort extra\n\
        property double x\nproperty float32 z\nelement edge 2\nproperty uint8 a\nproperty list int8 float b\nelement face 4\n\
        property int label\nproperty list uint16 uint vertex_indices\nend_header\n";
    let mut bytes = header.as_bytes().to_vec();
    for p in tetrahedron().positions {
        bytes.extend((p.y as i16).to_be_bytes());
        bytes.extend([1, 0, 9]);
        bytes.extend(p.x.to_be_bytes());
        bytes.extend((p.z as f32).to_be_bytes());
    }
    bytes.extend([5, 1, 0, 0, 0, 0, 6, 0]);
    for face in FACES {
        bytes.extend((-1i32).to_be_bytes());
        bytes.extend(3u16.to_be_bytes());
        bytes.extend_from_slice(face.map(u32::to_be_bytes).as_flattened());
    }
    bytes
}

fn text_obj() -> String {
    let vertices: String = CORNERS.lines().map(|line| format!("v {line} 1.0\n")).collect();
    format!(
        "# x\nmtllib a.mtl\n{vertices}vn 0 0 1\nf 1/2/1 3//1 2\\\n# next\nf 1 \\\n 2 4\nf -3 -2 -1 # three\nf 1 4 3\n"
    )
    .replace("2\\\n# next", "2")
}

/// A GLB file of a document and its binary data.
fn glb(document: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = document.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = b"glTF".to_vec();
    let words = |file: &mut Vec<u8>, words: [u32; 2]| words.iter().for_each(|w| file.extend(w.to_le_bytes()));
    words(&mut file, [2, length as u32]);
    words(&mut file, [json.len() as u32, u32::from_le_bytes(*b"JSON")]);
    file.extend(json);
    words(&mut file, [binary.len() as u32, u32::from_le_bytes(*b"BIN\0")]);
    file.extend(binary);
    file
}

/// The tetrahedron with 16-bit indices, positions 16 bytes apart, and `nodes`.
fn tetrahedron_glb(nodes: &str) -> Vec<u8> {
    let mut binary = Vec::new();
    for p in tetrahedron().positions {
        [p.x, p.y, p.z, 7.0]
            .iter()
            .for_each(|x| binary.extend((*x as f32).to_le_bytes()));
    }
    FACES
        .iter()
        .flatten()
        .for_each(|v| binary.extend((*v as u16).to_le_bytes()));
    let document = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":4}},
        {{"bufferView":1,"componentType":5123,"type":"SCALAR","count":12}}],
        "bufferViews":[{{"buffer":0,"byteLength":64,"byteStride":16}},{{"buffer":0,"byteOffset":64,"byteLength":24}}],
        "buffers":[{{"byteLength":88}}]}}"#
    );
    glb(&document, &binary)
}

#[test]
fn other_ways_to_write_a_mesh_are_read() {
    let expected = corners(&tetrahedron());
    assert_eq!(corners(&parsed("a.STL", text_stl().as_bytes())), expected);
    assert_eq!(corners(&parsed("a.ply", text_ply().as_bytes())), expected);
    assert_eq!(
        corners(&parsed("a.ply", text_ply().replace('\n', "\r\n").as_bytes())),
        expected
    );
    assert_eq!(corners(&parsed("a.ply", &big_endian_ply())), expected);
    assert_eq!(corners(&parsed("a.obj", text_obj().as_bytes())), expected);
}

#[test]
fn polygons_become_fans() {
    let mesh = parsed(
        "a.obj",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n",
    );
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

/// A binary file may begin as text does.
#[test]
fn a_binary_file_called_solid_is_binary() {
    let mut file = written(&surface(), "stl");
    file[..5].copy_from_slice(b"solid");
    assert_eq!(parsed("a.stl", &file).triangles.len(), 70);
}

#[test]
fn nodes_move_what_they_hold() {
    let plain = parsed("a.glb", &tetrahedron_glb(r#"{"mesh":0}"#));
    // Metres, up along y and to the front along z.
    let world = |p: DVec3| DVec3::new(p.x, -p.z, p.y) * 1000.0;
    let expected = |place: fn(DVec3) -> DVec3| {
        corners(&tetrahedron())
            .into_iter()
            .map(move |t| t.map(place).map(world))
    };
    assert!(corners(&plain).into_iter().eq(expected(|p| p)));
    assert!(solid(&plain).contains(world(DVec3::splat(0.1))));
    let moved = parsed(
        "a.glb",
        &tetrahedron_glb(r#"{"children":[1],"translation":[1,2,3]},{"mesh":0,"scale":[2,1,-1],"rotation":[0,0,0,1]}"#),
    );
    let mirrored = expected(|p| p * DVec3::new(2.0, 1.0, -1.0) + DVec3::new(1.0, 2.0, 3.0));
    let turned = mirrored.map(|[a, b, c]| [a, c, b]);
    assert!(corners(&moved).into_iter().eq(turned), "a mirror turns triangles");
}

fn says(name: &str, bytes: &[u8], what: &str) {
    let text = refusal(name, bytes);
    assert!(text.contains(what), "{text} does not say {what}");
}

#[test]
fn refusals_say_what_and_where() {
    says("a.xyz", b"", "a.xyz: no mesh format has this suffix");
    says(
        "a.stl",
        b"",
        "a.stl, byte 0: the file ends before the number of triangles",
    );
    let stl = written(&surface(), "stl");
    says(
        "a.stl",
        &stl[..300],
        "a.stl, byte 80: 3584 bytes are declared, and the file has 300",
    );
    says(
        "a.stl",
        b"solid\nvertex 1 2\n",
        "line 2: the vertex has less than three coordinates",
    );
    says("a.stl", b"solid\nvertex 1 2 x\n", "line 2: `x` is not a number");
    says(
        "a.obj",
        b"v 0 0 0\nf 1 2\n",
        "a.obj, line 2: the face has less than three corners",
    );
    says("a.obj", b"v 0 0 0\n\nf 0 1 2\n", "line 3: `0` is no vertex");
    says(
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex x\n",
        "line 3: `element vertex x` is not of a PLY header",
    );
}

#[test]
fn refusals_of_ply_say_what_and_where() {
    let ply = text_ply();
    says(
        "a.ply",
        ply.replace("3 0 2 1", "3 0 2.5 1").as_bytes(),
        "line 15: 2.5 is no vertex",
    );
    says(
        "a.ply",
        ply.replace("vertex 4", "vertex 99999999999").as_bytes(),
        "the 99999999999 elements `vertex` that it declares",
    );
    says(
        "a.ply",
        ply.replace("element face 4", "element fac 4").as_bytes(),
        "the header has 0 elements `face`",
    );
    let header = "ply\nformat binary_big_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4000000000\nproperty list uchar int vertex_indices\nend_header\n\x03\0\0";
    says(
        "a.ply",
        header.as_bytes(),
        "the 4000000000 elements `face` that it declares",
    );
}

#[test]
fn refusals_of_glb_say_what_and_where() {
    let text = |from: &str, to: &str| {
        let file = tetrahedron_glb(r#"{"mesh":0}"#);
        let (json, rest) = (&file[20..file.len() - 96], &file[file.len() - 88..]);
        glb(&String::from_utf8_lossy(json).replace(from, to), rest)
    };
    for (from, to, what) in [
        ("\"count\":4", "\"count\":4000000000000", "byte"),
        ("\"count\":12", "\"count\":11", "11 corners"),
        (
            "\"indices\":1",
            "\"indices\":1,\"mode\":5",
            "mesh 0 has primitives of mode 5",
        ),
        ("\"mesh\":0", "\"mesh\":3", "no item 3 of `meshes`"),
        ("\"mesh\":0", "\"children\":[0]", "node 0 has several parents"),
        ("\"mesh\":0", "\"mesh\":0,\"skin\":0", "node 0 has a skin"),
        (
            "\"mesh\":0",
            "\"mesh\":0,\"matrix\":[1]",
            "node 0 has a `matrix` that is none",
        ),
        (
            "\"asset\"",
            "\"extensionsRequired\":[\"KHR_draco\"],\"asset\"",
            "requires the extension \"KHR_draco\"",
        ),
        ("\"byteLength\":88", "\"uri\":\"a.bin\"", "data outside the file"),
        ("\"byteLength\":24", "\"byteLength\":99", "ends beyond the 88 bytes"),
    ] {
        says("a.glb", &text(from, to), what);
    }
}

/// Files of all formats, small ones.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let mesh = Mesh {
        positions: tetrahedron()
            .positions
            .iter()
            .map(|p| p.as_vec3().to_array())
            .collect::<Vec<_>>()
            .into(),
        triangles: FACES.to_vec().into(),
        parts: vec![Part {
            label: 0,
            iso: None,
            triangles: 0..4,
        }],
        ..Mesh::default()
    };
    vec![
        ("a.ply", written(&mesh, "ply")),
        ("a.ply", text_ply().into_bytes()),
        ("a.ply", big_endian_ply()),
        ("a.stl", written(&mesh, "stl")),
        ("a.stl", text_stl().into_bytes()),
        ("a.obj", text_obj().into_bytes()),
        ("a.glb", written(&mesh, "glb")),
        ("a.glb", tetrahedron_glb(r#"{"children":[1]},{"mesh":0}"#)),
    ]
}

/// What reads as a part of a file is the part of a mesh; the rest says why not.
#[test]
fn a_file_cut_off_anywhere_is_refused_or_less() {
    for (name, file) in samples() {
        let whole = corners(&parsed(name, &file));
        for length in 0..file.len() {
            if let Ok(mesh) = parse(Path::new(name), &file[..length]) {
                let is_text = std::str::from_utf8(&file).is_ok();
                assert!(
                    is_text && mesh.triangles.len() <= whole.len(),
                    "{name} cut at {length} of {}",
                    file.len()
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn no_damage_makes_a_reader_panic(
        sample in 0..8usize,
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        is_cut in any::<bool>(),
    ) {
        let (name, mut file) = samples().swap_remove(sample);
        for (place, byte) in damage {
            let at = place.index(file.len());
            file[at] = byte;
        }
        if is_cut {
            file.truncate(cut.index(file.len()));
        }
        if let Ok(mesh) = parse(Path::new(name), &file) {
            // What is read may be no solid, and is told so.
            let _ = vcsg::voxelize::TriangleSolid::new(&mesh);
        }
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = read(Path::new("nowhere/a.stl")).expect_err("no file").to_string();
    assert!(error.starts_with("nowhere/a.stl: cannot be read"), "{error}");
}
