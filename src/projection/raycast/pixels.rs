//! A frame in parts, each the work of one thread.

use std::sync::{Mutex, PoisonError};
use std::vec;

use super::simd::{EDGE, RAYS, each};
use crate::image::Frame;

/// Columns of a part: a few tiles are soon done, so that no thread waits long for another's last.
const COLUMNS: usize = 64;

/// The parts of a frame that no thread has taken yet.
pub struct Parts<'a>(Mutex<vec::IntoIter<Pixels<'a>>>);

impl<'a> Parts<'a> {
    /// All of a frame's, as high as tiles of `tile` pixels are.
    pub fn of(frame: &'a mut Frame, tile: usize) -> Self {
        Self(Mutex::new(Pixels::parts(frame, tile).into_iter()))
    }

    /// The next one.
    pub fn take(&self) -> Option<Pixels<'a>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).next()
    }
}

/// The pixels of some tiles side by side.
pub struct Pixels<'a> {
    /// The first of them.
    pub first: [u32; 2],
    /// All, row by row: as many rows as a tile has, but at the lower edge of the frame.
    rows: Vec<&'a mut [[f32; 4]]>,
}

impl<'a> Pixels<'a> {
    /// Those of a frame, in parts as high as tiles of `tile` pixels are.
    fn parts(frame: &'a mut Frame, tile: usize) -> Vec<Self> {
        let width = frame.width() as usize;
        let columns = width.div_ceil(COLUMNS);
        let mut parts = Vec::new();
        for (band, pixels) in frame.pixels_mut().chunks_mut(tile * width).enumerate() {
            let first = parts.len();
            parts.extend((0..columns).map(|column| Self {
                first: [column * COLUMNS, band * tile].map(|n| n as u32),
                rows: Vec::with_capacity(tile),
            }));
            for row in pixels.chunks_mut(width) {
                for (part, pixels) in parts[first..].iter_mut().zip(row.chunks_mut(COLUMNS)) {
                    part.rows.push(pixels);
                }
            }
        }
        parts
    }

    /// The column behind the last one.
    pub fn end(&self) -> u32 {
        self.first[0] + self.rows[0].len() as u32
    }

    /// Writes what of a square of pixels is among them, the first one at `first`.
    #[inline(always)]
    pub fn write(&mut self, first: [u32; 2], square: &[[f32; 4]; RAYS]) {
        let [column, row] = each!(axis of [0, 1] => (first[axis] - self.first[axis]) as usize);
        let (squares, _) = square.as_chunks::<EDGE>();
        match self.rows.get_mut(row..row + EDGE) {
            Some([a, b, c, d]) if column + EDGE <= a.len() => {
                each!(row of [(a, 0), (b, 1), (c, 2), (d, 3)] => {
                    row.0[column..column + EDGE].copy_from_slice(&squares[row.1]);
                });
            }
            _ => self.write_some([column, row], squares),
        }
    }

    /// Writes what of a square there is room for.
    #[cold]
    #[inline(never)]
    fn write_some(&mut self, [column, row]: [usize; 2], squares: &[[[f32; 4]; EDGE]]) {
        for (row, pixels) in self.rows.iter_mut().skip(row).zip(squares) {
            let there = row.get_mut(column..).unwrap_or_default();
            let room = there.len().min(EDGE);
            there[..room].copy_from_slice(&pixels[..room]);
        }
    }
}
