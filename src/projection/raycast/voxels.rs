//! Blocks as rays sample them.
//!
//! *Practice.* Numbers are stored in 15 bits, so that differences are in 16: values are fractions of the target's value range times coverage,
//! so nothing is scaled in a frame. Soft normals are made once, for all frames with one
//! [`Shading::soft_gradient`](super::super::Shading::soft_gradient), in 32 bits; they lie apart from values, of which many more are read.

use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::Pod;
use rayon::prelude::*;

use super::normals::voxel_normals;
use super::shown::ShownBlock;
use super::simd::{EDGE, each};
use crate::array::Array;
use crate::projection::{FrameSpec, SoftNormals, TransferFunction, TransferTable, VisibleValues};
use crate::target::{Block, BlockVoxels, CellRanges, Layout, Target};

/// How many numbers are stored for each entry of a table of transfer, a power of two.
pub(super) const PER_ENTRY: i16 = 8;

/// What is stored for 1.
pub(super) const ONE: f32 = (PER_ENTRY as usize * (TransferTable::LEN - 1)) as f32;

/// A target ready to be cast.
pub struct CastTarget {
    pub(super) blocks: Vec<CastBlock>,
    /// The cells of each block.
    pub(super) cells: Vec<CellRanges>,
    /// What shows of it, of the frame before.
    shown: Mutex<Option<Arc<Shown>>>,
}

/// What shows of a target.
pub(super) struct Shown {
    of: Look,
    /// The transfer function for a step of depth.
    pub table: TransferTable,
    /// Of each block; `None` of one of which nothing does.
    pub blocks: Vec<Option<ShownBlock>>,
}

/// What that depends on.
#[derive(PartialEq)]
struct Look {
    transfer: TransferFunction,
    /// Whether the transfer function is asked.
    classifies: bool,
    step_mm: f64,
    /// See [`ShownBlock::all`].
    edge: usize,
}

/// The voxels of a block and of one more on each side, x fastest.
pub(super) struct CastBlock {
    /// The lattice's voxel that is stored first.
    pub first: [i32; 3],
    /// How far apart rows and planes of stored voxels are; 0 in a block of one value.
    pub strides: [usize; 2],
    /// How many there are along each axis; a few in a block of one value.
    pub dims: [i32; 3],
    /// Fraction of the value range, or opacity, times coverage, in parts of [`ONE`].
    pub weighted: Array<i16>,
    /// Likewise coverage; empty where it is 1 throughout.
    pub coverage: Array<i16>,
    /// Likewise red, green and blue times opacity and coverage in a target of colours, else empty.
    pub rgb: [Array<i16>; 3],
    /// Soft normals in the world, [packed](super::simd::packed); empty if the target is not lit.
    pub normals: Array<u32>,
}

/// The voxels of a [`CastBlock`], as they are read.
pub(super) struct Voxels<'a> {
    pub first: [i32; 3],
    pub dims: [i32; 3],
    pub strides: [usize; 2],
    /// See [`CastBlock::has_few`].
    pub has_few: bool,
    pub weighted: &'a [i16],
    pub coverage: &'a [i16],
    pub rgb: [&'a [i16]; 3],
    pub normals: &'a [u32],
}

impl Voxels<'_> {
    /// Where the voxel is stored that is so many from the first one along each axis, if it is.
    #[inline(always)]
    pub fn index(&self, [x, y, z]: [i32; 3]) -> isize {
        let [row, plane] = each!(stride of [self.strides[0], self.strides[1]] => stride as isize);
        x as isize + y as isize * row + z as isize * plane
    }

    /// Whether the [`EDGE`]³ voxels are stored from that one on.
    #[inline(always)]
    pub fn holds_few(&self, [x, y, z]: [i32; 3]) -> bool {
        let [x, y, z] = each!(at of [(x, 0), (y, 1), (z, 2)] => at.0 >= 0 && at.0 <= self.dims[at.1] - EDGE as i32);
        x & y & z
    }
}

impl CastTarget {
    /// Reconstructs the blocks of `target`, with normals if `normals` says how.
    pub fn new(target: &Target, normals: Option<&SoftNormals>) -> Self {
        let blocks = target.blocks.par_iter().map(|block| prepare(target, block, normals));
        let (blocks, cells) = blocks.unzip();
        Self {
            blocks,
            cells,
            shown: Mutex::default(),
        }
    }

    /// The target of `spec`, as its frame needs it.
    pub fn of(spec: &FrameSpec) -> Self {
        let normals = spec
            .shading()
            .map(|s| SoftNormals::new(&spec.target.lattice, s.soft_gradient));
        Self::new(spec.target, normals.as_ref())
    }

