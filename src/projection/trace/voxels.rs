//! A target's blocks as rays sample them, and what rays can skip.
//!
//! *Practice.* An empty leaf of the octree is skipped as a whole, and of a block the cells of 8³ voxels in which nothing that a ray looks
//! for can be: nothing that shows, no surface from outside, no surface from within.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::classifier::{Classifier, Sample};
use super::ray::{Line, Ray};
use crate::math::{Interval, affine};
use crate::target::{Block, BlockVoxels, Cube, Lattice, Layout, Octree, OctreeNode, Target};

/// Edge of a cell in voxels.
const CELL: usize = 8;

/// What a ray looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quest {
    /// Whatever shows.
    Shown = 1,
    /// A surface, from outside.
    Entrance = 2,
    /// A surface, from within.
    Exit = 4,
}

/// Densities below which nothing of a surface is met, and above which a surface is met for good.
pub const SURFACE: [f64; 2] = [0.25, 0.75];

/// A target in memory.
pub struct Level {
    /// Where its voxels are.
    pub lattice: Lattice,
    lattice_from_world: DAffine3,
    octree: Octree,
    blocks: Vec<LevelBlock>,
}

/// A block with an apron of one voxel.
struct LevelBlock {
    origin: [usize; 3],
    /// The value of a block that is covered by one throughout.
    uniform: Option<f32>,
    voxels: BlockVoxels,
    cells: Cells,
}

/// What can be in each cell of a block: bits of [`Quest`].
struct Cells {
    dims: [usize; 3],
    found: Vec<u8>,
}

impl Level {
    /// Reconstructs the blocks of `target`.
    pub fn new(target: &Target, classifier: &Classifier) -> Self {
        let blocks = target.blocks.par_iter();
        Self {
            lattice: target.lattice,
            lattice_from_world: target.lattice.world_from_lattice.inverse(),
            octree: target.octree.clone(),
            blocks: blocks.map(|block| LevelBlock::new(target, block, classifier)).collect(),
        }
    }

    /// The largest distance between neighbouring voxels, millimetres.
    pub fn voxel_mm(&self) -> f64 {
        self.lattice.spacing_mm().max_element()
    }

    /// Whether a place of the world is in the lattice's box.
    pub fn holds(&self, world: DVec3) -> bool {
        let at = affine::point(&self.lattice_from_world, world);
        self.lattice.bounds().contains(at)
    }

    /// Voxel steps along the axes of the lattice, in the world.
    pub fn axes(&self) -> [DVec3; 3] {
        let axes = self.lattice.world_from_lattice.matrix3;
        [axes.x_axis, axes.y_axis, axes.z_axis]
    }

    /// The gradient in the world of what changes by `differences` a voxel, along each axis.
    pub fn gradient(&self, differences: [f64; 3]) -> DVec3 {
        // A gradient is a covector: it transforms with the inverse transpose.
        self.lattice_from_world.matrix3.transpose() * DVec3::from_array(differences)
    }

    /// The voxel that holds a place of the lattice, or is nearest to one beyond it.
    fn voxel(&self, at: DVec3) -> [i64; 3] {
        let dims = self.lattice.dims;
        std::array::from_fn(|a| ((at[a] + 0.5) as i64).clamp(0, dims[a] as i64 - 1))
    }

    fn leaf(&self, voxel: [i64; 3]) -> Leaf {
        let mut cube = self.octree.root;
        let mut node = self.octree.nodes[0];
        while let OctreeNode::Split(first) = node {
            let octant = cube.octant_with(voxel);
            cube = cube.octant(octant);
            node = self.octree.nodes[first as usize + octant];
        }
        Leaf { cube, node }
    }
}

/// A leaf of the octree.
#[derive(Clone, Copy)]
struct Leaf {
    cube: Cube,
    node: OctreeNode,
}

impl Leaf {
    fn holds(&self, voxel: [i64; 3]) -> bool {
        let Cube { origin, size } = self.cube;
        (0..3).all(|a| (0..size as i64).contains(&(voxel[a] - origin[a])))
    }
}

