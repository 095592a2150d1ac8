//! Damaged files are refused, or read as what they then say: nothing panics, and nothing is allocated that is not there.

use proptest::prelude::*;
use vcsg::volume::io::ReadOptions;

use crate::hand_made_samples::{appended, samples, zlib};
use crate::read;

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes are changed, lost or doubled anywhere, most often in the markup, where sizes are.
    #[test]
    fn damage_never_panics(
        which in 0..6_usize,
        hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..4),
    ) {
        let (name, mut bytes) = samples().swap_remove(which);
        for (place, byte, how) in hits {
            let at = place.index(bytes.len());
            match how {
                0 => bytes.truncate(at + 1),
                1 => bytes.insert(at, byte),
                2 => bytes[at] = b"0123456789"[usize::from(byte % 10)],
                _ => bytes[at] = byte,
            }
        }
        if let Ok(volume) = read(name, &bytes, &ReadOptions::default()) {
            // No more voxels than the best compression makes of so many bytes.
            prop_assert!(volume.grid.voxels().len() <= bytes.len() * 8736);
        }
    }
}

/// Numbers of blocks, and sizes, that no memory could hold.
#[test]
fn declared_sizes_are_held_against_the_bytes() {
    let size = zlib().len() as u64;
    for compressor in ["vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"] {
        for words in [
            [1 << 61, 64, 0, size],
            [u64::MAX, 1, 1, size],
            [1, 1 << 60, 0, size],
            [1, 64, 1 << 60, size],
            [1, 64, 0, 1 << 60],
        ] {
            let data = [words.map(u64::to_le_bytes).concat(), zlib()].concat();
            let attributes = format!("header_type=\"UInt64\" compressor=\"{compressor}\"");
            let file = appended(&attributes, &data);
            assert!(
                read("a.vti", &file, &ReadOptions::default()).is_err(),
                "{compressor} {words:?}"
            );
            // The same, where the image asks for as much.
            let large = String::from_utf8_lossy(&file).replace("0 7 0 3", "0 1048575 0 1048575");
            let error = read("a.vti", large.as_bytes(), &ReadOptions::default()).unwrap_err();
            assert!(error.to_string().contains("bytes"), "{error}");
        }
    }
}
