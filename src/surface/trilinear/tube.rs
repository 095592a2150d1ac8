//! The tube: where a tunnel runs through a cell, its surface connects two contours.
//!
//! *Theory.* The sections across an axis are bilinear; their asymptotic decider is a quadratic in the height. A tunnel is there
//! if and only if the decider has two roots in the cell within one run of ambiguous sections: between the roots two sheets are
//! bridged that are apart both above and below. Half-way between, arcs of the level set then connect points of two contours; in a
//! cell without a tunnel they never do, for there all contours bound discs. At each root the section's level set is a pair of
//! crossing lines, and those of all three axes form a closed hexagon on the level set around the tunnel (Grosso 2016): six corners
//! of the box that the roots span. The two lines through every second corner run on to one contour, on the three faces at a corner
//! of the cell; those through the others to the other contour, on the opposite faces.
//! *Practice.* The hexagon's corners are the tube's interior vertices. Each fans out to the vertices of its contour between the
//! two segments that its lines meet; six triangles within the hexagon join both sides. Which vertices belong together is read
//! from signs, not from distances, so that the tube is in order even where it is infinitely thin.

use super::contour::Contours;
use super::section::{Saddles, Section};
use super::triangles::CellTriangles;

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
    /// The hexagon's corners on this side, by the axis of the section that has its saddle there.
    ring: [[f64; 3]; 3],
    /// The first edge of the contour segment that the lines along each axis meet.
    meets: [u8; 3],
    /// The axes in the order in which the contour comes to those segments.
    order: [usize; 3],
}

impl Tube {
    /// The tube through a cell, if there is one.
    pub fn find(values: &[f64; 8], contours: &Contours) -> Option<Self> {
        if contours.firsts().len() < 2 {
            return None;
        }
        let section = Section::at_extreme(values, AXIS).filter(Section::is_ambiguous)?;
        let column = section.bridged();
        let label = |axis, side| contours.label[section.edge_on(section.side(axis, side)) as usize];
        // The two sides of a column that an arc cuts off.
        if label(1, 0) == label(0, 1 - column) {
            return None;
        }
        let saddles = Saddles::new(values, AXIS);
        let corner = [column, 0, u8::from((column == 0) == saddles.rises())];
        let heights = section.saddle_heights();
        let box_corner = |upper: u8| {
            let [x, y] = saddles.at(heights[1 - upper as usize]);
            [x, y, heights[upper as usize]]
        };
        let [near, far] = [corner[2], 1 - corner[2]].map(box_corner);
        let opposite = corner.map(|side| 1 - side);
        let ends = [
            End::new(values, contours, corner, [near, far])?,
            End::new(values, contours, opposite, [far, near])?,
        ];
        // Rounding may leave nothing that fits together; the contours then keep their discs.
        let are_opposed = ends[0].label != ends[1].label && ends[0].order[1] != ends[1].order[1];
        are_opposed.then_some(Self { ends })
    }

    /// Whether a contour bounds the tube.
    pub fn bounds(&self, label: u8) -> bool {
        self.ends.iter().any(|end| end.label == label)
    }

    /// Adds the tube's triangles.
    pub fn triangulate(&self, contours: &Contours, out: &mut CellTriangles) {
        let [a, b] = &self.ends;
        let [ring_a, ring_b] = [a, b].map(|end| end.ring.map(|at| out.add_vertex(at)));
        a.triangulate(contours, ring_a, ring_b, out);
        b.triangulate(contours, ring_b, ring_a, out);
    }
}

impl End {
    /// The end around a corner of the cell; `near` and `far` are the box's corners that are not the hexagon's.
    fn new(values: &[f64; 8], contours: &Contours, corner: [u8; 3], [near, far]: [[f64; 3]; 2]) -> Option<Self> {
        let ring = [0, 1, 2].map(|axis| {
            let mut at = near;
            at[axis] = far[axis];
            at
        });
        let [x, y, z] = [0, 1, 2].map(|axis| segment_met(values, contours, axis, corner[axis as usize]));
        let meets = [x?, y?, z?];
        let label = contours.label[meets[0] as usize];
        let order = order_along(contours, meets)?;
        Some(Self {
            label,
            ring,
            meets,
            order,
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

/// The first edge of the contour segment that the hexagon's lines along `axis` meet on the lower (0) or upper (1) face.
fn segment_met(values: &[f64; 8], contours: &Contours, axis: u8, side: u8) -> Option<u8> {
    let section = Section::at_extreme(values, (axis + 1) % 3)?;
    let end = section.edge_on(section.side(axis, side));
    let mut on_face = (0..12).filter(|&edge| contours.face[edge as usize] == 2 * axis + side);
    on_face.find(|&edge| edge == end || contours.next[edge as usize] == end)
}

/// The axes in the order in which a contour comes to three of its segments; `None` if they are not on one.
fn order_along(contours: &Contours, meets: [u8; 3]) -> Option<[usize; 3]> {
    let walk = contours.walk(meets[0]);
    let mut axes = walk.filter_map(|edge| meets.iter().position(|&met| met == edge));
    Some([axes.next()?, axes.next()?, axes.next()?])
}
