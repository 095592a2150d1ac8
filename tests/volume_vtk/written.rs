//! Every variant that VTK writes.

use serde_json::{Value, json};
use tempfile::TempDir;
use vcsg::volume::io::{self, ReadOptions};

use crate::oracle::Oracle;
use crate::{f64s, folder, named};

const TYPES: [(&str, usize); 11] = [
    ("bit", 1),
    ("u8", 1),
    ("i8", 1),
    ("u16", 2),
    ("i16", 2),
    ("u32", 4),
    ("i32", 4),
    ("f32", 4),
    ("f64", 8),
    ("i64", 8),
    ("u64", 8),
];

/// An extent that begins nowhere near 0: 5 x 4 x 3 points.
const EXTENT: [i64; 6] = [-1, 3, 2, 5, 0, 2];

/// Axes turned about z, and no round numbers.
fn place() -> Value {
    json!({
        "extent": EXTENT,
        "spacing": [0.1, 0.7, 1.0 / 3.0],
        "origin": [-10.3, 1e3, 0.1],
        "direction": [0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0],
    })
}

struct Case<'a> {
    kind: &'a str,
    components: usize,
    of: &'a str,
    writer: Value,
}

fn merged(parts: &[&Value]) -> Value {
    let fields = parts.iter().flat_map(|part| part.as_object().unwrap().clone());
    Value::Object(fields.collect())
}

fn count(of: &str) -> usize {
    if of == "points" { 5 * 4 * 3 } else { 4 * 3 * 2 }
}

/// Bytes of the type that are a number each, no NaN, and change from value to value.
fn values(kind: &str, count: usize) -> (Vec<u8>, Vec<f64>) {
    let whole = |i: usize| (i as u64 * 2_654_435_761) % 200_003;
    let bit = |i: usize| whole(i) & 1;
    let part = |i: usize| whole(i) as f64 / 7.0 - 9000.0;
    let mut bytes = Vec::new();
    let mut numbers = Vec::new();
    for i in 0..count {
        macro_rules! put {
            ($T:ident $number:ident) => {{
                let v = $number(i) as $T;
                bytes.extend(v.to_le_bytes());
                numbers.push(v as f64);
            }};
        }
        match kind {
            "bit" => put!(u8 bit),
            "u8" => put!(u8 whole),
            "i8" => put!(i8 whole),
            "u16" => put!(u16 whole),
            "i16" => put!(i16 whole),
            "u32" => put!(u32 whole),
            "i32" => put!(i32 whole),
            "f32" => put!(f32 part),
            "f64" => put!(f64 part),
            "i64" => put!(i64 whole),
            _ => put!(u64 whole),
        }
    }
    (bytes, numbers)
}

fn check(oracle: &mut Oracle, folder: &TempDir, case: &Case) {
    let suffix = match case.writer["writer"].as_str() {
        Some("xml") => "vti",
        Some("parallel") => "pvti",
        _ => "vtk",
    };
    let path = folder.path().join(format!("a.{suffix}"));
    let (bytes, numbers) = values(case.kind, count(case.of) * case.components);
    let what = json!({
        "path": path, "type": case.kind, "components": case.components, "of": case.of, "bytes": bytes.len(), "active": true,
    });
    let request = merged(&[&place(), &what, &case.writer]);
    let seen = oracle.write(&request, &bytes);
    assert_eq!(seen.count, count(case.of), "{request}");
    // In text, legacy files have six digits of a number: what VTK reads of them counts.
    let numbers = match suffix {
        "vtk" => oracle.read(&path, case.of).1,
        _ => numbers,
    };
    for component in 0..case.components {
        let options = ReadOptions {
            component: Some(component),
            ..named("some values")
        };
        let volume = io::read_with(&path, &options).unwrap_or_else(|e| panic!("{request}: {e}"));
        let expected: Vec<_> = numbers
            .iter()
            .copied()
            .skip(component)
            .step_by(case.components)
            .collect();
        assert_eq!(f64s(volume.grid.voxels()), expected, "{request}");
        assert_eq!(volume.components, case.components);
        let expected = if case.of == "points" { [5, 4, 3] } else { [4, 3, 2] };
        assert_eq!(volume.grid.dims(), expected, "{request}");
        assert_eq!(
            volume.grid.world_from_index().translation.to_array(),
            seen.first,
            "{request}"
        );
    }
}

