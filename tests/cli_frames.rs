//! `vcsg render --frames` from outside.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

const SCENE: &str = "scene spacing=2 {
    sphere radius=20 value=100
    sphere radius=6 center=\"30 0 0\" value=50
}
transfer {
    point 0 opacity=0 color=\"#000000\"
    point 100 opacity=0.8 color=\"#ffc080\"
}
view azimuth=30
render size=\"64x48\"
animation frames=6 {
    track \"view\" property=\"azimuth\" { at 0 0; at 5 50 }
TRACK}
";

fn folder(track: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.kdl"), SCENE.replace("TRACK", track)).unwrap();
    folder
}

fn vcsg(folder: &Path, arguments: &[&str], path: Option<&Path>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    if let Some(path) = path {
        command.env("PATH", path);
    }
    command
        .current_dir(folder)
        .args(["render", "scene.kdl"])
        .args(arguments)
        .output()
        .unwrap()
}

fn succeed(folder: &Path, arguments: &[&str]) {
    let output = vcsg(folder, arguments, None);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

fn fail(folder: &Path, arguments: &[&str], path: Option<&Path>) -> String {
    let output = vcsg(folder, arguments, path);
    assert!(!output.status.success(), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn frame(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

#[test]
fn frames_are_numbered_and_differ() {
    let folder = folder("");
    succeed(folder.path(), &["-o", "f-%03d.png", "--frames", "0..5"]);
    let frames: Vec<_> = (0..6).map(|n| frame(folder.path(), &format!("f-00{n}.png"))).collect();
    assert!(frames.windows(2).all(|pair| pair[0] != pair[1]));
    assert!(!folder.path().join("f-006.png").exists());
}

#[test]
fn shards_and_single_frames_are_the_same_frames() {
    let folder = folder("");
    succeed(folder.path(), &["-o", "all-%d.png", "--frames", "0..5"]);
    for part in ["1/3", "2/3", "3/3"] {
        succeed(
            folder.path(),
            &["-o", "part-%d.png", "--frames", "0..5", "--shard", part],
        );
    }
    for n in 0..6 {
        let name = |what: &str| format!("{what}-{n}.png");
        assert_eq!(frame(folder.path(), &name("all")), frame(folder.path(), &name("part")));
    }
}

#[test]
fn a_moving_model_is_drawn() {
    let folder = folder("    track \"scene/sphere[2]\" property=\"center\" { at 0 \"30 0 0\"; at 5 \"0 -30 20\" }\n");
    succeed(folder.path(), &["-o", "f-%d.png", "--frames", "0..5", "--no-shading"]);
    succeed(folder.path(), &["-o", "g-%d.png", "--frames", "5..5", "--no-shading"]);
    assert_ne!(frame(folder.path(), "f-4.png"), frame(folder.path(), "f-5.png"));
    assert!(folder.path().join("g-5.png").exists());
}

#[test]
fn frames_that_are_there_are_kept() {
    let folder = folder("");
    fs::write(folder.path().join("f-1.png"), "kept").unwrap();
    succeed(folder.path(), &["-o", "f-%d.png", "--frames", "0..2"]);
    assert_eq!(frame(folder.path(), "f-1.png"), b"kept");
    assert!(frame(folder.path(), "f-2.png").starts_with(b"\x89PNG"));
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = folder("");
    let says = |arguments: &[&str], what: &str| {
        let said = fail(folder.path(), arguments, None);
        assert!(said.contains(what), "{said}");
    };
    says(&["-o", "f.png", "--frames", "0..5"], "%04d");
    says(&["-o", "f-%d.png", "--frames", "0..6"], "there is no frame 6");
    says(&["-o", "f-%d.png", "--frames", "3..1"], "not a range");
    says(&["-o", "f-%d.png", "--frames", "0..1", "--shard", "3/2"], "not a part");
    fs::write(folder.path().join("scene.kdl"), "scene { sphere radius=1 }\n").unwrap();
    says(&["-o", "f-%d.png", "--frames", "0..1"], "no `animation` node");
}

#[test]
fn without_ffmpeg_there_is_no_video_and_nothing_is_drawn() {
    let folder = folder("");
    let arguments = ["-o", "f-%d.png", "--frames", "0..1", "--video", "v.mp4"];
    let said = fail(folder.path(), &arguments, Some(folder.path()));
    assert!(said.contains("no ffmpeg is installed"), "{said}");
    assert!(!folder.path().join("f-0.png").exists());
}

/// A stand-in for ffmpeg, which writes its arguments to the file that they end in.
#[cfg(unix)]
#[test]
fn ffmpeg_is_given_the_frames() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("");
    let program = folder.path().join("ffmpeg");
    fs::write(
        &program,
        "#!/bin/sh\nfor last; do :; done\n[ \"$last\" = -version ] || echo \"$@\" > \"$last\"\n",
    )
    .unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let arguments = ["-o", "f-%d.png", "--frames", "1..2", "--video", "v.mp4"];
    let output = vcsg(folder.path(), &arguments, Some(folder.path()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let given = fs::read_to_string(folder.path().join("v.mp4")).unwrap();
    assert!(
        given.contains("-framerate 25 -start_number 1 -i f-%d.png -frames:v 2"),
        "{given}"
    );
}
