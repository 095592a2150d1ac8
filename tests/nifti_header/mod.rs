//! NIfTI-1 headers made by hand.

use glam::{DMat3, DQuat, DVec3};

/// A header of 348 bytes, field by field at its place in nifti1.h.
#[derive(Clone)]
pub struct Header {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Whether fields are put in big-endian order.
    big: bool,
}

impl Header {
    /// A single file's header for `dim` and a data type code.
    pub fn new(dim: &[i16], datatype: i16) -> Self {
        let mut header = Self {
            bytes: vec![0; 348],
            big: false,
        };
        header.i32(0, 348);
        header.i16(40, dim.len() as i16);
        for axis in 0..7 {
            header.i16(42 + 2 * axis, dim.get(axis).copied().unwrap_or(1));
        }
        header.i16(70, datatype);
        for axis in 0..8 {
            header.f32(76 + 4 * axis, 1.0);
        }
        header.f32(108, 352.0);
        header.bytes[344..].copy_from_slice(b"n+1\0");
        header
    }

    fn put<const N: usize>(&mut self, at: usize, mut bytes: [u8; N]) {
        if self.big {
            bytes.reverse();
        }
        self.bytes[at..at + N].copy_from_slice(&bytes);
    }

    pub fn i16(&mut self, at: usize, v: i16) {
        self.put(at, v.to_le_bytes());
    }

    pub fn i32(&mut self, at: usize, v: i32) {
        self.put(at, v.to_le_bytes());
    }

    pub fn f32(&mut self, at: usize, v: f32) {
        self.put(at, v.to_le_bytes());
    }

    /// The same header in the other byte order.
    pub fn swapped(dim: &[i16], datatype: i16) -> Self {
        let little = Self::new(dim, datatype);
        let mut big = little.clone();
        big.big = true;
        let fields = [(0, 4)].into_iter().chain((40..56).step_by(2).map(|at| (at, 2)));
        let fields = fields.chain([(70, 2)]).chain((76..112).step_by(4).map(|at| (at, 4)));
        for (at, size) in fields {
            big.bytes[at..at + size].reverse();
        }
        big
    }

    /// Rows of the RAS matrix and origin.
    pub fn sform(&mut self, axes: DMat3, origin: DVec3) {
        self.i16(254, 1);
        for row in 0..3 {
            let r = axes.row(row);
            for (column, v) in [r.x, r.y, r.z, origin[row]].into_iter().enumerate() {
                self.f32(280 + 16 * row + 4 * column, v as f32);
            }
        }
    }

    pub fn qform(&mut self, q: DQuat, qfac: f32, origin: DVec3) {
        let q = if q.w < 0.0 { -q } else { q };
        self.i16(252, 1);
        self.f32(76, qfac);
        for (n, v) in [q.x, q.y, q.z, origin.x, origin.y, origin.z].into_iter().enumerate() {
            self.f32(256 + 4 * n, v as f32);
        }
    }

    /// The whole single file.
    pub fn with(&self, data: &[u8]) -> Vec<u8> {
        [&self.bytes, [0; 4].as_slice(), data].concat()
    }
}
