//! The target lattice: where the model is sampled.
//!
//! *Practice.* A model whose volumes all lie on one lattice is sampled on that lattice, so its voxels are copied and not
//! interpolated; any other model gets an axis-aligned lattice in the world at the finest leaf's spacing. The lattice fills
//! the model's box. Beyond its outermost voxels the target is constant, so a face that is not a volume's own gets one more
//! layer of voxels, which is empty.
//!
//! A lattice is a box of an endless grid, which depends on the spacing and the axes and not on what the box holds: the volume's
//! own, or one whose cells' faces lie at multiples of the spacing in the world. Samples are computed at points of the grid. So a
//! voxel of two lattices on one grid has the same bits in both.

use glam::{DAffine3, DVec3, I64Vec3};

use super::{Block, TargetError};
use crate::math::{Aabb, Interval, affine};
use crate::model::{Model, Source, Tree};

/// A regular lattice in the world; voxel `(i, j, k)` has its centre at lattice point `(i, j, k)`. It is a box of a grid, in which
/// models are flattened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Voxels along each axis, at least 1.
    pub dims: [usize; 3],
    /// From lattice coordinates to world millimetres; the grid's map and the place of voxel 0 in one.
    pub world_from_lattice: DAffine3,
    world_from_grid: DAffine3,
    first: I64Vec3,
}

/// Why a model has no lattice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// Nothing to sample.
    #[error("the model is empty: no volume or primitive is left of it")]
    Empty,
    /// Infinite extent.
    #[error("the model is unbounded: intersect its half-spaces with a volume, a box or a sphere")]
    Unbounded,
    /// A spacing that cannot be.
    #[error("a spacing of {0} mm is not possible; it must be above 0")]
    Spacing(f64),
    /// More voxels along an axis than can be counted exactly.
    #[error(
        "{voxels:.0} voxels along an axis at a spacing of {spacing_mm} mm; the limit is {}: use a larger spacing",
        Lattice::MAX_DIM
    )]
    TooFine {
        /// Voxels along the longest axis.
        voxels: f64,
        /// The spacing asked for.
        spacing_mm: f64,
    },
}

impl Lattice {
    /// The most voxels along an axis.
    pub const MAX_DIM: usize = 1 << 16;

    /// Voxels along the longest axis of a model that has no volume to take a spacing from.
    const DEFAULT_DIM: f64 = 256.0;

    /// A volume's lattice serves a whole scene only while its spacings differ by no more than this.
    const MAX_ANISOTROPY: f64 = 2.5;

    /// A grid has its point 0 at a multiple of this many points from that of its axes, where a lattice begins near to it: 0 but
    /// for scenes that are far off, whose points would else be too large to be exact.
    const ANCHORS: f64 = (1 << 20) as f64;

    /// How many voxels before the world's origin the axes of axis-aligned grids begin. Cubes of an octree lie at multiples of their
    /// size; in binary this is 101010101, so the origin, about which many scenes lie, is about a third of an edge away from the faces of
    /// cubes of up to 1024 voxels.
    const ASIDE: f64 = 341.0;

    /// The lattice placed by `world_from_lattice`, on the grid that has its point 0 in voxel 0.
    pub fn new(dims: [usize; 3], world_from_lattice: DAffine3) -> Self {
        Self {
            dims,
            world_from_lattice,
            world_from_grid: world_from_lattice,
            first: I64Vec3::ZERO,
        }
    }

    /// The lattice that begins at `first`, a point of whole numbers on the axes of `world_from_axes`.
    fn on_axes(world_from_axes: &DAffine3, first: DVec3, dims: [usize; 3]) -> Self {
        // Nought is added to make −0, which depends on where the lattice begins, 0.
        let anchor = (first / Self::ANCHORS).round() * Self::ANCHORS + 0.0;
        let grid = Self::new(dims, world_from_axes * DAffine3::from_translation(anchor));
        grid.moved((first - anchor).as_i64vec3(), dims)
    }

    /// A lattice on the same grid, from point `first` of this one on.
    pub(super) fn moved(&self, first: I64Vec3, dims: [usize; 3]) -> Self {
        let first = self.first + first;
        Self {
            dims,
            first,
            world_from_lattice: self.world_from_grid * DAffine3::from_translation(first.as_dvec3()),
            ..*self
        }
    }

