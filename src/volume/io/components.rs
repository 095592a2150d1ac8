//! One number a voxel, of files that hold several.
//!
//! *Practice.* A component is taken as it is. Otherwise three or four whole numbers of 8 or 16 bits are a colour, of which the
//! luminance is taken (Rec. 709, of the numbers as they are stored; a fourth, the opacity, counts for nothing), and all else is
//! a vector, of which the length is taken; unless the format says what they are.

use std::iter::StepBy;
use std::path::Path;
use std::slice::Iter;

use super::error::ReadError;
use super::stored::Stored;
use crate::volume::grid::Voxels;
use crate::volume::voxel::{Voxel, VoxelType, for_type, map_type};

/// Rec. 709's share of red, green and blue in the luminance.
const REC_709: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Which number of a voxel, or what of them all, and how they lie: runs of so many voxels' first numbers, then as many of the
/// second, and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Components {
    /// Numbers a voxel in the file.
    count: usize,
    /// The one that is meant.
    chosen: Option<usize>,
    /// What the format says that becomes of them otherwise.
    usual: Option<Rule>,
    /// Voxels in a run: 1 where the numbers of a voxel follow each other.
    run: usize,
}

/// What becomes of several numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// One of them is taken.
    Component(usize),
    /// They are a colour.
    Luminance,
    /// They are a vector, or a complex number.
    Length,
}

impl Components {
    /// One number a voxel.
    pub(super) const SCALAR: Self = Self {
        count: 1,
        chosen: None,
        usual: None,
        run: 1,
    };

    /// `chosen`, or all, of the `count` numbers (at least one) of a voxel in the file at `path`.
    pub(super) fn new(path: &Path, count: usize, chosen: Option<usize>) -> Result<Self, ReadError> {
        match chosen {
            Some(chosen) if chosen >= count => {
                let what = format!("it has no component {chosen}: its voxels have {count}");
                Err(ReadError::unsupported(path, what).hint(format!("components are counted from 0 to {}", count - 1)))
            }
            _ => Ok(Self {
                count,
                chosen,
                ..Self::SCALAR
            }),
        }
    }

    /// The same where the format says what becomes of them.
    pub(super) fn as_rule(self, usual: Rule) -> Self {
        let usual = Some(usual);
        Self { usual, ..self }
    }

    /// The same in runs of `run` voxels.
    pub(super) fn in_runs(self, run: usize) -> Self {
        Self { run, ..self }
    }

    /// How many numbers a voxel has in the file.
    pub(super) fn count(self) -> usize {
        self.count
    }

    /// How many voxels a run has.
    pub(super) fn run(self) -> usize {
        self.run
    }

    /// The one that is meant, if one is.
    pub(super) fn chosen(self) -> Option<usize> {
        match self.usual {
            Some(Rule::Component(component)) => self.chosen.or(Some(component)),
            _ => self.chosen,
        }
    }

    fn rule(self, stored: VoxelType) -> Rule {
        match (self.chosen, self.usual, self.count, stored) {
            (Some(component), ..) => Rule::Component(component),
            (None, _, 1, _) => Rule::Component(0),
            (None, Some(usual), ..) => usual,
            (None, None, 3 | 4, VoxelType::U8 | VoxelType::U16) => Rule::Luminance,
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

    /// What a user should know of it, of voxels that hold numbers of type `stored`.
    pub(super) fn note(self, stored: Stored) -> Option<String> {
        let what = match self.rule(stored.voxel()) {
            _ if self.count == 1 => return None,
            Rule::Component(component) => format!("component {component} is read"),
            Rule::Luminance => "read as their luminance (Rec. 709), rounded".to_owned(),
            Rule::Length => "read as their magnitude".to_owned(),
        };
        let count = self.count;
        Some(format!(
            "{count} components a voxel: {what}; --component reads one of them"
        ))
    }

    /// The one number of each voxel, of whole runs of which `voxels` has all numbers.
    pub(super) fn one(self, voxels: Voxels) -> Voxels {
        match (self.rule(voxels.voxel_type()), voxels) {
            (Rule::Component(_), voxels) if self.count == 1 => voxels,
            (Rule::Component(c), voxels) => map_type!(Voxels, voxels, Voxels, v => self.every(&v, |voxel| voxel.at(c))),
            (Rule::Luminance, voxels) => map_type!(Voxels, voxels, Voxels, v => self.every(&v, luminance)),
            (Rule::Length, Voxels::F64(v)) => Voxels::F64(self.every(&v, length)),
            (Rule::Length, voxels) => {
                Voxels::F32(for_type!(Voxels, voxels, v => self.every(&v, |voxel| length(voxel) as f32)))
            }
        }
    }

    fn every<T: Voxel, U>(self, numbers: &[T], of: impl Fn(Numbers<T>) -> U) -> Vec<U> {
        let mut all = Vec::with_capacity(numbers.len() / self.count);
        for runs in numbers.chunks_exact(self.run * self.count) {
            all.extend((0..self.run).map(|i| {
                of(Numbers {
                    from_first: &runs[i..],
                    step: self.run,
                })
            }));
        }
        all
    }
}

/// A voxel's numbers.
struct Numbers<'a, T> {
    from_first: &'a [T],
    step: usize,
}

impl<'a, T: Voxel> Numbers<'a, T> {
    fn at(&self, n: usize) -> T {
        self.from_first[n * self.step]
    }

    fn iter(&self) -> StepBy<Iter<'a, T>> {
        self.from_first.iter().step_by(self.step)
    }
}

fn luminance<T: Voxel>(colour: Numbers<T>) -> T {
    let parts = colour.iter().zip(REC_709);
    T::nearest(parts.map(|(v, share)| v.to_f64() * share).sum())
}

fn length<T: Voxel>(vector: Numbers<T>) -> f64 {
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
    fn runs_and_neighbours_give_the_same() {
        let neighbours = Voxels::U8(vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
        let runs = Voxels::U8(vec![1, 4, 2, 5, 3, 6, 7, 10, 8, 11, 9, 12]);
        for rule in [Rule::Component(0), Rule::Component(2), Rule::Luminance, Rule::Length] {
            let read = components(3, None).as_rule(rule);
            assert_eq!(
                read.in_runs(2).one(runs.clone()),
                read.one(neighbours.clone()),
                "{rule:?}"
            );
        }
    }

    #[test]
    fn a_component_that_is_not_there_is_refused() {
        assert!(Components::new(Path::new("a"), 3, Some(3)).is_err());
    }
}
