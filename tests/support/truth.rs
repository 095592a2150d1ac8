//! A second evaluation of a model, in world millimetres and double precision, straight from the definitions (VCSG §2.1–2.3).
//!
//! Each value carries a bound on how far the tree's single-precision value may be from it, worked out alongside. With ε =
//! `f32::EPSILON` a rounded operation errs by ε/2 of its result; an operation on values in error adds the error times its
//! largest slope. Points within [`NEAR`] of a boundary, and values within their bound of a window's end, are undecided.

use glam::DVec3;
use vcsg::math::{Aabb, Interval};
use vcsg::model::{Admitted, BooleanOp, Combine, Lut, MaskLeaf, Model, Node, NodeId, ValueMap, ValueRule, VolumeLeaf};
use vcsg::volume::Bricks;
use vcsg::voxelize::Solid;

/// How far a leaf's own coordinates in the tree may be from these, in its units. The tree snaps a map's entries by up to
/// 1e-9: for lattice coordinates up to 64 that is 1e-9·(1 + 3·64) < 2e-7. The sampler rounds to 2⁻²⁴ voxel, 6e-8. Double
/// precision's own rounding is 1e-13 here.
const NEAR: f64 = 3e-7;

const EPSILON: f64 = f32::EPSILON as f64;

/// A value, and how far the tree's may be from it.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    pub value: f64,
    pub error: f64,
}

/// What is at a point: a value or nothing. `Err` when the point is too near a boundary to tell.
pub type Truth = Result<Option<Bounded>, Undecided>;

/// A point too near a boundary.
#[derive(Clone, Copy, Debug)]
pub struct Undecided;

/// The node `id` of `model` at `p`, a point of the node's parent's frame.
pub fn sample(model: &Model, id: NodeId, p: DVec3) -> Truth {
    match model.node(id) {
        Node::Volume(leaf) => volume(leaf, leaf.bricks.world_from_index().inverse().transform_point3(p)),
        Node::Mask(leaf) => mask(leaf, leaf.bricks.world_from_index().inverse().transform_point3(p)),
        Node::Primitive(crisp) => Ok(side(depth_within(&crisp.solid, p))?.then_some(Bounded {
            value: f64::from(crisp.value),
            error: 0.0,
        })),
        Node::Transform {
            child,
            parent_from_child,
        } => sample(model, *child, parent_from_child.inverse().transform_point3(p)),
        // Held against the spline itself by the test `deformation`.
        Node::Deform { .. } => Err(Undecided),
        Node::Transfer { child, map } => Ok(sample(model, *child, p)?.map(|v| mapped(map, v))),
        // No opacity is a value of a definition.
        Node::Classify { .. } => Err(Undecided),
        Node::Cut { child, plane } => {
            let kept = side(-(plane.normal.dot(p) + plane.offset))?;
            Ok(sample(model, *child, p)?.filter(|_| kept))
        }
        Node::Combine(c) => {
            let (first, second) = (sample(model, c.first, p)?, sample(model, c.second, p)?);
            Ok(combined(c, first, second))
        }
    }
}

/// Whether a point that lies `depth` within something is inside it.
fn side(depth: f64) -> Result<bool, Undecided> {
    // Along a diagonal a point may be off by √3 of what it is along each axis.
    if depth.abs() <= 2.0 * NEAR {
        return Err(Undecided);
    }
    Ok(depth > 0.0)
}

fn depth_within(solid: &Solid, p: DVec3) -> f64 {
    match solid {
        Solid::Sphere { center, radius } => radius - p.distance(*center),
        Solid::Box(b) => depth_in_box(b, p),
        Solid::HalfSpace(plane) => -(plane.normal.dot(p) + plane.offset),
        other => -other.distance(p),
    }
}

fn depth_in_box(b: &Aabb, p: DVec3) -> f64 {
    (p - b.min).min(b.max - p).min_element()
}

fn volume(leaf: &VolumeLeaf, p: DVec3) -> Truth {
    let bricks = &leaf.bricks;
    if !side(depth_in_box(&bricks.index_bounds(), p))? {
        return Ok(None);
    }
    if bricks.has_missing() && (p - p.round()).abs().min_element() <= NEAR {
        return Err(Undecided);
    }
    let Some(v) = trilinear(bricks, p) else {
        return Ok(None);
    };
    let Interval { lo, hi } = leaf.window;
    let margins = [v.value - f64::from(lo), f64::from(hi) - v.value];
    if margins.iter().any(|m| m.abs() <= v.error) {
        return Err(Undecided);
    }
    Ok(margins.iter().all(|&m| m > 0.0).then_some(v))
}