/// Samples at places of the world that are near to each other: a leaf is looked up when they leave the one before.
pub struct Nearby<'a> {
    level: &'a Level,
    leaf: Option<Leaf>,
}

impl<'a> Nearby<'a> {
    /// Those of `level`.
    pub fn new(level: &'a Level) -> Self {
        Self { level, leaf: None }
    }

    /// The sample at a place of the world. Beyond the lattice its outermost voxels go on.
    pub fn sample(&mut self, world: DVec3) -> Sample {
        let level = self.level;
        let centres = level.lattice.centres();
        let at = affine::point(&level.lattice_from_world, world).clamp(centres.min, centres.max);
        let voxel = level.voxel(at);
        let leaf = match self.leaf {
            Some(leaf) if leaf.holds(voxel) => leaf,
            _ => *self.leaf.insert(level.leaf(voxel)),
        };
        match leaf.node {
            OctreeNode::Block(block) => level.blocks[block as usize].sample(at),
            _ => Sample::default(),
        }
    }
}

impl LevelBlock {
    fn new(target: &Target, block: &Block, classifier: &Classifier) -> Self {
        let cell_dims = block.extent.map(|n| n.div_ceil(CELL));
        if block.layout == Layout::Uniform {
            let found = found(classifier, block.range.value, [1.0; 2]);
            return Self {
                origin: block.origin,
                uniform: Some(block.range.value.lo),
                voxels: BlockVoxels::default(),
                cells: Cells {
                    dims: cell_dims,
                    found: vec![found; cell_dims.iter().product()],
                },
            };
        }
        let voxels = BlockVoxels::reconstruct(target, block, Block::APRON);
        let count = cell_dims.iter().product();
        let cell = |n: usize| {
            let cell = [
                n % cell_dims[0],
                n / cell_dims[0] % cell_dims[1],
                n / (cell_dims[0] * cell_dims[1]),
            ];
            let (values, coverages) = ranges(&voxels, cell);
            found(classifier, values, coverages)
        };
        let found = (0..count).map(cell).collect();
        Self {
            origin: block.origin,
            uniform: None,
            voxels,
            cells: Cells { dims: cell_dims, found },
        }
    }

    /// The trilinear sample at a place of the lattice, in the block or within half a voxel of it.
    fn sample(&self, at: DVec3) -> Sample {
        if let Some(value) = self.uniform {
            return Sample {
                premultiplied: f64::from(value),
                coverage: 1.0,
                rgb: [0.0; 3],
            };
        }
        let dims = self.voxels.dims;
        let base = at.to_array().map(floor);
        let t = std::array::from_fn(|a| at[a] - base[a] as f64);
        let corner: [usize; 3] = std::array::from_fn(|a| {
            let stored = base[a] + 1 - self.origin[a] as i64;
            stored.clamp(0, dims[a] as i64 - 2) as usize
        });
        let first = corner[0] + dims[0] * (corner[1] + dims[1] * corner[2]);
        let strides = [dims[0], dims[0] * dims[1]];
        let mix = |numbers: &[f32]| trilinear(|n| [numbers[n], numbers[n + 1]], first, strides, t);
        let voxels = &self.voxels;
        Sample {
            premultiplied: mix(&voxels.premultiplied),
            coverage: voxels.coverage.as_ref().map_or(1.0, |coverage| mix(coverage)),
            rgb: voxels.rgb().map_or([0.0; 3], |rgb| {
                [0, 1, 2].map(|c| trilinear(|n| [rgb[n][c], rgb[n + 1][c]], first, strides, t))
            }),
        }
    }
}

/// The whole number at or below `x`; without a call, as which processors without SSE 4.1 have it.
#[inline]
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(towards_zero as f64 > x)
}

/// Between eight numbers: `pair` gives one and the next along x, and the others are `y` and `z` further on.
#[inline(always)]
fn trilinear(pair: impl Fn(usize) -> [f32; 2], first: usize, [y, z]: [usize; 2], t: [f64; 3]) -> f64 {
    let along_x = |[a, b]: [f32; 2]| lerp(f64::from(a), f64::from(b), t[0]);
    let near = lerp(along_x(pair(first)), along_x(pair(first + y)), t[1]);
    let far = lerp(along_x(pair(first + z)), along_x(pair(first + y + z)), t[1]);
    lerp(near, far, t[2])
}

