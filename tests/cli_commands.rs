//! The program from outside: what it prints, writes and answers.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "scene spacing=2 {
    subtract {
        sphere radius=20 value=100
        box min=\"0 -30 -30\" max=\"30 30 0\"
    }
}
transfer {
    point 0 opacity=0 color=\"#000000\"
    point 100 opacity=0.8 color=\"#ffc080\"
}
view azimuth=30
";

/// Four by three by two voxels with values 0 to 23.
const VOLUME: &str = "NRRD0004
type: short
dimension: 3
space: left-posterior-superior
sizes: 4 3 2
space directions: (1,0,0) (0,2,0) (0,0,3)
space origin: (10,20,30)
encoding: ascii

0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23
";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.kdl"), SCENE).unwrap();
    fs::write(folder.path().join("volume.nrrd"), VOLUME).unwrap();
    folder
}

fn vcsg(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command.current_dir(folder).args(arguments).output().unwrap()
}

/// The standard output of a run that must succeed.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = vcsg(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, arguments)).unwrap()
}

/// The standard error of a run that must fail, without a panic and with nothing new in the folder.
fn fail(folder: &Path, arguments: &[&str]) -> String {
    let before = names(folder);
    let output = vcsg(folder, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments:?}: {message}");
    assert!(message.starts_with("error: "), "{arguments:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(names(folder), before, "{arguments:?}");
    message
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}

#[test]
fn info_describes_a_volume_in_the_conventions_of_itk() {
    let folder = folder();
    let info = json(folder.path(), &["info", "--json", "volume.nrrd"]);
    let volume = &info["volumes"][0];
    assert_eq!(volume["dims"], serde_json::json!([4, 3, 2]));
    assert_eq!(volume["spacing"], serde_json::json!([1.0, 2.0, 3.0]));
    assert_eq!(volume["origin"], serde_json::json!([10.0, 20.0, 30.0]));
    assert_eq!(volume["voxel"], "i16");
    assert_eq!(
        (volume["min"].as_f64(), volume["max"].as_f64()),
        (Some(0.0), Some(23.0))
    );
    assert_eq!(volume["mean"].as_f64(), Some(11.5));
    assert!(succeed(folder.path(), &["info", "volume.nrrd"]).contains("4 x 3 x 2 voxels of i16"));
}

#[test]
fn info_describes_a_scene() {
    let folder = folder();
    let info = json(folder.path(), &["info", "--json", "scene.kdl"]);
    assert_eq!(info["scene"]["nodes"], 3);
    assert_eq!(
        info["scene"]["bounds_mm"],
        serde_json::json!([[-20.0, -20.0, -20.0], [20.0, 20.0, 20.0]])
    );
}

#[test]
fn the_reference_draws_the_same_bytes_twice() {
    let folder = folder();
    let draw = |name: &str| {
        let about = json(
            folder.path(),
            &[
                "render",
                "scene.kdl",
                "-o",
                name,
                "--renderer",
                "reference",
                "--size",
                "48x36",
                "--json",
            ],
        );
        assert_eq!(about["size"], serde_json::json!([48, 36]));
        fs::read(folder.path().join(name)).unwrap()
    };
    let first = draw("a.png");
    assert!(first.starts_with(b"\x89PNG"));
    assert_eq!(first, draw("b.png"));
    assert!(draw("c.exr").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
}

#[test]
fn slices_are_drawn_on_a_device_without_a_validation_message() {
    let folder = folder();
    let about = json(
        folder.path(),
        &[
            "render",
            "scene.kdl",
            "-o",
            "a.png",
            "--size",
            "64x48",
            "--validation",
            "--json",
            "--background",
            "transparent",
        ],
    );
    assert!(about["device"].is_string(), "{about}");
    assert!(about["milliseconds"]["draw"].as_f64().unwrap() > 0.0);
    let picture = image::open(folder.path().join("a.png")).unwrap().to_rgba8();
    assert_eq!(picture.get_pixel(0, 0).0[3], 0, "the corner is empty");
    assert!(picture.get_pixel(32, 24).0[3] > 200, "the middle is not");
}

#[test]
fn a_baked_scene_is_a_volume_with_the_scene_in_it() {
    let folder = folder();
    succeed(
        folder.path(),
        &["bake", "scene.kdl", "-o", "baked.nrrd", "--outside", "-7"],
    );
    let info = json(folder.path(), &["info", "--json", "baked.nrrd"]);
    let volume = &info["volumes"][0];
    assert_eq!(volume["spacing"], serde_json::json!([2.0, 2.0, 2.0]));
    assert_eq!(
        (volume["min"].as_f64(), volume["max"].as_f64()),
        (Some(-7.0), Some(100.0))
    );
    let voxels: f64 = volume["dims"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_f64().unwrap())
        .product();
    let inside = (volume["mean"].as_f64().unwrap() + 7.0) / 107.0 * voxels * 8.0;
    let exact = 0.75 * 4.0 / 3.0 * std::f64::consts::PI * 8000.0;
    // The boundary's voxels, half of 5,000 mm² of surface times 2 mm, are in or out by their centres: evenly, so far less than
    // a tenth of them are wrong.
    assert!((inside - exact).abs() < 500.0, "{inside} mm³ instead of {exact}");
}

/// The first voxel's place on an axis and the distance to the next, millimetres, of a volume with the same ones on all axes.
fn first_and_spacing_mm(nrrd: &[u8]) -> [f64; 2] {
    let text = String::from_utf8_lossy(nrrd);
    ["space origin: (", "space directions: ("].map(|key| {
        let (_, rest) = text.split_once(key).expect("the field");
        let number = rest.split(',').next().expect("a number");
        number.parse().expect("a number")
    })
}

/// The finest level is the scene as it is baked alone, and each point of a level is one of the level before.
#[test]
fn baked_levels_lie_on_one_another_or_there_are_none() {
    let folder = folder();
    let read = |name: &str| fs::read(folder.path().join(name));
    succeed(folder.path(), &["bake", "scene.kdl", "-o", "l.nrrd", "--levels", "3"]);
    succeed(
        folder.path(),
        &["bake", "scene.kdl", "-o", "alone.nrrd", "--spacing", "2"],
    );
    assert_eq!(read("l-0.nrrd").unwrap(), read("alone.nrrd").unwrap());
    let levels = [0, 1, 2].map(|level| first_and_spacing_mm(&read(&format!("l-{level}.nrrd")).unwrap()));
    for [[finer_first, finer], [first, spacing]] in levels.windows(2).map(|pair| [pair[0], pair[1]]) {
        assert_eq!(spacing, 2.0 * finer);
        assert_eq!(((first - finer_first) / finer).fract(), 0.0, "{levels:?}");
    }
    fs::create_dir(folder.path().join("m-2.nrrd")).unwrap();
    let refused = vcsg(folder.path(), &["bake", "scene.kdl", "-o", "m.nrrd", "--levels", "3"]);
    assert!(!refused.status.success());
    assert!(read("m-0.nrrd").is_err() && read("m-1.nrrd").is_err());
}

/// The scenes are drawn too, so none of them has a mistake.
#[test]
fn bench_measures_the_scenes_of_figure_6() {
    let folder = folder();
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes");
    let asked = ["bench", "figure6", "--scenes", scenes, "--repetitions", "1", "--json"];
    let rows = json(folder.path(), &asked);
    let rows = rows.as_array().expect("a table");
    assert_eq!(rows.len(), 7);
    for row in rows {
        let figure = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} of {row}"));
        let parts = figure("templates_ms") + figure("projection_ms") + figure("read_back_ms");
        // Of one repetition medians are the figures themselves.
        assert!(
            (figure("rendering_ms") - parts).abs() < 1e-6 * parts && figure("build_ms") > 0.0,
            "{row}"
        );
        assert!(figure("blocks") > 0.0 && figure("memory_mib") > 1.0, "{row}");
    }
}

#[test]
fn a_bare_volume_renders_with_no_further_options() {
    let folder = folder();
    succeed(
        folder.path(),
        &["render", "volume.nrrd", "-o", "v.png", "--size", "32x32"],
    );
    assert!(folder.path().join("v.png").exists());
}

/// Arguments, and a part of the message that they are answered with.
const MISTAKES: &[(&[&str], &str)] = &[
    (&["info", "missing.nrrd"], "missing.nrrd"),
    (&["info", "missing.kdl"], "missing.kdl"),
    (&["info", "short.nrrd"], "short.nrrd"),
    (&["info", "words.txt"], "words.txt"),
    (
        &["render", "typo.kdl", "-o", "a.png"],
        "typo.kdl:2:3: unknown node `shpere`",
    ),
    (&["render", "typo.kdl", "-o", "a.png"], "did you mean `sphere`?"),
    (&["render", "scene.kdl", "-o", "a.jpeg"], "a.jpeg"),
    (
        &[
            "render",
            "scene.kdl",
            "-o",
            "none/a.png",
            "--renderer",
            "reference",
            "--size",
            "8x8",
        ],
        "none/a.png",
    ),
    (
        &["render", "scene.kdl", "-o", "a.png", "--preset", "ct-bnoe"],
        "ct-bone",
    ),
    (
        &["render", "scene.kdl", "-o", "a.png", "--window", "5", "--level", "3"],
        "--preset",
    ),
    (&["render", "scene.kdl", "-o", "a.png", "--window", "5"], "--level"),
    (&["render", "scene.kdl", "-o", "a.png", "--zoom", "0"], "--zoom"),
    (&["render", "scene.kdl", "-o", "a.png", "--size", "0x9"], "1024x768"),
    (
        &["render", "scene.kdl", "-o", "a.png", "--device", "no such device"],
        "no such device",
    ),
    (
        &["render", "huge.kdl", "-o", "a.png", "--renderer", "reference"],
        "budget is 1 MiB",
    ),
    (&["render", "scene.kdl", "-o", "a.png", "--surface", "nan"], "--surface"),
    (
        &[
            "render",
            "scene.kdl",
            "-o",
            "a.png",
            "--surface",
            "50",
            "--renderer",
            "reference",
        ],
        "--renderer slices",
    ),
    (
        &[
            "render",
            "scene.kdl",
            "-o",
            "a.png",
            "--surface",
            "50",
            "--renderer",
            "reference",
        ],
        "--renderer slices",
    ),
    (&["render", "open.kdl", "-o", "a.png", "--renderer", "reference"], ""),
    (&["bake", "scene.kdl", "-o", "a.vtk"], ".nrrd"),
    (&["convert", "volume.nrrd", "a.txt"], ".nrrd"),
    (&["convert", "scene.kdl", "a.nrrd"], "vcsg bake"),
    (&["convert", "volume.nrrd", "none/a.mhd"], "none/a"),
    (&["bake", "scene.kdl", "-o", "none/a.nrrd"], "none/a.nrrd"),
    (&["paint"], "paint"),
];

#[test]
fn every_mistake_has_one_clear_message() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("typo.kdl", "scene {\n  shpere radius=1\n}\n");
    write(
        "huge.kdl",
        "scene spacing=0.01 budget-mib=1 { box min=\"0 0 0\" max=\"99 99 99\" }",
    );
    write("open.kdl", "scene { half-space normal=\"0 0 1\" }");
    write("short.nrrd", &VOLUME.replace(" 23", ""));
    write("words.txt", "no volume");
    for (arguments, part) in MISTAKES {
        let message = fail(folder.path(), arguments);
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
}

#[test]
fn without_a_driver_the_message_says_what_to_install() {
    let folder = folder();
    let slices = ["render", "scene.kdl", "-o", "a.png", "--renderer", "slices"];
    let device = ["render", "scene.kdl", "-o", "a.png", "--device", "0"];
    for subcommand in [&["devices"][..], &slices, &device] {
        let (succeeded, message) = without_a_driver(folder.path(), subcommand);
        assert!(!succeeded, "{message}");
        assert!(message.contains("mesa-vulkan-drivers"), "{message}");
    }
    assert!(!folder.path().join("a.png").exists());
}

#[test]
fn without_a_driver_rays_are_cast_on_the_processor() {
    let folder = folder();
    let draw = |name: &str, renderer: &[&str]| {
        let arguments = [&["render", "scene.kdl", "--size", "40x30", "-o", name][..], renderer].concat();
        let (succeeded, message) = without_a_driver(folder.path(), &arguments);
        assert!(succeeded, "{message}");
        (fs::read(folder.path().join(name)).unwrap(), message)
    };
    let (fallen_back, message) = draw("a.png", &[]);
    assert!(
        message.contains("mesa-vulkan-drivers") && message.contains("on the processor"),
        "{message}"
    );
    let (asked_for, message) = draw("b.png", &["--renderer", "raycast"]);
    assert_eq!(message, "");
    assert_eq!(fallen_back, asked_for);
}

/// Runs the program where Vulkan has no driver: whether it succeeded, and what it said on stderr.
fn without_a_driver(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command.current_dir(folder).args(arguments);
    command
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent");
    let output = command.output().unwrap();
    (output.status.success(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let folder = folder();
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command
        .current_dir(folder.path())
        .args(["info", "--json", "volume.nrrd"]);
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut child = command.stdout(writer).stderr(Stdio::piped()).spawn().unwrap();
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert_eq!(message, "");
}

#[test]
fn help_has_examples_and_devices_are_listed() {
    let folder = folder();
    for subcommand in ["render", "info", "bake", "devices"] {
        let help = succeed(folder.path(), &[subcommand, "--help"]);
        assert!(help.contains(&format!("vcsg {subcommand}")), "{help}");
        assert!(help.contains("Examples:"), "{help}");
    }
    let devices = json(folder.path(), &["devices", "--json"]);
    assert_eq!(devices["devices"][0]["uuid"].as_str().map(str::len), Some(36));
}
