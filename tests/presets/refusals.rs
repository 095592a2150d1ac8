//! What is refused of volume properties, and what is taken of them.

use std::fs;
use std::path::{Path, PathBuf};

use vcsg::projection::volume_property::{self, Reading};
use vcsg::projection::{Material, Mode};
use vcsg::scene::{NoVolumes, Scene};

const SCHEMA: &str = "volume-property-schema-v1.0.0.json#";

const COLOR: &str =
    r#""rgbTransferFunction": {"points": [{"x": 0, "color": [1, 0, 0]}, {"x": 100, "color": [1, 1, 1]}]}"#;
const OPACITY: &str = r#""scalarOpacity": {"points": [{"x": 0, "y": 0}, {"x": 100, "y": 0.5}]}"#;

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    file
}

fn with_component(component: &str) -> String {
    format!(r#"{{"@schema": "{SCHEMA}", "volumeProperties": [{{"components": [{{{component}}}]}}]}}"#)
}

fn read(name: &str, text: &str) -> Result<Reading, String> {
    let folder = tempfile::tempdir().unwrap();
    volume_property::read(&file(folder.path(), name, text)).map_err(|e| e.to_string())
}

#[test]
fn what_means_nothing_is_refused_with_its_place() {
    let point = |x: &str, y: &str| {
        with_component(&format!(
            r#"{COLOR}, "scalarOpacity": {{"points": [{{"x": {x}, "y": {y}}}]}}"#
        ))
    };
    let many: Vec<_> = (0..5000).map(|x| format!(r#"{{"x": {x}, "y": 0}}"#)).collect();
    let many = with_component(&format!(
        r#"{COLOR}, "scalarOpacity": {{"points": [{}]}}"#,
        many.join(",")
    ));
    let cases = [
        ("a.vp.json", "{\n  nothing", "a.vp.json:2"),
        ("a.vp.json", "{}", "@schema"),
        ("a.vp.json", &format!(r#"{{"@schema": "{SCHEMA}"}}"#), "is empty"),
        ("a.vp.json", &with_component(OPACITY), "rgbTransferFunction"),
        ("a.vp.json", &with_component(COLOR), "scalarOpacity"),
        (
            "a.vp.json",
            &point("0", "1.5"),
            "scalarOpacity, point 1: 1.5 is not in 0..1",
        ),
        ("a.vp.json", &point("1e300", "1"), "single precision"),
        ("a.vp.json", &many, "at most 4096"),
        (
            "a.vp.json",
            &with_component(&format!(r#"{COLOR}, {OPACITY}, "scalarOpacityUnitDistance": 0"#)),
            "above 0",
        ),
        (
            "a.vp.json",
            &with_component(&format!(
                r#"{COLOR}, {OPACITY}, "shade": true, "lighting": {{"diffuse": -1}}"#
            )),
            "diffuse is -1",
        ),
        ("a.vp", "1\n1\n0.9\n0.1\n", "a.vp:5: the file ends here"),
        ("a.vp", "1\n1\n0.9\n0.1\nx\n", "a.vp:5: `x` is not"),
        (
            "a.vp",
            "1\n1\n0.9\n0.1\n0.2\n10\n3 0 0 1\n4 0 1 255 1\n4 0 1 1 1\n",
            "a.vp:7: opacity",
        ),
        (
            "a.vp",
            "1\n1\n0.9\n0.1\n0.2\n10\n1e9 0 0\n4 0 1 255 1\n4 0 1 1 1\n",
            "a.vp:7: opacity",
        ),
        ("a.json", "{}", ".vp.json or a .vp"),
    ];
    for (name, text, wanted) in cases {
        let said = read(name, text).expect_err(text);
        assert!(said.contains(wanted), "{said}, not {wanted}");
    }
}

#[test]
fn what_is_not_taken_is_said() {
    let gradient = r#""gradientOpacity": {"points": [{"x": 0, "y": 0}, {"x": 50, "y": 1}]}"#;
    let left_out = |more: &str| {
        read("a.vp.json", &with_component(&format!("{COLOR}, {OPACITY}{more}")))
            .unwrap()
            .left_out
    };
    assert_eq!(left_out("").len(), 0);
    assert!(left_out(&format!(", {gradient}"))[0].contains("gradient opacity"));
    assert_eq!(
        left_out(&format!(r#", {gradient}, "disableGradientOpacity": true"#)).len(),
        0
    );
    let older = "1\n1\n0.9\n0.1\n0.2\n10\n4 0 0 1 1\n4 0 0 255 1\n4 0 1 1 1\n";
    let older = read("a.vp", older).unwrap();
    assert!(older.left_out[0].contains("gradient opacity"));
    let material = Material {
        ambient: 0.1,
        diffuse: 0.9,
        specular: 0.2,
        // The nearest power of two to 10.
        shininess_log2: 3,
    };
    assert_eq!(older.property.material, Some(material));
}

#[test]
fn a_scene_takes_a_file_and_what_it_says_itself_goes_before_it() {
    let folder = tempfile::tempdir().unwrap();
    file(
        folder.path(),
        "flat.vp.json",
        &with_component(&format!(r#"{COLOR}, {OPACITY}, "scalarOpacityUnitDistance": 4"#)),
    );
    let scene = |rest: &str| {
        let text = format!("scene {{ sphere radius=1 }}\n{rest}\n");
        Scene::parse("a.kdl", &text, folder.path(), &mut NoVolumes)
    };
    let flat = scene("transfer file=\"flat.vp.json\"").unwrap();
    assert_eq!((flat.settings.mode, &flat.settings.shading), (Mode::Composite, &None));
    let data = vcsg::projection::presets::DataStatistics::of_sample(vec![0.0, 1.0]).unwrap();
    let function = |scene: &Scene| scene.transfer.as_ref().unwrap().function(&data, 1.0);
    assert_eq!(
        (function(&flat).evaluate(50.0).1, function(&flat).unit_mm()),
        (0.25, 4.0)
    );
    let own =
        scene("transfer file=\"flat.vp.json\" unit-mm=2\nmaterial specular=0.7\nrender mode=\"additive\"").unwrap();
    assert_eq!(function(&own).unit_mm(), 2.0);
    assert_eq!(own.settings.mode, Mode::Additive);
    assert_eq!(own.settings.shading.map(|s| s.material.specular), Some(0.7));
    for (rest, wanted) in [
        ("transfer file=\"none.vp.json\"", "none.vp.json"),
        ("transfer file=\"flat.vp.json\" preset=\"grey\"", "one of them"),
        ("transfer file=\"flat.vp.json\" window=10 level=5", "state their values"),
    ] {
        let said = scene(rest).expect_err(rest).to_string();
        assert!(said.starts_with("a.kdl:2:") && said.contains(wanted), "{said}");
    }
}

#[test]
fn a_preset_brings_its_mode_and_its_shading() {
    let scene = |rest: &str| {
        let text = format!("scene {{ sphere radius=1 }}\n{rest}\n");
        Scene::parse("a.kdl", &text, ".".as_ref(), &mut NoVolumes)
            .unwrap()
            .settings
    };
    let mip = scene("transfer preset=\"ct-mip\"");
    assert_eq!((mip.mode, mip.shading), (Mode::Mip, None));
    let shaded = scene("transfer preset=\"ct-mip\"\nrender mode=\"composite\" shading=#true\nlight towards=\"0 0 -1\"");
    assert_eq!(shaded.mode, Mode::Composite);
    assert_eq!(
        shaded.shading.map(|s| (s.lights.len(), s.material)),
        Some((1, Material::default()))
    );
    let metal = scene("transfer preset=\"ct-metal\"").shading.unwrap();
    assert!(metal.material.specular > Material::default().specular);
    assert_eq!(
        scene("transfer preset=\"ct-metal\"\nrender shading=#false").shading,
        None
    );
}
