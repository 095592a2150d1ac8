//! Nodes are added, removed and moved in a scene's text; edits are undone and redone; key frames set values.

use std::path::Path;

use glam::DVec3;
use proptest::prelude::*;
use proptest::sample::Index;
use vcsg::model::Node;
use vcsg::scene::{
    Editor, NoVolumes, Problem, Scene, SceneError, Source, with_argument, with_node, with_node_moved, with_property,
    without_node,
};
use vcsg::target::VoxelTarget;
use vcsg::voxelize::Solid;

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("scene.kdl", text, Path::new("."), &mut NoVolumes)
}

fn source(text: &str) -> Source {
    Source::new("scene.kdl", text)
}

const SCENE: &str = "// Two balls.
scene spacing=1 {
    sphere radius=3 center=\"0 0 0\" // the first
    /* in between */
    subtract {
        sphere radius=4 center=\"9 0 0\"; box min=\"9 -5 -5\" max=\"14 5 5\"
    }
}
view azimuth=30   // from the left
";

#[test]
fn a_node_is_added_where_it_is_asked_for() {
    let with = |parent: &[usize], index| {
        with_node(&source(SCENE), parent, index, "sphere radius=1")
            .unwrap()
            .text()
            .to_owned()
    };
    let first = SCENE.replace("    sphere radius=3", "    sphere radius=1\n    sphere radius=3");
    assert_eq!(with(&[0], 0), first);
    let last = SCENE.replace("    }\n}\n", "    }\n    sphere radius=1\n}\n");
    assert_eq!(with(&[0], 9), last);
    let inline = SCENE.replace("; box", "; sphere radius=1; box");
    assert_eq!(with(&[0, 1], 1), inline);
    assert_eq!(with(&[], 9), format!("{SCENE}sphere radius=1\n"));
    assert!(with_node(&source(SCENE), &[0, 5], 0, "sphere radius=1").is_err());
}

#[test]
fn a_block_on_one_line_stays_on_it() {
    for (before, after) in [
        ("scene { a; b }", "scene { a; b; new }"),
        ("scene { a; b; }", "scene { a; b; new }"),
        ("scene {}", "scene { new }"),
        ("scene", "scene {\n    new\n}"),
        ("scene { a /* } */ }", "scene { a /* } */; new }"),
    ] {
        assert_eq!(with_node(&source(before), &[0], 9, "new").unwrap().text(), after);
    }
}

#[test]
fn a_removed_node_takes_its_line_and_leaves_comments() {
    let without = |path: &[usize]| without_node(&source(SCENE), path).unwrap().text().to_owned();
    assert_eq!(without(&[0, 0]), SCENE.replace("sphere radius=3 center=\"0 0 0\"", ""));
    assert_eq!(
        without(&[0, 1, 0]),
        SCENE.replace("sphere radius=4 center=\"9 0 0\";", "")
    );
    let block = SCENE.find("    subtract").unwrap();
    let end = SCENE.find("}\nview").unwrap();
    assert_eq!(without(&[0, 1]), format!("{}{}", &SCENE[..block], &SCENE[end..]));
    assert!(without_node(&source(SCENE), &[0, 2]).is_err());
}

#[test]
fn a_moved_node_is_what_it_was() {
    let moved = with_node_moved(&source(SCENE), &[0, 0], &[0, 1], 2).unwrap();
    let scene = parse(moved.text()).unwrap();
    assert_eq!(scene.model.nodes().len(), parse(SCENE).unwrap().model.nodes().len());
    assert!(moved.text().contains("/* in between */") && moved.text().contains("// the first"));
    assert!(with_node_moved(&source(SCENE), &[0], &[0, 1], 0).is_err());
    let swapped = with_node_moved(&source("scene { a; b; c }"), &[0, 2], &[0], 0).unwrap();
    assert_eq!(swapped.text(), "scene { c; a; b;  }");
}

fn editor() -> Editor<NoVolumes> {
    Editor::new(&parse(SCENE).unwrap(), NoVolumes).unwrap()
}

#[test]
fn an_edit_that_leaves_no_scene_changes_nothing() {
    let mut editor = editor();
    let refused = editor.edit(|s| with_property(s, &[0, 0], "radius", Some((-1.0).into())));
    assert!(matches!(refused.unwrap_err().problem(), Problem::BadValue { .. }));
    assert_eq!(editor.scene().to_text(), SCENE);
    assert!(!editor.undo().unwrap() && !editor.redo().unwrap());
}

#[test]
fn a_saved_scene_is_the_text() {
    let mut editor = editor();
    editor
        .edit(|s| with_property(s, &[0, 0], "radius", Some(2.5.into())))
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("saved.kdl");
    editor.save(&path).unwrap();
    assert_eq!(
        std::fs::read_to_string(path).unwrap(),
        SCENE.replace("radius=3", "radius=2.5")
    );
}

