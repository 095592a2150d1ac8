//! A TIFF file in which photometry says nothing but that black is 0.
//!
//! *Practice.* The `tiff` crate refuses palettes and inverts images whose white is 0; scientific readers (tifffile) take both
//! as they are stored. So the crate is shown another photometric interpretation than the file's.

use std::io::{Read, Result, Seek, SeekFrom};

/// The file, with two bytes in the place of others.
#[derive(Debug)]
pub(super) struct Shown<R> {
    file: R,
    position: u64,
    /// Where they are, and which.
    shown: Option<(u64, [u8; 2])>,
}

impl<R: Read + Seek> Shown<R> {
    pub(super) fn new(file: R) -> Self {
        Self {
            file,
            position: 0,
            shown: None,
        }
    }

    /// Shows `bytes` at `position`, and nothing else that is not there.
    pub(super) fn show(&mut self, shown: Option<(u64, [u8; 2])>) {
        self.shown = shown;
    }
}

impl<R: Read> Read for Shown<R> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let read = self.file.read(into)?;
        for (position, byte) in self.shown.iter().flat_map(|(at, bytes)| (*at..).zip(bytes)) {
            let place = position.checked_sub(self.position).map(|n| n as usize);
            if let Some(here) = place.filter(|n| *n < read) {
                into[here] = *byte;
            }
        }
        self.position += read as u64;
        Ok(read)
    }
}

impl<R: Seek> Seek for Shown<R> {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        self.position = self.file.seek(to)?;
        Ok(self.position)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn two_bytes_are_others_however_they_are_read() {
        let mut shown = Shown::new(Cursor::new((0..10).collect::<Vec<u8>>()));
        shown.show(Some((4, [40, 50])));
        for size in 1..10 {
            shown.seek(SeekFrom::Start(2)).unwrap();
            let mut bytes: Vec<u8> = Vec::new();
            let mut part = vec![0; size];
            while let n @ 1.. = shown.read(&mut part).unwrap() {
                bytes.extend(&part[..n]);
            }
            assert_eq!(bytes, [2, 3, 40, 50, 6, 7, 8, 9]);
        }
    }
}
