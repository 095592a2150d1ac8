//! What is refused, and that nothing damaged is more than an error.

use proptest::prelude::*;
use serde_json::{Value, json};
use vcsg::volume::io::{Budget, Problem, ReadOptions};

use crate::folder::{Folder, version_2, version_3};

fn error(document: &str, array: &Value, options: &ReadOptions) -> String {
    let folder = Folder::new();
    folder.json(document, array);
    folder.open(options).unwrap_err().to_string()
}

/// The array of `version`, with a field set.
fn with(mut array: Value, field: &str, value: Value) -> Value {
    array[field] = value;
    array
}

#[test]
fn what_is_not_read_is_named() {
    let two = || version_2(&[4, 4, 4], &[2, 2, 2]);
    let three = || version_3(&[4, 4, 4], &[2, 2, 2]);
    let delta = |more: Value| {
        with(
            two(),
            "filters",
            json!([with(json!({"id": "delta", "dtype": "|u1"}), "astype", more)]),
        )
    };
    let rectangles = json!({"name": "rectangular", "configuration": {"chunk_shape": [[2, 2], [4], [4]]}});
    for (array, word) in [
        (with(two(), "dtype", json!("<c8")), "<c8"),
        (with(two(), "dtype", json!([["r", "|u1"], ["g", "|u1"]])), "\"r\""),
        (with(two(), "compressor", json!({"id": "lzma"})), "lzma"),
        (delta(json!("|i1")), "`delta`"),
        (with(delta(json!("<f4")), "dtype", json!("<f4")), "`delta`"),
        (
            with(two(), "filters", json!([{"id": "shuffle", "elementsize": 0}])),
            "`shuffle`",
        ),
        (
            with(two(), "filters", json!([{"id": "fixedscaleoffset", "dtype": "<f4"}])),
            "`fixedscaleoffset`",
        ),
        (with(two(), "order", json!("D")), "`D`"),
        (with(two(), "dimension_separator", json!("-")), "`-`"),
        (with(two(), "fill_value", json!(300)), "300"),
        (with(two(), "chunks", json!([2, 2])), "axes"),
        (with(two(), "chunks", json!([2, 0, 2])), "no elements"),
        (with(three(), "data_type", json!("complex64")), "complex64"),
        (with(three(), "chunk_grid", rectangles), "rectangular"),
        (with(three(), "codecs", json!(["bytes", "zfp"])), "zfp"),
        (with(three(), "codecs", json!(["gzip", "bytes"])), "gzip"),
        (with(three(), "codecs", json!([])), "codecs"),
        (with(three(), "chunk_key_encoding", json!({"name": "other"})), "other"),
        (with(three(), "shape", json!([1 << 30, 1, 1])), "too large"),
    ] {
        let document = if array["zarr_format"] == 2 {
            ".zarray"
        } else {
            "zarr.json"
        };
        let error = error(document, &array, &ReadOptions::default());
        assert!(error.contains(word), "{word}: {error}");
    }
}

#[test]
fn groups_that_are_no_image_are_told_from_one() {
    let folder = Folder::new();
    folder.json(
        "zarr.json",
        &json!({"zarr_format": 3, "node_type": "group", "attributes": {}}),
    );
    let error = folder.open(&ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("no image"), "{error}");
    let plate = json!({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"plate": {}}}});
    folder.json("zarr.json", &plate);
    let error = folder.open(&ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("plate"), "{error}");
    folder.file("zarr.json", b"{\n\"a\": x}");
    let error = folder.open(&ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("line 2"), "{error}");
}

/// What reading it all says.
fn refused(folder: &Folder) -> Problem {
    let opened = folder.open(&ReadOptions::default()).unwrap();
    opened.grid().unwrap_err().problem
}

#[test]
fn chunks_of_another_length_are_damaged() {
    let folder = Folder::new();
    folder.json("zarr.json", &version_3(&[2, 2, 2], &[2, 2, 2]));
    for length in [0, 7, 9, 100] {
        folder.file("c/0/0/0", &vec![1; length]);
        assert!(matches!(refused(&folder), Problem::Compressed(_)), "{length}");
    }
}

