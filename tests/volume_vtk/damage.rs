//! Damaged files are refused, or read as what they then say: nothing panics, and nothing is allocated that is not there.

use proptest::prelude::*;
use vcsg::volume::io::ReadOptions;

use crate::hand_made_samples::samples;
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