/// What the voxel says whose cell holds the point.
fn mask(leaf: &MaskLeaf, p: DVec3) -> Truth {
    let bricks = &leaf.bricks;
    if !side(depth_in_box(&bricks.index_bounds(), p))? {
        return Ok(None);
    }
    let nearest = p.round();
    if ((p - nearest).abs().max_element() - 0.5).abs() <= NEAR {
        return Err(Undecided);
    }
    let [i, j, k] = nearest.to_array().map(|n| n as usize);
    let voxel = bricks.voxel(i, j, k);
    let inside = match leaf.admitted {
        Admitted::NotZero => voxel != 0.0 && !voxel.is_nan(),
        Admitted::Within(Interval { lo, hi }) => lo <= voxel && voxel <= hi,
    };
    Ok(inside.then_some(Bounded {
        value: f64::from(leaf.value),
        error: 0.0,
    }))
}

/// The trilinear interpolation at index-space point `p`; `None` next to a missing voxel.
fn trilinear(bricks: &Bricks, p: DVec3) -> Option<Bounded> {
    let last = DVec3::from(bricks.dims().map(|n| (n - 1) as f64));
    let p = p.clamp(DVec3::ZERO, last);
    let (base, t) = (p.floor(), p - p.floor());
    let corners = (0..8).map(|n| {
        let up = DVec3::from([1, 2, 4].map(|bit| f64::from(u8::from(n & bit != 0))));
        let [i, j, k] = (base + up).min(last).to_array().map(|c| c as usize);
        let weights = up * t + (1.0 - up) * (1.0 - t);
        (f64::from(bricks.voxel(i, j, k)), weights.element_product())
    });
    let (mut value, mut lo, mut hi) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (v, weight) in corners {
        value += v * weight;
        (lo, hi) = (lo.min(v), hi.max(v));
    }
    // Three nested interpolations round by 5ε of the largest voxel; along each axis the slope is at most the voxels' spread,
    // or, where the tree's point falls into the next cell, that of all voxels.
    let all = bricks.value_range();
    let largest = f64::from(all.lo.abs().max(all.hi.abs()));
    let error = 5.0 * EPSILON * largest + 3.0 * NEAR * f64::from(all.width());
    (!value.is_nan()).then_some(Bounded { value, error })
}

fn mapped(map: &ValueMap, v: Bounded) -> Bounded {
    let (x, e) = (v.value, v.error);
    match map {
        ValueMap::Linear { scale, offset } => {
            let (s, o) = (f64::from(*scale), f64::from(*offset));
            Bounded {
                value: s * x + o,
                error: s.abs() * e + EPSILON * ((s * x).abs() + s.abs() * e + o.abs()),
            }
        }
        ValueMap::Quadratic { a, b, c } => {
            let [a, b, c] = [*a, *b, *c].map(f64::from);
            let reach = x.abs() + e;
            let slope = 2.0 * a.abs() * reach + b.abs();
            // Four roundings, each of at most the sum of all terms.
            let terms = a.abs() * reach * reach + b.abs() * reach + c.abs();
            Bounded {
                value: (a * x + b) * x + c,
                error: slope * e + 3.0 * EPSILON * terms,
            }
        }
        ValueMap::Table(points) => Bounded {
            value: looked_up(points, x),
            // The interpolation subtracts, divides, multiplies and adds; `v − a` of a rounded `v` is exact or errs by ε of it.
            error: steepest(points) * (e + EPSILON * x.abs()) + 4.0 * EPSILON * extent(points, x),
        },
    }
}

fn looked_up(points: &[(f32, f32)], x: f64) -> f64 {
    let points: Vec<(f64, f64)> = points.iter().map(|p| (f64::from(p.0), f64::from(p.1))).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return x;
    };
    let stretch = points.windows(2).find(|s| s[0].0 <= x && x < s[1].0);
    match stretch {
        Some(s) => s[0].1 + (x - s[0].0) * (s[1].1 - s[0].1) / (s[1].0 - s[0].0),
        None if x < first.0 => first.1,
        None => last.1,
    }
}

/// The largest slope of a table; 1 for an empty one, which keeps every value.
fn steepest(points: &[(f32, f32)]) -> f64 {
    let slope = |s: &[(f32, f32)]| f64::from((s[1].1 - s[0].1) / (s[1].0 - s[0].0)).abs();
    let none = if points.is_empty() { 1.0 } else { 0.0 };
    points.windows(2).map(slope).fold(none, f64::max)
}

fn extent(points: &[(f32, f32)], x: f64) -> f64 {
    points
        .iter()
        .map(|p| 2.0 * f64::from(p.1).abs())
        .fold(x.abs(), f64::max)
}

