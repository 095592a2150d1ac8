//! What scenes say of tracing, and what they cannot say.

use vcsg::scene::{NoVolumes, Scene, SceneError};

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("t.kdl", text, ".".as_ref(), &mut NoVolumes)
}

const BALL: &str = "scene { sphere radius=5 }\n";

#[test]
fn optics_objects_and_lights_are_read() {
    let text = "scene { sphere radius=5 }
optics reflect=0.25 transmit=0.5 index=1.33 tint=\"#80ff00\" tint-mm=3
object spacing=2 levels=2 { transfer { point 1 opacity=1 color=\"#ffffff\" }; optics; box min=\"0 0 0\" max=\"9 9 9\" }
object { box min=\"0 0 0\" max=\"9 9 9\" }
light at=\"1 2 3\" u=\"1 0 0\" v=\"0 1 0\" intensity=0.5
trace samples=9 depth=0 light-parts=3 seed=7
";
    let trace = parse(text).expect("a scene").trace;
    let optics = trace.optics.expect("optics");
    assert_eq!(optics.index(), 1.33);
    assert!(optics.transmits() && (optics.through(3.0)[0] - 128.0 / 255.0).abs() < 1e-6);
    assert_eq!(trace.objects.len(), 2);
    assert_eq!(
        (trace.objects[0].target.spacing_mm, trace.objects[0].target.levels),
        (Some(2.0), 2)
    );
    assert!(trace.objects[0].optics.is_some() && trace.objects[0].transfer.is_some());
    assert!(trace.objects[1].optics.is_none() && trace.objects[1].transfer.is_none());
    assert_eq!((trace.lights.len(), trace.far_lights), (1, false));
    let sampling = trace.sampling;
    assert_eq!((sampling.samples, sampling.seed), (9, 7));
    assert_eq!((sampling.bounds.depth, sampling.bounds.light_parts), (0, 3));
}

#[test]
fn only_what_others_cannot_show_needs_tracing() {
    let needs = |more: &str| parse(&format!("{BALL}{more}")).expect("a scene").trace.is_needed();
    assert!(!needs("") && !needs("light towards=\"0 0 -1\"") && !needs("trace samples=4"));
    assert!(needs("optics") && needs("object { sphere radius=2 }") && needs("light at=\"0 0 9\""));
}

#[test]
fn mistakes_name_their_place() {
    let mistakes = [
        ("optics index=0", "(2, 1)", "refraction index is 0"),
        ("optics index=-1.5", "(2, 1)", "refraction index is -1.5"),
        ("optics reflect=1.5", "(2, 1)", "`reflect` is 1.5"),
        ("optics transmit=-0.1", "(2, 1)", "`transmit` is -0.1"),
        ("optics tint=\"#808080\" tint-mm=0", "(2, 1)", "0 mm"),
        ("optics tint-mm=3", "(2, 8)", "goes with a `tint`"),
        ("light at=\"0 0 1\" u=\"1 0 0\" v=\"2 0 0\"", "(2, 1)", "no area"),
        ("light at=\"0 0 1\" u=\"1 0 0\"", "(2, 1)", "go together"),
        ("light at=\"0 0 1\" towards=\"0 0 -1\"", "(2, 18)", "one of them"),
        ("light towards=\"0 0 -1\" v=\"2 0 0\"", "(2, 24)", "give `at` too"),
        ("light at=\"0 0 x\"", "(2, 7)", "3 finite numbers"),
        ("trace samples=0", "(2, 7)", "a whole number in 1.."),
        ("trace depth=65", "(2, 7)", "a whole number in 0..64"),
        ("object { }", "(2, 1)", "at least one child"),
        ("object { optics; optics; sphere radius=1 }", "(2, 18)", "twice"),
        ("object { view; sphere radius=1 }", "(2, 10)", "unknown node"),
        (
            "object { transfer; classify { point 1 opacity=1 color=\"#ffffff\"; sphere radius=1 } }",
            "(2, 10)",
            "are colours",
        ),
        ("optics\noptics", "(3, 1)", "twice"),
    ];
    for (mistake, place, says) in mistakes {
        let error = parse(&format!("{BALL}{mistake}")).expect_err(mistake);
        let found = format!("{:?}", error.place().unwrap_or_default());
        assert!(error.to_string().contains(says), "{mistake}: {error}");
        assert_eq!(found, place, "{mistake}: {error}");
    }
}

#[test]
fn six_lights_of_any_kind_are_too_many() {
    let lights = |n: usize| "light at=\"0 0 9\"\n".repeat(n) + "light towards=\"0 0 -1\"\n";
    assert!(parse(&format!("{BALL}{}", lights(4))).is_ok());
    assert!(parse(&format!("{BALL}{}", lights(5))).is_err());
}
