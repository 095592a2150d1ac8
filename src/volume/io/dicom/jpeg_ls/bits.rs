//! The bits of a scan, and numbers in Golomb's code of limited length.

/// Bits from the highest of each byte on. A byte behind 0xff has but seven, so that a marker is never among them.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Those that come next, from the highest bit on; zeros behind them.
    held: u64,
    count: u32,
    is_behind_ff: bool,
}

/// That there are no more bits, or that they mean nothing.
#[derive(Debug)]
pub(super) struct Damaged;

impl<'a> Bits<'a> {
    /// Those of `bytes` from `at` on, up to a marker.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self {
            bytes,
            at,
            held: 0,
            count: 0,
            is_behind_ff: false,
        }
    }

    /// Where the marker behind them is, at the earliest.
    pub(super) fn end(&self) -> usize {
        self.at
    }

    fn fill(&mut self) {
        while self.count <= 56 {
            let Some(&byte) = self.bytes.get(self.at) else { return };
            if byte == 0xff && self.bytes.get(self.at + 1).is_none_or(|next| *next >= 0x80) {
                return;
            }
            let bits = if self.is_behind_ff { 7 } else { 8 };
            self.held |= u64::from(byte) << (64 - self.count - bits);
            self.count += bits;
            self.is_behind_ff = byte == 0xff;
            self.at += 1;
        }
    }

    /// The next `count` bits, 32 at most, as a number.
    #[inline]
    pub(super) fn number(&mut self, count: u32) -> Result<i32, Damaged> {
        if count == 0 {
            return Ok(0);
        }
        if self.count < count {
            self.fill();
        }
        if self.count < count || count > 31 {
            return Err(Damaged);
        }
        let number = self.held >> (64 - count);
        self.held <<= count;
        self.count -= count;
        Ok(number as i32)
    }

    /// How many zeros come before a one, `most` at most; the one is passed.
    #[inline]
    fn zeros(&mut self, most: u32) -> Result<u32, Damaged> {
        let mut zeros = 0;
        loop {
            self.fill();
            let here = self.held.leading_zeros().min(self.count);
            zeros += here;
            if zeros > most || self.count == 0 {
                return Err(Damaged);
            }
            if here < self.count {
                // Two steps: a shift by all 64 bits is none.
                self.held = self.held << here << 1;
                self.count -= here + 1;
                return Ok(zeros);
            }
            self.held = 0;
            self.count = 0;
        }
    }

    /// A number in Golomb's code of parameter `k`: as many zeros as its part above `k` bits, or, so that none takes more than `limit`
    /// bits, the most of them and then itself less one in `whole` bits (A.5.3).
    #[inline]
    pub(super) fn golomb(&mut self, k: u32, limit: u32, whole: u32) -> Result<i32, Damaged> {
        let most = limit.checked_sub(whole + 1).ok_or(Damaged)?;
        match self.zeros(most)? {
            high if high == most => Ok(self.number(whole)? + 1),
            // `k` is at most 16, and of zeros there are fewer than 64.
            high => Ok((high << k) as i32 | self.number(k)?),
        }
    }
}
