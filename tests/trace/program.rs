//! `vcsg render` with rays that are traced, from outside.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Output};

use image::RgbaImage;
use tempfile::TempDir;

/// A glass ball above a mirror.
const SCENE: &str = "scene spacing=1 { box min=\"-20 -20 -14\" max=\"20 20 -8\" }
optics reflect=0.7
transfer { point 1 opacity=1 color=\"#806040\" }
object spacing=1 { optics transmit=1 index=1.5; sphere radius=7 }
light at=\"30 -40 50\"
background \"#a0b0c0\"
render size=\"48x36\"
view azimuth=20 elevation=20
";

fn run(folder: &Path, text: &str, options: &[&str]) -> Output {
    fs::write(folder.join("scene.kdl"), text).expect("a file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command
        .current_dir(folder)
        .args(["render", "scene.kdl", "-o", "a.png", "--json"]);
    command.args(options).output().expect("a run")
}

fn drawn(text: &str, options: &[&str]) -> (RgbaImage, serde_json::Value) {
    let folder: TempDir = tempfile::tempdir().expect("a folder");
    let output = run(folder.path(), text, options);
    assert!(
        output.status.success(),
        "{options:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let picture = image::open(folder.path().join("a.png")).expect("a picture").to_rgba8();
    (picture, serde_json::from_slice(&output.stdout).expect("JSON"))
}

fn refused(text: &str, options: &[&str]) -> String {
    let folder: TempDir = tempfile::tempdir().expect("a folder");
    let output = run(folder.path(), text, options);
    assert!(!output.status.success(), "{options:?}");
    assert!(!folder.path().join("a.png").exists(), "{options:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_scene_that_needs_it_is_traced() {
    let (unsaid, json) = drawn(SCENE, &[]);
    let (said, _) = drawn(SCENE, &["--renderer", "trace", "--seed", "0"]);
    assert_eq!(unsaid, said);
    assert_eq!(json["objects"].as_array().map(Vec::len), Some(2));
    assert_eq!((json["samples"].as_u64(), json["depth"].as_u64()), (Some(1), Some(6)));
    let (finer, json) = drawn(SCENE, &["--samples", "3", "--depth", "2"]);
    assert_eq!((json["samples"].as_u64(), json["depth"].as_u64()), (Some(3), Some(2)));
    assert_ne!(unsaid, finer);
}

#[test]
fn what_does_not_go_together_is_refused() {
    let ball = "scene { sphere radius=5 }\n";
    assert!(refused(SCENE, &["--renderer", "raycast"]).contains("--renderer trace"));
    assert!(refused(ball, &["--renderer", "raycast", "--samples", "4"]).contains("--renderer trace"));
    assert!(refused(ball, &["--progressive", "--renderer", "raycast"]).contains("--renderer trace"));
    assert!(refused(SCENE, &["--progressive", "--frames", "0..1"]).contains("--frames"));
    assert!(refused(SCENE, &["--mode", "mip"]).contains("cannot be traced"));
    assert!(refused(SCENE, &["--surface", "1"]).contains("surfaces are drawn beside slices and cast rays"));
    assert!(refused(SCENE, &["--samples", "0"]).contains("samples"));
    assert!(refused(SCENE, &["--depth", "65"]).contains("depth"));
}

/// Any scene can be traced: without light a medium is what the ray caster makes of it, up to where samples are.
#[test]
fn an_unlit_medium_is_what_the_ray_caster_draws() {
    let text = "scene spacing=1 { sphere radius=12 value=5; box min=\"0 0 0\" max=\"14 14 14\" value=9 }
transfer { point 4 opacity=0.02 color=\"#3080d0\"; point 10 opacity=0.2 color=\"#f0a030\" }
render size=\"64x64\" shading=#false samples-per-voxel=4
view azimuth=30 elevation=25 projection=\"perspective\" fov=30
background \"#204060\"
";
    let [(traced, _), (cast, _)] = ["trace", "raycast"].map(|renderer| drawn(text, &["--renderer", renderer]));
    let off = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    let worst = traced.as_raw().iter().zip(cast.as_raw()).map(off).max();
    // Both take four samples a voxel, at other places: a step of opacity 0.2 · ¼ more or less at either end, of a difference of
    // colours of at most 1, is 0.05 · 255 = 13 where a ray meets crisp ends, and much less in soft surfaces.
    println!("at most {worst:?} of 255");
    assert!(worst < Some(13));
}

#[test]
fn frames_of_an_animation_are_traced() {
    let folder: TempDir = tempfile::tempdir().expect("a folder");
    let animated =
        format!("{SCENE}animation frames=2 {{ track \"view\" property=\"azimuth\" {{ at 0 0; at 1 40 }} }}\n");
    fs::write(folder.path().join("scene.kdl"), animated).expect("a file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command.current_dir(folder.path());
    let output = command
        .args(["render", "scene.kdl", "-o", "f%d.png", "--frames", "0..1"])
        .output()
        .expect("a run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let [first, second] = ["f0.png", "f1.png"].map(|name| image::open(folder.path().join(name)).expect("a frame"));
    assert_ne!(first, second);
}

/// What `--progressive` writes, through a pipe, which has all of it: pictures of one, two and three samples, each whole, the last one that
/// without the option.
#[test]
fn a_picture_is_written_after_each_sample() {
    let folder: TempDir = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("a.png");
    let mut pictures = Vec::new();
    for samples in ["1", "2", "3"] {
        assert!(run(folder.path(), SCENE, &["--samples", samples]).status.success());
        pictures.extend(fs::read(&picture).expect("a picture"));
    }
    let last = fs::read(&picture).expect("the last picture");
    assert!(
        run(folder.path(), SCENE, &["--samples", "3", "--progressive"])
            .status
            .success()
    );
    assert!(fs::read(&picture).expect("a picture") == last);
    let mut files: Vec<_> = fs::read_dir(folder.path())
        .expect("the folder")
        .map(|f| f.expect("a file").file_name())
        .collect();
    files.sort();
    assert_eq!(files, ["a.png", "scene.kdl"], "something was left behind");

    fs::remove_file(&picture).expect("removed");
    assert!(Command::new("mkfifo").arg(&picture).status().expect("mkfifo").success());
    // While this end is open the pipe has not ended, whoever closes its other end between two pictures.
    let hold = fs::File::options()
        .read(true)
        .write(true)
        .open(&picture)
        .expect("a pipe");
    let mut pipe = fs::File::open(&picture).expect("a pipe");
    let drawing = std::thread::spawn({
        let folder = folder.path().to_owned();
        move || {
            let output = run(&folder, SCENE, &["--samples", "3", "--progressive"]);
            drop(hold);
            output
        }
    });
    let mut written = Vec::new();
    pipe.read_to_end(&mut written).expect("what is written");
    assert!(drawing.join().expect("a run").status.success());
    assert!(written == pictures, "{} bytes for {}", written.len(), pictures.len());
}

/// What cannot be is told alike whichever of both casts rays: where it stands, and what there can be.
#[test]
fn bad_input_is_refused_by_both_kinds_of_rays() {
    let ball = "scene spacing=1 { sphere radius=5 }\n";
    for renderer in ["raycast", "trace"] {
        let told = |line: &str, options: &[&str]| {
            let options = [&["--renderer", renderer], options].concat();
            // Long lines are broken, wherever.
            let told = refused(&format!("{ball}{line}\n"), &options);
            told.split_whitespace()
                .filter(|word| *word != "│")
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert!(told("", &["--size", "0x5"]).contains("each side in 1..16384"));
        assert!(told("", &["--size", "5x40000"]).contains("each side in 1..16384"));
        assert!(told("", &["--depth", "65"]).contains("0..=64"));
        for (line, says) in [
            ("render size=\"5x0\"", "each side in 1..16384"),
            ("light towards=\"0 0 0\"", "not of length 0"),
            ("light towards=\"0 0 -1\" intensity=-1", "must be in 0..10"),
            ("light at=\"0 0 9\" u=\"1 0 0\" v=\"3 0 0\"", "span no area"),
            ("optics transmit=1 index=0", "must be in 0.1..10"),
            ("optics transmit=1 index=-1.5", "must be in 0.1..10"),
            ("trace depth=65", "must be a whole number in 0..64"),
        ] {
            let told = told(line, &[]);
            assert!(
                told.contains(says) && told.contains("scene.kdl:2:"),
                "{renderer}, {line}: {told}"
            );
        }
    }
}
