//! Target blocks as 3D textures, packed in pages (design §5).
//!
//! *Theory.* Each target block is a 3D texture, bound and drawn (VCSG §3.3.2).
//! *Changes from the paper.* Blocks of one shape share a page, so that what is bound changes seldom; each carries an apron of
//! one voxel, so that filtering inside it never sees its neighbours in the page. Soft normals are stored beside the values:
//! one fetch instead of six (see [`texels`](super::texels)).
//! *Practice.* No page is larger than the device's 3D images. Voxels are reconstructed, encoded and uploaded batch by batch,
//! so no second copy of the target is ever held.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::arrange::{Arrangement, Class, PagePlan};
use super::pieces::{self, Piece, PieceTexels};
use crate::gpu::{
    Buffer, BufferRole, Command, Device, Extent, Format, GpuError, Image, ImageCopy, ImageRole, Recording, Region,
};
use crate::projection::SoftNormals;
use crate::target::{Block, CellRanges, Layout, Target, Update};

/// Bytes reconstructed before they are handed to the device.
const BATCH_BYTES: usize = 16 << 20;

/// What the texels of a page are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Texels {
    /// Values, in a lit target with normals beside them.
    Values,
    /// Value times coverage, and coverage.
    Mixed,
    /// Colour times opacity and coverage, and opacity times coverage.
    Colors,
}

/// A 3D texture of blocks of one shape.
pub struct Page {
    /// What its texels are.
    pub texels: Texels,
    /// Texels along each axis.
    pub dims: [u32; 3],
    /// The values; in a covered page of a lit target each with its soft normal.
    pub values: Arc<Image>,
    /// The soft normals of a page of a lit target that has none beside its values.
    pub normals: Option<Arc<Image>>,
}

/// Where a block is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slot {
    /// Index of its page.
    pub page: usize,
    /// Its first stored texel.
    pub origin: [usize; 3],
}

/// A target on a device.
pub struct PagedTarget {
    /// The pages.
    pub pages: Vec<Page>,
    /// Where each block of the target is.
    pub slots: Vec<Slot>,
    /// The cells of each block.
    pub cells: Vec<CellRanges>,
    /// What reconstructing the blocks took.
    pub reconstruct: Duration,
    /// What bringing them to the device took.
    pub upload: Duration,
    /// Cells of pages that hold no block.
    free: Vec<(Class, Slot)>,
}

/// The formats of values and normals that pages use; a device must filter all of them linearly.
pub const FORMATS: [Format; 3] = [Format::R16_UNORM, Format::R16G16_UNORM, NORMAL_FORMAT];

/// The format of normals, with values or an empty channel before them.
const NORMAL_FORMAT: Format = Format::R16G16B16A16_UNORM;

/// The format of colours.
const COLOR_FORMAT: Format = Format::R16G16B16A16_UNORM;

