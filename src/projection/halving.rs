//! How the visible parts of a cube become as few boxes as pay.
//!
//! *Practice.* A cube is halved along one axis after another, in whatever order is cheapest, and each part that shows anything is
//! drawn whole where that is no dearer than its halves. The farther half always comes first, so the boxes are in order.

use super::DrawCost;
use crate::math::{Aabb, Viewpoint};
use crate::target::{Cube, VoxelBox, octants_back_to_front};

/// A box that is drawn, and the block that holds its voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VisibleBox {
    /// Index of the block.
    pub block: u32,
    /// First voxel in the lattice.
    pub origin: [usize; 3],
    /// Voxels along each axis, at least 1.
    pub extent: [usize; 3],
}

impl VisibleBox {
    pub(super) fn new(block: u32, VoxelBox { origin, extent }: VoxelBox) -> Self {
        Self { block, origin, extent }
    }

    /// The box of its cells in lattice coordinates.
    pub fn bounds(&self) -> Aabb {
        let Self { origin, extent, .. } = *self;
        VoxelBox { origin, extent }.bounds()
    }
}

/// What is drawn of a part of a block, back to front, and what it costs.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    pub boxes: Vec<VisibleBox>,
    pub cost: f64,
}

/// A cube of a block whose octants are decided.
pub(super) struct Halving<'a> {
    pub block: u32,
    pub cube: Cube,
    /// Of the lattice.
    pub dims: [usize; 3],
    pub octants: &'a [Shown; 8],
    pub cost: &'a DrawCost,
}

/// A part of a cube: the octant at its low end, and the axes (bits) along which it is as long as the cube.
#[derive(Clone, Copy)]
struct Part {
    octant: usize,
    free: usize,
}

impl Part {
    const WHOLE: Self = Self { octant: 0, free: 0b111 };

    /// The halves on the low and the high side of each axis along which there are two.
    fn halves(self) -> impl Iterator<Item = (usize, [Self; 2])> {
        let axes = (0..3).filter(move |axis| self.free >> axis & 1 == 1);
        axes.map(move |axis| {
            let free = self.free & !(1 << axis);
            let half = |octant| Self { octant, free };
            (axis, [half(self.octant), half(self.octant | 1 << axis)])
        })
    }
}

impl Halving<'_> {
    /// The boxes that are drawn of the cube as seen from `viewpoint` (lattice coordinates).
    pub fn shown(&self, viewpoint: Viewpoint) -> Shown {
        let mut shown = Shown::default();
        let Some(whole) = self.whole(Part::WHOLE) else {
            return shown;
        };
        if (0..8).all(|octant| self.is_whole(octant)) {
            shown.boxes.push(whole);
            shown.cost = self.cost.of(whole.extent);
        } else {
            let far = octants_back_to_front(&self.cube, viewpoint)[0];
            self.collect(Part::WHOLE, far, &mut shown);
        }
        shown
    }

    /// Whether all of an octant is drawn, as one box: if that is so of all eight, nothing is gained by drawing them apart.
    fn is_whole(&self, octant: usize) -> bool {
        let voxels = self.cube.octant(octant).voxels(self.dims);
        match self.octants[octant].boxes[..] {
            [only] => only.extent == voxels.extent,
            _ => voxels.is_empty(),
        }
    }

    /// Adds the boxes of `part`. Bit `a` of `far` says that the high side of axis `a` is the farther one.
    fn collect(&self, part: Part, far: usize, shown: &mut Shown) {
        if part.free == 0 {
            let octant = &self.octants[part.octant];
            shown.boxes.extend(&octant.boxes);
            shown.cost += octant.cost;
            return;
        }
        let Some(whole) = self.whole(part) else {
            return;
        };
        let (axis, halves, cost) = self.cheapest(part);
        let whole_cost = self.cost.of(whole.extent);
        if whole_cost <= cost {
            shown.boxes.push(whole);
            shown.cost += whole_cost;
            return;
        }
        let [low, high] = halves;
        let ordered = if far >> axis & 1 == 1 { [high, low] } else { [low, high] };
        ordered.into_iter().for_each(|half| self.collect(half, far, shown));
    }

    /// The axis to halve `part` along, the halves, and what they cost.
    fn cheapest(&self, part: Part) -> (usize, [Part; 2], f64) {
        let costs = part
            .halves()
            .map(|(axis, halves)| (axis, halves, halves.iter().map(|half| self.cost_of(*half)).sum::<f64>()));
        costs
            .min_by(|a, b| a.2.total_cmp(&b.2))
            .unwrap_or((0, [part; 2], f64::INFINITY))
    }

    fn cost_of(&self, part: Part) -> f64 {
        if part.free == 0 {
            return self.octants[part.octant].cost;
        }
        self.whole(part)
            .map_or(0.0, |whole| self.cost.of(whole.extent).min(self.cheapest(part).2))
    }

    /// The box of `part`, if anything in it shows.
    fn whole(&self, part: Part) -> Option<VisibleBox> {
        let within = |octant: &usize| octant & !part.free == part.octant;
        let shows = |octant: usize| !self.octants[octant].boxes.is_empty();
        (0..8).filter(within).any(shows).then(|| {
            let half = self.cube.size / 2;
            let bit = |bits: usize, a: usize| bits >> a & 1;
            let edges = std::array::from_fn(|a| half * (1 + bit(part.free, a)));
            let low = self.cube.octant(part.octant).origin;
            VisibleBox::new(self.block, VoxelBox::clipped(low, edges, self.dims))
        })
    }
}
