//! Where blocks go in pages: blocks of one shape fill equal cells of a page.

use std::collections::BTreeMap;

use super::pages::{Slot, Texels};
use super::pieces;
use crate::target::{Block, Layout, Target};

/// The largest page, bytes of values: several small allocations rather than one that may not be had.
const PAGE_BYTES: usize = 256 << 20;

/// Blocks up to this edge fill a cell of their whole cube, even where the lattice cuts them short, so that they share pages.
const SHARED_EDGE: usize = 64;

/// What blocks of one page have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Class {
    texels: Texels,
    cell: [usize; 3],
}

impl Class {
    /// The class of a block of `target`.
    pub fn of(target: &Target, block: &Block) -> Self {
        let cell = if block.layout != Layout::Uniform && block.size <= SHARED_EDGE {
            [block.size + 2 * Block::APRON; 3]
        } else {
            pieces::stored_dims(block)
        };
        Self {
            texels: match block.layout {
                _ if target.tree.has_colors() => Texels::Colors,
                Layout::Mixed => Texels::Mixed,
                Layout::Covered | Layout::Uniform => Texels::Values,
            },
            cell,
        }
    }

    /// How many texels a cell has.
    pub fn len(&self) -> usize {
        self.cell.iter().product()
    }

    /// The first texel of cell `n` in a grid of cells.
    fn origin(&self, n: usize, grid: [usize; 3]) -> [usize; 3] {
        let at = [n % grid[0], n / grid[0] % grid[1], n / (grid[0] * grid[1])];
        std::array::from_fn(|a| at[a] * self.cell[a])
    }
}

/// A page before it is allocated: cells of one shape in a grid.
pub(super) struct PagePlan {
    pub texels: Texels,
    pub dims: [usize; 3],
}

/// Blocks with their cells, and the pages that are new for them.
pub(super) struct Arrangement {
    pub pages: Vec<PagePlan>,
    pub slots: Vec<(usize, Slot)>,
}

impl Arrangement {
    /// Cells for some blocks of `target`: such as are `free`, then those of new pages, whose numbers begin at `first_page`. Cells of
    /// new pages that are left become free.
    pub fn new(
        target: &Target,
        blocks: &[usize],
        free: &mut Vec<(Class, Slot)>,
        first_page: usize,
        longest_edge: u32,
    ) -> Self {
        let mut classes: BTreeMap<Class, Vec<usize>> = BTreeMap::new();
        for &index in blocks {
            classes
                .entry(Class::of(target, &target.blocks[index]))
                .or_default()
                .push(index);
        }
        let mut arrangement = Self {
            pages: Vec::new(),
            slots: Vec::new(),
        };
        free.retain(|(class, slot)| match classes.get_mut(class).and_then(Vec::pop) {
            Some(index) => {
                arrangement.slots.push((index, *slot));
                false
            }
            None => true,
        });
        for (class, blocks) in classes.into_iter().filter(|(_, blocks)| !blocks.is_empty()) {
            arrangement.add_pages(class, &blocks, free, first_page, longest_edge);
        }
        arrangement
    }

    fn add_pages(
        &mut self,
        class: Class,
        blocks: &[usize],
        free: &mut Vec<(Class, Slot)>,
        first_page: usize,
        longest_edge: u32,
    ) {
        let texel = size_of::<u16>() * class.texels.channels();
        let most = (PAGE_BYTES / (texel * class.len())).max(1);
        let limit = class.cell.map(|edge| (longest_edge as usize / edge).max(1));
        for chunk in blocks.chunks(most.min(limit.iter().product())) {
            let grid = near_cube(chunk.len(), limit);
            let page = first_page + self.pages.len();
            let slot = |n: usize| Slot {
                page,
                origin: class.origin(n, grid),
            };
            self.slots
                .extend(chunk.iter().enumerate().map(|(n, &block)| (block, slot(n))));
            free.extend((chunk.len()..grid.iter().product()).map(|n| (class, slot(n))));
            self.pages.push(PagePlan {
                texels: class.texels,
                dims: std::array::from_fn(|a| grid[a] * class.cell[a]),
            });
        }
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