/// What may be done to a scene with some nodes.
#[derive(Clone, Debug)]
enum Act {
    Radius(f64),
    Insert(Index, Index),
    Remove(Index),
    Move(Index, Index, Index),
    Undo,
    Redo,
}

fn act() -> impl Strategy<Value = Act> {
    let any = any::<Index>;
    prop_oneof![
        2 => (1u32..40).prop_map(|n| Act::Radius(f64::from(n) / 8.0)),
        3 => (any(), any()).prop_map(|(parent, at)| Act::Insert(parent, at)),
        1 => any().prop_map(Act::Remove),
        2 => (any(), any(), any()).prop_map(|(from, to, at)| Act::Move(from, to, at)),
        2 => Just(Act::Undo),
        1 => Just(Act::Redo),
    ]
}

/// Paths that there may be, with or without a node.
const PATHS: [&[usize]; 8] = [
    &[0],
    &[0, 0],
    &[0, 1],
    &[0, 2],
    &[0, 1, 0],
    &[0, 1, 1],
    &[0, 1, 2],
    &[0, 1, 0, 0],
];

fn path(index: &Index) -> &'static [usize] {
    PATHS[index.index(PATHS.len())]
}

fn perform(editor: &mut Editor<NoVolumes>, act: &Act) -> Result<(), SceneError> {
    let ball = "sphere radius=2 /* new */ center=\"4 1 0\"";
    match act {
        Act::Radius(radius) => editor.edit(|s| with_property(s, &[0, 0], "radius", Some((*radius).into()))),
        Act::Insert(parent, at) => editor.edit(|s| with_node(s, path(parent), at.index(4), ball)),
        Act::Remove(at) => editor.edit(|s| without_node(s, path(at))),
        Act::Move(from, to, at) => editor.edit(|s| with_node_moved(s, path(from), path(to), at.index(4))),
        Act::Undo => editor.undo().map(|_| ()),
        Act::Redo => editor.redo().map(|_| ()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn edits_can_be_undone_and_redone_and_the_target_follows(acts in prop::collection::vec(act(), 1..24)) {
        let mut editor = editor();
        let mut texts = vec![SCENE.to_owned()];
        let mut at = 0;
        let mut target = editor.scene().target.build(&editor.scene().model).unwrap();
        for act in &acts {
            let refused = perform(&mut editor, act).is_err();
            match act {
                Act::Undo => at -= usize::from(at > 0),
                Act::Redo => at += usize::from(at + 1 < texts.len()),
                _ if refused => {}
                _ => {
                    at += 1;
                    texts.truncate(at);
                    texts.push(editor.scene().to_text().to_owned());
                }
            }
            prop_assert_eq!(editor.scene().to_text(), &texts[at]);
            prop_assert!(editor.scene().to_text().starts_with("// Two balls.\n"));
            prop_assert!(editor.scene().to_text().ends_with("view azimuth=30   // from the left\n"));
            let scene = editor.scene();
            let anew = scene.target.build(&scene.model).unwrap();
            target = scene.target.update(&target, &scene.model).unwrap().target;
            prop_assert_eq!(&target.octree, &anew.octree);
            prop_assert_eq!(VoxelTarget::new(&target).voxels, VoxelTarget::new(&anew).voxels);
        }
    }

    #[test]
    fn a_node_added_and_removed_leaves_the_text(parent in any::<Index>(), at in 0usize..4) {
        let parent: &[usize] = [&[0][..], &[0, 1]][parent.index(2)];
        let with = with_node(&source(SCENE), parent, at, "box min=\"0 0 0\" max=\"1 { 1\"").unwrap();
        let children = [2, 2][parent.len() - 1];
        let path = [parent, &[at.min(children)]].concat();
        let without = without_node(&with, &path).unwrap();
        // A semicolon may stay where one is needed no more.
        let bare = |text: &str| text.replace([';', ' '], "");
        prop_assert_eq!(bare(without.text()), bare(SCENE));
    }
}

const ANIMATED: &str = "scene {
    sphere radius=3
    union { box min=\"0 0 0\" max=\"1 1 1\"; sphere radius=1; }
    translate \"0 0 0\" { sphere radius=2 value=7 }
}
transfer {
    point 0 opacity=0 color=\"#000000\"
    point 100 opacity=0.5 color=\"#ff0000\"
}
view azimuth=0
animation frames=11 fps=10 {
    track \"view\" property=\"azimuth\" { at 0 0; at 10 90 }
    track \"scene/union/sphere\" property=\"radius\" ease=\"smooth\" { at 0 1; at 10 3 }
    track \"scene/translate\" { at 0 \"0 0 0\"; at 10 \"10 0 -5\" }
    track \"transfer/point[2]\" property=\"color\" { at 0 \"#ff0000\"; at 10 \"#0000ff\" }
}
";

fn radii(scene: &Scene) -> Vec<f64> {
    let radius = |node: &Node| match node {
        Node::Primitive(primitive) => match primitive.solid {
            Solid::Sphere { radius, .. } => Some(radius),
            _ => None,
        },
        _ => None,
    };
    scene.model.nodes().iter().filter_map(radius).collect()
}

#[test]
fn a_frame_has_the_values_of_its_time() {
    let scene = parse(ANIMATED).unwrap();
    let animation = scene.animation.as_ref().unwrap();
    assert_eq!(
        (animation.frames, animation.fps, animation.moves_model()),
        (11, 10.0, true)
    );
    let at = |frame| scene.at_frame(frame, &mut NoVolumes).unwrap();
    assert_eq!([0, 5, 10].map(|n| at(n).view.azimuth_deg), [0.0, 45.0, 90.0]);
    assert_eq!([0, 5, 10].map(|n| radii(&at(n))[1]), [1.0, 2.0, 3.0]);
    // A smooth start: 3t² − 2t³ at 1/10.
    assert!((radii(&at(1))[1] - 1.056).abs() < 1e-12);
    let by = at(5).model.nodes().iter().find_map(|node| match node {
        Node::Transform { parent_from_child, .. } => Some(parent_from_child.translation),
        _ => None,
    });
    assert_eq!(by, Some(DVec3::new(5.0, 0.0, -2.5)));
    let colour = at(5).source().text().contains("color=\"#800080\"");
    assert!(colour, "{}", at(5).source().text());
}

#[test]
fn what_is_not_animated_stays_to_the_byte() {
    let scene = parse(ANIMATED).unwrap();
    assert_eq!(scene.to_text(), ANIMATED);
    let last = scene.at_frame(10, &mut NoVolumes).unwrap();
    let expected = ANIMATED
        .replacen("view azimuth=0", "view azimuth=90", 1)
        .replacen("sphere radius=1;", "sphere radius=3;", 1)
        .replacen("translate \"0 0 0\"", "translate \"10 0 -5\"", 1)
        .replacen("color=\"#ff0000\"", "color=\"#0000ff\"", 1);
    assert_eq!(last.to_text(), expected);
}

#[test]
fn tracks_that_cannot_be_are_refused_where_they_stand() {
    let refused = |tracks: &str| {
        let text = format!("scene {{ sphere radius=1 }}\nanimation frames=5 {{\n{tracks}\n}}\n");
        let error = parse(&text).unwrap_err();
        assert_eq!(error.place().map(|(line, _)| line), Some(3), "{error}");
        error.problem().clone()
    };
    let keys = "{ at 0 1; at 4 2 }";
    let there = vec!["sphere".to_owned()];
    assert_eq!(
        refused(&format!("track \"scene/box\" property=\"radius\" {keys}")),
        Problem::NotThere {
            wanted: "box".into(),
            there
        }
    );
    assert!(matches!(
        refused(&format!("track \"scene/sphere[2]\" {keys}")),
        Problem::NotThere { .. }
    ));
    assert!(matches!(
        refused(&format!("track \"scene\" property=\"spacing\" {keys}")),
        Problem::Conflict(_)
    ));
    assert!(matches!(
        refused("track \"scene/sphere\" { at 3 1; at 3 2 }"),
        Problem::BadValue { .. }
    ));
    assert!(matches!(
        refused("track \"scene/sphere\" { at 0 1; at 1 \"2 3\" }"),
        Problem::BadValue { .. }
    ));
    assert!(matches!(
        refused("track \"scene/sphere\" {}"),
        Problem::TooFewChildren { .. }
    ));
}

#[test]
fn a_track_that_makes_a_bad_value_names_its_frame() {
    let text = "scene { sphere radius=1 }\nanimation frames=5 { track \"scene/sphere\" property=\"radius\" { at 0 1; at 4 -1 } }\n";
    let scene = parse(text).unwrap();
    assert!(scene.at_frame(0, &mut NoVolumes).is_ok());
    let error = scene.at_frame(4, &mut NoVolumes).unwrap_err();
    assert!(error.to_string().contains("at frame 4:1:"), "{error}");
}

#[test]
fn an_argument_is_changed_alone() {
    let text = "scene { translate  \"1 2 3\" { sphere radius=1 } }";
    let edited = with_argument(&source(text), &[0, 0], 0, "4 5 6".into()).unwrap();
    assert_eq!(edited.text(), text.replace("1 2 3", "4 5 6"));
    assert!(with_argument(&source(text), &[0], 0, 1.into()).is_err());
}
