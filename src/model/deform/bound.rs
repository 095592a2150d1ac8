//! What a spline's derivatives can be in a ball.
//!
//! *Theory.* About x, split φ in what bends smoothly in the ball and, for a thin plate, the landmarks near to it, whose
//! gradients jump: each is Lipschitz with its weight's length. The smooth part's third derivative is bounded landmark by
//! landmark; its second is known at x, and so bounded in the ball. Let D be the most that the Jacobian can be from the smooth
//! part's at x, and κ the norm of that one's inverse: where κD < 1 every Jacobian in the ball has an inverse, of norm at most
//! κ/(1 − κD) (Banach), and so φ is one to one in it.

use glam::{DMat3, DVec3};
use multiversion::multiversion;

use super::radial::Radial;
use super::spline::{Columns, LANES, Spline, for_basis, total};

/// A spline about a point.
pub(super) struct Local {
    /// The smooth part's Jacobian at the point.
    pub jacobian: DMat3,
    /// The smooth part's second derivatives at the point, of each coordinate.
    pub hessians: [DMat3; 3],
    /// The norm of the smooth part's second derivative in the ball, at most.
    pub second: f64,
    /// The most that the near landmarks together change per millimetre.
    pub kinks: f64,
    /// The ball's radius, millimetres.
    pub radius: f64,
}

/// Sums about `x`: nine of the smooth part's Jacobian, column after column; six second derivatives (xx yy zz xy xz yz) of each
/// coordinate; the bound of the third; the near landmarks' weights.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn local_sums<R: Radial>(radial: R, columns: &Columns, x: DVec3, radius: f64, near: f64) -> [f64; 29] {
    let mut sums = [[0.0; LANES]; 29];
    let near = if R::HAS_KINK { near } else { -1.0 };
    let [fx, fy, fz] = &columns.from;
    let [wx, wy, wz] = &columns.weight;
    for (c, length) in columns.length.iter().enumerate() {
        let (fx, fy, fz, wx, wy, wz) = (&fx[c], &fy[c], &fz[c], &wx[c], &wy[c], &wz[c]);
        for l in 0..LANES {
            let [dx, dy, dz] = [x.x - fx[l], x.y - fy[l], x.z - fz[l]];
            let r = (dx * dx + dy * dy + dz * dz).sqrt();
            let is_far = r > near;
            let far = if is_far { 1.0 } else { 0.0 };
            let terms = radial.terms(if is_far { r } else { 1.0 });
            let (g, h) = (terms.g, terms.h);
            let second = [
                g + h * dx * dx,
                g + h * dy * dy,
                g + h * dz * dz,
                h * dx * dy,
                h * dx * dz,
                h * dy * dz,
            ];
            for (i, w) in [wx[l], wy[l], wz[l]].into_iter().enumerate() {
                let w = w * far;
                let wg = w * g;
                sums[i][l] += wg * dx;
                sums[3 + i][l] += wg * dy;
                sums[6 + i][l] += wg * dz;
                for (k, s) in second.iter().enumerate() {
                    sums[9 + 6 * i + k][l] += w * s;
                }
            }
            sums[27][l] += far * length[l] * radial.third(if is_far { r - radius } else { 1.0 });
            sums[28][l] += (1.0 - far) * length[l];
        }
    }
    sums.map(|lanes| total(&lanes))
}

impl Local {
    /// `spline` in the ball of `radius` (mm) about `x`. A thin plate's landmarks within `near` of x are apart; those beyond it
    /// must be beyond the ball.
    pub fn new(spline: &Spline, x: DVec3, radius: f64, near: f64) -> Self {
        let sums = for_basis!(spline.basis, radial => local_sums(radial, &spline.columns, x, radius, near));
        let entries: &[f64; 9] = sums[..9].try_into().expect("nine of many");
        let hessians = [0, 1, 2].map(|i| {
            let s = &sums[9 + 6 * i..];
            DMat3::from_cols_array(&[s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2]])
        });
        let square = |m: &DMat3| m.to_cols_array().iter().map(|e| e * e).sum::<f64>();
        let third = sums[27];
        Self {
            jacobian: DMat3::IDENTITY + spline.drift + DMat3::from_cols_array(entries),
            second: hessians.iter().map(square).sum::<f64>().sqrt() + radius * third,
            hessians,
            kinks: sums[28],
            radius,
        }
    }

    /// The smooth part's second derivative at the point, along `v` twice.
    pub fn bend(&self, v: DVec3) -> DVec3 {
        DVec3::from(self.hessians.map(|h| v.dot(h * v)))
    }

    /// [`Self::new`] with as many landmarks near as makes the bounds the least: the third derivative of one that is beyond 3
    /// radii changes its gradient by less than its weight.
    pub fn bounded(spline: &Spline, x: DVec3, radius: f64) -> Self {
        Self::new(spline, x, radius, 3.0 * radius)
    }

    /// The most that a Jacobian in the ball is from the smooth part's at its middle.
    pub fn change(&self) -> f64 {
        self.second * self.radius + self.kinks
    }

    /// The inverse of the smooth part's Jacobian, its norm κ, and the most of the norm of an inverse in the ball; `None`
    /// unless the map is proven to be one to one there and to keep its handedness.
    pub fn inverse(&self) -> Option<(DMat3, f64, f64)> {
        if self.jacobian.determinant() <= 0.0 {
            return None;
        }
        let inverse = self.jacobian.inverse();
        let norm = norm(&inverse);
        let left = 1.0 - norm * self.change();
        (left > 0.0 && norm.is_finite()).then_some((inverse, norm, norm / left))
    }
}

/// A bound of a matrix's norm: |A|₂² ≤ |A|₁ |A|∞.
pub(super) fn norm(m: &DMat3) -> f64 {
    let largest_column = |m: &DMat3| {
        let sums = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.abs().element_sum());
        sums[0].max(sums[1]).max(sums[2])
    };
    (largest_column(m) * largest_column(&m.transpose())).sqrt()
}
