//! The topology of a trilinear level set by subdivision in whole numbers, without its saddles.
//!
//! A box that the level set meets is halved until the interpolant rises or falls strictly along one axis and no face has
//! alternating signs. Then the level set in it is a disc: seen along that axis it is the face without the inside of one end and
//! the outside of the other, which are apart, and each in one piece on the rim since neither end alternates. Where a box is
//! halved, χ(whole) = χ(one half) + χ(other half) − χ(level set in the section), and the section's level set is arcs, one for two
//! sign changes around the section, however they are paired. Discs are of one component where the level set crosses the rectangle
//! that their boxes share; its extremes there are at corners.
//!
//! An axis is halved at most [`DEPTH`] times. Values of at most 2¹⁹ in size, weighted with three factors of at most 2^DEPTH, stay
//! below 2⁶¹, so that all arithmetic is exact in `i64`. A level set that is not resolved then comes within about 2^−DEPTH of a
//! saddle of the interpolant or of one of its sections; it is discarded, and counted.

use std::ops::Range;

use crate::weld::{Groups, Shape, lower_corner};

/// How often an axis may be halved.
const DEPTH: u32 = 14;

/// The level set in one cell.
pub struct Truth {
    pub shape: Shape,
    /// For each edge that the level set crosses, which component does; unspecified names.
    pub component_of_edge: [Option<usize>; 12],
}

/// Two opposite corners in units of 2^−DEPTH.
type Bounds = [[i64; 3]; 2];

/// A cell, the boxes of the discs found in it, and which of them hang together.
struct Division<'a> {
    corners: &'a [i64; 8],
    discs: Vec<Bounds>,
    joined: Vec<[usize; 2]>,
}

impl Truth {
    /// The truth for corner values of at most 2¹⁹ in size, zero counting as inside; `None` if it is not resolved.
    pub fn of(corners: &[i64; 8]) -> Option<Self> {
        let mut division = Division {
            corners,
            discs: vec![],
            joined: vec![],
        };
        let euler = division.euler([[0; 3], [1 << DEPTH; 3]])?;
        let names = division.components();
        let component_of_edge = std::array::from_fn(|edge| division.crossing_disc(edge).map(|disc| names[disc]));
        let components = (0..names.len()).filter(|&disc| names[disc] == disc).count();
        Some(Self {
            shape: Shape { euler, components },
            component_of_edge,
        })
    }
}

impl Division<'_> {
    /// The interpolant times 2^(3·DEPTH).
    fn value(&self, at: [i64; 3]) -> i64 {
        let mix = |a: i64, b: i64, t: i64| a * ((1 << DEPTH) - t) + b * t;
        let face: [i64; 4] = std::array::from_fn(|c| mix(self.corners[c], self.corners[c + 4], at[2]));
        mix(mix(face[0], face[2], at[1]), mix(face[1], face[3], at[1]), at[0])
    }

    /// The values at the corners of a box, or of a rectangle if it is flat.
    fn part(&self, bounds: Bounds) -> [i64; 8] {
        std::array::from_fn(|c| self.value([0, 1, 2].map(|axis| bounds[c >> axis & 1][axis])))
    }

    /// The Euler characteristic in a box, whose discs are added; `None` if it is not resolved.
    fn euler(&mut self, bounds: Bounds) -> Option<i64> {
        let part = self.part(bounds);
        if !is_met(&part) {
            return Some(0);
        }
        if is_disc(&part) {
            self.discs.push(bounds);
            return Some(1);
        }
        let axis = (0..3).max_by_key(|&axis| bounds[1][axis] - bounds[0][axis])?;
        let middle = (bounds[0][axis] + bounds[1][axis]) / 2;
        (middle > bounds[0][axis]).then_some(())?;
        let [mut lower, mut upper] = [bounds; 2];
        lower[1][axis] = middle;
        upper[0][axis] = middle;
        let section = self.part([upper[0], lower[1]]);
        let first = self.discs.len();
        let of_lower = self.euler(lower)?;
        let second = self.discs.len();
        let of_upper = self.euler(upper)?;
        self.join(axis, middle, [first..second, second..self.discs.len()]);
        Some(of_lower + of_upper - arcs(&section, axis))
    }

    /// Joins discs on both sides of a section that meet in it.
    fn join(&mut self, axis: usize, middle: i64, sides: [Range<usize>; 2]) {
        let touching = |side: usize| {
            let discs = sides[side].clone();
            let touching = discs.filter(|&disc| self.discs[disc][1 - side][axis] == middle);
            touching.collect::<Vec<_>>()
        };
        let [lower, upper] = [touching(0), touching(1)];
        let pairs = lower.iter().flat_map(|&a| upper.iter().map(move |&b| [a, b]));
        let meet = |pair: &[usize; 2]| {
            let face = overlap(&self.discs[pair[0]], &self.discs[pair[1]]);
            (0..3).all(|k| k == axis || face[0][k] < face[1][k]) && is_met(&self.part(face))
        };
        let met: Vec<_> = pairs.filter(meet).collect();
        self.joined.extend(met);
    }

    /// For each disc, one disc of its component.
    fn components(&self) -> Vec<usize> {
        let mut groups = Groups::new(self.discs.len());
        self.joined.iter().for_each(|&[a, b]| groups.join(a, b));
        (0..self.discs.len()).map(|disc| groups.root(disc)).collect()
    }

    /// The disc that crosses an edge of the cell.
    fn crossing_disc(&self, edge: usize) -> Option<usize> {
        let lower = lower_corner(edge);
        let ends = [lower, lower | 1 << (edge / 4)];
        let ends = ends.map(|c| [0, 1, 2].map(|axis| ((c >> axis & 1) as i64) << DEPTH));
        self.discs.iter().position(|disc| {
            let piece = overlap(disc, &ends);
            (0..3).all(|axis| piece[0][axis] <= piece[1][axis]) && is_met(&self.part(piece))
        })
    }
}

fn overlap(a: &Bounds, b: &Bounds) -> Bounds {
    let ends = |axis: usize| [a[0][axis].max(b[0][axis]), a[1][axis].min(b[1][axis])];
    [0, 1].map(|end| [0, 1, 2].map(|axis| ends(axis)[end]))
}

/// Whether both signs are there.
fn is_met(part: &[i64; 8]) -> bool {
    part.iter().any(|&v| v >= 0) && part.iter().any(|&v| v < 0)
}

/// Corners around the lower (0) or upper (1) face across an axis.
fn around(part: &[i64; 8], axis: usize, side: usize) -> [bool; 4] {
    let [u, v] = [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
    [0, u, u | v, v].map(|c| part[c | side << axis] >= 0)
}

/// The number of arcs in a box that is flat along an axis.
fn arcs(section: &[i64; 8], axis: usize) -> i64 {
    let around = around(section, axis, 0);
    (0..4).filter(|&k| around[k] != around[(k + 1) % 4]).count() as i64 / 2
}

/// Whether the level set in a box that it meets is certainly a disc.
fn is_disc(part: &[i64; 8]) -> bool {
    let alternates = |axis, side| {
        let [a, b, c, d] = around(part, axis, side);
        a == c && b == d && a != b
    };
    let is_monotone = |axis: usize| {
        let steps = (0..8)
            .filter(|c| c >> axis & 1 == 0)
            .map(|c| part[c | 1 << axis] - part[c]);
        steps.map(i64::signum).sum::<i64>().abs() == 4
    };
    !(0..3).any(|axis| alternates(axis, 0) || alternates(axis, 1)) && (0..3).any(is_monotone)
}
