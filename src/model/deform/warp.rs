//! A morph in a tree's frame: from where things are seen to where they were.
//!
//! *Theory.* With M the map from the node's own frame to the tree's, M φ M⁻¹ maps the tree's frame to itself, so what lies below
//! the deformation keeps its maps. Errors and boxes are in the tree's units: voxels, if the frame is a lattice.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::bound::{Local, norm};
use super::invert::Preimage;
use super::morph::Morph;
use super::table::Table;
use crate::math::{Aabb, affine};

/// A deformation of a tree.
#[derive(Clone, Debug)]
pub struct Warp {
    /// The deformation, above this one in the tree, that points have been taken through before.
    pub outer: Option<u32>,
    /// How many deformations a point has been taken through with this one.
    pub nesting: usize,
    /// In the tree's frame, where what is deformed may be, before.
    pub source: Aabb,
    /// In the tree's frame, where it may be after.
    pub domain: Aabb,
    pub frame: Frame,
    /// φ⁻¹ by cells; empty until it is made.
    pub table: Arc<Table>,
}

/// A morph, and how its millimetres lie in the tree's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub morph: Arc<Morph>,
    pub node_from_frame: DAffine3,
    pub frame_from_node: DAffine3,
    /// The edge of the smallest cells of the table, in the frame's units.
    pub step: f64,
    /// A point of the frame, in steps, where cells of all sizes have a corner.
    pub anchor: DVec3,
    /// A voxel in the frame's units.
    pub voxel: f64,
    /// What interpolation may be off by, in voxels.
    pub error_voxels: f64,
}

/// Why a deformation cannot be tabulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WarpError {
    /// What is deformed is endless.
    #[error("what is deformed is endless: intersect it with a volume, a box or a sphere inside the deformation")]
    Endless,
    /// The search for a preimage stopped within what is deformed.
    #[error(
        "a deformation cannot be undone near {:.2} {:.2} {:.2} mm (before it), at landmark {nearest}: the map nearly \
         folds there; move that landmark less or raise the stiffness",
        .place_mm.x, .place_mm.y, .place_mm.z
    )]
    NoInverse {
        /// Where the search stopped, before the deformation.
        place_mm: DVec3,
        /// The landmark nearest to it.
        nearest: String,
    },
    /// Too many cells.
    #[error(
        "a deformation needs more than {} cells to be within its error; allow a larger `error`, or use a larger spacing",
        Table::MAX_CELLS
    )]
    TooManyCells,
    /// Deformations in deformations.
    #[error("deformations are nested more than {} deep", Warp::MAX_NESTED)]
    Nested,
}

/// What a table of φ⁻¹ came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WarpReport {
    /// Cells.
    pub cells: usize,
    /// The largest error in voxels, measured in the middle of each cell.
    pub measured_voxels: f64,
}

impl Warp {
    /// The deepest nesting of deformations.
    pub const MAX_NESTED: usize = 16;

    /// A warp without a table.
    pub fn new(outer: Option<u32>, nesting: usize, mut frame: Frame) -> Result<Self, WarpError> {
        if nesting > Self::MAX_NESTED {
            return Err(WarpError::Nested);
        }
        if outer.is_some() {
            // Points that come from another deformation are not at voxels, where smallest cells are exact.
            frame.step *= 0.125;
            frame.anchor *= 8.0;
        }
        Ok(Self {
            outer,
            nesting,
            source: Aabb::EMPTY,
            domain: Aabb::EMPTY,
            frame,
            table: Arc::default(),
        })
    }

    /// States what is deformed, a box of the tree's frame.
    pub fn place(&mut self, source: Aabb) -> Result<(), WarpError> {
        if source.is_empty() {
            return Ok(());
        }
        if !source.is_finite() {
            return Err(WarpError::Endless);
        }
        self.source = source;
        self.domain = self.frame.image_bounds(&source);
        Ok(())
    }

    /// Whether both have the same table, which what they stand in has no part in.
    pub fn is_like(&self, other: &Self) -> bool {
        let places = |warp: &Self| (warp.source, warp.domain);
        places(self) == places(other) && self.frame == other.frame
    }

    /// Makes the table.
    pub fn tabulate(&mut self) -> Result<(), WarpError> {
        self.table = Arc::new(Table::build(&self.frame, &self.source, &self.domain)?);
        Ok(())
    }
}

