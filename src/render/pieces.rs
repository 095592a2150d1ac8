//! Blocks in pieces small enough to be reconstructed and handed to the device without a copy of the whole.

use std::ops::Range;

use rayon::prelude::*;

use super::texels::{self, NormalRows, Rows};
use crate::projection::SoftNormals;
use crate::target::{Block, BlockVoxels, CELL, CellRanges, Lattice, Layout, Target};

/// Voxels of a piece, about: large blocks are cut into slabs of this size.
const PIECE_VOXELS: usize = 1 << 20;

/// A slab of a block, as a block of its own, and where its planes lie among the block's stored planes.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Index of the block.
    pub index: usize,
    /// The slab.
    pub slab: Block,
    /// First stored plane of the block that this piece fills.
    pub first_plane: usize,
    /// The planes it fills, counted from its own first apron plane.
    pub planes: Range<usize>,
}

/// What a piece becomes.
pub struct PieceTexels {
    /// Value or colour texels; values with normals beside them if the block is covered and the target lit.
    pub values: Vec<u16>,
    /// Normal texels of colours and of a mixed block of a lit target; a covered one has them in its values.
    pub normals: Vec<u16>,
    /// The slab's cells.
    pub cells: CellRanges,
}

/// All pieces of some of a target's blocks, in order.
pub fn pieces(target: &Target, blocks: &[usize]) -> Vec<Piece> {
    let cut = |&index: &usize| cut(&target.lattice, index, &target.blocks[index]);
    blocks.iter().flat_map(cut).collect()
}

/// The pieces of a block. All but the first begin with a cell.
fn cut(lattice: &Lattice, index: usize, block: &Block) -> Vec<Piece> {
    if block.layout == Layout::Uniform {
        return vec![Piece {
            index,
            slab: block.clone(),
            first_plane: 0,
            planes: 0..UNIFORM_EDGE,
        }];
    }
    let plane = block.extent[0] * block.extent[1];
    let thickness = (PIECE_VOXELS / plane).next_multiple_of(CELL).max(CELL);
    let depth = block.extent[2];
    let before = (lattice.first().z + block.origin[2] as i64).rem_euclid(CELL as i64) as usize;
    let begin = |n: usize| (n * thickness).saturating_sub(before);
    (0..)
        .take_while(|n| begin(*n) < depth)
        .map(|n| piece(index, block, begin(n)..begin(n + 1).min(depth)))
        .collect()
}

fn piece(index: usize, block: &Block, z: Range<usize>) -> Piece {
    let mut slab = block.clone();
    slab.origin[2] += z.start;
    slab.extent[2] = z.len();
    // Only the block's first and last slab fill its apron planes.
    let begin = if z.start == 0 { 0 } else { Block::APRON };
    let end = if z.end == block.extent[2] {
        2 * Block::APRON
    } else {
        Block::APRON
    };
    Piece {
        index,
        slab,
        first_plane: z.start + begin,
        planes: begin..z.len() + end,
    }
}

/// Edge of the cell that a block of one value fills: two texels, between which filtering finds the same value everywhere.
pub const UNIFORM_EDGE: usize = 2;

/// Stored texels of a block along each axis.
pub fn stored_dims(block: &Block) -> [usize; 3] {
    match block.layout {
        Layout::Uniform => [UNIFORM_EDGE; 3],
        Layout::Covered | Layout::Mixed => block.stored_dims(),
    }
}

/// Reconstructs pieces side by side.
pub fn fill(target: &Target, pieces: &[Piece], normals: Option<&SoftNormals>) -> Vec<PieceTexels> {
    pieces
        .par_iter()
        .map(|piece| fill_one(target, piece, normals))
        .collect()
}

fn fill_one(target: &Target, piece: &Piece, normals: Option<&SoftNormals>) -> PieceTexels {
    let slab = &piece.slab;
    if slab.layout == Layout::Uniform {
        return uniform(target, slab, normals.is_some());
    }
    let Some(soft) = normals else {
        let voxels = BlockVoxels::reconstruct(target, slab, Block::APRON);
        let rows = Rows::new(slab, &voxels, target.value_range);
        let planes = piece.planes.clone();
        return PieceTexels {
            values: match voxels.rgb() {
                Some(_) => rows.colors(planes),
                None => rows.values(planes),
            },
            normals: Vec::new(),
            cells: CellRanges::new(&target.lattice, slab, &voxels),
        };
    };
    let voxels = BlockVoxels::reconstruct(target, slab, Block::REACH);
    let rows = Rows::new(slab, &voxels, target.value_range);
    let normal_rows = NormalRows::new(soft, target.value_range, &target.lattice, slab, &voxels);
    let planes = piece.planes.clone();
    let (values, normals) = if voxels.rgb().is_some() {
        (rows.colors(planes.clone()), rows.normals(&normal_rows, planes))
    } else if slab.layout == Layout::Mixed {
        (rows.values(planes.clone()), rows.normals(&normal_rows, planes))
    } else {
        let lit = rows.lit_values(&normal_rows, planes);
        (lit, Vec::new())
    };
    PieceTexels {
        values,
        normals,
        cells: CellRanges::new(&target.lattice, slab, &voxels),
    }
}

fn uniform(target: &Target, block: &Block, lit: bool) -> PieceTexels {
    const TEXELS: usize = UNIFORM_EDGE * UNIFORM_EDGE * UNIFORM_EDGE;
    PieceTexels {
        values: texels::uniform(target.value_range, block.range.value.lo, lit, TEXELS),
        normals: Vec::new(),
        cells: CellRanges::uniform(&target.lattice, block),
    }
}