/// VCSG §2.3 for crisp operands: the first alone, the second alone, and `u` where both are.
fn combined(c: &Combine, first: Option<Bounded>, second: Option<Bounded>) -> Option<Bounded> {
    let both = first.zip(second).map(|(a, b)| joined(&c.rule, a, b));
    match c.op {
        BooleanOp::Union => both.or(first).or(second),
        BooleanOp::Intersection => both,
        BooleanOp::Subtraction => first.filter(|_| second.is_none()),
        BooleanOp::SubtractionWithRule => both.or(first),
    }
}

fn joined(rule: &ValueRule, a: Bounded, b: Bounded) -> Bounded {
    let (v, w) = (a.value, b.value);
    let rounding = 2.0 * EPSILON * (v.abs() + w.abs() + a.error + b.error);
    let (value, error) = match rule {
        ValueRule::First => return a,
        ValueRule::Second => return b,
        ValueRule::Max => (v.max(w), a.error.max(b.error)),
        ValueRule::Min => (v.min(w), a.error.max(b.error)),
        ValueRule::Sum => (v + w, a.error + b.error + rounding),
        ValueRule::Difference => (v - w, a.error + b.error + rounding),
        ValueRule::Average => (0.5 * (v + w), 0.5 * (a.error + b.error) + rounding),
        ValueRule::Blend(t) => {
            let t = f64::from(*t);
            (t * v + (1.0 - t) * w, t * a.error + (1.0 - t) * b.error + rounding)
        }
        ValueRule::Product => {
            let slope = v.abs() * b.error + w.abs() * a.error + a.error * b.error;
            (v * w, slope + EPSILON * ((v * w).abs() + slope))
        }
        ValueRule::AlgebraicSum => {
            let slope = (1.0 + v.abs() + a.error) * b.error + (1.0 + w.abs() + b.error) * a.error;
            // Three roundings, each of at most the sum of all terms.
            let terms = v.abs() + w.abs() + (v * w).abs() + slope;
            (v + w - v * w, slope + 2.0 * EPSILON * terms)
        }
        ValueRule::AbsoluteDifference => ((v - w).abs(), a.error + b.error + rounding),
        ValueRule::Quotient => {
            // Where the divisor may be 0 the error is infinite.
            let least = (w.abs() - b.error).max(0.0);
            let slope = (a.error + (v / w).abs() * b.error) / least;
            (v / w, slope + EPSILON * ((v / w).abs() + slope))
        }
        ValueRule::Over | ValueRule::Plus | ValueRule::In | ValueRule::Out | ValueRule::Atop | ValueRule::Xor => {
            unreachable!("rules of colours in a scene of values")
        }
        ValueRule::Table(lut) => return tabulated(lut, a, b),
    };
    Bounded { value, error }
}

/// A table's bilinear value. It changes by no more than neighbouring entries differ for a step of one entry.
fn tabulated(lut: &Lut, a: Bounded, b: Bounded) -> Bounded {
    let (width, values) = (lut.width(), lut.values());
    let height = values.len() / width;
    let [first, second] = lut.axes();
    let ((x, x_error), (y, y_error)) = (entries_from(first, width, a), entries_from(second, height, b));
    let entry = |i: usize, j: usize| f64::from(values[i.min(width - 1) + width * j.min(height - 1)]);
    let (i, j) = (x.floor() as usize, y.floor() as usize);
    let (s, t) = (x.fract(), y.fract());
    let row = |j: usize| (1.0 - s) * entry(i, j) + s * entry(i + 1, j);
    let all = || (0..width * height).map(|n| (n % width, n / width));
    let steepest = |by: [usize; 2]| {
        let rise = |(i, j): (usize, usize)| (entry(i + by[0], j + by[1]) - entry(i, j)).abs();
        all().map(rise).fold(0.0, f64::max)
    };
    let largest = all().map(|(i, j)| entry(i, j).abs()).fold(0.0, f64::max);
    Bounded {
        value: (1.0 - t) * row(j) + t * row(j + 1),
        // Two interpolations, one after the other, of a difference, two products and a sum.
        error: steepest([1, 0]) * x_error + steepest([0, 1]) * y_error + 4.0 * EPSILON * largest,
    }
}

/// How many entries from the first one `v` lies, and how far the tree's place may be from there: the error of the value, and a
/// difference, a width, a quotient and a product that are rounded.
fn entries_from(axis: Interval, entries: usize, v: Bounded) -> (f64, f64) {
    let (last, width) = ((entries - 1) as f64, f64::from(axis.hi) - f64::from(axis.lo));
    let place = ((v.value - f64::from(axis.lo)) / width).clamp(0.0, 1.0) * last;
    (place, last / width * v.error + 2.0 * EPSILON * last)
}
