//! The tube: where a tunnel runs through a cell, its surface connects two contours.
//!
//! *Theory.* The sections across an axis are bilinear; their asymptotic decider is a quadratic in the height. A tunnel is there
//! if and only if the decider has two roots in the cell within one run of ambiguous sections: between them two sheets are
//! bridged that are apart both above and below. Arcs of the level set in the section half-way between the roots then connect
//! points of two contours, and of no cell without a tunnel, whose contours all bound discs. At each root the section's level set
//! is a pair of crossing lines; with the other axes' these lines form a closed hexagon on the level set around the tunnel (Grosso
//! 2016), six corners of the box that the roots span. Every second corner's two lines run on to one contour, on the three faces
//! at one corner of the cell, those of the others to the other contour on the opposite faces.
//! *Practice.* The hexagon's corners are the tube's interior vertices. Each belongs to the contour that its lines run on to, and
//! fans out to the contour's vertices between the two segments that the lines meet; six triangles within the hexagon join both
//! sides. Nothing is measured, so the triangles cannot come out tangled in a flat cell.

use super::CellTriangles;
use super::contour::Contours;
use super::section::{Section, saddle_heights};

/// The axis across which sections are examined. Every axis sees a tunnel.
const AXIS: u8 = 2;

/// A tube between two contours.
pub(super) struct Tube {
    ends: [End; 2],
}

/// One side of the hexagon, and the contour that it runs on to.
struct End {
    /// The contour's label.
    label: u8,
    /// The hexagon's corners on this side, by the axis of the section through each that has its saddle there.
    ring: [[f64; 3]; 3],
    /// The first edge of the contour segment that the ring's lines along each axis meet.
    meets: [u8; 3],
    /// The axes in the order in which the contour comes to those segments.
    order: [usize; 3],
}

impl Tube {
    /// The tube through a cell, if there is one.
    pub fn find(values: &[f64; 8], contours: &Contours) -> Option<Self> {
        let [lower, upper] = saddle_heights(values, AXIS)?;
        let between = Section::new(values, AXIS, 0.5 * (lower + upper));
        if !between.is_ambiguous() {
            return None;
        }
        let [a, b] = between.arc().map(|side| contours.label[between.edge_on(side) as usize]);
        (a != b).then_some(())?;
        let [p, q] = [lower, upper].map(|height| Section::new(values, AXIS, height).saddle());
        let near = [p[0], p[1], upper];
        let far = [q[0], q[1], lower];
        let ends = [End::new(values, contours, near, far)?, End::new(values, contours, far, near)?];
        let opposed = ends[0].label != ends[1].label && ends[0].order[1] != ends[1].order[1];
        opposed.then_some(Self { ends })
    }

    /// Whether a contour bounds the tube.
    pub fn bounds(&self, label: u8) -> bool {
        self.ends.iter().any(|end| end.label == label)
    }

    /// Adds the tube's triangles.
    pub fn triangulate(&self, contours: &Contours, out: &mut CellTriangles) {
        let rings = [0, 1].map(|side: usize| self.ends[side].ring.map(|at| out.add_vertex(at)));
        self.ends[0].triangulate(contours, rings[0], rings[1], out);
        self.ends[1].triangulate(contours, rings[1], rings[0], out);
    }
}

impl End {
    /// The end at `near`, a corner of the roots' box off the hexagon; `far` is the opposite corner.
    fn new(values: &[f64; 8], contours: &Contours, near: [f64; 3], far: [f64; 3]) -> Option<Self> {
        let ring = [0, 1, 2].map(|axis| {
            let mut at = near;
            at[axis] = far[axis];
            at
        });
        let [x, y, z] = [0, 1, 2].map(|axis| segment_beside(values, contours, near, far, axis));
        let meets = [x?, y?, z?];
        Some(Self {
            label: contours.label[meets[0] as usize],
            ring,
            meets,
            order: order_along(contours, meets)?,
        })
    }

    /// Adds the band from the contour to the corners `mine`, and the triangles of the hexagon beside it, which reach to `theirs`.
    ///
    /// Between the segments that two axes' lines meet, the contour belongs to the corner of the third axis.
    fn triangulate(&self, contours: &Contours, mine: [u8; 3], theirs: [u8; 3], out: &mut CellTriangles) {
        let mut passed = 0;
        for edge in contours.walk(self.meets[self.order[0]]) {
            let next = contours.next[edge as usize];
            let [axis, before, after] = [0, 1, 2].map(|n| self.order[(passed + n) % 3]);
            out.add([edge, next, mine[before]]);
            if edge == self.meets[axis] {
                out.add([mine[before], next, mine[after]]);
                out.add([mine[before], mine[after], theirs[axis]]);
                passed += 1;
            }
        }
    }
}

/// The first edge of the contour segment that the lines along `axis` meet on the face on the side of `near`.
fn segment_beside(values: &[f64; 8], contours: &Contours, near: [f64; 3], far: [f64; 3], axis: usize) -> Option<u8> {
    let along = (axis + 1) % 3;
    let section = Section::new(values, along as u8, 0.5 * (near[along] + far[along]));
    let side = u8::from(near[axis] > far[axis]);
    let end = section.edge_on(section.side(axis as u8, side));
    let face = 2 * axis as u8 + side;
    let mut on_face = (0..12).filter(|&edge| contours.face[edge as usize] == face);
    on_face.find(|&edge| edge == end || contours.next[edge as usize] == end)
}

/// The axes in the order in which a contour comes to three of its segments; `None` if they are not on one.
fn order_along(contours: &Contours, meets: [u8; 3]) -> Option<[usize; 3]> {
    let walk = contours.walk(meets[0]);
    let mut axes = walk.filter_map(|edge| meets.iter().position(|&met| met == edge));
    Some([axes.next()?, axes.next()?, axes.next()?])
}
