//! Random cells and lattices.

/// Splitmix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 to `n - 1`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// From 1 to 2¹⁹, evenly or evenly in the logarithm.
    pub fn magnitude(&mut self, logarithmic: bool) -> i64 {
        let shift = if logarithmic { self.below(19) } else { 0 };
        1 + self.below(1 << (19 - shift)) as i64
    }

    /// Of either sign, never zero.
    pub fn generic(&mut self, logarithmic: bool) -> i64 {
        let magnitude = self.magnitude(logarithmic);
        if self.bits() & 1 == 1 { magnitude } else { -magnitude }
    }

    /// Eight samples, of one size or of many.
    pub fn cell(&mut self) -> [i64; 8] {
        let logarithmic = self.bits() & 1 == 1;
        std::array::from_fn(|_| self.generic(logarithmic))
    }

    /// A whole number from -3 to 3: many zeros and ties.
    pub fn small(&mut self) -> i64 {
        self.below(7) as i64 - 3
    }
}

/// The inside corners of the ambiguous cases 3, 4, 6, 7, 10, 12 and 13 (Chernyaev 1995).
const HARD: [u8; 7] = [
    1 | 1 << 3,
    1 | 1 << 7,
    1 | 1 << 1 | 1 << 7,
    1 | 1 << 3 | 1 << 5,
    1 | 1 << 1 | 1 << 6 | 1 << 7,
    1 | 1 << 1 | 1 << 2 | 1 << 7,
    1 | 1 << 3 | 1 << 5 | 1 << 6,
];

/// A cell of a hard case in a random orientation, with either side inside.
pub fn hard(random: &mut Random) -> [i64; 8] {
    let signs = HARD[random.below(HARD.len() as u64) as usize];
    let side = if random.bits() & 1 == 1 { 1 } else { -1 };
    let logarithmic = random.bits() & 1 == 1;
    let cell = std::array::from_fn(|c| {
        let sign = if signs >> c & 1 == 1 { side } else { -side };
        sign * random.magnitude(logarithmic)
    });
    orient(&cell, random.below(48) as usize)
}

/// One of the 48 orientations of a cell.
pub fn orient<T: Copy>(cell: &[T; 8], orientation: usize) -> [T; 8] {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let order = ORDERS[orientation / 8];
    std::array::from_fn(|c| {
        let turned = (0..3).fold(0, |turned, axis| turned | (c >> axis & 1) << order[axis]);
        cell[turned ^ (orientation % 8)]
    })
}