/// All that the XML writer can do, but for the kinds of values.
fn xml_writers() -> Vec<Value> {
    let mut all = Vec::new();
    for (mode, encode) in [
        ("ascii", true),
        ("binary", true),
        ("appended", true),
        ("appended", false),
    ] {
        for compressor in [None, Some("zlib"), Some("lz4"), Some("lzma")] {
            for wide in [false, true] {
                for order in ["little", "big"] {
                    all.push(json!({
                        "writer": "xml", "mode": mode, "encode": encode, "compressor": compressor, "wide": wide, "order": order,
                        "block": 64, "pieces": 1,
                    }));
                }
            }
        }
    }
    all
}

#[test]
fn every_variant_of_xml_is_read() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    for (number, writer) in xml_writers().into_iter().enumerate() {
        let (kind, _) = TYPES[number % TYPES.len()];
        for of in ["points", "cells"] {
            let (components, writer) = (1 + number % 3, writer.clone());
            check(
                &mut oracle,
                &folder,
                &Case {
                    kind,
                    components,
                    of,
                    writer,
                },
            );
        }
    }
}

#[test]
fn every_type_of_xml_is_read() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    for (kind, _) in TYPES {
        for writer in xml_writers().into_iter().step_by(3) {
            let case = Case {
                kind,
                components: 1,
                of: "points",
                writer,
            };
            check(&mut oracle, &folder, &case);
        }
    }
}

#[test]
fn pieces_are_put_together() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    for pieces in [2, 3, 5] {
        for of in ["points", "cells"] {
            let writer = json!({
                "writer": "xml", "mode": "appended", "encode": false, "compressor": "zlib", "wide": true, "order": "little",
                "block": 32768, "pieces": pieces,
            });
            let case = Case {
                kind: "u16",
                components: 2,
                of,
                writer,
            };
            check(&mut oracle, &folder, &case);
        }
    }
}

#[test]
fn pieces_in_files_are_put_together() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    for (pieces, ghosts, compressor) in [(1, 0, None), (2, 0, Some("zlib")), (3, 1, None), (8, 2, Some("lz4"))] {
        for kind in ["bit", "f32"] {
            let writer = json!({
                "writer": "parallel", "mode": "appended", "encode": true, "compressor": compressor, "wide": true, "order": "big",
                "block": 32768, "pieces": pieces, "ghosts": ghosts,
            });
            let case = Case {
                kind,
                components: 2,
                of: "points",
                writer,
            };
            check(&mut oracle, &folder, &case);
        }
    }
}

#[test]
fn every_variant_of_legacy_files_is_read() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    for (kind, _) in TYPES {
        for (binary, version) in [(false, 42), (true, 42), (false, 51), (true, 51)] {
            for of in ["points", "cells"] {
                for components in [1, 3] {
                    let writer = json!({"writer": "legacy", "binary": binary, "version": version});
                    check(
                        &mut oracle,
                        &folder,
                        &Case {
                            kind,
                            components,
                            of,
                            writer,
                        },
                    );
                }
            }
        }
    }
}

/// What the legacy writer keeps of a place, its reader gives back: our place is that.
#[test]
fn the_place_of_a_legacy_file_is_vtks() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    for version in [42, 51] {
        let path = folder.path().join("a.vtk");
        let (bytes, _) = values("i16", count("points"));
        let what = json!({
            "path": path, "type": "i16", "components": 1, "of": "points", "bytes": bytes.len(), "active": true,
            "writer": "legacy", "binary": true, "version": version,
        });
        oracle.write(&merged(&[&place(), &what]), &bytes);
        let (seen, values) = oracle.read(&path, "points");
        let grid = io::read_with(&path, &named("some values")).unwrap().grid;
        assert_eq!(f64s(grid.voxels()), values);
        assert_eq!(grid.world_from_index().translation.to_array(), seen.first);
    }
}
