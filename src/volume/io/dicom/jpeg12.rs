//! JPEG with twelve bits a sample: the extended sequential process (ITU-T T.81, SOF1) of one component.
//!
//! *Practice.* The crates that decode JPEG stop at eight bits outside the lossless process, and scanners do send twelve. The
//! inverse transform is the definition in `f32`, a row and a column at a time, so that a sample is within one of any exact one.

/// Samples in the order of the image, and the image's size.
pub(super) struct Decoded {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// A sample a pixel.
    pub samples: Vec<u16>,
}

/// The natural order of the zigzag.
const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7, 14, 21,
    28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39, 46, 53, 60, 61, 54,
    47, 55, 62, 63,
];

/// A Huffman table: of each length the first code, one past the last, and the place of its values.
#[derive(Clone, Default)]
struct Huffman {
    first: [i32; 17],
    count: [i32; 17],
    place: [usize; 17],
    values: Vec<u8>,
}

impl Huffman {
    fn new(counts: &[u8], values: &[u8]) -> Self {
        let mut table = Self {
            values: values.to_vec(),
            ..Self::default()
        };
        let (mut code, mut place) = (0, 0);
        for bits in 1..=16 {
            table.first[bits] = code;
            table.count[bits] = i32::from(counts[bits - 1]);
            table.place[bits] = place;
            place += usize::from(counts[bits - 1]);
            code = (code + table.count[bits]) << 1;
        }
        table
    }
}

/// The bits of a scan. Behind its end, or a marker, they are zeros.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    hold: u32,
    held: u32,
}

impl Bits<'_> {
    fn bit(&mut self) -> i32 {
        if self.held == 0 {
            self.hold = u32::from(self.byte());
            self.held = 8;
        }
        self.held -= 1;
        (self.hold >> self.held & 1) as i32
    }

    fn byte(&mut self) -> u8 {
        match self.bytes.get(self.at..) {
            Some([0xff, 0, ..]) => {
                self.at += 2;
                0xff
            }
            Some([0xff, ..] | []) | None => 0,
            Some([byte, ..]) => {
                self.at += 1;
                *byte
            }
        }
    }

    /// Past the restart marker that follows.
    fn restart(&mut self) {
        self.held = 0;
        if let Some([0xff, 0xd0..=0xd7, ..]) = self.bytes.get(self.at..) {
            self.at += 2;
        }
    }

    fn symbol(&mut self, table: &Huffman) -> Option<u8> {
        let mut code = 0;
        for bits in 1..=16 {
            code = code << 1 | self.bit();
            let index = code - table.first[bits];
            if (0..table.count[bits]).contains(&index) {
                return table.values.get(table.place[bits] + index as usize).copied();
            }
        }
        None
    }

    /// A number of `size` bits and its sign, as F.2.2.1 extends it.
    fn number(&mut self, size: u32) -> i32 {
        let value = (0..size).fold(0, |v, _| v << 1 | self.bit());
        match size > 0 && value < 1 << (size - 1) {
            true => value - (1 << size) + 1,
            false => value,
        }
    }
}

/// What the segments before the scan say.
#[derive(Default)]
struct Header {
    size: Option<[usize; 2]>,
    quantization: [Vec<u16>; 4],
    dc: [Huffman; 4],
    ac: [Huffman; 4],
    table: usize,
    restart: usize,
}

/// Whether `stream` is JPEG of the extended process with twelve bits a sample.
pub(super) fn is_twelve_bit(stream: &[u8]) -> bool {
    let frame = segments(stream).find(|s| matches!(s.0, 0xc0..=0xc2));
    matches!(frame, Some((0xc1, [12, ..], _)))
}

/// Decodes `stream`, of a size that `check` allows.
pub(super) fn decode(stream: &[u8], check: impl Fn(usize, usize) -> bool) -> Result<Decoded, String> {
    let mut header = Header::default();
    for (marker, segment, end) in segments(stream) {
        if marker == 0xda {
            let [width, height] = header.size.ok_or("its JPEG stream has no frame header")?;
            if !check(width, height) {
                return Err(format!("its JPEG stream is an image of {width} x {height}"));
            }
            let &[1, _, tables, ..] = segment else {
                return Err("JPEG of twelve bits with several components is not read".into());
            };
            return header.scan(&stream[end..], tables);
        }
        header
            .take(marker, segment)
            .ok_or("a segment of its JPEG stream is damaged")?;
    }
    Err("its JPEG stream has no scan".into())
}

/// The marker, the contents and the end of each segment, up to a scan's.
pub(super) fn segments(stream: &[u8]) -> impl Iterator<Item = (u8, &[u8], usize)> {
    let mut at = 2;
    let mut over = false;
    std::iter::from_fn(move || {
        while !over && stream.get(at..at + 2) == Some(&[0xff, 0xff]) {
            at += 1;
        }
        let &[0xff, marker, high, low] = stream.get(at..at + 4).filter(|_| !over)? else {
            return None;
        };
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        let segment = stream.get(at + 4..end)?;
        at = end;
        over = marker == 0xda;
        Some((marker, segment, end))
    })
}

