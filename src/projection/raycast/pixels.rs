//! A frame in parts, each the work of one thread.

use super::simd::{EDGE, RAYS};
use crate::image::Frame;

/// Columns of a part: a few tiles are soon done, so that no thread waits long for another's last.
const COLUMNS: usize = 64;

/// The pixels of some tiles side by side.
pub struct Pixels<'a> {
    /// The first of them.
    pub first: [u32; 2],
    /// All, row by row: as many rows as a tile has, but at the lower edge of the frame.
    rows: Vec<&'a mut [[f32; 4]]>,
}

impl<'a> Pixels<'a> {
    /// Those of a frame, in parts as high as tiles of `tile` pixels are.
    pub fn of(frame: &'a mut Frame, tile: usize) -> Vec<Self> {
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
        let [column, row] = [0, 1].map(|axis| (first[axis] - self.first[axis]) as usize);
        let rows = self.rows.iter_mut().skip(row);
        for (row, pixels) in rows.zip(square.as_chunks::<EDGE>().0) {
            match row.get_mut(column..column + EDGE) {
                Some(whole) => whole.copy_from_slice(pixels),
                None => write_some(row.get_mut(column..).unwrap_or_default(), pixels),
            }
        }
    }
}

/// Writes what of a row of pixels there is room for.
#[cold]
#[inline(never)]
fn write_some(row: &mut [[f32; 4]], pixels: &[[f32; 4]; EDGE]) {
    row.copy_from_slice(&pixels[..row.len()]);
}
