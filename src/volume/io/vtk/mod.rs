//! VTK's image data: XML (.vti, .pvti) and legacy files (.vtk).
//!
//! Formats: VTK's "File Formats" (legacy 1 to 5.1, XML 0.1 to 2.x); where it says nothing, what VTK 9 writes.
//!
//! *Practice.* Coordinates are taken as LPS millimetres, as ITK does, and no axis is turned. The origin is where index (0, 0, 0) is,
//! wherever the extent begins. Values of cells lie at the cells' centres.

mod base64;
mod bits;
mod blocks;
mod legacy;
mod legacy_header;
mod parallel;
mod pieces;
mod xml;
mod xml_header;

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::components::Components;
use super::error::ReadError;
use super::open::{Declared, ReadOptions};
use super::stored::Stored;

pub(super) use self::legacy::FORMAT as LEGACY;
pub(super) use self::xml::FORMAT as XML;

/// What an array's values belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    Points,
    Cells,
}

/// An array, as headers declare it.
#[derive(Clone, Debug)]
struct Array {
    of: Of,
    name: String,
    /// The type's name in the file, and the type where it is a number's.
    kind: (String, Option<Stored>),
    /// Numbers a voxel.
    components: usize,
    /// Whether the file names it as the one that is meant.
    is_active: bool,
}

/// Points of an image, from first to last along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Extent {
    first: [i64; 3],
    last: [i64; 3],
}

impl Extent {
    /// Of six numbers, first and last of each axis in turn; `None` where an axis ends before it begins.
    fn new(numbers: [i64; 6]) -> Option<Self> {
        let extent = Self {
            first: [0, 2, 4].map(|i| numbers[i]),
            last: [1, 3, 5].map(|i| numbers[i]),
        };
        let is_axis = |a: usize| extent.last[a].checked_sub(extent.first[a]).is_some_and(|n| n >= 0);
        (0..3).all(is_axis).then_some(extent)
    }

    /// How many points, or cells between them, lie along an axis. An axis of one point has one cell.
    fn dims(&self, of: Of) -> [usize; 3] {
        std::array::from_fn(|a| {
            let cells = self.last[a].abs_diff(self.first[a]) as usize;
            match of {
                Of::Points => cells.saturating_add(1),
                Of::Cells => cells.max(1),
            }
        })
    }

    fn contains(&self, part: &Self) -> bool {
        (0..3).all(|a| self.first[a] <= part.first[a] && part.last[a] <= self.last[a])
    }
}

/// Where an image's points lie.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    extent: Extent,
    /// Of index (0, 0, 0).
    origin: DVec3,
    spacing: DVec3,
    direction: DMat3,
}

impl Lattice {
    /// The place of the voxels, of which the first is at the extent's first point, or amid its first cell.
    fn world_from_index(&self, of: Of) -> DAffine3 {
        let [x, y, z] = self.spacing.to_array();
        let d = &self.direction;
        let axes = DMat3::from_cols(d.x_axis * x, d.y_axis * y, d.z_axis * z);
        let [i, j, k] = std::array::from_fn(|a| {
            let within = of == Of::Cells && self.extent.first[a] < self.extent.last[a];
            self.extent.first[a] as f64 + if within { 0.5 } else { 0.0 }
        });
        // In vtkImageData's order, so that the bits are the same.
        let first = d.x_axis * (i * x) + d.y_axis * (j * y) + d.z_axis * (k * z) + self.origin;
        DAffine3::from_mat3_translation(axes, first)
    }
}

/// What is read of a file: one array, or part of it.
#[derive(Clone, Copy, Debug)]
struct Choice {
    /// Its index.
    index: usize,
    of: Of,
    stored: Stored,
    /// Whether they are bits, eight in a byte.
    are_bits: bool,
    components: Components,
}

impl Choice {
    /// Bytes of so many numbers in the file.
    fn bytes(&self, count: u64) -> u64 {
        match self.are_bits {
            true => bits::bytes(count),
            false => count.saturating_mul(self.stored.bytes() as u64),
        }
    }
}

/// The array that `options` name. Else the active one; else the first of one number a voxel; else the first. Those of points come
/// before those of cells.
fn choose(path: &Path, arrays: &[Array], options: &ReadOptions) -> Result<Choice, ReadError> {
    let by_place = |of: Of| (arrays.iter().enumerate()).filter(move |(_, array)| array.of == of);
    let all: Vec<_> = by_place(Of::Points).chain(by_place(Of::Cells)).collect();
    let found = match &options.array {
        Some(name) => all.iter().find(|(_, array)| array.name == *name),
        None => default(&all),
    };
    let Some(&(index, array)) = found else {
        return Err(missing(path, &all, options));
    };
    let Some(stored) = array.kind.1 else {
        let what = format!(
            "the array `{}` holds `{}`, which are no numbers",
            array.name, array.kind.0
        );
        return Err(ReadError::unsupported(path, what).hint(names(&all)));
    };
    Ok(Choice {
        index,
        of: array.of,
        stored,
        are_bits: array.kind.0 == bits::BIT,
        components: Components::new(path, array.components, options.component)?,
    })
}

fn default<'a>(all: &'a [(usize, &'a Array)]) -> Option<&'a (usize, &'a Array)> {
    for of in [Of::Points, Of::Cells] {
        let numbers = || (all.iter()).filter(move |(_, array)| array.of == of && array.kind.1.is_some());
        let found = (numbers().find(|(_, array)| array.is_active))
            .or_else(|| numbers().find(|(_, array)| array.components == 1))
            .or_else(|| numbers().next());
        if found.is_some() {
            return found;
        }
    }
    None
}

fn missing(path: &Path, all: &[(usize, &Array)], options: &ReadOptions) -> ReadError {
    let what = match &options.array {
        Some(name) => format!("it has no array `{name}`"),
        None => "it has no array of numbers".to_owned(),
    };
    ReadError::unsupported(path, what).hint(names(all))
}

fn names(all: &[(usize, &Array)]) -> String {
    match all {
        [] => "it holds none".to_owned(),
        all => {
            let names: Vec<_> = all.iter().map(|(_, array)| format!("`{}`", array.name)).collect();
            format!("it holds {}: name one with --array", names.join(", "))
        }
    }
}

/// What is declared of the array `choice` of `arrays` on `lattice`.
fn declared(format: &'static str, arrays: &[Array], choice: &Choice, lattice: &Lattice) -> Declared {
    let array = &arrays[choice.index];
    let mut notes = Vec::new();
    if choice.of == Of::Cells {
        notes.push(format!(
            "`{}` has values of cells: each is a voxel at its cell's centre",
            array.name
        ));
    }
    let others: Vec<_> = (arrays.iter().enumerate())
        .filter(|(i, array)| *i != choice.index && array.kind.1.is_some())
        .map(|(_, array)| format!("`{}`", array.name))
        .collect();
    if !others.is_empty() {
        notes.push(format!("array `{}`; others: {}", array.name, others.join(", ")));
    }
    Declared {
        format,
        name: String::new(),
        dims: lattice.extent.dims(choice.of),
        voxel: choice.components.voxel(choice.stored.voxel()),
        world_from_index: lattice.world_from_index(choice.of),
        frames: 1,
        components: choice.components.count(),
        notes,
    }
}
