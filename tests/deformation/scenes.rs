//! Deformations in scenes.

use std::path::Path;

use vcsg::model::Node;
use vcsg::scene::{NoVolumes, Scene, SceneError};

fn parse(text: &str, folder: &Path) -> Result<Scene, SceneError> {
    Scene::parse("test.kdl", text, folder, &mut NoVolumes)
}

const PAIRS: &str = "0 0 0 1 0 0\n9 0 0 9 0 0\n0 9 0 0 9 0\ntip 0 0 9 0 0 8\n";

const FCSV: &str = "# CoordinateSystem = LPS\n0,0,0,0\n1,9,0,0\n2,0,9,0\n3,0,0,9\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("pairs.txt"), PAIRS).expect("a file");
    std::fs::write(folder.path().join("before.fcsv"), FCSV).expect("a file");
    std::fs::write(folder.path().join("after.fcsv"), FCSV.replace("0,0,0,0", "0,1,0,0")).expect("a file");
    std::fs::write(folder.path().join("short.fcsv"), "0,1,2,3\n").expect("a file");
    folder
}

#[test]
fn landmarks_come_from_a_table_two_lists_or_children() {
    let folder = folder();
    let inline = "pair from=\"0 0 0\" to=\"1 0 0\"; pair from=\"9 0 0\" to=\"9 0 0\"; pair from=\"0 9 0\" to=\"0 9 0\"";
    for (properties, children, landmarks) in [
        ("landmarks=\"pairs.txt\"", "", 4),
        ("from=\"before.fcsv\" to=\"after.fcsv\" stiffness=0.5 support=80", "", 4),
        ("error=0.5", inline, 3),
    ] {
        let text = format!("scene {{ deform {properties} {{ {children}\n sphere radius=5 }} }}");
        let scene = parse(&text, folder.path()).expect("a scene");
        let Some(Node::Deform {
            morph, error_voxels, ..
        }) = scene.model.nodes().last()
        else {
            panic!("no deformation: {text}");
        };
        assert_eq!(morph.spline().landmarks(), landmarks);
        assert_eq!(*error_voxels, if properties.starts_with("error") { 0.5 } else { 0.1 });
        let target = scene.target.build(&scene.model).expect("a target");
        assert!(!target.blocks.is_empty() && target.tree.deformations().count() == 1);
    }
}

/// Holds what a node in a scene is answered with.
fn told(folder: &tempfile::TempDir, node: &str, column: usize, needle: &str) {
    let error = parse(&format!("scene {{\n    {node}\n}}"), folder.path()).expect_err(needle);
    assert_eq!(error.place(), Some((2, column)), "{error}");
    assert!(error.to_string().contains(needle), "{error}");
}

#[test]
fn what_cannot_be_deformed_is_said_with_its_place() {
    let folder = folder();
    let told = |node: &str, column: usize, needle: &str| told(&folder, node, column, needle);
    told(
        "deform { sphere radius=5 }",
        5,
        "takes its landmarks from `pair` children",
    );
    told(
        "deform landmarks=\"pairs.txt\" to=\"after.fcsv\" { sphere radius=5 }",
        5,
        "takes its landmarks from",
    );
    told("deform landmarks=\"none.txt\" { sphere radius=5 }", 12, "none.txt");
    told(
        "deform from=\"before.fcsv\" to=\"short.fcsv\" { sphere radius=5 }",
        31,
        "4 points before and 1 after",
    );
    told(
        "deform from=\"pairs.txt\" to=\"short.fcsv\" { sphere radius=5 }",
        12,
        "is a .fcsv or a .mrk.json",
    );
    told(
        "deform landmarks=\"pairs.txt\" stiffness=-1 { sphere radius=5 }",
        34,
        "`stiffness` is -1",
    );
    told(
        "deform landmarks=\"pairs.txt\" support=0 { sphere radius=5 }",
        34,
        "`support` is 0",
    );
    told(
        "deform landmarks=\"pairs.txt\" { half-space normal=\"0 0 1\" }",
        5,
        "what is deformed is endless",
    );
    told("deform landmarks=\"pairs.txt\" { }", 5, "needs at least one child");
    told(
        "deform { pair from=\"0 0 0\" to=\"1 0 0\"; sphere radius=5 }",
        5,
        "1 landmarks are too few",
    );
}

#[test]
fn a_fold_and_a_pair_without_an_end_are_said_with_their_places() {
    let folder = folder();
    let told = |node: &str, column: usize, needle: &str| told(&folder, node, column, needle);
    let far = "pair name=\"far\" from=\"1 0 0\" to=\"-9 0 0\"; pair from=\"-1 0 0\" to=\"9 0 0\"; pair from=\"0 9 0\" to=\"0 9 0\"";
    told(
        &format!("deform {{ {far}; sphere radius=5 }}"),
        5,
        "space folds over itself about",
    );
    told(
        "deform { pair from=\"0 0 0\"; sphere radius=5 }",
        14,
        "`pair` needs the property `to`",
    );
}
