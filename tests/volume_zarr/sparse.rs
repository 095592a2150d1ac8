//! Levels larger than memory.

use serde_json::json;
use vcsg::volume::io::{Budget, Problem, ReadOptions};

use crate::folder::{Folder, version_3};

fn within(mebibytes: u64) -> ReadOptions {
    ReadOptions {
        budget: Budget::of_bytes(mebibytes << 20),
        ..ReadOptions::default()
    }
}

/// 256 GiB of voxels, of which 1 MiB is there.
#[test]
fn a_level_larger_than_memory_takes_what_is_there() {
    let folder = Folder::new();
    let n = 4096;
    let mut array = version_3(&[n, n, n], &[64, 64, 64]);
    array["data_type"] = json!("float32");
    array["fill_value"] = json!("NaN");
    array["codecs"] = json!([{"name": "bytes", "configuration": {"endian": "little"}}]);
    folder.json("zarr.json", &array);
    let chunk: Vec<u8> = (0..64 * 64 * 64).flat_map(|n| (n as f32).to_le_bytes()).collect();
    folder.file("c/40/41/42", &chunk);
    let bricks = folder.open(&within(128)).unwrap().bricks().unwrap();
    assert!(bricks.bytes() < 80 << 20, "{}", bricks.bytes());
    let [i, j, k] = [42 * 64, 41 * 64, 40 * 64];
    assert_eq!(bricks.voxel(i, j, k), 0.0);
    assert_eq!(bricks.voxel(i + 63, j + 1, k + 2), (2.0 * 64.0 + 1.0) * 64.0 + 63.0);
    assert!(bricks.voxel(i - 1, j, k).is_nan());
    assert_eq!(bricks.value_range().hi, 64.0 * 64.0 * 64.0 - 1.0);
}

#[test]
fn more_than_the_budget_is_refused_before_it_is_there() {
    let folder = Folder::new();
    let is_over = |error: &vcsg::volume::io::ReadError| matches!(error.problem, Problem::Budget { .. });
    // So many bricks take more even if each is one value, and so do the voxels of a grid, and those of a chunk.
    folder.json("zarr.json", &version_3(&[1 << 20, 1 << 20, 1 << 20], &[64, 64, 64]));
    assert!(is_over(&folder.open(&within(64)).unwrap().bricks().unwrap_err()));
    assert!(is_over(&folder.open(&within(64)).unwrap().grid().unwrap_err()));
    folder.json(
        "zarr.json",
        &version_3(&[1 << 20, 1 << 20, 1 << 20], &[1 << 20, 1 << 10, 1]),
    );
    assert!(is_over(&folder.open(&within(64)).unwrap_err()));
    // Statistics need no memory.
    folder.json("zarr.json", &version_3(&[1 << 20, 1 << 20, 1 << 20], &[64, 64, 64]));
    assert_eq!(folder.open(&within(64)).unwrap().info().unwrap().max, 9.0);
}

#[test]
fn voxels_that_outgrow_the_budget_are_refused() {
    let folder = Folder::new();
    folder.json("zarr.json", &version_3(&[64, 320, 320], &[64, 64, 64]));
    let noise: Vec<u8> = (0..64 * 64 * 64)
        .map(|n: u32| (n.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    for n in 0..25 {
        folder.file(&format!("c/0/{}/{}", n / 5, n % 5), &noise);
    }
    assert!(folder.open(&within(64)).unwrap().bricks().is_ok());
    let error = folder.open(&within(4)).unwrap().bricks().unwrap_err();
    assert!(matches!(error.problem, Problem::Budget { .. }), "{error}");
    assert!(error.to_string().contains("--read-budget-mib"), "{error}");
}