#[inline(always)]
fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// The ranges of covered values and of coverages that samples in a cell can have: those of its voxels and one more on each side.
fn ranges(voxels: &BlockVoxels, cell: [usize; 3]) -> (Interval, [f64; 2]) {
    let before = voxels.apron - 1;
    let first: [usize; 3] = cell.map(|c| c * CELL + before);
    let last: [usize; 3] = std::array::from_fn(|a| (first[a] + CELL + 2).min(voxels.dims[a]));
    let [mut values, mut coverages] = [Interval::EMPTY; 2];
    for k in first[2]..last[2] {
        for j in first[1]..last[1] {
            let row = voxels.dims[0] * (j + voxels.dims[1] * k);
            for n in row + first[0]..row + last[0] {
                let coverage = voxels.coverage.as_ref().map_or(1.0, |c| c[n]);
                coverages = coverages.hull(Interval::point(coverage));
                if coverage > 0.0 {
                    values = values.hull(Interval::point(voxels.premultiplied[n] / coverage));
                }
            }
        }
    }
    (values, [f64::from(coverages.lo), f64::from(coverages.hi)])
}

/// What can be found among values and coverages in these ranges.
fn found(classifier: &Classifier, values: Interval, [thin, thick]: [f64; 2]) -> u8 {
    let [least, most] = classifier.densities(values);
    let shown = if most > 0.0 && thick > 0.0 {
        Quest::Shown as u8
    } else {
        0
    };
    let entrance = if most * thick >= SURFACE[0] {
        Quest::Entrance as u8
    } else {
        0
    };
    let exit = if least * thin <= SURFACE[1] {
        Quest::Exit as u8
    } else {
        0
    };
    shown | entrance | exit
}

/// A ray on its way through a level.
pub struct Walk<'a> {
    level: &'a Level,
    /// The ray in the level's lattice.
    pub line: Line,
    /// Where it is in the lattice's box, millimetres.
    pub enter: f64,
    /// Where it leaves that.
    pub leave: f64,
    /// The axes of the faces of that.
    pub axes: [usize; 2],
    leaf: Option<(Leaf, [DVec3; 2])>,
}

/// A part of a ray in which there is one thing to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Whether what is looked for can be in it.
    pub worthwhile: bool,
    /// Where it ends, millimetres, behind where it was asked for.
    pub end: f64,
}

impl<'a> Walk<'a> {
    /// `ray` through `level`.
    pub fn new(level: &'a Level, ray: &Ray) -> Self {
        let line = ray.line_in(&level.lattice_from_world);
        let bounds = level.lattice.bounds();
        let stretch = line.stretch(bounds.min, bounds.max);
        Self {
            level,
            line,
            enter: stretch.enter,
            leave: stretch.leave,
            axes: stretch.axes,
            leaf: None,
        }
    }

