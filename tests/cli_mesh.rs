//! `vcsg mesh` from outside.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

const HEAD: &str = "target/deps/data/ch2.nii.gz";

/// Runs `vcsg mesh` with `arguments`; returns whether it succeeded, its stdout and its stderr.
fn mesh(arguments: &[&str]) -> (bool, String, String) {
    assert!(Path::new(HEAD).exists(), "{HEAD} is missing: run make setup");
    let output = Command::cargo_bin("vcsg")
        .expect("the program")
        .arg("mesh")
        .args(arguments)
        .output()
        .expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (output.status.success(), text(output.stdout), text(output.stderr))
}

fn measures(arguments: &[&str]) -> Value {
    let (done, stdout, stderr) = mesh(arguments);
    assert!(done, "{stderr}");
    let value: Value = serde_json::from_str(&stdout).expect("JSON");
    value["measures"].clone()
}

#[test]
fn a_volume_cut_open_is_closed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.glb");
    let name = path.to_str().expect("a name");
    let cut = ["--cut", "0,0,20", "0,0,1"];
    let open = measures(&[HEAD, "--iso", "60", "--json", "-o", name]);
    let closed = measures(&[&[HEAD, "--iso", "60", "--json", "-o", name], &cut[..]].concat());
    assert_eq!(closed["boundary_edges"], 0);
    assert!(open["boundary_edges"].as_u64() > Some(0));
    let top = closed["bounds_mm"][1][2].as_f64().expect("a bound");
    // The plane itself, rounded to 24 bits.
    assert!((top - 20.0).abs() <= 20.0 * 0.5_f64.powi(23), "{top}");
    assert!(path.metadata().expect("the mesh").len() > 1_000_000);
}

#[test]
fn the_largest_piece_and_fewer_triangles() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("skin.stl");
    let name = path.to_str().expect("a name");
    let common = [HEAD, "--iso", "60", "--average", "--json", "-o", name];
    let all = measures(&common);
    let largest = measures(&[&common[..], &["--largest", "1"]].concat());
    assert_eq!(largest["components"], 1);
    assert!(largest["triangles"].as_u64() < all["triangles"].as_u64());
    let fewer = measures(&[&common[..], &["--largest", "1", "--simplify", "50000"]].concat());
    assert!(fewer["triangles"].as_u64() <= Some(50_000));
    // 84 bytes and 50 a triangle: what was written is what was measured.
    let size = path.metadata().expect("the mesh").len();
    assert_eq!(Some(size - 84), fewer["triangles"].as_u64().map(|n| 50 * n));
}

#[test]
fn several_isovalues_are_several_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = |n: &str| folder.path().join(n).to_str().expect("a name").to_owned();
    let of = |isos: &[&str], file: &str| {
        let path = name(file);
        let isos: Vec<&str> = isos.iter().flat_map(|iso| ["--iso", iso]).collect();
        measures(&[&[HEAD, "--average", "--json", "-o", &path], &isos[..]].concat())["triangles"].as_u64()
    };
    let both = of(&["60", "120"], "both.obj");
    let sum = of(&["60"], "one.obj")
        .zip(of(&["120"], "other.obj"))
        .map(|(a, b)| a + b);
    assert_eq!(both, sum);
    let text = std::fs::read_to_string(name("both.obj")).expect("the mesh");
    assert_eq!(text.lines().filter(|line| line.starts_with("g ")).count(), 2);
}

#[test]
fn an_empty_surface_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("none.ply");
    let (done, stdout, stderr) = mesh(&[HEAD, "--iso", "1000", "-o", path.to_str().expect("a name")]);
    assert!(done && path.exists());
    assert!(stdout.contains("triangles           0"), "{stdout}");
    assert!(
        stderr.contains("the surface at 1000 is empty: values go from 0 to 254"),
        "{stderr}"
    );
}

#[test]
fn what_cannot_be_done_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a name").to_owned();
    let (ply, odd, lost) = (path("a.ply"), path("a.xyz"), path("none/a.ply"));
    let cases: [(&[&str], &str); 7] = [
        (&[HEAD, "--iso", "nan", "-o", &ply], "not a finite number"),
        (&[HEAD, "-o", &ply], "--iso"),
        (&[HEAD, "--iso", "60", "-o", &odd], "no mesh format"),
        (&[HEAD, "--iso", "60", "-o", &lost], "cannot write"),
        (
            &[HEAD, "--iso", "60", "-o", &ply, "--cut", "0,0,0", "0,0,0"],
            "the normal is 0,0,0",
        ),
        (&[HEAD, "--iso", "60", "-o", &ply, "--seed", "1,2"], "three numbers"),
        (
            &["assets/scenes/head-cut.kdl", "--iso", "60", "-o", &ply, "--average"],
            "own lattice",
        ),
    ];
    for (arguments, message) in cases {
        let (done, stdout, stderr) = mesh(arguments);
        assert!(!done && stdout.is_empty(), "{arguments:?}: {stdout}");
        assert!(stderr.contains(message), "{arguments:?}: {stderr}");
    }
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 0);
}