#[test]
fn a_chunk_that_expands_to_too_much_is_damaged() {
    let folder = Folder::new();
    let bomb = vec![7; 50 << 20];
    for (codec, bytes) in [
        ("gzip", gzip(&bomb)),
        ("zstd", zstd::bulk::compress(&bomb, 1).unwrap()),
        ("blosc", blosc_header(50 << 20)),
    ] {
        folder.json(
            "zarr.json",
            &with(version_3(&[2, 2, 2], &[2, 2, 2]), "codecs", json!(["bytes", codec])),
        );
        folder.file("c/0/0/0", &bytes[..bytes.len().min(1 << 16)]);
        assert!(matches!(refused(&folder), Problem::Compressed(_)), "{codec}");
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A header of Blosc that declares `length` bytes.
fn blosc_header(length: u32) -> Vec<u8> {
    let numbers = [length, length, 20].map(u32::to_le_bytes).concat();
    [&[2, 1, 1 << 5, 1], &*numbers, &[0; 64]].concat()
}

/// Shards of two chunks each, with an index of offsets and lengths behind them.
fn shard(entries: [[u64; 2]; 2]) -> (Folder, Vec<u8>) {
    let folder = Folder::new();
    let sharding = json!({"chunk_shape": [1, 2, 2], "codecs": ["bytes"],
        "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, "crc32c"]});
    let codecs = json!([{"name": "sharding_indexed", "configuration": sharding}]);
    folder.json("zarr.json", &with(version_3(&[2, 2, 2], &[2, 2, 2]), "codecs", codecs));
    let index: Vec<u8> = entries.iter().flatten().flat_map(|n| n.to_le_bytes()).collect();
    let sum = crc32c::crc32c(&index).to_le_bytes();
    let bytes = [&[1, 2, 3, 4], &*index, &sum].concat();
    folder.file("c/0/0/0", &bytes);
    (folder, bytes)
}

#[test]
fn shards_are_read_by_their_index() {
    let absent = [u64::MAX; 2];
    let (folder, bytes) = shard([absent, [0, 4]]);
    let grid = folder.open(&ReadOptions::default()).unwrap().grid().unwrap();
    let voxels: Vec<f64> = (0..8).map(|n| grid.voxels().get(n)).collect();
    assert_eq!(voxels, [9.0, 9.0, 9.0, 9.0, 1.0, 2.0, 3.0, 4.0]);
    for entry in [[0, 3], [1 << 40, 4], [u64::MAX - 1, 4], [0, u64::MAX]] {
        let (folder, _) = shard([absent, entry]);
        assert!(matches!(refused(&folder), Problem::Compressed(_)), "{entry:?}");
    }
    for end in 0..bytes.len() {
        folder.file("c/0/0/0", &bytes[..end]);
        assert!(matches!(refused(&folder), Problem::Compressed(_)), "{end}");
    }
    let mut flipped = bytes;
    flipped[5] ^= 1;
    folder.file("c/0/0/0", &flipped);
    assert!(matches!(refused(&folder), Problem::Compressed(_)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Whatever bytes a chunk has, reading it is an error or voxels, and no panic.
    #[test]
    fn damaged_chunks_never_panic(codec in prop::sample::select(vec!["gzip", "zstd", "blosc", "crc32c", "numcodecs.lz4"]),
        mut bytes in prop::collection::vec(any::<u8>(), 0..200), flags: u8, typesize in 0u8..20) {
        if codec == "blosc" && bytes.len() > 16 {
            bytes[..16].copy_from_slice(&[&[2, 1, flags, typesize], &*[4096, 1024, 200].map(u32::to_le_bytes).concat()].concat());
            bytes[16..].iter_mut().skip(1).step_by(4).for_each(|b| *b = 0);
        }
        let folder = Folder::new();
        let array = with(version_3(&[16, 16, 16], &[16, 16, 16]), "codecs", json!(["bytes", codec]));
        folder.json("zarr.json", &array);
        folder.file("c/0/0/0", &bytes);
        let options = ReadOptions { budget: Budget::of_bytes(16 << 20), ..ReadOptions::default() };
        let _ = folder.open(&options).and_then(|opened| opened.info());
    }
}
