//! The lines of a header in text.

use std::io::{BufRead, Take};
use std::path::Path;

use super::error::ReadError;

/// The most bytes such a header may have.
const MAX_BYTES: u64 = 1 << 20;

/// Numbered lines.
pub(super) struct Lines<'a, R> {
    path: &'a Path,
    reader: Take<R>,
    /// The number of the line that was read last, from 1 on.
    pub number: usize,
    /// Bytes of the lines that were read, ends included.
    pub bytes: u64,
}

impl<'a, R: BufRead> Lines<'a, R> {
    /// The lines of the file at `path`.
    pub(super) fn new(path: &'a Path, reader: R) -> Self {
        Self {
            path,
            reader: reader.take(MAX_BYTES),
            number: 0,
            bytes: 0,
        }
    }

    /// The next line without its end; `None` at the file's end.
    pub(super) fn next(&mut self) -> Result<Option<String>, ReadError> {
        let mut line = Vec::new();
        let read = self.reader.read_until(b'\n', &mut line);
        let read = read.map_err(|e| ReadError::io(self.path, e))?;
        if read == 0 {
            return Ok(None);
        }
        self.number += 1;
        self.bytes += read as u64;
        Ok(Some(String::from_utf8_lossy(&line).trim_end().to_owned()))
    }
}
