//! The chunks of a Zarr array, as parts of a volume.
//!
//! *Practice.* Which chunks there are is told by the folder, so that absent ones cost nothing, however many they are: what lies between
//! two that are there is a few boxes of one value. Chunks are read and decoded some at a time, on all threads.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use half::f16;
use rayon::prelude::*;

use super::array::{Array, Element};
use super::codec::damaged;
use super::listing::present;
use super::shard;
use crate::volume::grid::{Region, Voxels};
use crate::volume::io::budget::Budget;
use crate::volume::io::error::{Problem, ReadError};
use crate::volume::io::part::Part;
use crate::volume::io::stored::decode;
use crate::volume::voxel::map_type;

/// The most bytes of chunks that are decoded at a time, unless one has more.
const BATCH: u64 = 64 << 20;

/// How often a chunk is held at most: as its file has it, decoded, and in the volume's order, where a half float takes twice its room.
pub(super) const COPIES: u64 = 4;

/// The volume that is read of an array.
#[derive(Clone, Debug)]
pub(super) struct Selection {
    /// The array's axes along the volume's, the fastest first, three at most.
    pub spatial: Vec<usize>,
    /// The index along each other axis of the array; along the spatial ones 0.
    pub index: Vec<usize>,
}

impl Selection {
    /// Of some number an axis, those of the volume's axes; 1 for missing ones.
    pub fn of(&self, numbers: &[usize]) -> [usize; 3] {
        std::array::from_fn(|a| self.spatial.get(a).map_or(1, |axis| numbers[*axis]))
    }

    /// The index along each axis of the array of what is at a place of the volume; `along(axis)` of another axis.
    pub fn indices(&self, place: [usize; 3], along: impl Fn(usize) -> usize) -> Vec<usize> {
        let mut indices: Vec<usize> = (0..self.index.len()).map(along).collect();
        for (axis, at) in self.spatial.iter().zip(place) {
            indices[*axis] = at;
        }
        indices
    }
}

/// Some of the volume, before it is read.
pub(super) enum Chunk {
    /// A region of absent chunks.
    Absent(Region),
    /// A chunk that is there.
    There {
        /// Its voxels.
        region: Region,
        /// Its file.
        file: Arc<PathBuf>,
        /// Its bytes in the file; without them all.
        bytes: Option<Range<u64>>,
    },
}

/// All parts of a volume.
pub(super) struct Chunks {
    array: Arc<Array>,
    selection: Selection,
    /// Chunks along the volume's axes.
    grid: [usize; 3],
    /// How many chunks are decoded at a time.
    batch: usize,
    /// How many of the grid's chunks are done.
    done: usize,
    /// Where the others that are there are in the grid, the last one first; `None` before the folder is looked at.
    there: Option<Vec<usize>>,
    waiting: VecDeque<Chunk>,
    ready: VecDeque<Result<Part, ReadError>>,
}

/// The place in a grid of its `n`-th member.
pub(super) fn place(n: usize, [nx, ny, _]: [usize; 3]) -> [usize; 3] {
    [n % nx, n / nx % ny, n / (nx * ny)]
}

impl Chunks {
    /// The parts of what is selected of `array`. Those that are held at a time take at most half of `budget`, unless one takes more.
    pub fn new(array: Array, selection: Selection, budget: Budget) -> Self {
        let most = BATCH.min(budget.bytes() / (2 * COPIES)) as usize;
        let (dims, chunk) = (selection.of(&array.shape), selection.of(&array.chunk));
        Self {
            grid: std::array::from_fn(|a| dims[a].div_ceil(chunk[a])),
            batch: (most / array.unit_bytes().max(1)).clamp(1, 4 * rayon::current_num_threads()),
            array: Arc::new(array),
            selection,
            done: 0,
            there: None,
            waiting: VecDeque::new(),
            ready: VecDeque::new(),
        }
    }

    fn chunk_count(&self) -> usize {
        self.grid.iter().product()
    }

    /// The voxels of a box of the grid.
    fn voxels(&self, chunks: &Region) -> Region {
        let (dims, chunk) = (
            self.selection.of(&self.array.shape),
            self.selection.of(&self.array.chunk),
        );
        let first: [usize; 3] = std::array::from_fn(|a| chunks.first[a] * chunk[a]);
        let size = std::array::from_fn(|a| chunks.size[a].saturating_mul(chunk[a]).min(dims[a] - first[a]));
        Region { first, size }
    }

