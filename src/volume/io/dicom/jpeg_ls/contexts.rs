//! What a scan has learnt of its errors of prediction, by the gradients about a sample.

use super::bits::{Bits, Damaged};
use super::parameters::Parameters;

/// The largest parameter of Golomb's code: a larger one no sample of 16 bits asks for.
const MAX_K: u32 = 16;

/// How many contexts gradients of one sign give.
pub(super) const REGULAR: usize = 365;

/// Errors about samples of alike gradients (A.6).
#[derive(Clone, Copy)]
pub(super) struct Regular {
    /// The sum of their sizes.
    sizes: i64,
    /// Their sum.
    bias: i32,
    /// What the prediction is corrected by.
    pub correction: i32,
    count: i32,
}

/// The least `k` for which `count` doubled `k` times is no less than `sizes`.
#[inline]
fn parameter(count: i32, sizes: i64) -> Result<u32, Damaged> {
    (0..=MAX_K).find(|k| i64::from(count) << k >= sizes).ok_or(Damaged)
}

impl Regular {
    pub(super) fn new(parameters: &Parameters) -> Self {
        Self {
            sizes: i64::from(parameters.first_sizes()),
            bias: 0,
            correction: 0,
            count: 1,
        }
    }

    /// The next error, from which this context learns.
    #[inline]
    pub(super) fn error(&mut self, bits: &mut Bits, parameters: &Parameters) -> Result<i32, Damaged> {
        let k = parameter(self.count, self.sizes)?;
        let mapped = bits.golomb(k, parameters.limit, parameters.whole_bits)?;
        let inverted = parameters.near == 0 && k == 0 && 2 * self.bias <= -self.count;
        // Even are 0, 1, 2 …, odd −1, −2, …; the other way round where most were negative.
        let error = (mapped >> 1) ^ -(mapped & 1) ^ -i32::from(inverted);
        if error.abs() > parameters.range {
            return Err(Damaged);
        }
        self.learn(error, parameters);
        Ok(error)
    }

    fn learn(&mut self, error: i32, parameters: &Parameters) {
        self.sizes += i64::from(error.abs());
        self.bias += error * parameters.step();
        if self.count == parameters.reset {
            self.sizes >>= 1;
            self.bias >>= 1;
            self.count >>= 1;
        }
        self.count += 1;
        if self.bias <= -self.count {
            self.bias = (self.bias + self.count).max(1 - self.count);
            self.correction = (self.correction - 1).max(-128);
        } else if self.bias > 0 {
            self.bias = (self.bias - self.count).min(0);
            self.correction = (self.correction + 1).min(127);
        }
    }
}

/// Errors of samples that end a run (A.7.2).
#[derive(Clone, Copy)]
pub(super) struct RunEnd {
    /// 1 where the sample above is the run's, else 0.
    kind: i32,
    sizes: i64,
    count: i32,
    negative: i32,
}

impl RunEnd {
    pub(super) fn new(kind: i32, parameters: &Parameters) -> Self {
        Self {
            kind,
            sizes: i64::from(parameters.first_sizes()),
            count: 1,
            negative: 0,
        }
    }

    /// The next error, behind a run whose length took `run_bits`.
    pub(super) fn error(&mut self, bits: &mut Bits, parameters: &Parameters, run_bits: u32) -> Result<i32, Damaged> {
        let k = parameter(self.count, self.sizes + i64::from((self.count >> 1) * self.kind))?;
        let limit = parameters.limit.checked_sub(run_bits + 1).ok_or(Damaged)?;
        let mapped = bits.golomb(k, limit, parameters.whole_bits)?;
        let sum = mapped + self.kind;
        let size = (sum + 1) / 2;
        let is_negative = (k != 0 || 2 * self.negative >= self.count) == (sum & 1 == 1);
        if size > parameters.range {
            return Err(Damaged);
        }
        let error = if is_negative { -size } else { size };
        self.negative += i32::from(error < 0);
        self.sizes += i64::from((mapped + 1 - self.kind) >> 1);
        if self.count == parameters.reset {
            self.sizes >>= 1;
            self.count >>= 1;
            self.negative >>= 1;
        }
        self.count += 1;
        Ok(error)
    }
}
