//! φ: an affine map and a radial function about each landmark.
//!
//! *Practice.* Sums run over lanes of eight landmarks, in an order that does not depend on the width of registers.

use glam::{DMat3, DVec3};
use multiversion::multiversion;

use super::radial::{Compact, Radial, ThinPlate};

/// Landmarks that are summed side by side.
pub(super) const LANES: usize = 8;

/// A smooth map from the place of things to where they go, millimetres both.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// φ(x) = x + drift(x) + Σ weight · U(|x − from|): the drift's linear part.
    pub(super) drift: DMat3,
    /// The drift at `centre`.
    pub(super) shift: DVec3,
    /// The landmarks' mean, millimetres.
    pub(super) centre: DVec3,
    /// Their mean distance from it.
    pub(super) scale: f64,
    pub(super) basis: Basis,
    pub(super) columns: Columns,
    /// The names of the landmarks that columns stand for.
    pub(super) names: Vec<String>,
    /// The farthest that a landmark stays from its target, millimetres.
    pub(super) residual_mm: f64,
    /// Dimensions that the landmarks span.
    pub(super) rank: usize,
}

/// Which radial function it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    ThinPlate(ThinPlate),
    Compact(Compact),
}

/// Calls `$f` with the basis's function.
macro_rules! for_basis {
    ($basis:expr, $radial:ident => $f:expr) => {
        match $basis {
            $crate::model::deform::spline::Basis::ThinPlate($radial) => $f,
            $crate::model::deform::spline::Basis::Compact($radial) => $f,
        }
    };
}
pub(super) use for_basis;

/// The landmarks' places and weights, coordinate by coordinate; the last lanes are filled up with landmarks of no weight.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Columns {
    pub from: [Vec<[f64; LANES]>; 3],
    pub weight: [Vec<[f64; LANES]>; 3],
    /// The weights' lengths.
    pub length: Vec<[f64; LANES]>,
}

impl Columns {
    pub fn new(places: &[DVec3], weights: &[DVec3]) -> Self {
        let lanes = |of: &dyn Fn(usize) -> f64| -> Vec<[f64; LANES]> {
            (0..places.len().div_ceil(LANES))
                .map(|chunk| std::array::from_fn(|lane| of(chunk * LANES + lane)))
                .collect()
        };
        let weight = |n: usize| weights.get(n).copied().unwrap_or(DVec3::ZERO);
        let place = |n: usize| places[n.min(places.len() - 1)];
        Self {
            from: [0, 1, 2].map(|axis| lanes(&|n| place(n)[axis])),
            weight: [0, 1, 2].map(|axis| lanes(&|n| weight(n)[axis])),
            length: lanes(&|n| weight(n).length()),
        }
    }

    /// The `n`th landmark's place.
    pub fn place(&self, n: usize) -> DVec3 {
        DVec3::from([0, 1, 2].map(|axis| self.from[axis][n / LANES][n % LANES]))
    }

    /// The `n`th landmark's weight.
    pub fn weight(&self, n: usize) -> DVec3 {
        DVec3::from([0, 1, 2].map(|axis| self.weight[axis][n / LANES][n % LANES]))
    }
}

/// Sums of the radial part at `x`: its value, and the nine entries of its Jacobian, column after column.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn radial_sums<R: Radial>(radial: R, columns: &Columns, x: DVec3) -> [f64; 12] {
    let mut sums = [[0.0; LANES]; 12];
    let [fx, fy, fz] = &columns.from;
    let [wx, wy, wz] = &columns.weight;
    for ((((((fx, fy), fz), wx), wy), wz), _) in fx.iter().zip(fy).zip(fz).zip(wx).zip(wy).zip(wz).zip(&columns.length)
    {
        for l in 0..LANES {
            let d = [x.x - fx[l], x.y - fy[l], x.z - fz[l]];
            let w = [wx[l], wy[l], wz[l]];
            let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let terms = radial.terms(r);
            for i in 0..3 {
                sums[i][l] += w[i] * terms.u;
                let wg = w[i] * terms.g;
                for j in 0..3 {
                    sums[3 + 3 * j + i][l] += wg * d[j];
                }
            }
        }
    }
    sums.map(|lanes| total(&lanes))
}

/// The sum over lanes, in one order.
#[inline(always)]
pub(super) fn total(lanes: &[f64; LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = *lanes;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

impl Spline {
    /// Where the point `x` goes.
    pub fn point(&self, x: DVec3) -> DVec3 {
        self.point_and_jacobian(x).0
    }

    /// Where the point `x` goes, and the map's Jacobian there; at a landmark of a thin plate, where that jumps, its mean.
    pub fn point_and_jacobian(&self, x: DVec3) -> (DVec3, DMat3) {
        let sums = for_basis!(self.basis, radial => radial_sums(radial, &self.columns, x));
        let value = DVec3::new(sums[0], sums[1], sums[2]);
        let entries: &[f64; 9] = sums[3..].try_into().expect("nine of twelve");
        let affine = x + self.shift + self.drift * (x - self.centre);
        (
            affine + value,
            DMat3::IDENTITY + self.drift + DMat3::from_cols_array(entries),
        )
    }

    /// The landmarks in use; those that repeat others are not.
    pub fn landmarks(&self) -> usize {
        self.names.len()
    }

    /// The farthest that a landmark stays from its target, millimetres.
    pub fn residual_mm(&self) -> f64 {
        self.residual_mm
    }

    /// Dimensions that the landmarks span: 3, or 2 in a plane, or 1 on a line. Across them nothing is stretched or turned but by
    /// the radial part.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The reach of landmarks that is felt within `radius` of `x`: infinite where nothing ends.
    pub(super) fn reach_felt(&self, x: DVec3, radius: f64) -> f64 {
        let reach = for_basis!(self.basis, radial => radial.reach());
        let is_felt = |n: usize| self.columns.place(n).distance(x) < reach + radius;
        match reach.is_finite() && (0..self.names.len()).any(is_felt) {
            true => reach,
            false => f64::INFINITY,
        }
    }

    /// The name of the landmark nearest to `x`, before it moves.
    pub fn nearest(&self, x: DVec3) -> &str {
        &self.names[self.nearest_index(x)]
    }

    /// The number of the landmark nearest to `x`.
    pub(super) fn nearest_index(&self, x: DVec3) -> usize {
        let nearer = |a: &usize, b: &usize| {
            let distance = |n: usize| self.columns.place(n).distance_squared(x);
            distance(*a).total_cmp(&distance(*b))
        };
        (0..self.names.len()).min_by(nearer).unwrap_or(0)
    }
}
