//! Target blocks as 3D textures, packed in pages (design §5).
//!
//! *Theory.* Each target block is a 3D texture, bound and drawn (VCSG §3.3.2).
//! *Changes from the paper.* Blocks of one shape share a page, so that what is bound changes seldom; each carries an apron of
//! one voxel, so that filtering inside it never sees its neighbours in the page. Soft normals are stored beside the values:
//! one fetch instead of six (see [`texels`](super::texels)).
//! *Practice.* No page is larger than the device's 3D images. Voxels are reconstructed, encoded and uploaded batch by batch,
//! so no second copy of the target is ever held.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::pieces::{self, Piece, PieceTexels};
use crate::gpu::{
    Buffer, BufferRole, Command, Device, Extent, Format, GpuError, Image, ImageCopy, ImageRole, Recording, Region,
};
use crate::projection::SoftNormals;
use crate::target::{Block, CellRanges, Layout, Target};

/// Bytes reconstructed before they are handed to the device.
const BATCH_BYTES: usize = 16 << 20;

/// The largest page, bytes of values: several small allocations rather than one that may not be had.
const PAGE_BYTES: usize = 256 << 20;

/// Blocks up to this edge fill a cell of their whole cube, even where the lattice cuts them short, so that they share pages.
const SHARED_EDGE: usize = 64;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
        let (plans, slots) = arrange(target, device.info().limits.image_dimension_3d);
        let pages = plans
            .iter()
            .map(|plan| plan.allocate(device, normals.is_some()))
            .collect::<Result<Vec<_>, _>>()?;
        let mut paged = Self {
            pages,
            slots,
            cells: empty_cells(target),
            reconstruct: Duration::ZERO,
            upload: Duration::ZERO,
        };
        let all = pieces::pieces(target);
        let mut rest = &all[..];
        while !rest.is_empty() {
            let (batch, later) = rest.split_at(batch_len(rest));
            let begin = Instant::now();
            let filled = pieces::fill(target, batch, normals);
            let reconstructed = Instant::now();
            paged.send(device, batch, &filled)?;
            paged.reconstruct += reconstructed - begin;
            paged.upload += reconstructed.elapsed();
            for (piece, texels) in batch.iter().zip(&filled) {
                paged.cells[piece.index].ranges.extend(&texels.cells.ranges);
            }
            progress(batch.iter().map(|p| p.slab.extent.iter().product::<usize>()).sum());
            rest = later;
        }
        Ok(paged)
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
    blocks.map(CellRanges::empty).collect()
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

/// A page before it is allocated: cells of one shape in a grid.
struct PagePlan {
    texels: Texels,
    dims: [usize; 3],
}

/// Places every block of `target` in a page.
fn arrange(target: &Target, longest_edge: u32) -> (Vec<PagePlan>, Vec<Slot>) {
    let mut classes: BTreeMap<(Texels, [usize; 3]), Vec<usize>> = BTreeMap::new();
    for (index, block) in target.blocks.iter().enumerate() {
        let class = (texels_of(target, block), cell_dims(block));
        classes.entry(class).or_default().push(index);
    }
    let mut plans = Vec::new();
    let mut slots = vec![
        Slot {
            page: 0,
            origin: [0; 3]
        };
        target.blocks.len()
    ];
    for ((texels, cell), blocks) in classes {
        let texel = size_of::<u16>() * texels.channels();
        let most = (PAGE_BYTES / (texel * cell.iter().product::<usize>())).max(1);
        let limit = cell.map(|edge| (longest_edge as usize / edge).max(1));
        for chunk in blocks.chunks(most.min(limit.iter().product())) {
            let grid = near_cube(chunk.len(), limit);
            for (n, &block) in chunk.iter().enumerate() {
                let at = [n % grid[0], n / grid[0] % grid[1], n / (grid[0] * grid[1])];
                slots[block] = Slot {
                    page: plans.len(),
                    origin: std::array::from_fn(|a| at[a] * cell[a]),
                };
            }
            plans.push(PagePlan {
                texels,
                dims: std::array::from_fn(|a| grid[a] * cell[a]),
            });
        }
    }
    (plans, slots)
}

fn texels_of(target: &Target, block: &Block) -> Texels {
    match block.layout {
        _ if target.tree.has_colors() => Texels::Colors,
        Layout::Mixed => Texels::Mixed,
        Layout::Covered | Layout::Uniform => Texels::Values,
    }
}

fn cell_dims(block: &Block) -> [usize; 3] {
    if block.layout != Layout::Uniform && block.size <= SHARED_EDGE {
        [block.size + 2 * Block::APRON; 3]
    } else {
        pieces::stored_dims(block)
    }
}

/// A grid of at least `n` cells, as near a cube as `limit` allows.
fn near_cube(n: usize, limit: [usize; 3]) -> [usize; 3] {
    let x = ((n as f64).cbrt().ceil() as usize).clamp(1, limit[0]);
    let y = ((n.div_ceil(x) as f64).sqrt().ceil() as usize).clamp(1, limit[1]);
    let z = n.div_ceil(x * y);
    if z <= limit[2] {
        return [x, y, z];
    }
    // The last axis is full: widen the others as far as they go.
    let y = n.div_ceil(x * limit[2]).min(limit[1]);
    [n.div_ceil(y * limit[2]), y, limit[2]]
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
    fn channels(self) -> usize {
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
