//! Random numbers that are the same whoever draws them, and points spread evenly over a square.
//!
//! *Practice.* A number is a hash of seed, pixel, sample, and how many were drawn before it, so a frame does not depend on which thread draws
//! what. Samples of a pixel follow the additive sequence of the plastic number (Roberts 2018), shifted by a hash for each pixel: any
//! number of them is spread evenly.

/// Random numbers of one sample of one pixel.
#[derive(Clone, Debug)]
pub struct Stream {
    state: u64,
    sample: u32,
}

impl Stream {
    /// Those of sample `sample` of pixel `(x, y)`.
    pub fn new(seed: u64, [x, y]: [u32; 2], sample: u32) -> Self {
        let pixel = u64::from(y) << 32 | u64::from(x);
        Self {
            state: mixed(mixed(seed) ^ pixel),
            sample,
        }
    }

    /// A point of the unit square; over the samples of a pixel those of one turn are spread evenly.
    pub fn point(&mut self) -> [f64; 2] {
        const PLASTIC: f64 = 1.324_717_957_244_746;
        let shift = [self.number(), self.number()];
        let n = f64::from(self.sample);
        [0, 1].map(|axis| (shift[axis] + n / PLASTIC.powi(axis as i32 + 1)).fract())
    }

    /// A number in [0, 1), the same for all samples of a pixel.
    fn number(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mixed(self.state) >> 11) as f64 * 0.5f64.powi(53)
    }

    /// The point of the pixel that the sample is taken at, from its corner: the middle for the first.
    pub fn in_pixel(&mut self) -> [f64; 2] {
        let [first, point] = [
            Self {
                sample: 0,
                ..self.clone()
            }
            .point(),
            self.point(),
        ];
        [0, 1].map(|axis| (point[axis] - first[axis] + 1.5).fract())
    }
}

/// SplitMix64's finaliser (Steele, Lea and Flood 2014).
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_pixel_are_spread_evenly() {
        // Each of 16 squares gets its share of 256 points, within one in four: random points would miss it by as much in most runs.
        for pixel in [[0, 0], [17, 3], [640, 480]] {
            let mut counts = [0; 16];
            for sample in 0..256 {
                let [x, y] = Stream::new(1, pixel, sample).point();
                counts[(4.0 * x) as usize + 4 * (4.0 * y) as usize] += 1;
            }
            assert!(counts.iter().all(|n| (12..=20).contains(n)), "{counts:?}");
        }
    }

    #[test]
    fn the_first_sample_is_in_the_middle() {
        for pixel in [[0, 0], [5, 9]] {
            assert_eq!(Stream::new(3, pixel, 0).in_pixel(), [0.5, 0.5]);
        }
    }

    #[test]
    fn seeds_pixels_and_turns_differ() {
        let first = |seed, pixel| Stream::new(seed, pixel, 0).point();
        assert_ne!(first(0, [0, 0]), first(1, [0, 0]));
        assert_ne!(first(0, [0, 0]), first(0, [1, 0]));
        assert_ne!(first(0, [1, 0]), first(0, [0, 1]));
        let mut stream = Stream::new(0, [0, 0], 0);
        assert_ne!(stream.point(), stream.point());
    }
}
