//! Random scenes survive load, save and edit.

use std::path::Path;

use glam::DVec3;
use proptest::prelude::*;
use vcsg::model::Node;
use vcsg::projection::{Projection, View};
use vcsg::scene::{NoVolumes, Scene, SceneError, Source, SurfaceSpec, with_property};
use vcsg::voxelize::Solid;

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("random.kdl", text, Path::new("."), &mut NoVolumes)
}

/// A random shape of the language, with the way to one of its spheres.
#[derive(Clone, Debug)]
struct Written {
    text: String,
    path_to_sphere: Vec<usize>,
}

/// What may stand between nodes and must come through.
fn layout() -> impl Strategy<Value = &'static str> {
    prop_oneof![
        Just("\n"),
        Just("\n\n      "),
        Just("; "),
        Just(" // note { \" }\n"),
        Just("\r\n\t"),
        Just("\n/* block /* nested } */ */ "),
        Just("\n/-sphere radius=0 { nothing }\n"),
    ]
}

fn sphere() -> impl Strategy<Value = Written> {
    (0.5..50.0f64, -9..9i32, any::<bool>()).prop_map(|(radius, x, spaced)| Written {
        text: match spaced {
            true => format!("sphere  radius = {radius:?}   center=\"{x} 0  1\""),
            false => format!("sphere center=#\"{x},0,1\"# radius={radius:?} value=1_0"),
        },
        path_to_sphere: Vec::new(),
    })
}

const HEADS: &[&str] = &[
    "union rule=max",
    "intersect family=\"product\"",
    "subtract",
    "overlay rule=\"blend 0.5\"",
    "translate \"1 2 3\"",
    "rotate axis=\"1 1 0\" angle=33.5",
    "scale 0x2",
    "mirror normal=\"0 1 0\"",
    "shear xy=-0.5e0",
    "map linear scale=2",
    "cut normal=\"0 0 1\"",
];

fn shape() -> impl Strategy<Value = Written> {
    sphere().prop_recursive(4, 24, 3, |inner| {
        let children = prop::collection::vec((inner, layout()), 2..4);
        (prop::sample::select(HEADS), children, any::<prop::sample::Index>()).prop_map(|(head, children, chosen)| {
            let chosen = chosen.index(children.len());
            let body: String = children
                .iter()
                .map(|(child, gap)| format!("{}{gap}", child.text))
                .collect();
            let mut path_to_sphere = vec![chosen];
            path_to_sphere.extend(&children[chosen].0.path_to_sphere);
            Written {
                text: format!("{head} {{\n{body}\n}}"),
                path_to_sphere,
            }
        })
    })
}

/// A number that its decimal text gives back.
fn number(range: std::ops::Range<i32>) -> impl Strategy<Value = f64> {
    range.prop_map(|n| f64::from(n) / 8.0)
}

