//! What a file of raw voxels may hold, by its name and its size.
//!
//! *Practice.* A guess is offered, as the options to type, and never taken: one file can be many volumes.

use std::path::Path;

use crate::volume::voxel::VoxelType;

/// How many layouts are offered.
const OFFERS: usize = 4;

/// Words in file names that tell a type.
const TYPES: [(&str, VoxelType); 24] = [
    ("u8", VoxelType::U8),
    ("uint8", VoxelType::U8),
    ("uchar", VoxelType::U8),
    ("8bit", VoxelType::U8),
    ("i8", VoxelType::I8),
    ("int8", VoxelType::I8),
    ("u16", VoxelType::U16),
    ("uint16", VoxelType::U16),
    ("ushort", VoxelType::U16),
    ("16bit", VoxelType::U16),
    ("i16", VoxelType::I16),
    ("int16", VoxelType::I16),
    ("short", VoxelType::I16),
    ("u32", VoxelType::U32),
    ("uint32", VoxelType::U32),
    ("i32", VoxelType::I32),
    ("int32", VoxelType::I32),
    ("int", VoxelType::I32),
    ("f32", VoxelType::F32),
    ("float32", VoxelType::F32),
    ("float", VoxelType::F32),
    ("f64", VoxelType::F64),
    ("float64", VoxelType::F64),
    ("double", VoxelType::F64),
];

/// One type of each size, the likeliest first.
const LIKELY: [VoxelType; 4] = [VoxelType::U8, VoxelType::U16, VoxelType::F32, VoxelType::F64];

/// Sides of square slices, the likeliest first.
const SIDES: [usize; 5] = [512, 256, 128, 1024, 64];

/// What the user of the file at `path` can do.
pub(super) fn hint(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let bytes = path.metadata().map_or(0, |file| file.len());
    let offers: Vec<_> = offers(&name, bytes).iter().map(Offer::options).collect();
    match &offers[..] {
        [] => format!(
            "say what its {bytes} bytes are, with --raw-dims, --raw-type and --raw-spacing, or write a NRRD header (.nhdr) beside it: size, voxel type, spacing"
        ),
        offers => format!(
            "its size, voxel type and spacing have to be said; by its name and {bytes} bytes it may be: {}",
            offers.join(", or ")
        ),
    }
}

/// A layout that a file may have.
#[derive(Debug, PartialEq)]
struct Offer {
    dims: [usize; 3],
    voxel: VoxelType,
    /// Bytes before the first voxel.
    skip: u64,
}

impl Offer {
    /// The options that say it.
    fn options(&self) -> String {
        let [x, y, z] = self.dims;
        let skip = match self.skip {
            0 => String::new(),
            skip => format!(" --raw-skip {skip}"),
        };
        format!("--raw-dims {x},{y},{z} --raw-type {}{skip}", self.voxel.name())
    }
}

/// Layouts that a file of this name and size may have, the likeliest first: what its name says, else cubes, else squares.
fn offers(name: &str, bytes: u64) -> Vec<Offer> {
    let named_type =
        (words(name)).find_map(|word| TYPES.iter().find(|(known, _)| *known == word).map(|(_, voxel)| *voxel));
    let types: Vec<_> = named_type.map_or(LIKELY.to_vec(), |voxel| vec![voxel]);
    let mut offers = Vec::new();
    if let Some(dims) = dims(name) {
        let size = |voxel: VoxelType| {
            dims.iter()
                .try_fold(voxel.bytes() as u64, |n, &d| n.checked_mul(d as u64))
        };
        let fits = |voxel: &VoxelType| size(*voxel).is_some_and(|size| 0 < size && size <= bytes);
        // The widest type that fits leaves the fewest bytes.
        let best = types
            .iter()
            .filter(|voxel| fits(voxel))
            .max_by_key(|voxel| voxel.bytes());
        offers.extend(best.and_then(|&voxel| {
            let skip = bytes - size(voxel)?;
            Some(Offer { dims, voxel, skip })
        }));
        return offers;
    }
    let exact = |[x, y]: [usize; 2], voxel: VoxelType| {
        let slice = (x * y * voxel.bytes()) as u64;
        let slices = (bytes / slice) as usize;
        (bytes.is_multiple_of(slice) && slices > 1).then_some(Offer {
            dims: [x, y, slices],
            voxel,
            skip: 0,
        })
    };
    for &voxel in &types {
        let side = ((bytes / voxel.bytes() as u64) as f64).cbrt().round() as usize;
        if side > 1 {
            offers.extend(exact([side; 2], voxel).filter(|offer| offer.dims[2] == side));
        }
    }
    for side in SIDES {
        for &voxel in &types {
            let likely = |offer: &Offer| (8..=2048).contains(&offer.dims[2]) && !offers.contains(offer);
            offers.extend(exact([side; 2], voxel).filter(likely));
        }
    }
    offers.truncate(OFFERS);
    offers
}

fn words(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| !c.is_ascii_alphanumeric())
}

/// Three numbers with an x between them.
fn dims(name: &str) -> Option<[usize; 3]> {
    words(name).find_map(|word| {
        let numbers: Option<Vec<usize>> = word.split('x').map(|n| n.parse().ok()).collect();
        numbers?.try_into().ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(name: &str, bytes: u64) -> Vec<String> {
        offers(name, bytes).iter().map(Offer::options).collect()
    }

    #[test]
    fn names_that_carry_sizes_are_believed_if_they_fit() {
        assert_eq!(
            options("bolt_uint8_70x123x66.raw", 568_260),
            ["--raw-dims 70,123,66 --raw-type u8"]
        );
        assert_eq!(
            options("stent_int16_128x128x256.raw", 8 << 20),
            ["--raw-dims 128,128,256 --raw-type i16"]
        );
        assert_eq!(
            options("a-4x4x4.raw", 256 + 10),
            ["--raw-dims 4,4,4 --raw-type f32 --raw-skip 10"]
        );
        assert!(options("a_uint8_70x123x66.raw", 1000).is_empty());
    }

    #[test]
    fn sizes_alone_tell_cubes_and_squares() {
        assert_eq!(
            options("neghip.raw", 66 * 66 * 66),
            [
                "--raw-dims 66,66,66 --raw-type u8",
                "--raw-dims 33,33,33 --raw-type f64"
            ]
        );
        assert_eq!(
            options("a.raw", 256 * 256 * 109)[0],
            "--raw-dims 256,256,109 --raw-type u8"
        );
        assert!(options("a.raw", 0).is_empty());
        assert!(options("a.raw", 1_000_003).is_empty());
    }
}
