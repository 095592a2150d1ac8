//! `vcsg presets` and `vcsg render --preset FILE` from outside.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use vcsg::projection::presets;

const SCENE: &str = "scene spacing=2 { sphere radius=20 value=300 }\nrender size=\"48x36\"\n";

fn vcsg(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command.current_dir(folder).args(arguments).output().unwrap()
}

/// What a run that must succeed says, on standard output and on standard error.
fn succeed(folder: &Path, arguments: &[&str]) -> [String; 2] {
    let output = vcsg(folder, arguments);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let [out, err] = [output.stdout, output.stderr].map(text);
    assert!(output.status.success(), "{arguments:?}: {err}");
    [out, err]
}

fn fail(folder: &Path, arguments: &[&str], wanted: &str) {
    let output = vcsg(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        !output.status.success() && said.contains(wanted),
        "{arguments:?}: {said}"
    );
}

#[test]
fn presets_are_listed_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let [list, _] = succeed(folder.path(), &["presets"]);
    assert_eq!(list.lines().count(), presets::all().len());
    for preset in presets::all() {
        let lists = |line: &&str| line.starts_with(preset.name()) && line.ends_with(preset.description());
        assert!(list.lines().any(|line| lists(&line)), "{}", preset.name());
    }
    let [text, _] = succeed(folder.path(), &["presets", "ct-bone"]);
    assert!(
        text.contains("preset \"ct-bone\"") && text.contains("material"),
        "{text}"
    );
    let [json, _] = succeed(folder.path(), &["presets", "--json", "ct-mip"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["presets"][0]["mode"], &json["presets"][0]["material"]),
        (&"mip".into(), &Value::Null)
    );
    fail(folder.path(), &["presets", "ct-bnoe"], "unknown preset");
}

#[test]
fn a_preset_goes_to_3d_slicer_and_comes_back_as_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.kdl"), SCENE).unwrap();
    succeed(folder.path(), &["presets", "ct-bone", "--write", "bone.vp.json"]);
    let picture = |name: &str, preset: &str| {
        succeed(folder.path(), &["render", "scene.kdl", "-o", name, "--preset", preset]);
        fs::read(folder.path().join(name)).unwrap()
    };
    assert_eq!(picture("own.png", "ct-bone"), picture("file.png", "bone.vp.json"));
    let [_, said] = succeed(folder.path(), &["presets", "mr-mip", "--write", "mip.vp.json"]);
    assert!(said.contains("--volume") && said.contains("the mode mip"), "{said}");
    fail(
        folder.path(),
        &["presets", "ct-bone", "--write", "bone.json"],
        ".vp.json",
    );
    fail(folder.path(), &["presets", "--write", "bone.vp.json"], "<NAME>");
    fail(
        folder.path(),
        &["render", "scene.kdl", "-o", "a.png", "--preset", "none.vp.json"],
        "none.vp.json",
    );
    let fitted = [
        "render",
        "scene.kdl",
        "-o",
        "a.png",
        "--preset",
        "bone.vp.json",
        "--window",
        "9",
        "--level",
        "9",
    ];
    fail(folder.path(), &fitted, "points of its own");
}

#[test]
fn what_a_file_has_beyond_it_is_said() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.kdl"), SCENE).unwrap();
    let older = "1\n1\n0.9\n0.1\n0.2\n10\n4 0 0 300 1\n4 0 0 255 1\n8 0 1 0 0 300 0 1 0\n";
    fs::write(folder.path().join("look.vp"), older).unwrap();
    let [_, said] = succeed(
        folder.path(),
        &["render", "scene.kdl", "-o", "a.png", "--preset", "look.vp"],
    );
    assert!(said.contains("look.vp: not taken: gradient opacity"), "{said}");
}

#[test]
fn a_sheet_has_a_picture_of_a_preset() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.kdl"), SCENE).unwrap();
    succeed(
        folder.path(),
        &["presets", "grey", "--swatch", "grey.png", "--volume", "scene.kdl"],
    );
    assert!(
        fs::read(folder.path().join("grey.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    fail(folder.path(), &["presets", "--swatch", "grey.txt"], ".png");
    fail(
        folder.path(),
        &["presets", "grey", "--swatch", "a.png", "--volume", "none.nrrd"],
        "none.nrrd",
    );
}
