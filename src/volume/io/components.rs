//! Voxels of several numbers: which of them is read, or what they are together.

use std::iter::StepBy;
use std::path::Path;
use std::slice::Iter;

use super::error::ReadError;
use super::open::ReadOptions;
use crate::volume::grid::Voxels;
use crate::volume::voxel::{Voxel, VoxelType, for_type, map_type};

/// What is made of a voxel's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    /// The one of this number, from 0 on.
    One(usize),
    /// Of red, green and blue the luminance by ITU-R BT.709, rounded to the stored type; what follows them, as opacity, is left out.
    Luminance,
    /// The root of the sum of their squares, in `f64` if they are, else in `f32`.
    Magnitude,
}

/// How the numbers of voxels lie: runs of `run` voxels' first numbers, then as many of the second, and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Components {
    /// Numbers a voxel.
    pub count: usize,
    /// Voxels in a run: 1 where the numbers of a voxel follow each other.
    pub run: usize,
    /// What is made of them.
    pub reading: Reading,
}

/// Weights of red, green and blue, ITU-R BT.709.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

impl Components {
    /// One number a voxel.
    pub(super) const SCALAR: Self = Self {
        count: 1,
        run: 1,
        reading: Reading::One(0),
    };

    /// `count` numbers a voxel, one after the other, read as `usual` unless the options name one.
    pub(super) fn new(count: usize, usual: Reading, options: &ReadOptions) -> Self {
        let reading = match (options.component, count) {
            (Some(component), _) => Reading::One(component),
            (None, 1) => Reading::One(0),
            (None, _) => usual,
        };
        Self { count, run: 1, reading }
    }

    /// The same in runs of `run` voxels.
    pub(super) fn in_runs(self, run: usize) -> Self {
        Self { run, ..self }
    }

    /// Fails where the number that is asked for is none of theirs.
    pub(super) fn check(&self, path: &Path) -> Result<(), ReadError> {
        match self.reading {
            Reading::One(component) if component >= self.count => {
                let what = format!(
                    "there is no component {component}: a voxel has {}, from 0 on",
                    self.count
                );
                Err(ReadError::unsupported(path, what).hint("say another --component"))
            }
            _ => Ok(()),
        }
    }

    /// The type of what is made of numbers of the type `scalar`.
    pub(super) fn voxel(&self, scalar: VoxelType) -> VoxelType {
        match (self.reading, scalar) {
            (Reading::Magnitude, VoxelType::F64) => VoxelType::F64,
            (Reading::Magnitude, _) => VoxelType::F32,
            _ => scalar,
        }
    }

    /// What a user should know of it.
    pub(super) fn note(&self) -> Option<String> {
        let what = match self.reading {
            _ if self.count == 1 => return None,
            Reading::One(component) => format!("component {component} is read"),
            Reading::Luminance => "read as their luminance (Rec. 709), rounded".to_owned(),
            Reading::Magnitude => "read as their magnitude".to_owned(),
        };
        let others = "--component reads one of them";
        Some(format!("{} components a voxel: {what}; {others}", self.count))
    }

    /// One number a voxel, of whole runs of all.
    pub(super) fn combine(&self, scalars: Voxels) -> Voxels {
        if self.count == 1 {
            return scalars;
        }
        match (self.reading, scalars) {
            (Reading::Magnitude, Voxels::F64(v)) => Voxels::F64(self.each(&v, magnitude)),
            (Reading::Magnitude, scalars) => {
                Voxels::F32(for_type!(Voxels, scalars, v => self.each(&v, |v| magnitude(v) as f32)))
            }
            (Reading::Luminance, scalars) => map_type!(Voxels, scalars, Voxels, v => self.each(&v, luminance)),
            (Reading::One(n), scalars) => map_type!(Voxels, scalars, Voxels, v => self.each(&v, |v| v[n])),
        }
    }

    /// What `made` makes of each voxel's numbers.
    fn each<T: Voxel, U>(&self, scalars: &[T], made: impl Fn(Numbers<T>) -> U) -> Vec<U> {
        let mut all = Vec::with_capacity(scalars.len() / self.count);
        for runs in scalars.chunks_exact(self.run * self.count) {
            all.extend((0..self.run).map(|i| {
                made(Numbers {
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

impl<'a, T> Numbers<'a, T> {
    fn iter(&self) -> StepBy<Iter<'a, T>> {
        self.from_first.iter().step_by(self.step)
    }
}

impl<T> std::ops::Index<usize> for Numbers<'_, T> {
    type Output = T;

    fn index(&self, n: usize) -> &T {
        &self.from_first[n * self.step]
    }
}

fn magnitude<T: Voxel>(numbers: Numbers<T>) -> f64 {
    numbers.iter().map(|v| v.to_f64() * v.to_f64()).sum::<f64>().sqrt()
}

fn luminance<T: Voxel>(numbers: Numbers<T>) -> T {
    T::nearest(
        numbers
            .iter()
            .zip(LUMINANCE)
            .map(|(v, weight)| weight * v.to_f64())
            .sum(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three(reading: Reading) -> Components {
        Components {
            count: 3,
            run: 1,
            reading,
        }
    }

    #[test]
    fn runs_and_neighbours_give_the_same() {
        let neighbours = Voxels::U8(vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
        let runs = Voxels::U8(vec![1, 4, 2, 5, 3, 6, 7, 10, 8, 11, 9, 12]);
        for reading in [Reading::One(0), Reading::One(2), Reading::Luminance, Reading::Magnitude] {
            let expected = three(reading).combine(neighbours.clone());
            assert_eq!(three(reading).in_runs(2).combine(runs.clone()), expected, "{reading:?}");
        }
    }

    #[test]
    fn colours_become_grey_and_vectors_long() {
        let luminance = |colour: [u8; 3]| three(Reading::Luminance).combine(Voxels::U8(colour.to_vec()));
        assert_eq!(luminance([255, 0, 0]), Voxels::U8(vec![54]));
        assert_eq!(luminance([255; 3]), Voxels::U8(vec![255]));
        let long = three(Reading::Magnitude).combine(Voxels::I16(vec![-2, 3, 6]));
        assert_eq!(long, Voxels::F32(vec![7.0]));
        let exact = three(Reading::Magnitude).combine(Voxels::F64(vec![0.0, -0.1, 0.0]));
        assert_eq!(exact, Voxels::F64(vec![0.1]));
    }
}