    /// Has the next chunk that is there wait, and the absent ones before it.
    fn look(&mut self) -> Result<(), ReadError> {
        let mut there = match self.there.take() {
            Some(there) => there,
            None => present(&self.array, &self.selection, self.grid).map_err(|e| ReadError::io(&self.array.path, e))?,
        };
        let next = there.pop();
        self.there = Some(there);
        let end = next.unwrap_or(self.chunk_count());
        for (chunks, _) in Region::of_range(self.grid, self.done..end) {
            self.waiting.push_back(Chunk::Absent(self.voxels(&chunks)));
        }
        self.done = end;
        if let Some(next) = next {
            self.done += 1;
            let first = place(next, self.grid);
            let region = self.voxels(&Region { first, size: [1; 3] });
            let along = |axis: usize| self.selection.index[axis] / self.array.chunk[axis];
            let file = Arc::new(self.array.file(&self.selection.indices(first, along)));
            match self.array.is_sharded() {
                true => self
                    .waiting
                    .extend(shard::chunks(&self.array, &self.selection, &region, &file)?),
                false => self.waiting.push_back(Chunk::There {
                    region,
                    file,
                    bytes: None,
                }),
            }
        }
        Ok(())
    }

    /// Reads the next chunks, at most as many as are decoded at a time.
    fn read(&mut self) -> Result<(), ReadError> {
        while self.waiting.len() < self.batch && self.done < self.chunk_count() {
            self.look()?;
        }
        let batch: Vec<_> = self.waiting.drain(..self.batch.min(self.waiting.len())).collect();
        let parts = batch
            .into_par_iter()
            .map(|chunk| part(&self.array, &self.selection, chunk));
        self.ready = parts.collect::<Vec<_>>().into();
        Ok(())
    }
}

impl Iterator for Chunks {
    type Item = Result<Part, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ready.is_empty()
            && let Err(error) = self.read()
        {
            // Nothing comes after an error.
            self.done = self.chunk_count();
            self.waiting.clear();
            return Some(Err(error));
        }
        self.ready.pop_front()
    }
}

/// What a chunk is.
fn part(array: &Array, selection: &Selection, chunk: Chunk) -> Result<Part, ReadError> {
    let (region, file, bytes) = match chunk {
        Chunk::Absent(region) => return Ok(Part::Same(region, array.fill)),
        Chunk::There { region, file, bytes } => (region, file, bytes),
    };
    let elements = elements(array, &file, bytes)?;
    let strides = array.chain().strides(array.unit());
    let index = (0..strides.len()).filter(|axis| !selection.spatial.contains(axis));
    let start = index
        .map(|axis| selection.index[axis] % array.unit()[axis] * strides[axis])
        .sum();
    let strides = selection.of(&strides);
    Ok(Part::Box(
        region,
        map_type!(Voxels, elements, Voxels, all => gathered(&all, start, strides, region.size)),
    ))
}

/// The elements of a chunk, as they are stored.
fn elements(array: &Array, file: &Path, bytes: Option<Range<u64>>) -> Result<Voxels, ReadError> {
    let refused = |e: io::Error| match e.kind() {
        io::ErrorKind::InvalidData
        | io::ErrorKind::UnexpectedEof
        | io::ErrorKind::InvalidInput
        | io::ErrorKind::Other => {
            ReadError::new(file, Problem::Compressed(e)).hint("the chunk is damaged: copy or store the array again")
        }
        _ => ReadError::io(file, e),
    };
    let chain = array.chain();
    let stored = read(file, bytes, 2 * array.unit_bytes() + (1 << 16)).map_err(refused)?;
    let decoded = chain.decode(stored, array.unit_bytes()).map_err(refused)?;
    let (count, mut rest) = (array.unit().iter().product(), &*decoded);
    let elements = decode(file, array.element.stored(), chain.order, count, |bytes| {
        rest.read_exact(bytes).map_err(refused)
    })?;
    Ok(match (array.element, elements) {
        (Element::Half, Voxels::U16(bits)) => {
            Voxels::F32(bits.into_iter().map(|bits| f16::from_bits(bits).to_f32()).collect())
        }
        (_, elements) => elements,
    })
}

/// Some bytes of a file, at most `most`.
pub(super) fn read(file: &Path, bytes: Option<Range<u64>>, most: usize) -> io::Result<Vec<u8>> {
    let mut stream = File::open(file)?;
    let length = stream.metadata()?.len();
    let bytes = bytes.unwrap_or(0..length);
    let count = bytes.end.saturating_sub(bytes.start);
    if bytes.end > length {
        return Err(damaged(format!("it should have {} bytes, and has {length}", bytes.end)));
    }
    if count > most as u64 {
        return Err(damaged(format!(
            "it has {count} bytes, more than any codec makes of it"
        )));
    }
    stream.seek(SeekFrom::Start(bytes.start))?;
    let mut read = Vec::new();
    stream.take(count).read_to_end(&mut read)?;
    Ok(read)
}

/// The box of `size` of a chunk's elements from `start` on that lie `strides` apart.
fn gathered<T: Copy>(all: &[T], start: usize, strides: [usize; 3], size: [usize; 3]) -> Vec<T> {
    let mut voxels = Vec::with_capacity(size.iter().product());
    for k in 0..size[2] {
        for j in 0..size[1] {
            let row = &all[start + k * strides[2] + j * strides[1]..];
            match strides[0] {
                1 => voxels.extend_from_slice(&row[..size[0]]),
                stride => voxels.extend((0..size[0]).map(|i| row[i * stride])),
            }
        }
    }
    voxels
}
