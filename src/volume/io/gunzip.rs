//! Gzip streams as files hold them.

use std::io::{self, BufRead, Read};

use flate2::bufread::GzDecoder;

/// The bytes of one gzip member after the other, as block compressors write them; what follows the last is ignored, as `gzip`
/// does. Each member's checksum is tested at its end.
pub(super) struct Gunzip<R> {
    member: Option<GzDecoder<R>>,
}

/// The first bytes of a gzip member.
pub(super) const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Deflate's best ratio: a match of 258 bytes takes at least two bits.
const MAX_RATIO: u64 = 1032;

/// Whether `compressed` bytes of gzip can hold `expanded` bytes.
pub(super) fn can_hold(compressed: u64, expanded: u64) -> bool {
    expanded / MAX_RATIO <= compressed
}

impl<R: BufRead> Gunzip<R> {
    pub(super) fn new(reader: R) -> Self {
        Self {
            member: Some(GzDecoder::new(reader)),
        }
    }

    /// Whether there was another member to go on with.
    fn next_member(&mut self) -> io::Result<bool> {
        let Some(done) = self.member.take() else {
            return Ok(false);
        };
        let mut reader = done.into_inner();
        let more = reader.fill_buf()?.starts_with(&GZIP_MAGIC);
        if more {
            self.member = Some(GzDecoder::new(reader));
        }
        Ok(more)
    }
}

impl<R: BufRead> Read for Gunzip<R> {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        if buf.is_empty() {
            return Ok(0);
        }
        while let Some(member) = &mut self.member {
            match member.read(buf)? {
                0 => self.next_member()?,
                n => return Ok(n),
            };
        }
        Ok(0)
    }
}