    /// The lattice of a model: axis-aligned at `spacing_mm` when that is given, else as the module head says. It holds what
    /// soft surfaces add to a model when they are sampled on it.
    ///
    /// # Errors
    /// If the model cannot be flattened, is empty or unbounded, or the spacing impossible.
    pub fn of_model(model: &Model, spacing_mm: Option<f64>) -> Result<Self, TargetError> {
        // How far soft surfaces reach depends on the spacing, which the solids decide.
        let outline = |voxel_mm| Tree::outline(model, &DAffine3::IDENTITY, voxel_mm, None);
        let crisp = outline(0.0)?;
        let voxel_mm = Self::of_tree(&crisp, spacing_mm)?.spacing_mm().max_element();
        let soft = outline(voxel_mm)?;
        let has_volume = soft
            .leaves()
            .iter()
            .any(|leaf| matches!(leaf.source, Source::Volume(_)));
        let spacing_mm = if has_volume { spacing_mm } else { Some(voxel_mm) };
        Ok(Self::of_tree(&soft, spacing_mm)?)
    }

    /// The lattice of a model, flattened in the world: axis-aligned at `spacing_mm` when that is given, else as the module head says.
    ///
    /// # Errors
    /// If the model is empty or unbounded, or the spacing impossible.
    pub(super) fn of_tree(tree: &Tree, spacing_mm: Option<f64>) -> Result<Self, LatticeError> {
        let bounds = finite_bounds(tree)?;
        match (spacing_mm, common_lattice(tree)) {
            (Some(spacing), _) => Self::axis_aligned(&bounds, spacing),
            (None, Some(volume)) if volume.serves(tree) => match tree.bounds_in(&volume.world_from_index) {
                // Boxes are tighter along the volume's own axes, and there can show that cuts leave nothing.
                wanted if wanted.is_empty() => Err(LatticeError::Empty),
                wanted => volume.filling(&wanted),
            },
            (None, _) => Self::axis_aligned(&bounds, finest_spacing(tree, &bounds)),
        }
    }

    /// An axis-aligned lattice of isotropic spacing over `bounds` and one voxel round them. Faces of its cells lie at multiples of
    /// the spacing.
    ///
    /// # Errors
    /// If the spacing is not above 0 or gives too many voxels.
    pub fn axis_aligned(bounds: &Aabb, spacing_mm: f64) -> Result<Self, LatticeError> {
        Self::with_point(bounds, spacing_mm, 0.5 * spacing_mm)
    }

    /// The like of a model, flattened in the world, with a point of the grid at `point_mm` on every axis.
    ///
    /// # Errors
    /// As [`Self::of_tree`].
    pub(super) fn of_tree_with_point(tree: &Tree, spacing_mm: f64, point_mm: f64) -> Result<Self, LatticeError> {
        Self::with_point(&finite_bounds(tree)?, spacing_mm, point_mm)
    }

    fn with_point(bounds: &Aabb, spacing_mm: f64, point_mm: f64) -> Result<Self, LatticeError> {
        if !(spacing_mm.is_finite() && spacing_mm > 0.0) {
            return Err(LatticeError::Spacing(spacing_mm));
        }
        // Ends in voxels from the first face of the point's cell.
        let [min, max] = [bounds.min, bounds.max].map(|end| (end - point_mm) / spacing_mm + 0.5);
        let low = (min + 1e-6).floor();
        let cells = ((max - 1e-6).ceil() - low).max(DVec3::ONE);
        let voxels = (bounds.size() / spacing_mm).max_element().max(cells.max_element()) + 2.0;
        if voxels > Self::MAX_DIM as f64 || !low.is_finite() {
            return Err(LatticeError::TooFine { voxels, spacing_mm });
        }
        let world_from_axes = DAffine3 {
            matrix3: glam::DMat3::from_diagonal(DVec3::splat(spacing_mm)),
            translation: DVec3::splat(point_mm - Self::ASIDE * spacing_mm),
        };
        // Voxel 0 is the layer before the box.
        let dims = cells.to_array().map(|n| n as usize + 2);
        Ok(Self::on_axes(&world_from_axes, low - 1.0 + Self::ASIDE, dims))
    }

    /// A range that holds every value of `model` on the lattice.
    ///
    /// # Errors
    /// If the model cannot be flattened.
    pub fn value_range(&self, model: &Model) -> Result<Interval, TargetError> {
        let tree = Tree::new(model, &self.world_from_grid)?;
        Ok(super::octree::value_range(&tree, self))
    }

    /// From coordinates of the grid, which models are flattened in, to world millimetres.
    pub fn world_from_grid(&self) -> &DAffine3 {
        &self.world_from_grid
    }

    /// Voxel 0 as a point of the grid.
    pub fn first(&self) -> I64Vec3 {
        self.first
    }

