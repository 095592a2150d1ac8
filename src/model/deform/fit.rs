//! Fits a spline to landmarks.
//!
//! *Theory.* The spline is the drift, an affine map, and weights w such that φ(from) = to. The thin plate's function r is
//! conditionally negative definite, so the weights are orthogonal to the drift's functions, and a stiffness λ stands as −λ on the
//! diagonal: each landmark misses by λw (Wahba 1990, §2.4). Wendland's functions are positive definite and need no drift;
//! without one, nothing moves beyond the landmarks' support.
//! *Practice.* Movements are fitted, not targets. So across the dimensions that the landmarks do not span (they may lie in a
//! plane or on a line) the drift is none, and space is not squeezed flat. Lengths are in units of the landmarks' mean
//! distance from their mean.

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, Matrix3};

use super::landmarks::{Landmark, Smoothness, SplineError, distinct, most_torn};
use super::radial::{Compact, Radial, ThinPlate};
use super::spline::{Basis, Columns, Spline, for_basis};

/// A dimension is spanned if landmarks spread along it by this part of how they spread along the widest.
const SPANNED: f64 = 1e-6;

/// The most that a solution may miss, as a part of the largest movement, if the stiffness asks for no misses.
const MISS: f64 = 1e-6;

impl Spline {
    /// The spline of `landmarks`.
    ///
    /// # Errors
    /// If they are too few or too many, contradict each other, or their equations cannot be solved.
    pub fn new(landmarks: &[Landmark], smoothness: &Smoothness) -> Result<Self, SplineError> {
        let support_is_wrong = |mm: f64| !(mm.is_finite() && mm > 0.0);
        if !(smoothness.stiffness.is_finite() && smoothness.stiffness >= 0.0)
            || smoothness.support_mm.is_some_and(support_is_wrong)
        {
            return Err(SplineError::Smoothness);
        }
        let landmarks = distinct(landmarks)?;
        let system = System::new(&landmarks, smoothness);
        let [a, b] = most_torn(&landmarks);
        let unsolvable = || SplineError::Unsolvable(a.into(), b.into());
        let mut spline = system.solved(&landmarks).ok_or_else(unsolvable)?;
        let largest = landmarks.iter().map(|l| l.from.distance(l.to)).fold(0.0, f64::max);
        let misses = |l: &&Landmark| spline.point(l.from).distance(l.to);
        spline.residual_mm = landmarks.iter().map(misses).fold(0.0, f64::max);
        let solved = smoothness.stiffness > 0.0 || spline.residual_mm <= MISS * largest;
        (solved && spline.residual_mm.is_finite())
            .then_some(spline)
            .ok_or_else(unsolvable)
    }
}

/// The equations of a spline.
struct System {
    basis: Basis,
    centre: DVec3,
    scale: f64,
    /// Unit vectors along the dimensions in which the drift is linear.
    spanned: Vec<DVec3>,
    /// Whether there is a drift.
    drifts: bool,
    rank: usize,
    /// What stands on the diagonal beside U(0).
    diagonal: f64,
}

impl System {
    fn new(landmarks: &[&Landmark], smoothness: &Smoothness) -> Self {
        let count = landmarks.len() as f64;
        let centre = landmarks.iter().map(|l| l.from).sum::<DVec3>() / count;
        let scale = landmarks.iter().map(|l| l.from.distance(centre)).sum::<f64>() / count;
        let spanned = spanned(landmarks, centre);
        let (basis, drifts, diagonal) = match smoothness.support_mm {
            None => (Basis::ThinPlate(ThinPlate), true, -smoothness.stiffness),
            Some(mm) => {
                let per_support = 1.0 / mm;
                (Basis::Compact(Compact { per_support }), false, smoothness.stiffness)
            }
        };
        Self {
            basis,
            centre,
            scale,
            rank: spanned.len(),
            spanned,
            drifts,
            diagonal,
        }
    }

    /// The drift's functions at `place`: 1, and the coordinates along what is spanned.
    fn drift_terms(&self, place: DVec3) -> Vec<f64> {
        if !self.drifts {
            return Vec::new();
        }
        let along = |axis: &DVec3| axis.dot(place - self.centre) / self.scale;
        std::iter::once(1.0).chain(self.spanned.iter().map(along)).collect()
    }

    /// The radial part of the equations has the unit of r, millimetres, for a thin plate, and none for a compact one.
    fn unit(&self) -> f64 {
        if self.drifts { self.scale } else { 1.0 }
    }

    fn matrix(&self, landmarks: &[&Landmark]) -> DMatrix<f64> {
        let n = landmarks.len();
        let terms: Vec<Vec<f64>> = landmarks.iter().map(|l| self.drift_terms(l.from)).collect();
        let drift = terms[0].len();
        let radial = |r: f64| for_basis!(self.basis, radial => radial.terms(r).u) / self.unit();
        DMatrix::from_fn(n + drift, n + drift, |i, j| match (i < n, j < n) {
            (true, true) => {
                let diagonal = if i == j { self.diagonal / self.unit() } else { 0.0 };
                radial(landmarks[i].from.distance(landmarks[j].from)) + diagonal
            }
            (true, false) => terms[i][j - n],
            (false, true) => terms[j][i - n],
            (false, false) => 0.0,
        })
    }

    fn solved(&self, landmarks: &[&Landmark]) -> Option<Spline> {
        let n = landmarks.len();
        let matrix = self.matrix(landmarks);
        let size = matrix.nrows();
        let movement = |l: &Landmark| l.to - l.from;
        let wanted = DMatrix::from_fn(size, 3, |i, axis| landmarks.get(i).map_or(0.0, |l| movement(l)[axis]));
        let found = matrix.lu().solve(&wanted)?;
        let row = |i: usize| DVec3::from([0, 1, 2].map(|axis| found[(i, axis)]));
        let weights: Vec<DVec3> = (0..n).map(|i| row(i) / self.unit()).collect();
        let places: Vec<DVec3> = landmarks.iter().map(|l| l.from).collect();
        let shift = if self.drifts { row(n) } else { DVec3::ZERO };
        let axes = if self.drifts { &self.spanned[..] } else { &[] };
        let drift = axes.iter().enumerate().fold(DMat3::ZERO, |sum, (i, axis)| {
            let along = row(n + 1 + i) / self.scale;
            sum + DMat3::from_cols(along * axis.x, along * axis.y, along * axis.z)
        });
        Some(Spline {
            drift,
            shift,
            centre: self.centre,
            scale: self.scale,
            basis: self.basis,
            columns: Columns::new(&places, &weights),
            names: landmarks.iter().map(|l| l.name.clone()).collect(),
            residual_mm: 0.0,
            rank: self.rank,
        })
    }
}

/// Unit vectors along the dimensions that landmarks span.
fn spanned(landmarks: &[&Landmark], centre: DVec3) -> Vec<DVec3> {
    let spread = landmarks.iter().fold(Matrix3::zeros(), |sum, l| {
        let d = l.from - centre;
        let d = nalgebra::Vector3::new(d.x, d.y, d.z);
        sum + d * d.transpose()
    });
    let axes = spread.symmetric_eigen();
    let widest = axes.eigenvalues.max();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| axes.eigenvalues[b].total_cmp(&axes.eigenvalues[a]));
    let is_spanned = |&axis: &usize| axes.eigenvalues[axis] > SPANNED * SPANNED * widest;
    let unit = |axis: usize| DVec3::from([0, 1, 2].map(|i| axes.eigenvectors[(i, axis)]));
    order.into_iter().filter(is_spanned).map(unit).collect()
}