/// The inverse about one point of the frame.
#[derive(Clone, Copy)]
pub(super) struct Start {
    /// The point of the frame.
    at: DVec3,
    /// Where it was, in the node's frame.
    preimage: Preimage,
}

impl Frame {
    /// `morph` in a frame of which `voxel` units are a voxel. Cells have corners at voxels, and lie alike in the world in all
    /// lattices that are parts of one: wherever those begin, a voxel comes from the same place.
    pub fn new(
        morph: &Arc<Morph>,
        [node_from_frame, world_from_frame]: [&DAffine3; 2],
        voxel: f64,
        error: f64,
    ) -> Self {
        let origin = world_from_frame.inverse().translation / voxel;
        Self {
            morph: Arc::clone(morph),
            node_from_frame: *node_from_frame,
            frame_from_node: node_from_frame.inverse(),
            step: voxel,
            // Lattices are often half a voxel off the origin, or not at all; neither is near to where this jumps.
            anchor: (origin + 0.25).floor(),
            voxel,
            error_voxels: error,
        }
    }

    /// How φ⁻¹ = g bends at `start`: for each axis of the frame its second derivative along it, in voxels. D²g(u, u) is
    /// −J⁻¹ D²φ(J⁻¹u, J⁻¹u).
    pub(super) fn bends(&self, start: &Start) -> DVec3 {
        self.bends_as(start, &Local::new(&self.morph.spline, start.preimage.at, 0.0, 0.0))
    }

    /// [`Self::bends`] by what is known about `start` already: `local`, with no landmark near.
    pub(super) fn bends_as(&self, start: &Start, local: &Local) -> DVec3 {
        let inverse = start.preimage.jacobian.inverse();
        let bends = self.edges(1.0).map(|u| self.voxels(inverse * local.bend(inverse * u)));
        DVec3::from(bends)
    }

    /// Whether the cell of `size` about `start` may hold more than its corners and its middle tell: landmarks whose reach ends are
    /// felt in it, and it is larger than an eighth of that.
    pub(super) fn is_coarse(&self, start: &Start, size: f64) -> bool {
        let edges = self.edges(size);
        let radius = 1.3 * norm(&start.preimage.jacobian.inverse()) * half_diagonal(&edges);
        let felt = self.morph.spline.reach_felt(start.preimage.at, radius);
        edges.iter().any(|u| u.length() > felt / 8.0)
    }

    /// The spline in the cell of `size` about `start`.
    pub(super) fn about(&self, start: &Start, size: f64) -> Local {
        let radius = 1.3 * norm(&start.preimage.jacobian.inverse()) * half_diagonal(&self.edges(size));
        Local::new(&self.morph.spline, start.preimage.at, radius, 1.5 * radius)
    }

    /// What interpolation near a thin plate's landmark errs by, at most and in voxels, in the cell of `size` that the spline is
    /// `local` in; 0 where no landmark is near to it.
    ///
    /// There g has no second derivative. With S the smooth part's Jacobian, S g = P − w r(g) − …, and r(g) changes by at most
    /// the norm K of J⁻¹ a millimetre. Interpolation of what changes by c a millimetre errs by c times the half diagonal. What the
    /// smooth part bends comes on top.
    pub(super) fn error_at_landmarks(&self, local: &Local, size: f64) -> f64 {
        if local.kinks == 0.0 {
            return 0.0;
        }
        let edges = self.edges(size);
        let half_diagonal = half_diagonal(&edges);
        let inverse = local.jacobian.inverse();
        let norm_inverse = norm(&inverse);
        let left = 1.0 - norm_inverse * local.kinks;
        if left.is_nan() || left <= 0.0 {
            return f64::INFINITY;
        }
        let bent: f64 = edges
            .iter()
            .map(|&u| self.voxels(inverse * local.bend(inverse * u)))
            .sum();
        let voxels_per_mm = norm(&self.frame_from_node.matrix3) / self.voxel;
        voxels_per_mm * norm_inverse * norm_inverse / left * half_diagonal * local.kinks + bent / 8.0
    }

    /// The length, in voxels, of a vector of the node's.
    fn voxels(&self, mm: DVec3) -> f64 {
        (self.frame_from_node.matrix3 * mm).length() / self.voxel
    }

