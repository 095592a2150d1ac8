//! Arrays of bits, of which VTK packs eight in a byte, the first one highest.

use std::io::{self, Read};

/// How files call the type of bits.
pub(super) const BIT: &str = "bit";

/// Bytes of so many.
pub(super) fn bytes(count: u64) -> u64 {
    count.div_ceil(8)
}

/// The bits of a stream's bytes, a byte each.
pub(super) struct Bits<R> {
    packed: R,
    /// The bits in hand, the next one highest, and how many are left of them.
    byte: u8,
    left: u32,
}

impl<R: Read> Bits<R> {
    pub(super) fn new(packed: R) -> Self {
        Self {
            packed,
            byte: 0,
            left: 0,
        }
    }
}

impl<R: Read> Read for Bits<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.left == 0 && !into.is_empty() {
            let mut next = [0];
            if self.packed.read(&mut next)? == 0 {
                return Ok(0);
            }
            [self.byte] = next;
            self.left = 8;
        }
        let count = into.len().min(self.left as usize);
        for bit in &mut into[..count] {
            *bit = self.byte >> 7;
            self.byte <<= 1;
        }
        self.left -= count as u32;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bit_is_the_highest() {
        let (mut bits, mut first) = (Bits::new(&[0b1010_0000, 0b0000_0011][..]), [9; 3]);
        bits.read_exact(&mut first).unwrap();
        assert_eq!(first, [1, 0, 1]);
        let mut rest = Vec::new();
        bits.read_to_end(&mut rest).unwrap();
        assert_eq!(rest, [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1]);
        assert_eq!([0, 1, 8, 9].map(bytes), [0, 1, 1, 2]);
    }
}
