//! The same slice in each transfer syntax that the tests can write.

use charls::{CharLS, FrameInfo};
use tempfile::tempdir;
use vcsg::volume::io;

use crate::file::{BIG, DEFLATED, EXPLICIT, File, IMPLICIT, JPEG_LS, RLE, SIZE};

/// A frame of 16-bit values in RLE: a segment a byte, the high one first, each a run or literals.
pub fn rle(frame: &[u8]) -> Vec<u8> {
    let segments = [1, 0].map(|byte| {
        let bytes: Vec<u8> = frame.chunks_exact(2).map(|value| value[byte]).collect();
        let mut packed = match bytes.iter().all(|b| *b == bytes[0]) {
            true => vec![(257 - bytes.len()) as u8, bytes[0]],
            false => [&[bytes.len() as u8 - 1], &bytes[..]].concat(),
        };
        packed.resize(packed.len().next_multiple_of(2), 0);
        packed
    });
    let mut header = [0u32; 16];
    header[..3].copy_from_slice(&[2, 64, 64 + segments[0].len() as u32]);
    let header: Vec<u8> = header.iter().flat_map(|v| v.to_le_bytes()).collect();
    [header, segments.concat()].concat()
}

#[test]
fn every_transfer_syntax_holds_the_same_values() {
    let folder = tempdir().unwrap();
    let plain = File::slice(3, 0.0);
    let info = FrameInfo {
        width: SIZE[0] as u32,
        height: SIZE[1] as u32,
        bits_per_sample: 16,
        component_count: 1,
    };
    let jpeg_ls = CharLS::default().encode(info, 0, &plain.frames[0]).unwrap();
    let compressed = [(RLE, rle(&plain.frames[0])), (JPEG_LS, jpeg_ls)];
    let native = [EXPLICIT, IMPLICIT, DEFLATED, BIG].map(|syntax| (syntax, plain.frames[0].clone()));
    for (syntax, frame) in native.into_iter().chain(compressed) {
        let file = File {
            syntax,
            frames: vec![frame],
            ..plain.clone()
        };
        let volume = io::read(&file.write(folder.path(), "a.dcm")).unwrap_or_else(|e| panic!("{syntax}: {e}"));
        for (i, at) in (0..3).flat_map(|j| (0..4).map(move |i| [i, j, 0])).enumerate() {
            assert_eq!(volume.grid.value_at(at), 300.0 + i as f64, "{syntax}");
        }
    }
}

#[test]
fn frames_of_several_items_are_put_together() {
    let folder = tempdir().unwrap();
    let mut file = File::slice(3, 0.0);
    file.syntax = RLE;
    let frame = rle(&file.frames[0]);
    file.frames = vec![frame[..66].to_vec(), frame[66..].to_vec()];
    let volume = io::read(&file.write(folder.path(), "a.dcm")).unwrap();
    assert_eq!(volume.grid.value_at([3, 2, 0]), 311.0);
}

#[test]
fn files_without_preamble_and_meta_information_are_read_by_their_elements() {
    let folder = tempdir().unwrap();
    for (syntax, meta) in [(EXPLICIT, 28), (IMPLICIT, 26), (BIG, 28)] {
        let file = File {
            syntax,
            ..File::slice(3, 0.0)
        };
        let path = folder.path().join("bare");
        std::fs::write(&path, &file.bytes()[132 + meta..]).unwrap();
        let volume = io::read(&path).unwrap_or_else(|e| panic!("{syntax}: {e}"));
        assert_eq!(volume.grid.value_at([3, 2, 0]), 311.0, "{syntax}");
    }
}
