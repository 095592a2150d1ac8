//! Our voxels against those that zarr-python was given.

#[path = "../oracle/process.rs"]
mod process;

use std::fs;
use std::path::PathBuf;

use process::Process;
use serde::Deserialize;
use serde_json::json;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, ReadOptions};

#[derive(Deserialize)]
struct Case {
    name: String,
    path: PathBuf,
    #[serde(rename = "type")]
    voxel: String,
    dims: [usize; 3],
    voxels: PathBuf,
    frame: Option<usize>,
    component: Option<usize>,
}

/// The voxels as bytes; 64-bit integers as the doubles that they become.
fn bytes(voxels: &Voxels) -> &[u8] {
    match voxels {
        Voxels::U8(v) => v,
        Voxels::I8(v) => bytemuck::cast_slice(v),
        Voxels::U16(v) => bytemuck::cast_slice(v),
        Voxels::I16(v) => bytemuck::cast_slice(v),
        Voxels::U32(v) => bytemuck::cast_slice(v),
        Voxels::I32(v) => bytemuck::cast_slice(v),
        Voxels::F32(v) => bytemuck::cast_slice(v),
        Voxels::F64(v) => bytemuck::cast_slice(v),
    }
}

fn expected(case: &Case) -> Vec<u8> {
    let bytes = fs::read(&case.voxels).unwrap();
    let (eights, _) = bytes.as_chunks::<8>();
    let doubles: Vec<f64> = match case.voxel.as_str() {
        "i8" => eights.iter().map(|b| i64::from_le_bytes(*b) as f64).collect(),
        "u8" => eights.iter().map(|b| u64::from_le_bytes(*b) as f64).collect(),
        _ => return bytes,
    };
    bytemuck::cast_slice(&doubles).to_vec()
}

#[test]
fn voxels_are_those_that_zarr_python_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let mut oracle = Process::start("tests/oracle/zarr_arrays.py");
    oracle.send(&json!({ "folder": folder.path() }), &[]);
    let mut answer = serde_json::Deserializer::from_reader(&mut oracle.answers);
    let cases = Vec::<Case>::deserialize(&mut answer).expect("the oracle answers; see its message above");
    assert!(cases.len() > 100);
    for case in &cases {
        let options = ReadOptions {
            frame: case.frame,
            component: case.component,
            ..ReadOptions::default()
        };
        let volume = io::read_with(&case.path, &options).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        assert_eq!(volume.grid.dims(), case.dims, "{}", case.name);
        assert!(
            bytes(volume.grid.voxels()) == expected(case),
            "{}: other voxels",
            case.name
        );
        let info = io::open(&case.path, &options).unwrap().info().unwrap();
        assert_eq!(
            (info.min, info.max),
            (volume.grid.stats().min, volume.grid.stats().max),
            "{}",
            case.name
        );
        let bricks = io::open(&case.path, &options).unwrap().bricks().unwrap();
        let [i, j, k] = case.dims.map(|n| n / 2);
        assert_eq!(
            bricks.voxel(i, j, k),
            volume.grid.value_at([i, j, k]) as f32,
            "{}",
            case.name
        );
    }
}
