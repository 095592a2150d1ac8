//! Damaged files are refused, or read as what they then say: nothing panics.

use std::fs;

use proptest::prelude::*;
use serde_json::json;
use vcsg::volume::io;

use crate::folder;
use crate::oracle::Oracle;

/// One file of each kind.
fn samples() -> Vec<Vec<u8>> {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    let writers = [
        json!({"photometric": "minisblack"}),
        json!({"photometric": "minisblack", "compression": "lzw", "tile": [16, 16]}),
        json!({"photometric": "palette", "compression": "zlib", "bigtiff": true}),
        json!({"ome": true, "photometric": "minisblack", "compression": "packbits"}),
        json!({"imagej": true}),
    ];
    let sample = |writer| {
        oracle.write(&path, "u8", &[3, 20, 20], writer);
        fs::read(&path).unwrap()
    };
    writers.iter().map(sample).collect()
}

#[test]
fn damage_never_panics() {
    let samples = samples();
    let folder = folder();
    let path = folder.path().join("a.tif");
    let hit = (any::<prop::sample::Index>(), any::<u8>(), 0..3_u8);
    let config = ProptestConfig {
        cases: 500,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let which = 0..samples.len();
    proptest!(config, |(which in which, hits in prop::collection::vec(hit, 1..4))| {
        let mut bytes = samples[which].clone();
        for (place, byte, how) in hits {
            // Half of the hits are where the header and the first directory are.
            let at = place.index(bytes.len()) % if byte % 2 == 0 { bytes.len() } else { 400 };
            match how {
                0 => bytes.truncate(at + 1),
                _ => bytes[at] = byte,
            }
        }
        fs::write(&path, &bytes).unwrap();
        if let Ok(volume) = io::read(&path) {
            prop_assert!(volume.grid.voxels().len() <= bytes.len() << 15);
        }
    });
}

/// A page of 2^62 pixels, and one that is larger than is believed.
#[test]
fn declared_sizes_are_held_against_the_bytes() {
    for (width, height, compression) in [
        (1 << 31, 1 << 31, 1),
        (1 << 31, 1 << 31, 5),
        (1 << 17, 1 << 16, 8_u32),
        (1 << 16, 1 << 10, 8),
    ] {
        let tags = [
            (256, width),
            (257, height),
            (258, 8),
            (259, compression),
            (262, 1),
            (273, 8),
            (277, 1),
            (278, height),
            (279, 100),
        ];
        let mut bytes = b"II*\0\x08\0\0\0".to_vec();
        bytes.extend((tags.len() as u16).to_le_bytes());
        for (tag, value) in tags {
            bytes.extend(
                [
                    &(tag as u16).to_le_bytes()[..],
                    &[4, 0, 1, 0, 0, 0],
                    &u32::to_le_bytes(value),
                ]
                .concat(),
            );
        }
        bytes.extend([0; 4]);
        let folder = folder();
        let path = folder.path().join("a.tif");
        fs::write(&path, &bytes).unwrap();
        let error = io::read(&path).unwrap_err().to_string();
        assert!(error.contains("bytes"), "{width} {height} {compression}: {error}");
    }
}

/// A description of two gigabytes, in a file of some hundred bytes.
#[test]
fn a_long_description_is_not_believed() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    oracle.write(&path, "u8", &[3, 20, 20], &json!({"photometric": "minisblack"}));
    let mut bytes = fs::read(&path).unwrap();
    // Tag 270, text; how long it is follows.
    let entry = bytes.windows(4).position(|start| start == [0x0e, 1, 2, 0]).unwrap();
    bytes[entry + 4..entry + 8].copy_from_slice(&0x7600_0301_u32.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    let error = io::read(&path).unwrap_err().to_string();
    assert!(error.contains("limits"), "{error}");
}
