//! DICOM files as the tests write them: PS3.10 by hand, so that what reads them is not what wrote them.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::DeflateEncoder;

pub const IMPLICIT: &str = "1.2.840.10008.1.2";
pub const EXPLICIT: &str = "1.2.840.10008.1.2.1";
pub const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
pub const BIG: &str = "1.2.840.10008.1.2.2";
pub const RLE: &str = "1.2.840.10008.1.2.5";
pub const JPEG_LS: &str = "1.2.840.10008.1.2.4.80";

/// Columns and rows of the slices.
pub const SIZE: [usize; 2] = [4, 3];

/// An element's value.
#[derive(Clone)]
pub enum Value {
    /// Text of a representation.
    Text(&'static str, String),
    /// 16-bit numbers.
    Us(Vec<u16>),
    /// Items.
    Items(Vec<Elements>),
}

pub type Elements = BTreeMap<(u16, u16), Value>;

/// A file to be written.
#[derive(Clone)]
pub struct File {
    pub syntax: &'static str,
    pub elements: Elements,
    /// The frames' bytes as they are stored, in little endian.
    pub frames: Vec<Vec<u8>>,
}

impl File {
    /// A slice of 4 x 3 pixels: 100 times its `number` and on, at `z` millimetres.
    pub fn slice(number: u16, z: f64) -> Self {
        let values = (0..12).flat_map(|i| (100 * number + i).to_le_bytes()).collect();
        let mut file = Self {
            syntax: EXPLICIT,
            elements: Elements::new(),
            frames: vec![values],
        };
        file.text((0x8, 0x16), "UI", "1.2.840.10008.5.1.4.1.1.4");
        file.text((0x8, 0x18), "UI", &format!("1.2.3.{number}"));
        file.text((0x8, 0x60), "CS", "MR");
        file.text((0x8, 0x103e), "LO", "Test series");
        file.text((0x20, 0xe), "UI", "1.2.3");
        file.text((0x20, 0x13), "IS", &number.to_string());
        file.place([0.0, 0.0, z]);
        file.text((0x20, 0x37), "DS", "1\\0\\0\\0\\1\\0");
        file.text((0x28, 0x4), "CS", "MONOCHROME2");
        file.text((0x28, 0x30), "DS", "0.5\\0.25");
        for (tag, value) in [
            (0x2, 1),
            (0x10, 3),
            (0x11, 4),
            (0x100, 16),
            (0x101, 16),
            (0x102, 15),
            (0x103, 0),
        ] {
            file.us((0x28, tag), value);
        }
        file
    }

    pub fn text(&mut self, tag: (u16, u16), vr: &'static str, text: &str) {
        self.elements.insert(tag, Value::Text(vr, text.to_owned()));
    }

    pub fn us(&mut self, tag: (u16, u16), value: u16) {
        self.elements.insert(tag, Value::Us(vec![value]));
    }

    pub fn place(&mut self, [x, y, z]: [f64; 3]) {
        self.text((0x20, 0x32), "DS", &format!("{x}\\{y}\\{z}"));
    }

    /// The file's bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 128];
        bytes.extend(b"DICM");
        let mut meta = Vec::new();
        let explicit = Writer {
            explicit: true,
            big: false,
        };
        explicit.element(&mut meta, (2, 0x10), &Value::Text("UI", self.syntax.to_owned()));
        bytes.extend(meta);
        let data = self.dataset();
        if self.syntax == DEFLATED {
            let mut encoder = DeflateEncoder::new(&mut bytes, Compression::fast());
            encoder.write_all(&data).unwrap();
            encoder.finish().unwrap();
        } else {
            bytes.extend(data);
        }
        bytes
    }

    fn dataset(&self) -> Vec<u8> {
        let writer = Writer {
            explicit: self.syntax != IMPLICIT,
            big: self.syntax == BIG,
        };
        let mut bytes = Vec::new();
        for (tag, value) in &self.elements {
            writer.element(&mut bytes, *tag, value);
        }
        let native = [IMPLICIT, EXPLICIT, DEFLATED, BIG].contains(&self.syntax);
        if native {
            let mut pixels = self.frames.concat();
            if writer.big {
                pixels.chunks_exact_mut(2).for_each(<[u8]>::reverse);
            }
            writer.header(&mut bytes, (0x7fe0, 0x10), "OW", pixels.len() as u32);
            bytes.extend(pixels);
            return bytes;
        }
        writer.header(&mut bytes, (0x7fe0, 0x10), "OB", u32::MAX);
        writer.item(&mut bytes, &[]);
        for frame in &self.frames {
            writer.item(&mut bytes, frame);
        }
        writer.tag(&mut bytes, (0xfffe, 0xe0dd));
        bytes.extend([0; 4]);
        bytes
    }

    /// Writes it in `folder`.
    pub fn write(&self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        fs::write(&path, self.bytes()).unwrap();
        path
    }
}

struct Writer {
    explicit: bool,
    big: bool,
}

impl Writer {
    fn u16(&self, bytes: &mut Vec<u8>, v: u16) {
        bytes.extend(if self.big { v.to_be_bytes() } else { v.to_le_bytes() });
    }

    fn u32(&self, bytes: &mut Vec<u8>, v: u32) {
        bytes.extend(if self.big { v.to_be_bytes() } else { v.to_le_bytes() });
    }

    fn tag(&self, bytes: &mut Vec<u8>, (group, element): (u16, u16)) {
        self.u16(bytes, group);
        self.u16(bytes, element);
    }

    fn header(&self, bytes: &mut Vec<u8>, tag: (u16, u16), vr: &str, length: u32) {
        self.tag(bytes, tag);
        if !self.explicit {
            return self.u32(bytes, length);
        }
        bytes.extend(vr.as_bytes());
        if ["OB", "OW", "SQ", "UN"].contains(&vr) {
            bytes.extend([0; 2]);
            self.u32(bytes, length);
        } else {
            self.u16(bytes, length as u16);
        }
    }

    fn item(&self, bytes: &mut Vec<u8>, value: &[u8]) {
        self.tag(bytes, (0xfffe, 0xe000));
        self.u32(bytes, value.len() as u32);
        bytes.extend(value);
    }

    fn element(&self, bytes: &mut Vec<u8>, tag: (u16, u16), value: &Value) {
        match value {
            Value::Text(vr, text) => {
                let mut text = text.clone().into_bytes();
                if text.len() % 2 == 1 {
                    text.push(if *vr == "UI" { 0 } else { b' ' });
                }
                self.header(bytes, tag, vr, text.len() as u32);
                bytes.extend(text);
            }
            Value::Us(numbers) => {
                self.header(bytes, tag, "US", 2 * numbers.len() as u32);
                numbers.iter().for_each(|&n| self.u16(bytes, n));
            }
            Value::Items(items) => {
                let mut inner = Vec::new();
                for item in items {
                    let mut elements = Vec::new();
                    for (tag, value) in item {
                        self.element(&mut elements, *tag, value);
                    }
                    self.item(&mut inner, &elements);
                }
                self.header(bytes, tag, "SQ", inner.len() as u32);
                bytes.extend(inner);
            }
        }
    }
}
