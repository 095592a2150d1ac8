//! What cannot be written: a clear error, and nothing left behind.

use std::fs;
use std::io;
use std::path::Path;

use vcsg::surface::Mesh;
use vcsg::surface::io::{MeshWriteError, check_suffix, write_mesh};

use crate::sample;

#[test]
fn an_unknown_suffix_is_refused_with_the_known_ones() {
    for name in ["a.gltf", "a", "ply", "a.ply.gz", ""] {
        let error = check_suffix(Path::new(name)).expect_err(name).to_string();
        assert!(
            error.starts_with(name) && error.contains(".ply, .stl, .obj, .glb, .vtp"),
            "{error}"
        );
    }
    for name in ["a.ply", "a.b.STL", "folder.x/a.Obj", "a.gLB", ".vtp.vtp"] {
        check_suffix(Path::new(name)).expect(name);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let refused = write_mesh(&folder.path().join("a.txt"), &Mesh::default());
    assert!(
        matches!(refused, Err(MeshWriteError::UnknownSuffix { .. })),
        "{refused:?}"
    );
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn a_mesh_that_contradicts_itself_leaves_the_old_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mesh = sample::torus();
    mesh.triangles[17][2] = 1_000_000;
    for suffix in ["ply", "stl", "obj", "glb", "vtp"] {
        let path = folder.path().join(format!("a.{suffix}"));
        fs::write(&path, "old").expect("a first file");
        let error = write_mesh(&path, &mesh).expect_err("no such vertex").to_string();
        assert_eq!(
            error,
            "the mesh is inconsistent: triangle 17 has vertex 1000000 of 2560"
        );
        assert_eq!(fs::read(&path).expect("read"), b"old");
    }
}

#[test]
fn numbers_that_are_none_are_refused_where_there_are_none() {
    let folder = tempfile::tempdir().expect("a folder");
    for suffix in ["obj", "glb"] {
        let path = folder.path().join(format!("a.{suffix}"));
        let mut mesh = sample::torus();
        mesh.normals[9][1] = f32::INFINITY;
        let error = write_mesh(&path, &mesh).expect_err("infinite").to_string();
        assert!(
            error.starts_with("vertex 9 has a normal that is NaN or infinite"),
            "{error}"
        );
        mesh.positions[5][2] = f32::NAN;
        let error = write_mesh(&path, &mesh).expect_err("NaN").to_string();
        assert!(
            error.starts_with("vertex 5 has a position that is NaN or infinite"),
            "{error}"
        );
        assert!(!path.exists());
    }
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    for suffix in ["ply", "stl", "obj", "glb", "vtp"] {
        let path = folder.path().join(format!("a.{suffix}"));
        std::os::unix::fs::symlink("/dev/full", &path).expect("a link");
        match write_mesh(&path, &sample::torus()) {
            Err(MeshWriteError::Output(error)) => assert_eq!(error.source.kind(), io::ErrorKind::StorageFull),
            other => panic!("{suffix}: {other:?}"),
        }
        fs::remove_file(&path).expect("the link is still there");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn a_missing_folder_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = write_mesh(&folder.path().join("none/a.ply"), &sample::bare()).expect_err("no folder");
    assert!(error.to_string().contains("none/a.ply"), "{error}");
}