    /// The edges of a cell of `size` of the frame, in the node's millimetres.
    fn edges(&self, size: f64) -> [DVec3; 3] {
        let m = &self.node_from_frame.matrix3;
        [m.x_axis * size, m.y_axis * size, m.z_axis * size]
    }

    /// Finds where the frame's point `at` was, from a place nearby; `Err` has where the search stopped, in the node's frame.
    pub(super) fn seek(&self, at: DVec3, near: &Start) -> Result<Start, DVec3> {
        let moved = self.node_from_frame.matrix3 * (at - near.at);
        let guess = near.preimage.at + near.preimage.jacobian.inverse() * moved;
        let target = affine::point(&self.node_from_frame, at);
        let preimage = self.morph.spline.invert(target, guess)?;
        Ok(Start { at, preimage })
    }

    /// Finds where the frame's point `at` was, from no other.
    pub(super) fn seek_afresh(&self, at: DVec3) -> Result<Start, DVec3> {
        let target = affine::point(&self.node_from_frame, at);
        let preimage = self.morph.spline.invert_afresh(target)?;
        Ok(Start { at, preimage })
    }

    /// Where `at` would be in the frame if φ⁻¹ were linear about `start`.
    pub(super) fn extrapolated(&self, at: DVec3, start: &Start) -> DVec3 {
        let moved = self.node_from_frame.matrix3 * (at - start.at);
        let guess = start.preimage.at + start.preimage.jacobian.inverse() * moved;
        affine::point(&self.frame_from_node, guess)
    }

    /// `start` in the frame.
    pub(super) fn place(&self, start: &Start) -> DVec3 {
        affine::point(&self.frame_from_node, start.preimage.at)
    }

    /// A box of the frame that holds what φ makes of the box `source` of it. φ is one to one there, so what bounds the image is
    /// the image of the faces. Each is cut in patches, and in a patch φ is linear but for a bounded rest: half the second
    /// derivative times the radius squared, and each near landmark's weight times the radius.
    pub fn image_bounds(&self, source: &Aabb) -> Aabb {
        const PATCHES: usize = 24;
        let rows = self.frame_from_node.matrix3.transpose();
        let per_mm = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let bounds = patches(source, PATCHES).map(|(middle, half)| {
            let x = affine::point(&self.node_from_frame, middle);
            let mut edges = self.edges(2.0);
            (0..3).for_each(|axis| edges[axis] *= half[axis]);
            let radius = half_diagonal(&edges);
            let local = Local::bounded(&self.morph.spline, x, radius);
            let image = affine::point(&self.frame_from_node, self.morph.spline.point(x));
            let linear = self.frame_from_node.matrix3 * local.jacobian * self.node_from_frame.matrix3;
            let reach = absolute(&linear) * half;
            let rest = 0.5 * local.second * radius * radius + local.kinks * radius;
            Aabb::of_points([image]).expand(reach + per_mm * rest)
        });
        let hull = bounds.fold(Aabb::EMPTY, |hull, patch| hull.hull(&patch));
        // Far more than rounding, far less than a voxel.
        hull.expand(DVec3::splat(
            1e-9 * (1.0 + hull.min.abs().max(hull.max.abs()).max_element()),
        ))
    }
}

/// Half of the longest diagonal of a cell of these edges.
fn half_diagonal(&[a, b, c]: &[DVec3; 3]) -> f64 {
    let longest = [a + b + c, a + b - c, a - b + c, a - b - c].map(DVec3::length_squared);
    0.5 * longest.into_iter().fold(0.0, f64::max).sqrt()
}

fn absolute(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

/// The middles and half sizes of `n`² patches of each face of a box.
fn patches(whole: &Aabb, n: usize) -> impl Iterator<Item = (DVec3, DVec3)> + use<> {
    let (min, size) = (whole.min, whole.size());
    (0..6 * n * n).map(move |i| {
        let (face, u, v) = (i % 6, i / 6 % n, i / (6 * n));
        let axis = face / 2;
        let (across, along) = ((axis + 1) % 3, (axis + 2) % 3);
        let (mut at, mut half) = (DVec3::ZERO, size * (0.5 / n as f64));
        at[axis] = (face % 2) as f64;
        half[axis] = 0.0;
        at[across] = (u as f64 + 0.5) / n as f64;
        at[along] = (v as f64 + 0.5) / n as f64;
        (min + size * at, half)
    })
}