fn view() -> impl Strategy<Value = View> {
    let focus = prop::option::of((number(-99..99), number(-99..99), number(-99..99)).prop_map(DVec3::from));
    let fov = prop::option::of(number(8..1300));
    (
        number(-2880..2880),
        number(-700..700),
        number(-9..9),
        number(1..99),
        focus,
        fov,
    )
        .prop_map(|(azimuth_deg, elevation_deg, roll_deg, zoom, focus, fov)| View {
            azimuth_deg,
            elevation_deg,
            roll_deg,
            zoom,
            focus,
            projection: fov.map_or(Projection::Orthographic, |fov_y_deg| Projection::Perspective {
                fov_y_deg,
            }),
        })
}

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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn load_save_load_is_the_identity(written in shape(), before in layout()) {
        let text = format!("view{before}\nscene spacing=1.50 {{\n{}\n}} // end", written.text);
        let first = parse(&text).unwrap();
        prop_assert_eq!(first.to_text(), &text);
        let second = parse(first.to_text()).unwrap();
        prop_assert_eq!(format!("{:?}", first.model), format!("{:?}", second.model));
    }

    #[test]
    fn a_view_that_is_set_is_read_back_and_nothing_else_moves(written in shape(), views in [view(), view()]) {
        let text = format!("// head\nscene {{\n{}\n}}\nview   azimuth=1 /* keep */ zoom=2 // tail\nlight towards=\"0 0 -1\"", written.text);
        let mut scene = parse(&text).unwrap();
        for view in views {
            scene.set_view(view).unwrap();
            let again = parse(scene.to_text()).unwrap();
            prop_assert_eq!(again.view, view);
            let line = |text: &str| text.find("\nview ").unwrap();
            prop_assert_eq!(&scene.to_text()[..line(scene.to_text())], &text[..line(&text)]);
            prop_assert!(scene.to_text().ends_with(" // tail\nlight towards=\"0 0 -1\""));
            prop_assert!(scene.to_text().contains("/* keep */"));
        }
    }

    #[test]
    fn surfaces_come_through_and_their_values_can_be_edited(
        isovalues in prop::collection::vec(number(-999..999), 1..4),
        gap in layout(),
        iso in number(-999..999),
        view in view(),
    ) {
        let node = |iso: &f64| format!("surface shading=\"gouraud\"   iso={iso:?} /* keep */ color=#\"#102030\"#{gap}\n");
        let surfaces: String = isovalues.iter().map(node).collect();
        let mut scene = parse(&format!("{surfaces}scene {{ sphere radius=1 }}\n")).unwrap();
        let values = |scene: &Scene| scene.surfaces.iter().map(|s| s.iso).collect::<Vec<_>>();
        prop_assert_eq!(values(&scene), isovalues.clone());
        scene.set_view(view).unwrap();
        prop_assert!(scene.to_text().starts_with(&surfaces));
        prop_assert_eq!(&parse(scene.to_text()).unwrap().surfaces, &scene.surfaces);
        let last = isovalues.len() - 1;
        let edited = with_property(scene.source(), &[last], "iso", Some(iso.into())).unwrap();
        let edited = parse(edited.text()).unwrap();
        prop_assert_eq!(&values(&edited)[..last], &isovalues[..last]);
        prop_assert_eq!(edited.surfaces[last], SurfaceSpec { iso, ..scene.surfaces[last] });
    }

    #[test]
    fn an_edited_radius_is_the_only_change(written in shape(), radius in number(1..400)) {
        let text = format!("view\nscene {{\n{}\n}}\n", written.text);
        let source = Source::new("random.kdl", text.clone());
        let mut path = vec![1, 0];
        path.extend(&written.path_to_sphere);
        let edited = with_property(&source, &path, "radius", Some(radius.into())).unwrap();
        let (before, after) = (radii(&parse(&text).unwrap()), radii(&parse(edited.text()).unwrap()));
        let changed: Vec<_> = before.iter().zip(&after).filter(|(a, b)| a != b).collect();
        prop_assert!(changed.len() <= 1 && after.contains(&radius), "{:?} {:?}", before, after);
        let old = text.len() as i64 - edited.text().len() as i64;
        prop_assert!(old.abs() < 24);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[a-z{}\"#/*\\\\ \n=;0-9.-]{0,80}") {
        let _ = parse(&text);
        let _ = parse(&format!("scene {{ sphere radius=1 }}\n{text}"));
    }
}

#[test]
fn a_property_is_added_and_taken_away() {
    let source = Source::new("s.kdl", "scene {\n  sphere radius=1 { }  // ball\n}\n");
    let added = with_property(&source, &[0, 0], "value", Some(5.5.into())).unwrap();
    assert_eq!(added.text(), "scene {\n  sphere radius=1 value=5.5 { }  // ball\n}\n");
    let gone = with_property(&added, &[0, 0], "value", None).unwrap();
    assert_eq!(gone.text(), source.text());
    assert!(with_property(&source, &[0, 7], "value", None).is_err());
}

#[test]
fn a_view_is_added_to_a_scene_without_one() {
    let mut scene = parse("scene { sphere radius=1 }").unwrap();
    scene
        .set_view(View {
            azimuth_deg: 12.0,
            ..View::default()
        })
        .unwrap();
    assert_eq!(scene.to_text(), "scene { sphere radius=1 }\nview azimuth=12.0\n");
}
