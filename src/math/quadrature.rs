//! Gauss–Legendre quadrature.

/// The nodes in (-1, 1) and the weights of the rule with `N` points, exact for polynomials of degree `2N − 1`.
#[derive(Clone, Debug)]
pub struct GaussLegendre<const N: usize> {
    points: [(f64, f64); N],
}

impl<const N: usize> GaussLegendre<N> {
    /// The rule: the roots of the Legendre polynomial, by Newton's method from their asymptotic places.
    pub fn new() -> Self {
        let points = std::array::from_fn(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (N as f64 + 0.5)).cos();
            // Newton's method doubles the digits each time; from these places four times would do.
            for _ in 0..8 {
                let (value, slope) = legendre(N, x);
                x -= value / slope;
            }
            let (_, slope) = legendre(N, x);
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        });
        Self { points }
    }

    /// Points and weights for the interval from `lo` to `hi`.
    pub fn over(&self, lo: f64, hi: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        self.points.iter().map(move |&(x, w)| (middle + half * x, half * w))
    }

    /// The integral of `f` from `lo` to `hi`.
    pub fn integrate(&self, lo: f64, hi: f64, f: impl Fn(f64) -> f64) -> f64 {
        self.over(lo, hi).map(|(x, w)| w * f(x)).sum()
    }
}

impl<const N: usize> Default for GaussLegendre<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// The Legendre polynomial of degree `n` and its derivative at `x`.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_degree_2n_minus_1_are_exact() {
        let rule = GaussLegendre::<5>::new();
        let exact = |k: i32| (3f64.powi(k + 1) - (-1f64).powi(k + 1)) / f64::from(k + 1);
        for k in 0..10 {
            let sum = rule.integrate(-1.0, 3.0, |x| x.powi(k));
            assert!(
                (sum - exact(k)).abs() < 1e-12 * exact(k).abs().max(1.0),
                "degree {k}: {sum}"
            );
        }
        let beyond = rule.integrate(-1.0, 3.0, |x| x.powi(10));
        assert!((beyond - exact(10)).abs() > 1e-3, "degree 10 is beyond it");
    }
}