    /// The grid's point at point `p` of the lattice.
    pub fn grid_point(&self, p: DVec3) -> DVec3 {
        p + self.first.as_dvec3()
    }

    /// The grid's box at a box of the lattice.
    pub fn grid_box(&self, bounds: &Aabb) -> Aabb {
        Aabb::new(self.grid_point(bounds.min), self.grid_point(bounds.max))
    }

    /// Whether a voxel that both have lies at the same point of the same grid.
    pub fn shares_grid(&self, other: &Self) -> bool {
        self.world_from_grid == other.world_from_grid
    }

    /// The voxel centres that a picture of `cells` (lattice coordinates) can depend on, as a box of the grid.
    pub(super) fn reach(&self, cells: &Aabb) -> Aabb {
        self.grid_box(&Self::beyond(cells).intersect(&self.centres()))
    }

    /// [`Self::reach`] as if the lattice had no end.
    pub(super) fn endless_reach(&self, cells: &Aabb) -> Aabb {
        self.grid_box(&Self::beyond(cells))
    }

    fn beyond(cells: &Aabb) -> Aabb {
        // From cell faces to voxel centres is half a voxel inwards.
        cells.expand(DVec3::splat(Block::REACH as f64 - 0.5))
    }

    /// Boxes of the grid that hold all cells of one of two lattices on one grid that are not of the other.
    pub(super) fn difference(&self, other: &Self) -> Vec<Aabb> {
        let [ours, theirs] = [self, other].map(|lattice| lattice.grid_box(&lattice.bounds()));
        let slab = |axis: usize, [a, b]: [DVec3; 2]| {
            let mut slab = Aabb::ALL;
            (slab.min[axis], slab.max[axis]) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            (a[axis] != b[axis]).then_some(slab)
        };
        let sides = [[ours.min, theirs.min], [ours.max, theirs.max]];
        let slabs = (0..3).flat_map(|axis| sides.map(|faces| slab(axis, faces)));
        slabs.flatten().collect()
    }

    /// The box of all voxels' cells, in lattice coordinates.
    pub fn bounds(&self) -> Aabb {
        let n = DVec3::from_array(self.dims.map(|n| n as f64));
        Aabb::new(DVec3::splat(-0.5), n - 0.5)
    }

    /// The box of all voxels' centres, in lattice coordinates.
    pub fn centres(&self) -> Aabb {
        let n = DVec3::from_array(self.dims.map(|n| n as f64));
        Aabb::new(DVec3::ZERO, n - 1.0)
    }

    /// The world box of all voxels' cells.
    pub fn world_bounds(&self) -> Aabb {
        self.bounds().transformed(&self.world_from_lattice)
    }

    /// Distance between neighbouring voxels along each lattice axis, millimetres.
    pub fn spacing_mm(&self) -> DVec3 {
        affine::spacing(&self.world_from_lattice)
    }

    /// The part of it that holds `bounds`, in lattice coordinates, and a voxel round them; `None` where that has no voxel.
    pub fn part(&self, bounds: &Aabb) -> Option<Self> {
        let inside = bounds.expand(DVec3::ONE).intersect(&self.centres());
        if inside.is_empty() {
            return None;
        }
        let (first, last) = (inside.min.floor(), inside.max.ceil());
        let dims = (last - first + 1.0).to_array().map(|n| n as usize);
        Some(self.moved(first.as_i64vec3(), dims))
    }

    /// Voxels in all.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// Whether it has no voxel; never, for a lattice made here.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The box of a model that is flattened in the world.
fn finite_bounds(tree: &Tree) -> Result<Aabb, LatticeError> {
    let bounds = tree.bounds_in(&DAffine3::IDENTITY);
    if bounds.is_empty() {
        Err(LatticeError::Empty)
    } else if bounds.is_finite() {
        Ok(bounds)
    } else {
        Err(LatticeError::Unbounded)
    }
}

/// The lattice of a volume leaf in the world.
struct VolumeLattice {
    bounds: Aabb,
    world_from_index: DAffine3,
}

/// The lattice that all volume leaves share, if there is one.
fn common_lattice(tree: &Tree) -> Option<VolumeLattice> {
    let mut volumes = tree
        .leaves()
        .iter()
        .filter(|leaf| matches!(leaf.source, Source::Volume(_)));
    let first = volumes.next()?;
    let same = |leaf: &crate::model::Leaf| leaf.local_from_frame.abs_diff_eq(first.local_from_frame, 1e-9);
    volumes.all(same).then(|| VolumeLattice {
        bounds: first.local_bounds,
        world_from_index: first.local_from_frame.inverse(),
    })
}

impl VolumeLattice {
    fn serves(&self, tree: &Tree) -> bool {
        let spacing = affine::spacing(&self.world_from_index);
        let alone = tree.leaves().len() == 1;
        alone || spacing.max_element() <= Lattice::MAX_ANISOTROPY * spacing.min_element()
    }

