//! Tables interpolated by cubics (Catmull and Rom's), which need fewer entries than lines do.

/// The sum of `values`, weighted.
pub fn weigh(values: [f64; 4], weights: [f64; 4]) -> f64 {
    values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
}

/// The four entries round place `x` of `count` entries, counted from 0, and their weights. The first and the last stand for those
/// beyond them.
pub fn clamped(x: f64, count: usize) -> ([usize; 4], [f64; 4]) {
    let x = x.clamp(0.0, (count - 1) as f64);
    let n = (x as usize).min(count - 2);
    let entries = [n.saturating_sub(1), n, n + 1, (n + 2).min(count - 1)];
    (entries, weights(x - n as f64))
}

/// [`clamped`] of entries that come round again after the last.
pub fn periodic(x: f64, count: usize) -> ([usize; 4], [f64; 4]) {
    let floor = x.floor();
    let n = floor.rem_euclid(count as f64) as usize;
    let entries = [n + count - 1, n, n + 1, n + 2].map(|n| n % count);
    (entries, weights(x - floor))
}

fn weights(x: f64) -> [f64; 4] {
    [
        -0.5 * x * (1.0 - x) * (1.0 - x),
        1.0 + x * x * (1.5 * x - 2.5),
        x * (0.5 + x * (2.0 - 1.5 * x)),
        -0.5 * x * x * (1.0 - x),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_met_and_rounds_come_round() {
        let parabola = |x: f64| 3.0 + x * (0.5 - 2.0 * x);
        for n in 0..40 {
            let x = 1.0 + 0.125 * f64::from(n);
            let (entries, weights) = clamped(x, 8);
            let value = weigh(entries.map(|n| parabola(n as f64)), weights);
            assert!((value - parabola(x)).abs() < 1e-12, "{x}");
            let round = |x: f64| {
                let (entries, weights) = periodic(x, 8);
                weigh(entries.map(|n| (n * n) as f64), weights)
            };
            assert_eq!(round(x), round(x + 8.0), "{x}");
        }
    }
}
