//! Base64 as VTK writes it: between white space, and with padding in the midst, since a header and what follows it are encoded
//! each for itself.

use std::io::{self, BufRead, Read};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Characters decoded at a time: a multiple of four.
const CHUNK: usize = 1 << 14;

/// The bytes of a text in base64, which ends with its file or where markup begins.
pub(super) struct Base64<R> {
    text: R,
    bytes: Vec<u8>,
    /// How many of `bytes` are read.
    done: usize,
}

impl<R: BufRead> Base64<R> {
    pub(super) fn new(text: R) -> Self {
        Self {
            text,
            bytes: Vec::new(),
            done: 0,
        }
    }

    /// Decodes the next characters, up to a padding.
    fn refill(&mut self) -> io::Result<()> {
        let mut characters = Vec::with_capacity(CHUNK);
        let mut ends = false;
        while !ends {
            let text = self.text.fill_buf()?;
            ends = text.is_empty();
            let mut used = 0;
            for &c in text {
                ends = c == b'<' || characters.len() == CHUNK || (is_padded(&characters) && c != b'=');
                if ends {
                    break;
                }
                used += 1;
                if !c.is_ascii_whitespace() {
                    characters.push(c);
                }
            }
            self.text.consume(used);
        }
        self.done = 0;
        let decoded = STANDARD.decode(&characters);
        self.bytes = decoded.map_err(|e| io::Error::new(io::ErrorKind::InvalidData, format!("base64: {e}")))?;
        Ok(())
    }
}

/// Whether `characters` end with a padding that is whole.
fn is_padded(characters: &[u8]) -> bool {
    characters.len().is_multiple_of(4) && characters.last() == Some(&b'=')
}

impl<R: BufRead> Read for Base64<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.done == self.bytes.len() {
            self.refill()?;
        }
        let n = into.len().min(self.bytes.len() - self.done);
        into[..n].copy_from_slice(&self.bytes[self.done..self.done + n]);
        self.done += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(text: &str) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Base64::new(text.as_bytes()).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    #[test]
    fn padding_and_white_space_may_stand_anywhere() {
        assert_eq!(decoded(" AQ==\n AgM=BAUG <").unwrap(), [1, 2, 3, 4, 5, 6]);
        let long = STANDARD.encode(vec![7; 100_000]);
        assert_eq!(decoded(&long).unwrap(), vec![7; 100_000]);
    }

    #[test]
    fn what_is_no_base64_is_refused() {
        for text in ["AQI", "A*==", "AQ==A"] {
            assert!(decoded(text).is_err(), "{text}");
        }
    }
}
