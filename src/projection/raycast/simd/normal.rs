//! A normal in 32 bits.
//!
//! *Practice.* Two parts have 11 bits and the last one 10, with signs, from the highest bits down: as much is read for a normal as for two
//! numbers, and a normal is off by 0.0012 at most, 0.07°. Each part is taken out as the highest bits of a word, so that all are in the same
//! parts of 1.

/// What each part of a normal is of a word, for 1.
pub const ONE_NORMAL: f32 = (511 << 6) as f32;

/// The bits of a word that one of the first two parts has.
pub const FIRST_BITS: i16 = -1 << 5;

/// How far the second part is from the top, the third from there, and the third from the top of its word.
pub const SECOND: u32 = 11;
pub const THIRD: u32 = 6;

/// A normal, each part the nearest number, the higher of two. None is longer than 1.
#[inline(always)]
pub fn packed([x, y, z]: [f32; 3]) -> u32 {
    // Rust's float casts cut off what is behind the point.
    let nearest = |part: f32, one: i32| (part * one as f32 + (one as f32 + 0.5)) as i32 - one;
    let [x, y] = [x, y].map(|part| nearest(part, 511 << 1) as u32 & 0x7ff);
    let z = nearest(z, 511) as u32 & 0x3ff;
    x << 21 | y << 10 | z
}

/// Its parts, in parts of [`ONE_NORMAL`].
#[inline(always)]
pub fn parts(normal: u32) -> [i16; 3] {
    let [high, low] = [(normal >> 16) as i16, normal as i16];
    let second = high << SECOND | (low as u16 >> (16 - SECOND)) as i16;
    [high & FIRST_BITS, second & FIRST_BITS, low << THIRD]
}

#[cfg(test)]
mod tests {
    use super::{ONE_NORMAL, packed, parts};

    /// Half of what each part is counted in.
    const HALVES: [f32; 3] = [0.5 / 1022.0, 0.5 / 1022.0, 0.5 / 511.0];

    #[test]
    fn parts_are_off_by_half_of_what_they_are_counted_in() {
        for n in 0..4000 {
            let (turn, height) = (n as f32 * 2.4, n as f32 / 1999.5 - 1.0);
            let [round, length] = [(1.0 - height * height).max(0.0).sqrt(), (n % 7) as f32 / 6.0];
            let normal = [round * turn.cos(), height, round * turn.sin()].map(|part| part * length);
            let unpacked = parts(packed(normal)).map(|part| f32::from(part) / ONE_NORMAL);
            for (part, half) in HALVES.into_iter().enumerate() {
                let off = (unpacked[part] - normal[part]).abs();
                assert!(off <= half + 1e-6, "{off} of {normal:?} as {unpacked:?}");
            }
        }
    }

    #[test]
    fn ends_and_nothing_are_what_they_are() {
        for axis in 0..3 {
            for part in [-1.0, 0.0, 1.0] {
                let mut normal = [0.0; 3];
                normal[axis] = part;
                assert_eq!(parts(packed(normal)).map(|part| f32::from(part) / ONE_NORMAL), normal);
            }
        }
    }
}
