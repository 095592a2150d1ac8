//! The scene language: what each node makes, and what each mistake is answered with.

use std::path::Path;

use glam::{DAffine3, DVec3};
use vcsg::math::{Aabb, Interval};
use vcsg::model::{BooleanOp, Boundary, Combine, Family, Node, ValueMap, ValueRule};
use vcsg::projection::presets::{self, DataStatistics};
use vcsg::projection::{Mode, Projection};
use vcsg::scene::{NoVolumes, Scene, SceneError, SurfaceSpec, TransferChoice, TransferSpec};
use vcsg::surface::{MeshColor, MeshLook, MeshShading, Topology};
use vcsg::voxelize::Solid;

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("test.kdl", text, Path::new("."), &mut NoVolumes)
}

fn nodes(shapes: &str) -> Vec<Node> {
    parse(&format!("scene {{\n{shapes}\n}}\n"))
        .unwrap()
        .model
        .nodes()
        .to_vec()
}

fn transform_of(shapes: &str) -> DAffine3 {
    match nodes(shapes).pop() {
        Some(Node::Transform { parent_from_child, .. }) => parent_from_child,
        other => panic!("{other:?}"),
    }
}

const BALL: &str = "sphere radius=1";

#[test]
fn leaves_have_their_geometry_and_value() {
    let all = nodes(
        "sphere radius=2 center=\"1 2 3\" value=100\nbox min=\"-1 -1 -1\" max=\"1,2,3\"\nhalf-space point=\"0 0 5\" normal=\"0 0 2\"",
    );
    let primitive = |node: &Node| match node {
        Node::Primitive(primitive) => (primitive.solid.clone(), primitive.value),
        other => panic!("{other:?}"),
    };
    let center = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(primitive(&all[0]), (Solid::Sphere { center, radius: 2.0 }, 100.0));
    assert_eq!(primitive(&all[1]), (Solid::Box(Aabb::new(-DVec3::ONE, center)), 1.0));
    match primitive(&all[2]).0 {
        Solid::HalfSpace(plane) => assert_eq!((plane.normal, plane.offset), (DVec3::Z, -5.0)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn set_operations_fold_from_the_left() {
    let all = nodes("subtract family=\"product\" {\n sphere radius=1\n sphere radius=2\n sphere radius=3\n}");
    let combine = |node: &Node| match node {
        Node::Combine(c) => c.clone(),
        other => panic!("{other:?}"),
    };
    let (inner, outer) = (combine(&all[3]), combine(&all[4]));
    assert_eq!((inner.first.index(), inner.second.index()), (0, 1));
    assert_eq!((outer.first.index(), outer.second.index()), (3, 2));
    for Combine { op, rule, family, .. } in [inner, outer] {
        assert_eq!(
            (op, rule, family),
            (BooleanOp::Subtraction, ValueRule::First, Family::Product)
        );
    }
}

#[test]
fn value_rules_have_their_names() {
    let rule_of = |attributes: &str, name: &str| match nodes(&format!("{name} {attributes} {{ {BALL}; {BALL} }}")).pop()
    {
        Some(Node::Combine(c)) => c.rule,
        other => panic!("{other:?}"),
    };
    for (text, rule) in [
        ("first", ValueRule::First),
        ("second", ValueRule::Second),
        ("max", ValueRule::Max),
        ("min", ValueRule::Min),
        ("sum", ValueRule::Sum),
        ("difference", ValueRule::Difference),
        ("product", ValueRule::Product),
        ("average", ValueRule::Average),
        ("algebraic-sum", ValueRule::AlgebraicSum),
        ("absolute-difference", ValueRule::AbsoluteDifference),
        ("quotient", ValueRule::Quotient),
        ("blend 0.25", ValueRule::Blend(0.25)),
    ] {
        assert_eq!(rule_of(&format!("rule=\"{text}\""), "union"), rule);
        assert_eq!(rule_of(&format!("rule=\"{text}\""), "overlay"), rule);
    }
    assert_eq!(rule_of("", "intersect"), ValueRule::First);
    assert_eq!(rule_of("", "overlay"), ValueRule::Second);
}

#[test]
fn a_subtraction_with_a_rule_is_the_general_one() {
    let combine = |attributes: &str| match nodes(&format!("subtract {attributes} {{ {BALL}; {BALL} }}")).pop() {
        Some(Node::Combine(c)) => (c.op, c.rule),
        other => panic!("{other:?}"),
    };
    assert_eq!(combine(""), (BooleanOp::Subtraction, ValueRule::First));
    assert_eq!(
        combine("rule=\"max\""),
        (BooleanOp::SubtractionWithRule, ValueRule::Max)
    );
}

#[test]
fn a_table_is_a_rule() {
    let lut = "lut first=\"0..2\" second=\"0..1\" { row \"0 1 2\"; row \"10,11,12\" }";
    for name in ["union", "intersect", "subtract", "overlay", "repeat count=2"] {
        let Some(Node::Combine(c)) = nodes(&format!("{name} {{ {BALL}; {lut}; {BALL} }}")).pop() else {
            panic!("{name} does not combine");
        };
        let ValueRule::Table(table) = c.rule else {
            panic!("{name} has {:?}", c.rule);
        };
        assert_eq!(table.axes(), [Interval::new(0.0, 2.0), Interval::new(0.0, 1.0)]);
        assert_eq!((table.at(1.0, 1.0), table.at(2.0, 0.0)), (11.0, 2.0));
    }
}

#[test]
fn transforms_move_points_where_they_should() {
    // Sines and cosines of quarter turns and sums of three small products: a few units of rounding of numbers below 16.
    let tolerance = 16.0 * 8.0 * f64::EPSILON;
    for (text, from, to) in [
        ("translate \"1 2 3\"", [1.0, 1.0, 1.0], [2.0, 3.0, 4.0]),
        ("rotate axis=\"0 0 2\" angle=90", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        (
            "rotate axis=\"0 0 1\" angle=90 center=\"1 0 0\"",
            [2.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
        ),
        ("scale 2", [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]),
        ("scale \"1 2 -1\" center=\"0 1 0\"", [1.0, 2.0, 3.0], [1.0, 3.0, -3.0]),
        ("mirror normal=\"3 0 0\"", [1.0, 2.0, 3.0], [-1.0, 2.0, 3.0]),
        (
            "mirror point=\"5 9 9\" normal=\"1 0 0\"",
            [1.0, 2.0, 3.0],
            [9.0, 2.0, 3.0],
        ),
        ("shear xy=0.5 zx=2", [1.0, 2.0, 3.0], [2.0, 2.0, 5.0]),
        ("matrix \"0 1 0 5  0 0 1 6  1 0 0 7\"", [1.0, 2.0, 3.0], [7.0, 9.0, 8.0]),
    ] {
        let moved = transform_of(&format!("{text} {{ {BALL} }}")).transform_point3(DVec3::from(from));
        assert!((moved - DVec3::from(to)).length() <= tolerance, "{text}: {moved}");
    }
}

#[test]
fn maps_and_cuts_wrap_the_union_of_their_children() {
    let map_of = |text: &str| match nodes(text).pop() {
        Some(Node::Transfer { map, child }) => (map, child.index()),
        other => panic!("{other:?}"),
    };
    let linear = ValueMap::Linear {
        scale: 2.0,
        offset: 0.0,
    };
    assert_eq!(map_of(&format!("map linear scale=2 {{ {BALL}; {BALL} }}")), (linear, 2));
    let quadratic = ValueMap::Quadratic {
        a: 0.0,
        b: 3.0,
        c: -1.0,
    };
    assert_eq!(
        map_of(&format!("map \"quadratic\" b=3 c=-1 {{ {BALL} }}")),
        (quadratic, 0)
    );
    let table = ValueMap::Table([(0.0, 0.0), (100.0, 255.0)].into());
    assert_eq!(
        map_of(&format!("map table {{ at 0 0; at 100 255; {BALL} }}")),
        (table, 0)
    );
    match nodes(&format!("cut normal=\"0 1 0\" point=\"0 2 0\" {{ {BALL} }}")).pop() {
        Some(Node::Cut { plane, .. }) => assert_eq!((plane.normal, plane.offset), (DVec3::Y, -2.0)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_definition_is_built_once_however_often_it_is_used() {
    let text = "define \"a\" { sphere radius=1 }\ndefine \"idle\" { sphere radius=9 }\n".to_owned()
        + "use \"a\"\ntranslate \"5 0 0\" { use \"a\" }";
    let all = nodes(&text);
    assert_eq!(all.len(), 3, "{all:?}");
    // Doubling forty times would be 2^40 nodes if `use` copied.
    let mut doubling = String::from("define \"d0\" { sphere radius=1 }\n");
    for i in 0..40 {
        doubling += &format!(
            "define \"d{}\" {{ use \"d{i}\"; translate \"{i} 0 0\" {{ use \"d{i}\" }} }}\n",
            i + 1
        );
    }
    assert_eq!(nodes(&(doubling + "use \"d40\"")).len(), 81);
}

#[test]
fn the_rest_of_a_scene_is_read() {
    let scene = parse(
        r##"
scene spacing=0.5 budget-mib=64 coarsen=#true boundary="centre" min-block=8 levels=1 { sphere radius=1 }
transfer unit-mm=2 { point 0 opacity=0 color="#000000"; point 10 opacity=0.5 color="#ff0000" }
view azimuth=30 elevation=-20 roll=5 zoom=1.5 projection="perspective" fov=45 focus="1 2 3"
light towards="0 0 -2" intensity=0.5
light towards="0 -1 0"
material ambient=0.3 shininess=32 soft-gradient=0.02
depth-cue strength=0.25
background "transparent"
render mode="mip" samples-per-voxel=2 size="640x480"
"##,
    )
    .unwrap();
    assert_eq!(scene.target.spacing_mm, Some(0.5));
    assert_eq!((scene.target.budget_mib, scene.target.coarsen), (64, true));
    assert_eq!(
        (scene.target.boundary, scene.target.min_block),
        (Boundary::Centre, Some(8))
    );
    assert_eq!(
        (scene.view.azimuth_deg, scene.view.elevation_deg, scene.view.roll_deg),
        (30.0, -20.0, 5.0)
    );
    assert_eq!(scene.view.projection, Projection::Perspective { fov_y_deg: 45.0 });
    assert_eq!(scene.view.focus, Some(DVec3::new(1.0, 2.0, 3.0)));
    let shading = scene.settings.shading.unwrap();
    assert_eq!(shading.lights.len(), 2);
    assert_eq!(
        (shading.lights[0].towards, shading.lights[0].intensity),
        (-DVec3::Z, 0.5)
    );
    assert_eq!((shading.material.ambient, shading.material.shininess_log2), (0.3, 5));
    assert_eq!(shading.soft_gradient, 0.02);
    assert_eq!(
        (scene.settings.mode, scene.settings.samples_per_voxel),
        (Mode::Mip, 2.0)
    );
    assert_eq!(
        (scene.settings.background, scene.frame_size),
        ([0.0; 4], Some([640, 480]))
    );
    match scene.transfer.unwrap().choice {
        TransferChoice::Points(function) => {
            assert_eq!((function.points().len(), function.unit_mm()), (2, 2.0))
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn surfaces_are_read_in_their_order() {
    let text = "scene { sphere radius=1 }
surface iso=60 color=\"#ff0080\" shading=\"gouraud\" topology=\"trilinear\"
surface iso=-0.5
";
    let scene = parse(text).unwrap();
    let red = SurfaceSpec {
        iso: 60.0,
        topology: Topology::Trilinear,
        look: MeshLook {
            color: MeshColor::Uniform([1.0, 0.0, 128.0 / 255.0]),
            shading: MeshShading::Gouraud,
        },
    };
    assert_eq!(scene.surfaces, [red, SurfaceSpec::at(-0.5)]);
    let plain = parse("scene { sphere radius=1 }\nsurface iso=1 shading=\"phong\" topology=\"vtk\"\n").unwrap();
    assert_eq!(plain.surfaces, [SurfaceSpec::at(1.0)]);
}

#[test]
fn samples_are_shown_unless_surfaces_stand_alone() {
    let shows = |top: &str| {
        parse(&format!("scene {{ sphere radius=1 }}\n{top}\n"))
            .unwrap()
            .shows_samples()
    };
    assert!(shows(""));
    assert!(!shows("surface iso=0.5"));
    assert!(!shows("surface iso=0.5\nrender mode=\"composite\""));
    assert!(shows("surface iso=0.5\nrender mode=\"mip\""));
    assert!(shows("surface iso=0.5\ntransfer"));
    assert!(shows("transfer preset=\"grey\"\nsurface iso=0.5"));
}

#[test]
fn a_preset_may_have_a_window() {
    let scene = parse("scene { sphere radius=1 }\ntransfer preset=\"ct-bone\" window=400 level=40\n").unwrap();
    let transfer = scene.transfer.unwrap();
    assert_eq!(transfer.window, Some(Interval::new(-160.0, 240.0)));
    assert!(matches!(transfer.choice, TransferChoice::Preset(preset) if preset.name() == "ct-bone"));
    assert!(
        parse("scene { sphere radius=1 }\nrender shading=#false\n")
            .unwrap()
            .settings
            .shading
            .is_none()
    );
}

#[test]
fn a_target_is_known_by_its_covered_values_only() {
    let scene = parse(
        "scene spacing=1 { box min=\"0 0 0\" max=\"40 40 40\" value=-1000 filter=0; box min=\"60 0 0\" max=\"70 40 40\" value=500 filter=0 }",
    );
    let scene = scene.unwrap();
    let target = scene.target.build(&scene.model).unwrap();
    let data = DataStatistics::of_target(&target).unwrap();
    assert_eq!((data.min, data.max), (-1000.0, 500.0));
    assert_eq!((data.low, data.high), (-1000.0, 500.0));
    let function = TransferSpec::AUTOMATIC.function(&data, 100.0);
    let ct = presets::named("ct-muscle-bone").unwrap();
    assert_eq!(function, ct.transfer_function(ct.range(), 1.0));
}
