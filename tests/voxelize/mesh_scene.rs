//! Meshes in scenes.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use vcsg::model::Node;
use vcsg::scene::{MeshRequest, NoVolumes, Scene, VolumeFiles, VolumeLoader, VolumeRequest};
use vcsg::volume::Bricks;
use vcsg::voxelize::{Solid, TriangleSolid};

use crate::mesh_shapes::{cuboid, solid};

const CUBE: &str = "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n\
    f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";

fn load(scene: &str, files: &[(&str, &str)]) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("parts")).expect("a folder");
    for (name, text) in files.iter().chain([&("main.kdl", scene)]) {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let loaded = Scene::load(&folder.path().join("main.kdl"), &mut VolumeFiles);
    loaded.map_err(|error| error.to_string())
}

fn solids(scene: &Scene) -> Vec<(Arc<TriangleSolid>, f64, f32)> {
    let solid = |node: &Node| match node {
        Node::Primitive(p) => match &p.solid {
            Solid::Mesh(solid) => Some((Arc::clone(solid), p.filter_voxels, p.value)),
            _ => None,
        },
        _ => None,
    };
    scene.model.nodes().iter().filter_map(solid).collect()
}

#[test]
fn a_mesh_is_a_primitive_with_value_filter_and_unit() {
    let text = "scene { mesh \"parts/cube.obj\" value=70 filter=1.5 unit-mm=25.4 }";
    let scene = load(text, &[("parts/cube.obj", CUBE)]).expect("a scene");
    let [(solid, filter, value)] = &solids(&scene)[..] else {
        panic!("one mesh")
    };
    assert_eq!((*filter, *value), (1.5, 70.0));
    assert_eq!((solid.bounds().max, solid.triangle_count()), (DVec3::splat(25.4), 12));
}

#[test]
fn a_mesh_is_read_once_relative_to_its_file() {
    let include = "scene { mesh \"cube.obj\"; mesh \"cube.obj\" unit-mm=2 }";
    let text =
        "scene { mesh \"parts/cube.obj\"; translate \"9 0 0\" { mesh \"parts/cube.obj\" }; include \"parts/a.kdl\" }";
    let scene = load(text, &[("parts/cube.obj", CUBE), ("parts/a.kdl", include)]).expect("a scene");
    let solids = solids(&scene);
    assert_eq!(solids.len(), 4);
    assert!(Arc::ptr_eq(&solids[0].0, &solids[1].0) && Arc::ptr_eq(&solids[0].0, &solids[2].0));
    assert_eq!(solids[3].0.bounds().max, DVec3::splat(2.0));
}

#[test]
fn what_is_wrong_with_a_mesh_is_said_at_its_name() {
    let refused =
        |file: &str| load("scene {\n  mesh \"parts/a.obj\"\n}", &[("parts/a.obj", file)]).expect_err("a refusal");
    let open = refused(&CUBE.replace("f 1 2 4 3\n", ""));
    assert!(
        open.contains("main.kdl:2:8: cannot load the mesh") && open.contains("a.obj: the mesh is not watertight"),
        "{open}"
    );
    let bad = refused("v 0 0\n");
    assert!(
        bad.contains("main.kdl:2:8: ") && bad.contains("a.obj, line 1: the vertex has"),
        "{bad}"
    );
    let missing = load("scene { mesh \"no.ply\" }", &[]).expect_err("no file");
    assert!(missing.contains("no.ply: cannot be read"), "{missing}");
    let unit = load("scene { mesh \"a.obj\" unit-mm=0 }", &[]).expect_err("no size");
    assert!(unit.contains("`unit-mm` is 0; it must be above 0"), "{unit}");
    let none =
        Scene::parse("a.kdl", "scene { mesh \"a.obj\" }", Path::new("."), &mut NoVolumes).expect_err("no meshes");
    assert!(none.to_string().contains("meshes are not available here"), "{none}");
}

/// A loader that makes its meshes.
struct Cubes;

impl VolumeLoader for Cubes {
    fn load(&mut self, _: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        Err("none".into())
    }

    fn load_mesh(&mut self, request: &MeshRequest) -> Result<Arc<TriangleSolid>, String> {
        let bounds = vcsg::math::Aabb::new(DVec3::ZERO, DVec3::splat(request.unit_mm));
        Ok(Arc::new(solid(&cuboid(&bounds))))
    }
}

#[test]
fn another_loader_may_make_meshes() {
    let text = "scene { mesh \"any\" unit-mm=3 }";
    let scene = Scene::parse("a.kdl", text, Path::new("."), &mut Cubes).expect("a scene");
    assert_eq!(solids(&scene)[0].0.bounds().max, DVec3::splat(3.0));
}
