//! An image of several pieces, put together slice by slice.

use std::path::{Path, PathBuf};

use super::{Choice, Extent, Of};
use crate::volume::grid::Voxels;
use crate::volume::io::error::ReadError;
use crate::volume::io::open::Chunks;
use crate::volume::io::scalars::Scalars;

/// How many pieces may lie in one slice: each is a file that is open.
const MAX_OPEN: usize = 256;

/// Opens a piece's numbers.
pub(super) type Open = Box<dyn Fn() -> Result<Scalars, ReadError> + Send>;

/// A piece of the image.
pub(super) struct Part {
    pub extent: Extent,
    pub open: Open,
}

/// The image's slices. Where pieces overlap the last one counts, as in VTK.
pub(super) fn in_slices(path: &Path, parts: Vec<Part>, whole: &Extent, choice: &Choice) -> Result<Chunks, ReadError> {
    let [nx, ny, nz] = whole.dims(choice.of);
    let parts: Vec<_> = parts
        .into_iter()
        .map(|part| Placed::new(part, whole, choice.of))
        .collect();
    let count = |dims: [usize; 3]| dims.iter().fold(1_usize, |n, &d| n.saturating_mul(d));
    let mut assembly = Assembly {
        path: path.to_owned(),
        choice: *choice,
        dims: [nx, ny],
        parts,
    };
    // Of the pieces there is as much data as they declare, so the image is held against them before there is room for it.
    if assembly
        .parts
        .iter()
        .map(|p| count(p.dims))
        .fold(0, usize::saturating_add)
        < count([nx, ny, nz])
    {
        return Err(assembly.incomplete());
    }
    Ok(Box::new((0..nz).map(move |z| assembly.slice(z))))
}

/// A piece, and where its voxels are among the image's.
struct Placed {
    start: [usize; 3],
    dims: [usize; 3],
    open: Open,
    /// Its numbers, from its first slice to its last.
    scalars: Option<Scalars>,
}

impl Placed {
    fn new(part: Part, whole: &Extent, of: Of) -> Self {
        Self {
            start: std::array::from_fn(|a| part.extent.first[a].abs_diff(whole.first[a]) as usize),
            dims: part.extent.dims(of),
            open: part.open,
            scalars: None,
        }
    }

    fn has(&self, z: usize) -> bool {
        (self.start[2]..self.start[2] + self.dims[2]).contains(&z)
    }

    /// Its numbers in its next slice, which is the image's `z`-th.
    fn next(&mut self, z: usize, choice: &Choice) -> Result<Voxels, ReadError> {
        let count = self.dims[0] * self.dims[1] * choice.components.count();
        let scalars = match &mut self.scalars {
            Some(scalars) => scalars,
            none => none.insert((self.open)()?),
        };
        let numbers = scalars.next(count)?;
        if !self.has(z + 1) {
            self.scalars = None;
        }
        Ok(choice.components.one(numbers))
    }
}

struct Assembly {
    path: PathBuf,
    parts: Vec<Placed>,
    choice: Choice,
    /// Voxels along x and y.
    dims: [usize; 2],
}

impl Assembly {
    fn incomplete(&self) -> ReadError {
        ReadError::header(&self.path, "its pieces do not fill its WholeExtent").hint("export it again, in one piece")
    }

    fn slice(&mut self, z: usize) -> Result<Voxels, ReadError> {
        let [nx, ny] = self.dims;
        let components = self.choice.components;
        let voxel = components.voxel(self.choice.stored.voxel());
        let mut slice = Voxels::zeros(voxel, nx * ny);
        let mut is_there = vec![false; nx * ny];
        if self.parts.iter().filter(|p| p.has(z)).count() > MAX_OPEN {
            let what = format!("more than {MAX_OPEN} of its pieces lie in one slice");
            return Err(ReadError::unsupported(&self.path, what).hint("export it again, in one piece"));
        }
        for part in self.parts.iter_mut().filter(|p| p.has(z)) {
            let [width, height, _] = part.dims;
            let voxels = part.next(z, &self.choice)?;
            for y in 0..height {
                let to = (part.start[1] + y) * nx + part.start[0];
                slice.overwrite(to, &voxels, y * width..(y + 1) * width);
                is_there[to..to + width].fill(true);
            }
        }
        match is_there.contains(&false) {
            true => Err(self.incomplete()),
            false => Ok(slice),
        }
    }
}