    /// This lattice extended or cropped to `wanted`, a box of its index space.
    fn filling(&self, wanted: &Aabb) -> Result<Lattice, LatticeError> {
        let beyond = |face: f64, own: f64| if (face - own).abs() < 1e-6 { 0.0 } else { 1.0 };
        let mut first = DVec3::ZERO;
        let mut dims = [0; 3];
        for axis in 0..3 {
            let own = (self.bounds.min[axis], self.bounds.max[axis]);
            let (min, max) = if self.within(wanted, axis) {
                (wanted.min[axis].max(own.0), wanted.max[axis].min(own.1))
            } else {
                (wanted.min[axis], wanted.max[axis])
            };
            first[axis] = (min + 0.5 + 1e-6).floor() - beyond(min, own.0);
            let last = (max - 0.5 - 1e-6).ceil() + beyond(max, own.1);
            let voxels = last - first[axis] + 1.0;
            if voxels > Lattice::MAX_DIM as f64 {
                let spacing_mm = affine::spacing(&self.world_from_index)[axis];
                return Err(LatticeError::TooFine { voxels, spacing_mm });
            }
            dims[axis] = voxels.max(1.0) as usize;
        }
        Ok(Lattice::on_axes(&self.world_from_index, first, dims))
    }

    /// Whether the wanted box stays within the volume's on `axis`, but for rounding and the slack of a moved box.
    fn within(&self, wanted: &Aabb, axis: usize) -> bool {
        wanted.min[axis] >= self.bounds.min[axis] - 1e-6 && wanted.max[axis] <= self.bounds.max[axis] + 1e-6
    }
}

fn finest_spacing(tree: &Tree, bounds: &Aabb) -> f64 {
    let finest = tree
        .leaves()
        .iter()
        .filter(|leaf| matches!(leaf.source, Source::Volume(_)))
        .map(|leaf| affine::spacing(&leaf.local_from_frame.inverse()).min_element())
        .fold(f64::INFINITY, f64::min);
    if finest.is_finite() {
        finest
    } else {
        bounds.size().max_element() / Lattice::DEFAULT_DIM
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Plane;
    use crate::model::{Model, Node, VolumeLeaf};
    use crate::volume::{Bricks, Grid, Voxels};
    use crate::voxelize::{Primitive, Solid};

    /// A volume of 6 · 5 · 4 voxels, turned and stretched in the world.
    fn oblique() -> Node {
        let world_from_index = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 1.5, 2.0),
            glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7),
            DVec3::new(10.0, -20.0, 30.0),
        );
        let grid = Grid::new([6, 5, 4], world_from_index, Voxels::U8(vec![7; 120])).expect("a grid");
        Node::Volume(VolumeLeaf {
            bricks: Arc::new(Bricks::new(&grid)),
            window: Interval::ALL,
        })
    }

    fn lattice(model: &Model) -> Option<Lattice> {
        Lattice::of_model(model, None).ok()
    }

    #[test]
    fn an_oblique_volume_keeps_its_lattice() {
        let mut model = Model::default();
        model.push(oblique());
        assert_eq!(lattice(&model).map(|l| l.dims), Some([6, 5, 4]));
    }

    #[test]
    fn what_is_cut_away_along_the_volumes_own_axes_is_empty() {
        // In the world the boxes of what both cuts leave overlap: it takes the volume's axes to see that nothing is left.
        let world_from_index = DAffine3::from_mat3_translation(
            glam::DMat3::from_cols(
                DVec3::new(-0.18632472424888102, -0.31891908201174063, 0.33700699734926437),
                DVec3::new(0.6143608386553211, -0.6777132038359971, -0.3016704691074564),
                DVec3::new(0.5434561481132777, 0.2525313889276015, 0.5394439792183232),
            ),
            DVec3::new(-3.5, 6.210821776158894, 0.0),
        );
        let grid = Grid::new([1, 6, 9], world_from_index, Voxels::U8(vec![7; 54])).expect("a grid");
        let mut model = Model::default();
        let mut child = model.push(Node::Volume(VolumeLeaf {
            bricks: Arc::new(Bricks::new(&grid)),
            window: Interval::ALL,
        }));
        let oblique = DVec3::new(0.7852272262745581, -0.37770098700201665, -0.49067317792484505);
        for (normal, offset) in [(DVec3::X, 0.0), (oblique, 5.854400364729085)] {
            let plane = Plane { normal, offset };
            child = model.push(Node::Cut { child, plane });
        }
        let tree = Tree::new(&model, &DAffine3::IDENTITY).expect("a tree");
        assert!(
            !tree.bounds_in(&DAffine3::IDENTITY).is_empty(),
            "boxes that tell in the world"
        );
        let lattice = Lattice::of_model(&model, None);
        assert!(
            matches!(lattice, Err(TargetError::Lattice(LatticeError::Empty))),
            "{lattice:?}"
        );
    }

    #[test]
    fn a_turned_volume_keeps_its_lattice() {
        let mut model = Model::default();
        let child = model.push(oblique());
        let parent_from_child = DAffine3::from_rotation_y(0.4);
        model.push(Node::Transform {
            child,
            parent_from_child,
        });
        assert_eq!(lattice(&model).map(|l| l.dims), Some([6, 5, 4]));
    }

    #[test]
    fn a_moved_half_space_bounds_too() {
        let mut model = Model::default();
        let across = |axis: DVec3| Plane::through(DVec3::ZERO, axis).expect("a plane");
        let sides = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z].map(|axis| {
            let solid = Solid::HalfSpace(across(axis));
            let child = model.push(Node::Primitive(Primitive::crisp(solid, 1.0)));
            let parent_from_child = DAffine3::from_translation(5.0 * axis);
            model.push(Node::Transform {
                child,
                parent_from_child,
            })
        });
        let (op, rule, family) = (
            crate::model::BooleanOp::Intersection,
            Default::default(),
            Default::default(),
        );
        model.fold(op, rule, family, sides);
        let bounds = lattice(&model).expect("a bounded model").world_bounds();
        assert!(
            (bounds.size() - DVec3::splat(10.0)).abs().max_element() < 0.2,
            "{bounds:?}"
        );
    }

    #[test]
    fn the_grid_does_not_depend_on_the_box() {
        let on = |bounds: Aabb| Lattice::axis_aligned(&bounds, 0.3).expect("a lattice");
        let near = on(Aabb::new(DVec3::new(-7.0, 2.0, -0.1), DVec3::new(5.0, 9.0, 0.4)));
        let far = on(Aabb::new(DVec3::splat(40.0), DVec3::new(77.7, 50.0, 60.0)));
        assert!(near.shares_grid(&far) && near.first() != far.first());
        // A face of a cell at a multiple of the spacing; one empty voxel round the box.
        for lattice in [near, far] {
            let corner = lattice.world_bounds().min / 0.3;
            assert!((corner - corner.round()).abs().max_element() < 1e-9, "{corner}");
        }
        assert_eq!(near.first().to_array(), [-25, 5, -2].map(|n| n + 341));
        assert_eq!(near.dims, [43, 26, 5]);
        assert!(!near.shares_grid(&Lattice::axis_aligned(&near.world_bounds(), 0.31).expect("a lattice")));
    }

    #[test]
    fn what_is_far_off_has_a_grid_nearby() {
        for far in [1e9, 1e12, -1e15] {
            let bounds = Aabb::new(DVec3::splat(far), DVec3::splat(far + 64.0));
            let lattice = Lattice::axis_aligned(&bounds, 1.0).expect("a lattice");
            assert!(lattice.first().abs().max_element() <= 1 << 19, "{:?}", lattice.first());
            let bounds_error = lattice.world_bounds().min - (far - 1.0);
            assert!(bounds_error.abs().max_element() < 1e-15 * far.abs(), "{bounds_error}");
        }
    }

    #[test]
    fn only_cells_of_one_of_two_lattices_lie_in_their_difference() {
        let on = |min, max| Lattice::axis_aligned(&Aabb::new(min, max), 1.0).expect("a lattice");
        let one = on(DVec3::ZERO, DVec3::splat(9.0));
        assert!(one.difference(&one).is_empty());
        let other = on(DVec3::new(-3.0, 0.0, 1.0), DVec3::new(9.0, 12.0, 9.0));
        let within = |lattice: &Lattice, p: DVec3| lattice.grid_box(&lattice.bounds()).contains(p);
        let boxes = one.difference(&other);
        for n in 0..8000 {
            let p = DVec3::from([n % 20, n / 20 % 20, n / 400].map(|i| f64::from(i) - 5.0));
            let told = boxes.iter().any(|b| b.contains(p));
            assert!(told || within(&one, p) == within(&other, p), "{p}");
        }
        assert_eq!(boxes.len(), 3);
    }
}
