//! One number a voxel, of files that hold several.
//!
//! *Practice.* A component is taken as it is. Otherwise three or four whole numbers of 8 or 16 bits are a colour, of which the
//! luminance is taken (Rec. 709, of the numbers as they are stored; a fourth, the opacity, counts for nothing), and all else is
//! a vector, of which the length is taken.

use std::path::Path;

use super::error::ReadError;
use crate::volume::grid::Voxels;
use crate::volume::voxel::{Voxel, VoxelType, for_type, map_type};

/// Rec. 709's share of red, green and blue in the luminance.
const REC_709: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Which number of a voxel, or what of them all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Components {
    /// Numbers a voxel in the file.
    count: usize,
    /// The one that is meant.
    chosen: Option<usize>,
}

/// What becomes of several numbers.
enum Rule {
    Component(usize),
    Luminance,
    Length,
}

impl Components {
    /// `chosen`, or all, of the `count` numbers (at least one) of a voxel in the file at `path`.
    pub(super) fn new(path: &Path, count: usize, chosen: Option<usize>) -> Result<Self, ReadError> {
        match chosen {
            Some(chosen) if chosen >= count => {
                let what = format!("it has no component {chosen}: its voxels have {count}");
                Err(ReadError::unsupported(path, what).hint(format!("components are counted from 0 to {}", count - 1)))
            }
            _ => Ok(Self { count, chosen }),
        }
    }

    /// How many numbers a voxel has in the file.
    pub(super) fn count(self) -> usize {
        self.count
    }

    fn rule(self, stored: VoxelType) -> Rule {
        match (self.chosen, self.count, stored) {
            (Some(component), ..) => Rule::Component(component),
            (None, 1, _) => Rule::Component(0),
            (None, 3 | 4, VoxelType::U8 | VoxelType::U16) => Rule::Luminance,
            _ => Rule::Length,
        }
    }

    /// The type of the one number, of voxels that hold numbers of type `stored`.
    pub(super) fn voxel(self, stored: VoxelType) -> VoxelType {
        match (self.rule(stored), stored) {
            (Rule::Component(_) | Rule::Luminance, stored) => stored,
            (Rule::Length, VoxelType::F64) => VoxelType::F64,
            (Rule::Length, _) => VoxelType::F32,
        }
    }

    /// The one number of each voxel, of whose numbers `voxels` has all, voxel after voxel.
    pub(super) fn one(self, voxels: Voxels) -> Voxels {
        let n = self.count;
        match (self.rule(voxels.voxel_type()), voxels) {
            (Rule::Component(_), voxels) if n == 1 => voxels,
            (Rule::Component(c), voxels) => map_type!(Voxels, voxels, Voxels, v => every(&v, n, |voxel| voxel[c])),
            (Rule::Luminance, voxels) => map_type!(Voxels, voxels, Voxels, v => every(&v, n, luminance)),
            (Rule::Length, Voxels::F64(v)) => Voxels::F64(every(&v, n, length)),
            (Rule::Length, voxels) => {
                Voxels::F32(for_type!(Voxels, voxels, v => every(&v, n, |voxel| length(voxel) as f32)))
            }
        }
    }
}

fn every<T, U>(numbers: &[T], count: usize, of: impl Fn(&[T]) -> U) -> Vec<U> {
    numbers.chunks_exact(count).map(of).collect()
}

fn luminance<T: Voxel>(colour: &[T]) -> T {
    let parts = colour.iter().zip(REC_709);
    T::nearest(parts.map(|(v, share)| v.to_f64() * share).sum())
}

fn length<T: Voxel>(vector: &[T]) -> f64 {
    vector.iter().map(|v| v.to_f64() * v.to_f64()).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn components(count: usize, chosen: Option<usize>) -> Components {
        Components::new(Path::new("a"), count, chosen).unwrap()
    }

    #[test]
    fn colours_are_their_luminance() {
        let rgba = Voxels::U8(vec![255, 0, 0, 7, 0, 255, 0, 7, 0, 0, 255, 7, 255, 255, 255, 7]);
        assert_eq!(
            components(4, None).one(rgba.clone()),
            Voxels::U8(vec![54, 182, 18, 255])
        );
        assert_eq!(components(4, Some(3)).one(rgba), Voxels::U8(vec![7; 4]));
        assert_eq!(components(3, None).voxel(VoxelType::U16), VoxelType::U16);
    }

    #[test]
    fn vectors_are_their_length() {
        assert_eq!(components(2, None).one(Voxels::U8(vec![3, 4])), Voxels::F32(vec![5.0]));
        let vectors = Voxels::F64(vec![2.0, 3.0, 6.0, -1.0, 0.0, 0.0]);
        assert_eq!(components(3, None).one(vectors), Voxels::F64(vec![7.0, 1.0]));
        for stored in [VoxelType::I16, VoxelType::F64] {
            let one = components(3, None).one(Voxels::none(stored));
            assert_eq!(one.voxel_type(), components(3, None).voxel(stored));
        }
    }

    #[test]
    fn a_component_that_is_not_there_is_refused() {
        assert!(Components::new(Path::new("a"), 3, Some(3)).is_err());
    }
}