impl Header {
    fn take(&mut self, marker: u8, segment: &[u8]) -> Option<()> {
        match marker {
            0xc1 => {
                let &[12, h1, h0, w1, w0, 1, _, _, table, ..] = segment else {
                    return None;
                };
                self.size = Some([[w1, w0], [h1, h0]].map(|b| usize::from(u16::from_be_bytes(b))));
                self.table = usize::from(table & 3);
            }
            0xc4 => self.huffman(segment)?,
            0xdb => self.quantization(segment)?,
            0xdd => self.restart = usize::from(u16::from_be_bytes(*segment.first_chunk()?)),
            _ => {}
        }
        Some(())
    }

    fn huffman(&mut self, mut segment: &[u8]) -> Option<()> {
        while let [class, rest @ ..] = segment {
            let (counts, rest) = rest.split_at_checked(16)?;
            let total = counts.iter().map(|&n| usize::from(n)).sum();
            let (values, rest) = rest.split_at_checked(total)?;
            let tables = if class >> 4 == 0 { &mut self.dc } else { &mut self.ac };
            tables[usize::from(class & 3)] = Huffman::new(counts, values);
            segment = rest;
        }
        Some(())
    }

    fn quantization(&mut self, mut segment: &[u8]) -> Option<()> {
        while let [which, rest @ ..] = segment {
            let bytes = if which >> 4 == 0 { 1 } else { 2 };
            let (entries, rest) = rest.split_at_checked(64 * bytes)?;
            let entry = |value: &[u8]| value.iter().fold(0, |v, &b| v << 8 | u16::from(b));
            self.quantization[usize::from(which & 3)] = entries.chunks_exact(bytes).map(entry).collect();
            segment = rest;
        }
        Some(())
    }

    fn scan(&self, bytes: &[u8], tables: u8) -> Result<Decoded, String> {
        let [width, height] = self.size.unwrap_or_default();
        let mut samples = vec![0; width * height];
        let mut bits = Bits {
            bytes,
            at: 0,
            hold: 0,
            held: 0,
        };
        let cosines = cosines();
        let across = width.div_ceil(8);
        let mut dc = 0;
        for block in 0..across * height.div_ceil(8) {
            if self.restart > 0 && block > 0 && block % self.restart == 0 {
                bits.restart();
                dc = 0;
            }
            let coefficients = (self.block(&mut bits, tables, &mut dc)).ok_or("its JPEG stream is damaged")?;
            let pixels = inverse(&coefficients, &cosines);
            let (x0, y0) = (block % across * 8, block / across * 8);
            for y in y0..(y0 + 8).min(height) {
                for x in x0..(x0 + 8).min(width) {
                    let value = pixels[(y - y0) * 8 + x - x0].round() + 2048.0;
                    samples[y * width + x] = value.clamp(0.0, 4095.0) as u16;
                }
            }
        }
        Ok(Decoded { width, height, samples })
    }

    /// The next block's coefficients, times their quantization, in natural order.
    fn block(&self, bits: &mut Bits, tables: u8, dc: &mut i32) -> Option<[f32; 64]> {
        let quantization: &[u16; 64] = self.quantization[self.table].first_chunk()?;
        let (dc_table, ac_table) = (
            &self.dc[usize::from(tables >> 4 & 3)],
            &self.ac[usize::from(tables & 3)],
        );
        let mut block = [0.0; 64];
        let size = u32::from(bits.symbol(dc_table)?);
        *dc = dc.wrapping_add(bits.number(size.min(16)));
        block[0] = *dc as f32 * f32::from(quantization[0]);
        let mut k = 1;
        while k < 64 {
            let symbol = bits.symbol(ac_table)?;
            let (run, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            match (run, size) {
                (15, 0) => k += 16,
                (_, 0) => break,
                _ => {
                    k += run;
                    let place = usize::from(*ZIGZAG.get(k)?);
                    block[place] = bits.number(size) as f32 * f32::from(quantization[k]);
                    k += 1;
                }
            }
        }
        Some(block)
    }
}

/// Half of C(u) cos((2x + 1)uπ/16), at 8x + u.
fn cosines() -> [f32; 64] {
    std::array::from_fn(|i| {
        let (x, u) = ((i / 8) as f64, (i % 8) as f64);
        let scale = if i % 8 == 0 { 0.5f64.sqrt() } else { 1.0 };
        (scale / 2.0 * ((2.0 * x + 1.0) * u * std::f64::consts::PI / 16.0).cos()) as f32
    })
}

/// The inverse transform of A.3.3: first along rows, then along columns.
fn inverse(coefficients: &[f32; 64], cosines: &[f32; 64]) -> [f32; 64] {
    let along_rows: [f32; 64] = std::array::from_fn(|i| {
        let (v, x) = (i / 8, i % 8);
        (0..8).map(|u| coefficients[v * 8 + u] * cosines[x * 8 + u]).sum()
    });
    std::array::from_fn(|i| {
        let (y, x) = (i / 8, i % 8);
        (0..8).map(|v| along_rows[v * 8 + x] * cosines[y * 8 + v]).sum()
    })
}
