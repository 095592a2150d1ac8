//! Colour trees in scene files: what they make, and what is refused with which place.

use std::path::Path;

use vcsg::math::Interval;
use vcsg::model::{BooleanOp, Combine, Kind, Node, Tree, TreeError, ValueRule};
use vcsg::projection::presets;
use vcsg::scene::{NoVolumes, Scene, SceneError};

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("test.kdl", text, Path::new("."), &mut NoVolumes)
}

const BALL: &str = "sphere radius=1";
const RED: &str = "classify { point 1 opacity=0.5 color=\"#ff0000\"; sphere radius=1 }";

fn last(shapes: &str) -> Node {
    let scene = parse(&format!("scene {{\n{shapes}\n}}\n")).unwrap();
    scene.model.nodes().last().unwrap().clone()
}

fn rule(shapes: &str) -> (BooleanOp, ValueRule) {
    match last(shapes) {
        Node::Combine(Combine { op, rule, .. }) => (op, rule),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_classifier_has_a_transfer_function_of_its_own() {
    let Node::Classify { transfer, .. } =
        last("classify unit-mm=2 { sphere radius=1; point 3 opacity=0.5 color=\"#00ff00\" }")
    else {
        panic!("no classifier");
    };
    assert_eq!(
        (transfer.unit_mm(), transfer.evaluate(0.0)),
        (2.0, ([0.0, 1.0, 0.0], 0.5))
    );
    let bone = presets::named("ct-bone").unwrap();
    let Node::Classify { transfer, .. } = last(&format!("classify preset=\"ct-bone\" {{ {BALL} }}")) else {
        panic!("no classifier");
    };
    assert_eq!(transfer.window(), bone.transfer_function(bone.range(), 1.0).window());
    let brain = format!("classify preset=\"mr-brain\" window=100 level=150 {{ {BALL} }}");
    let Node::Classify { transfer, .. } = last(&brain) else {
        panic!("no classifier");
    };
    let own = presets::named("mr-brain").unwrap();
    let fitted = own.transfer_function(Interval::new(100.0, 200.0), own.unit_for(0.0));
    assert_eq!(*transfer, fitted);
}

#[test]
fn colours_have_rules_and_usual_ones() {
    for (text, expected) in [
        ("over", ValueRule::Over),
        ("plus", ValueRule::Plus),
        ("in", ValueRule::In),
        ("out", ValueRule::Out),
        ("atop", ValueRule::Atop),
        ("xor", ValueRule::Xor),
        ("first", ValueRule::First),
        ("second", ValueRule::Second),
    ] {
        assert_eq!(rule(&format!("union rule=\"{text}\" {{ {RED}; {RED} }}")).1, expected);
    }
    for (node, expected) in [
        ("union", (BooleanOp::Union, ValueRule::Over)),
        ("intersect", (BooleanOp::Intersection, ValueRule::First)),
        ("subtract", (BooleanOp::Subtraction, ValueRule::First)),
        ("overlay", (BooleanOp::SubtractionWithRule, ValueRule::Over)),
        ("repeat count=2", (BooleanOp::Union, ValueRule::Over)),
    ] {
        assert_eq!(rule(&format!("{node} {{ {RED}; {RED} }}")), expected, "{node}");
    }
    assert_eq!(rule(&format!("{RED}; {RED}")), (BooleanOp::Union, ValueRule::Over));
}

#[test]
fn colours_are_cut_moved_and_included_as_they_are() {
    for node in [
        "translate \"1 0 0\"",
        "cut normal=\"1 0 0\"",
        "cut normal=\"1 0 0\" filter=2",
    ] {
        let scene = parse(&format!("scene {{ {node} {{ {RED} }} }}\nrender mode=\"xray\"")).unwrap();
        assert!(scene.has_colors(), "{node}");
        assert!(Tree::in_world(&scene.model, 1.0).is_ok(), "{node}");
    }
    let complement = parse(&format!("scene {{ intersect {{ {BALL}; complement {{ {RED} }} }} }}")).unwrap();
    assert_eq!(complement.model.kind_of_root(), Some(Kind::Value));
}

/// The text in a `scene`, on line 2 and indented by four, and line, column and words of what it is answered with.
fn expect(text: &str, place: (usize, usize), words: &str) {
    let text = format!("scene {{\n    {text}\n}}\n");
    let error = parse(&text).expect_err(&text);
    assert_eq!(error.place(), Some(place), "{error}\n{text}");
    assert!(error.problem().to_string().contains(words), "{error}\n{text}");
    let line = text.lines().nth(place.0 - 1).unwrap().to_owned();
    let shown = format!("{:?}", miette::Report::new(error));
    assert!(shown.contains(line.trim()), "{shown}");
}

#[test]
fn mixing_values_and_colours_is_an_error_at_the_operand() {
    let red = "classify {\n point 1 opacity=1 color=\"#ffffff\"\n sphere radius=2 }";
    expect(
        &format!("union {{\n sphere radius=1\n {red}\n}}"),
        (4, 2),
        "`sphere` on line 3 gives values, and `classify` gives colours: values and colours cannot be combined",
    );
    expect(
        &format!("subtract {{ {RED}\n sphere radius=1 }}"),
        (3, 2),
        "`classify` on line 2 gives colours, and `sphere`",
    );
    expect(
        &format!("translate \"1 0 0\" {{ {RED}\n sphere radius=1 }}"),
        (3, 2),
        "cannot be combined",
    );
    expect(&format!("{RED}\n {BALL}"), (3, 2), "cannot be combined");
    expect(
        &format!("map linear {{ {RED} }}"),
        (2, 5),
        "`map` takes values, and `classify` on line 2 gives colours",
    );
    expect(
        &format!("classify preset=\"ct-bone\" {{ {RED} }}"),
        (2, 5),
        "`classify` takes values",
    );
    expect(
        &format!("union rule=\"max\" {{ {RED}; {RED} }}"),
        (2, 11),
        "the rule `max` does not combine colours, which `classify` on line 2 gives",
    );
    expect(
        &format!("union rule=\"over\" {{ {BALL}; {BALL} }}"),
        (2, 11),
        "does not combine values",
    );
    expect(
        &format!("union {{ {RED}; {RED}; lut first=\"0..1\" second=\"0..1\" {{ row \"1\" }} }}"),
        (2, 5),
        "the rule `lut` does not combine colours",
    );
    expect(
        &format!("classify {{ {BALL} }}"),
        (2, 5),
        "a `preset`, or at least one `point`",
    );
    expect(
        &format!("classify preset=\"mr-brain\" {{ {BALL} }}"),
        (2, 14),
        "give `window` and `level` too",
    );
    expect(
        "classify { point 1 opacity=1 color=\"#000000\" }",
        (2, 5),
        "at least one child",
    );
}

#[test]
fn what_shows_values_does_not_go_with_colours() {
    let with = |top: &str| parse(&format!("scene {{ {RED} }}\n{top}\n")).expect_err(top);
    let transfer = with("transfer preset=\"ct-bone\"");
    assert_eq!(transfer.place(), Some((2, 1)));
    assert!(transfer.to_string().contains("`transfer` has no values"), "{transfer}");
    let mode = with("render mode=\"mip\"");
    assert_eq!(mode.place(), Some((2, 8)));
    assert!(mode.to_string().contains("this mode shows values"), "{mode}");
}

#[test]
fn a_model_that_mixes_has_no_tree() {
    let scene = parse(&format!("scene {{ {RED} }}")).unwrap();
    let mut model = scene.model.clone();
    let ids: Vec<_> = model.ids().collect();
    // A ball and its colours.
    model.fold(BooleanOp::Union, ValueRule::First, Default::default(), [ids[1], ids[0]]);
    assert_eq!(Tree::in_world(&model, 1.0).unwrap_err(), TreeError::Mixed);
}
