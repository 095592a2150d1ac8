//! How the program reads large volumes and folders, from outside.

use std::path::Path;
use std::process::{Command, Output};

use glam::DAffine3;
use serde_json::{Value, json};
use vcsg::volume::io::{Encoding, write_nrrd};
use vcsg::volume::{Grid, Voxels};

fn vcsg(arguments: &[&str], path: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command.args(arguments).arg(path).output().unwrap()
}

#[test]
fn a_volume_beyond_the_budget_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let voxels = (0..128 * 128 * 128).map(|n: u32| (n.wrapping_mul(2_654_435_761) >> 24) as u8);
    let grid = Grid::new([128; 3], DAffine3::IDENTITY, Voxels::U8(voxels.collect())).unwrap();
    write_nrrd(&path, &grid, Encoding::Raw).unwrap();
    let ply = folder.path().join("a.ply");
    let output = [
        "mesh",
        "--iso",
        "200",
        "--read-budget-mib",
        "1",
        "-o",
        ply.to_str().unwrap(),
    ];
    let refused = vcsg(&output, &path);
    assert!(!refused.status.success() && !ply.exists());
    // Lines may be broken anywhere.
    let text = String::from_utf8_lossy(&refused.stderr).into_owned();
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    for word in ["a.nrrd", "2MiB", "1MiB", "--read-budget-mib"] {
        assert!(text.contains(word), "{text}");
    }
    // Where no terminal is, no bar is drawn.
    let info = vcsg(&["info", "--json", "--read-budget-mib", "2"], &path);
    assert!(info.status.success() && info.stderr.is_empty());
}

/// A bar is drawn where stderr is a terminal: one is made by `script`, of Debian's essential bsdutils.
#[test]
fn a_terminal_sees_how_much_has_come_and_how_fast() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    let voxels = (0..256 * 256 * 64).map(|n: u32| (n.wrapping_mul(2_654_435_761) >> 24) as u8);
    let grid = Grid::new([256, 256, 64], DAffine3::IDENTITY, Voxels::U8(voxels.collect())).unwrap();
    write_nrrd(&path, &grid, Encoding::Raw).unwrap();
    let info = format!("'{}' info '{}'", env!("CARGO_BIN_EXE_vcsg"), path.display());
    let shown = Command::new("script")
        .args(["-qec", &info, "/dev/null"])
        .output()
        .unwrap();
    assert!(shown.status.success());
    let text = String::from_utf8(shown.stdout).unwrap();
    let (bars, result) = text.rsplit_once("load").unwrap_or_else(|| panic!("no bar in {text:?}"));
    assert!(
        result.contains("256 x 256 x 64 voxels") && !bars.contains("voxels"),
        "{text:?}"
    );
    // Each bar takes the place of the one before, and the last one goes away.
    let bars: Vec<&str> = text.split("\u{1b}[2K").collect();
    assert!(bars.len() > 1 && !bars[bars.len() - 1].contains("load"), "{text:?}");
    let percents = bars[..bars.len() - 1].iter().map(|bar| {
        assert!(bar.contains("load") && bar.contains("iB/s"), "{bar:?}");
        let number = bar.split(" %").next().and_then(|start| start.split_whitespace().last());
        number
            .and_then(|number| number.parse::<u32>().ok())
            .unwrap_or_else(|| panic!("{bar:?}"))
    });
    let percents: Vec<u32> = percents.collect();
    assert!(
        percents.is_sorted() && percents.iter().all(|p| (1..=100).contains(p)),
        "{percents:?}"
    );
}

#[test]
fn a_zarr_folder_is_a_volume() {
    let folder = tempfile::tempdir().unwrap();
    let array = json!({
        "zarr_format": 2, "shape": [2, 3, 2, 4], "chunks": [1, 1, 2, 4], "dtype": "|u1", "compressor": null, "fill_value": 7, "order": "C",
    });
    std::fs::write(folder.path().join(".zarray"), array.to_string()).unwrap();
    std::fs::write(folder.path().join("1.2.0.0"), [1, 2, 3, 4, 5, 6, 7, 9]).unwrap();
    let info = vcsg(&["info", "--json", "--component", "1"], folder.path());
    let info: Value = serde_json::from_slice(&info.stdout).unwrap();
    let volume = &info["volumes"][0];
    assert_eq!(
        (&volume["format"], &volume["dims"]),
        (&json!("Zarr"), &json!([4, 2, 3]))
    );
    assert_eq!(
        (&volume["min"], &volume["max"], &volume["components"]),
        (&json!(1.0), &json!(9.0), &json!(2))
    );
}