    /// What of it shows in the frame of `spec`, in cells with an `edge` of so many voxels; found anew only if that is not what was asked for
    /// before.
    pub(super) fn shown(&self, spec: &FrameSpec, edge: usize) -> Arc<Shown> {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let of = Look {
            transfer: spec.transfer.clone(),
            classifies: spec.settings.mode.classifies(),
            step_mm: spec.planes().step_mm,
            edge,
        };
        if let Some(before) = shown.as_ref().filter(|shown| shown.of == of) {
            return before.clone();
        }
        let table = spec.table();
        let values = VisibleValues::in_frame(spec, &table);
        let blocks = ShownBlock::all(spec.target, self, &values, edge);
        shown.insert(Arc::new(Shown { of, table, blocks })).clone()
    }
}

/// A fraction of 1 as it is stored. Rust's float casts saturate.
#[inline(always)]
fn stored(fraction: f32) -> i16 {
    (fraction.min(1.0) * ONE + 0.5) as u16 as i16
}

/// The scales of value times coverage and of coverage that sum up to the fraction of the value range times coverage.
fn fraction_scales(target: &Target) -> [f32; 2] {
    let range = target.value_range;
    if range.width() > 0.0 {
        [1.0 / range.width(), -range.lo / range.width()]
    } else {
        [0.0, 0.0]
    }
}

fn prepare(target: &Target, block: &Block, normals: Option<&SoftNormals>) -> (CastBlock, CellRanges) {
    let scales = fraction_scales(target);
    if block.layout == Layout::Uniform {
        let value = scales[0] * block.range.value.lo + scales[1];
        return (
            CastBlock::uniform(block, value, normals.is_some()),
            CellRanges::uniform(&target.lattice, block),
        );
    }
    let apron = if normals.is_some() { Block::REACH } else { Block::APRON };
    let voxels = BlockVoxels::reconstruct(target, block, apron);
    let cells = CellRanges::new(&target.lattice, block, &voxels);
    (CastBlock::new(target, block, &voxels, normals), cells)
}

impl CastBlock {
    /// Whether there are [`EDGE`]³ voxels at least.
    pub fn has_few(&self) -> bool {
        self.dims.iter().all(|n| *n >= EDGE as i32)
    }

    /// Whether what shows of it can be told from its voxels alone.
    pub fn is_looked_into(&self) -> bool {
        self.strides != [0; 2] && self.coverage.is_empty()
    }

    /// As it is read.
    pub fn voxels(&self) -> Voxels<'_> {
        Voxels {
            first: self.first,
            dims: self.dims,
            strides: self.strides,
            has_few: self.has_few(),
            weighted: &self.weighted,
            coverage: &self.coverage,
            rgb: self.rgb.each_ref().map(|part| part as &[i16]),
            normals: &self.normals,
        }
    }

    /// The voxels that any place in a block of one value is among, a row that stands for all.
    fn uniform(block: &Block, value: f32, lit: bool) -> Self {
        Self {
            first: block.origin.map(|n| n as i32 - Block::APRON as i32),
            strides: [0; 2],
            dims: [EDGE as i32; 3],
            weighted: vec![stored(value); EDGE].into(),
            coverage: Array::default(),
            rgb: Default::default(),
            normals: Array::zeroed(if lit { EDGE } else { 0 }),
        }
    }

    fn new(target: &Target, block: &Block, voxels: &BlockVoxels, normals: Option<&SoftNormals>) -> Self {
        let [scale, offset] = fraction_scales(target);
        let block_of = Stored { block, voxels };
        let dims = block.stored_dims();
        let weighted = match &voxels.coverage {
            None => block_of.map(|n| stored(scale * voxels.premultiplied[n] + offset)),
            Some(c) => block_of.map(|n| stored(scale * voxels.premultiplied[n] + offset * c[n])),
        };
        Self {
            first: block.origin.map(|n| n as i32 - Block::APRON as i32),
            strides: [dims[0], dims[0] * dims[1]],
            dims: dims.map(|n| n as i32),
            weighted,
            coverage: voxels
                .coverage
                .as_ref()
                .map_or_else(Array::default, |c| block_of.map(|n| stored(c[n]))),
            rgb: voxels.rgb().map_or_else(Default::default, |rgb| {
                [0, 1, 2].map(|part| block_of.map(|n| stored(rgb[n][part])))
            }),
            normals: normals.map_or_else(Array::default, |soft| {
                voxel_normals(soft, target, block, voxels, [scale, offset])
            }),
        }
    }
}

/// The voxels of a block that are stored: those of its apron are, what only normals need is not.
struct Stored<'a> {
    block: &'a Block,
    voxels: &'a BlockVoxels,
}

impl Stored<'_> {
    /// What `f` makes of each of them, given its place among the reconstructed ones.
    fn map<T: Pod + Send>(&self, f: impl Fn(usize) -> T + Sync) -> Array<T> {
        let skip = self.voxels.apron - Block::APRON;
        let [nx, ny, nz] = self.block.stored_dims();
        let dims = self.voxels.dims;
        let mut all = Array::zeroed(nx * ny * nz);
        all.par_chunks_mut(nx).enumerate().for_each(|(row, voxels)| {
            let begin = skip + dims[0] * (row % ny + skip + dims[1] * (row / ny + skip));
            voxels.iter_mut().zip(begin..).for_each(|(voxel, n)| *voxel = f(n));
        });
        all
    }
}
