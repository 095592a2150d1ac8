//! Damaged files: an error or a volume, and nothing else.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use tempfile::tempdir;
use vcsg::volume::io;

/// Small files of each codec.
const FILES: [&str; 9] = [
    "MR_small_RLE.dcm",
    "MR_small_jp2klossless.dcm",
    "MR_small_jpeg_ls_lossless.dcm",
    "MR_small_implicit.dcm",
    "MR_small_bigendian.dcm",
    "JPGExtended.dcm",
    "SC_rgb_jpeg_dcmtk.dcm",
    "image_dfl.dcm",
    "rtdose.dcm",
];

fn read(bytes: &[u8]) {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.dcm");
    fs::write(&path, bytes).unwrap();
    if let Err(e) = io::read(&path) {
        assert!(!e.to_string().is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_are_refused_or_read(
        file in prop::sample::select(FILES.to_vec()),
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        length in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let path = Path::new("target/deps/data/pydicom").join(file);
        let mut bytes = fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}: run make setup", path.display()));
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if cut {
            bytes.truncate(length.index(bytes.len()) + 1);
        }
        read(&bytes);
    }
}