impl PagedTarget {
    /// Reconstructs all blocks of `target` and uploads them, with normals if `normals` says how. `progress` is told the
    /// number of voxels after each batch.
    ///
    /// # Errors
    /// If the device has not enough memory, or is lost.
    pub fn new(
        device: &Arc<Device>,
        target: &Target,
        normals: Option<&SoftNormals>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Self, GpuError> {
        let mut paged = Self {
            pages: Vec::new(),
            slots: vec![Slot::default(); target.blocks.len()],
            cells: empty_cells(target),
            reconstruct: Duration::ZERO,
            upload: Duration::ZERO,
            free: Vec::new(),
        };
        let all: Vec<usize> = (0..target.blocks.len()).collect();
        paged.fill(device, target, &all, normals, progress)?;
        Ok(paged)
    }

    /// The same after an edit of the target, which had been uploaded as it was `before` with the same value range and normals. Only
    /// blocks whose voxels have changed are reconstructed and uploaded, into cells that others have left or into new pages; what is
    /// left becomes new pages altogether once it would fill them less than half.
    ///
    /// # Errors
    /// If the device has not enough memory, or is lost.
    pub fn updated(
        mut self,
        device: &Arc<Device>,
        before: &Target,
        update: &Update,
        normals: Option<&SoftNormals>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Self, GpuError> {
        let target = &update.target;
        if self.texels() > 2 * target.blocks.iter().map(|b| Class::of(target, b).len()).sum::<usize>() {
            drop(self);
            return Self::new(device, target, normals, progress);
        }
        let mut paged = Self {
            slots: vec![Slot::default(); target.blocks.len()],
            cells: empty_cells(target),
            reconstruct: Duration::ZERO,
            upload: Duration::ZERO,
            free: std::mem::take(&mut self.free),
            pages: std::mem::take(&mut self.pages),
        };
        let mut gone = vec![true; before.blocks.len()];
        let mut changed = Vec::new();
        for (index, kept) in update.kept.iter().enumerate() {
            match kept.map(|old| old as usize) {
                Some(old) => {
                    gone[old] = false;
                    paged.slots[index] = self.slots[old];
                    paged.cells[index] = std::mem::take(&mut self.cells[old]);
                }
                None => changed.push(index),
            }
        }
        let left = (0..before.blocks.len()).filter(|&old| gone[old]);
        paged
            .free
            .extend(left.map(|old| (Class::of(before, &before.blocks[old]), self.slots[old])));
        paged.fill(device, target, &changed, normals, progress)?;
        Ok(paged)
    }

    /// Finds cells for some blocks of `target`, reconstructs and uploads them.
    fn fill(
        &mut self,
        device: &Arc<Device>,
        target: &Target,
        blocks: &[usize],
        normals: Option<&SoftNormals>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), GpuError> {
        let longest_edge = device.info().limits.image_dimension_3d;
        let arrangement = Arrangement::new(target, blocks, &mut self.free, self.pages.len(), longest_edge);
        for plan in &arrangement.pages {
            self.pages.push(plan.allocate(device, normals.is_some())?);
        }
        for (index, slot) in arrangement.slots {
            self.slots[index] = slot;
        }
        let all = pieces::pieces(target, blocks);
        let mut rest = &all[..];
        while !rest.is_empty() {
            let (batch, later) = rest.split_at(batch_len(rest));
            let begin = Instant::now();
            let filled = pieces::fill(target, batch, normals);
            let reconstructed = Instant::now();
            self.send(device, batch, &filled)?;
            self.reconstruct += reconstructed - begin;
            self.upload += reconstructed.elapsed();
            for (piece, texels) in batch.iter().zip(&filled) {
                self.cells[piece.index].append(&texels.cells);
            }
            progress(batch.iter().map(|p| p.slab.extent.iter().product::<usize>()).sum());
            rest = later;
        }
        Ok(())
    }

    fn texels(&self) -> usize {
        let texels = |page: &Page| page.dims.iter().map(|&n| n as usize).product::<usize>();
        self.pages.iter().map(texels).sum()
    }

    /// Bytes of all pages.
    pub fn bytes(&self) -> u64 {
        let page = |p: &Page| p.values.bytes() + p.normals.as_ref().map_or(0, |n| n.bytes());
        self.pages.iter().map(page).sum()
    }

    fn send(&self, device: &Arc<Device>, batch: &[Piece], filled: &[PieceTexels]) -> Result<(), GpuError> {
        let mut stage = Stage::default();
        for (piece, texels) in batch.iter().zip(filled) {
            let slot = self.slots[piece.index];
            let page = &self.pages[slot.page];
            let region = piece_region(piece, slot);
            stage.add(&page.values, region, &texels.values);
            if let Some(normals) = &page.normals {
                stage.add(normals, region, &texels.normals);
            }
        }
        stage.submit(device)
    }
}

fn empty_cells(target: &Target) -> Vec<CellRanges> {
    let blocks = target.blocks.iter();
    blocks
        .map(|block| CellRanges::empty(&target.lattice, &block.voxels()))
        .collect()
}

fn batch_len(pieces: &[Piece]) -> usize {
    let mut bytes = 0;
    let full = pieces.iter().position(|p| {
        bytes += p.slab.stored_len() * 16;
        bytes > BATCH_BYTES
    });
    full.unwrap_or(pieces.len()).max(1)
}

fn piece_region(piece: &Piece, slot: Slot) -> Region {
    let dims = pieces::stored_dims(&piece.slab);
    let [x, y, z] = slot.origin;
    Region {
        offset: [x, y, z + piece.first_plane].map(|n| n as u32),
        extent: [dims[0], dims[1], piece.planes.len()].map(|n| n as u32),
    }
}

/// Bytes on their way to images.
#[derive(Default)]
struct Stage<'a> {
    parts: Vec<(usize, &'a [u8])>,
    copies: Vec<(&'a Arc<Image>, Region, usize)>,
    bytes: usize,
}

impl<'a> Stage<'a> {
    /// Every texel size divides it.
    const ALIGNMENT: usize = 16;

    fn add(&mut self, image: &'a Arc<Image>, region: Region, texels: &'a [u16]) {
        let texels: &[u8] = bytemuck::cast_slice(texels);
        self.copies.push((image, region, self.bytes));
        self.parts.push((self.bytes, texels));
        self.bytes += texels.len().next_multiple_of(Self::ALIGNMENT);
    }

    fn submit(self, device: &Arc<Device>) -> Result<(), GpuError> {
        if self.bytes == 0 {
            return Ok(());
        }
        let buffer = Buffer::new(device, "block texels", BufferRole::Upload, self.bytes as u64)?;
        buffer.fill(|bytes| {
            for (offset, texels) in &self.parts {
                bytes[*offset..offset + texels.len()].copy_from_slice(texels);
            }
        })?;
        let mut recording = Recording::new();
        for (image, region, offset) in self.copies {
            recording.commands.push(Command::Upload(ImageCopy {
                buffer: Arc::clone(&buffer),
                offset: offset as u64,
                image: Arc::clone(image),
                region,
            }));
        }
        device.submit(&recording)?.wait()
    }
}

impl PagePlan {
    fn allocate(&self, device: &Arc<Device>, lit: bool) -> Result<Page, GpuError> {
        let dims = self.dims.map(|n| n as u32);
        let image = |label: &str, format| {
            let [width, height, depth] = dims;
            let extent = Extent::D3(width, height, depth);
            Image::new(device, label, ImageRole::Sampled, format, extent)
        };
        let beside = self.texels != Texels::Values && lit;
        Ok(Page {
            texels: self.texels,
            dims,
            values: image("values of target blocks", self.texels.format(lit))?,
            normals: beside
                .then(|| image("normals of target blocks", NORMAL_FORMAT))
                .transpose()?,
        })
    }
}

impl Texels {
    /// Numbers in a texel, normals apart.
    pub fn channels(self) -> usize {
        match self {
            Self::Values => 1,
            Self::Mixed => 2,
            Self::Colors => 4,
        }
    }

    fn format(self, lit: bool) -> Format {
        match self {
            Self::Values if lit => NORMAL_FORMAT,
            Self::Values => Format::R16_UNORM,
            Self::Mixed => Format::R16G16_UNORM,
            Self::Colors => COLOR_FORMAT,
        }
    }
}

/// The texture coordinates of a point of the lattice in a block's slot, and of a lattice step, along each axis.
pub fn texture_map(block: &Block, slot: Slot, page: &Page) -> TextureMap {
    let dims = DVec3::from_array(page.dims.map(f64::from));
    let slot_origin = DVec3::from_array(slot.origin.map(|n| n as f64));
    if block.layout == Layout::Uniform {
        // The middle of the cell, wherever in the block.
        return TextureMap {
            origin: (slot_origin + 0.5 * pieces::UNIFORM_EDGE as f64) / dims,
            step: DVec3::ZERO,
        };
    }
    let origin = DVec3::from_array(block.origin.map(|n| n as f64));
    // Voxel `origin` is the texel after the apron; texel centres are at half-integers.
    let first_center = slot_origin + Block::APRON as f64 + 0.5;
    TextureMap {
        origin: (first_center - origin) / dims,
        step: dims.recip(),
    }
}

/// An axis-wise linear map from lattice to texture coordinates: `origin + step · p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMap {
    /// Image of lattice point 0.
    pub origin: DVec3,
    /// Image of a lattice step along each axis.
    pub step: DVec3,
}