    /// What it goes through.
    pub fn level(&self) -> &'a Level {
        self.level
    }

    /// Half a voxel, millimetres of ray.
    pub fn half_voxel(&self) -> f64 {
        0.5 / self.line.step.length()
    }

    /// The region that the place `mm` is in, for `quest`.
    pub fn region(&mut self, mm: f64, quest: Quest) -> Region {
        if mm < self.enter || self.leave <= mm {
            let end = if mm < self.enter && self.enter < self.leave {
                self.enter
            } else {
                f64::INFINITY
            };
            return Region {
                worthwhile: quest == Quest::Exit,
                end,
            };
        }
        let at = self.line.at(mm);
        let (leaf, bounds) = *self.leaf_at(at);
        let (worthwhile, [low, high]) = match leaf.node {
            OctreeNode::Block(block) => {
                let block = &self.level.blocks[block as usize];
                let (found, bounds) = block.cell(at);
                (found & quest as u8 != 0, bounds)
            }
            _ => (quest == Quest::Exit, bounds),
        };
        let end = self.line.leave(low, high).min(self.leave);
        // Rounding must not keep a ray where it is.
        let least = (mm + 1e-6 * self.half_voxel()).max(mm.next_up());
        Region {
            worthwhile,
            end: (end + 1e-6 * self.half_voxel()).max(least),
        }
    }

    /// The sample at the place `mm`; nothing beyond the lattice.
    pub fn sample(&mut self, mm: f64) -> Sample {
        if mm < self.enter || self.leave < mm {
            return Sample::default();
        }
        let at = self.line.at(mm);
        match self.leaf_at(at).0.node {
            OctreeNode::Block(block) => self.level.blocks[block as usize].sample(at),
            _ => Sample::default(),
        }
    }

    /// The leaf that holds a place of the lattice, and its box.
    fn leaf_at(&mut self, at: DVec3) -> &(Leaf, [DVec3; 2]) {
        let left = |(_, [low, high]): &mut (Leaf, [DVec3; 2])| !(at.cmpge(*low).all() && at.cmple(*high).all());
        self.leaf.take_if(left);
        self.leaf.get_or_insert_with(|| {
            let leaf = self.level.leaf(self.level.voxel(at));
            let low = DVec3::from_array(leaf.cube.origin.map(|n| n as f64)) - 0.5;
            (leaf, [low, low + leaf.cube.size as f64])
        })
    }
}

impl LevelBlock {
    /// What can be found in the cell that holds a place, and its box.
    fn cell(&self, at: DVec3) -> (u8, [DVec3; 2]) {
        let origin = DVec3::from_array(self.origin.map(|n| n as f64)) - 0.5;
        let cell: [usize; 3] = std::array::from_fn(|a| {
            let n = ((at[a] - origin[a]).max(0.0) / CELL as f64) as usize;
            n.min(self.cells.dims[a] - 1)
        });
        let low = origin + DVec3::from_array(cell.map(|n| (n * CELL) as f64));
        let found = self.cells.found[cell[0] + self.cells.dims[0] * (cell[1] + self.cells.dims[1] * cell[2])];
        (found, [low, low + CELL as f64])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ControlPoint, Model, Node, TransferFunction};
    use crate::target::Subdivision;
    use crate::voxelize::{Primitive, Solid};

    fn level() -> Level {
        let ball = Solid::Sphere {
            center: DVec3::new(0.3, 0.2, 0.1),
            radius: 12.0,
        };
        let mut model = Model::default();
        model.push(Node::Primitive(Primitive::crisp(ball, 1.0)));
        let subdivision = Subdivision {
            min_block: 8,
            max_block: 8,
            ..Subdivision::default()
        };
        let target = Target::build(&model, Some(1.0), &subdivision).expect("a target");
        let point = ControlPoint {
            value: 0.0,
            color: [1.0; 3],
            opacity: 1.0,
        };
        let transfer = TransferFunction::new(vec![point], 1.0).expect("a transfer function");
        Level::new(&target, &Classifier::new(&target, &transfer))
    }

    /// From place to place, near and far, on the faces of blocks and beyond the lattice: what a look-up of its own gives, bit for bit.
    #[test]
    fn nearby_samples_are_those_of_a_look_up_each() {
        let level = level();
        let mut nearby = Nearby::new(&level);
        let mut found = 0;
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let mut about = DVec3::ZERO;
        for n in 0..60_000 {
            if n % 27 == 0 {
                about = DVec3::new(random(), random(), random()) * 30.0 - 16.5;
            }
            let at = about + 3.0 * DVec3::new(random(), random(), random());
            // Every other one on a voxel's face.
            let world = if n % 2 == 0 { at } else { (2.0 * at).floor() * 0.5 };
            let sample = nearby.sample(world);
            found += usize::from(sample.coverage > 0.0);
            assert_eq!(sample, Nearby::new(&level).sample(world), "{world}");
        }
        assert!(found > 1000, "{found}");
    }

    #[test]
    fn whole_numbers_are_at_or_below() {
        for x in [-2.5, -2.0, -0.5, -1e-300, 0.0, 0.7, 1.0, 1.0f64.next_down(), 3e9 + 0.5] {
            assert_eq!(floor(x), x.floor() as i64, "{x}");
        }
    }
}
