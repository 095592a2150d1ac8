//! A DICOM data set, of which only what a volume needs is kept.
//!
//! *Practice.* The tokens come from `dicom-parser`, lazily: what is not wanted is skipped without being kept, sequences nest on a
//! stack of this file's own and only so deep, and a value is read through a reader that ends where the file ends, so that a
//! declared length allocates nothing.

use std::io::{Read, Seek};

use dicom_core::dictionary::{DataDictionary, VirtualVr};
use dicom_core::{Tag, VR};
use dicom_dictionary_std::{StandardDataDictionary, tags};
use dicom_encoding::TransferSyntax;
use dicom_parser::StatefulDecode;
use dicom_parser::dataset::LazyDataToken;
use dicom_parser::dataset::lazy_read::LazyDataSetReader;

use crate::volume::io::stored::ByteOrder;

/// How deep sequences may nest; functional groups nest two deep.
const MAX_DEPTH: usize = 64;

/// The most bytes of one value that are kept: a palette has 65536 entries of two bytes, and 100,000 frames have offsets of 16
/// characters.
const MAX_VALUE: u32 = 1 << 21;

/// The elements that are kept, wherever they stand.
const WANTED: [Tag; 45] = [
    tags::IMAGE_TYPE,
    tags::SOP_INSTANCE_UID,
    tags::SERIES_DESCRIPTION,
    tags::SPACING_BETWEEN_SLICES,
    tags::IMAGER_PIXEL_SPACING,
    tags::NOMINAL_SCANNED_PIXEL_SPACING,
    tags::SERIES_INSTANCE_UID,
    tags::INSTANCE_NUMBER,
    tags::IMAGE_POSITION_PATIENT,
    tags::IMAGE_ORIENTATION_PATIENT,
    tags::TEMPORAL_POSITION_IDENTIFIER,
    tags::FRAME_CONTENT_SEQUENCE,
    tags::TEMPORAL_POSITION_INDEX,
    tags::PLANE_POSITION_SEQUENCE,
    tags::PLANE_ORIENTATION_SEQUENCE,
    tags::SAMPLES_PER_PIXEL,
    tags::PHOTOMETRIC_INTERPRETATION,
    tags::PLANAR_CONFIGURATION,
    tags::NUMBER_OF_FRAMES,
    tags::ROWS,
    tags::COLUMNS,
    tags::PIXEL_SPACING,
    tags::BITS_ALLOCATED,
    tags::BITS_STORED,
    tags::HIGH_BIT,
    tags::PIXEL_REPRESENTATION,
    tags::RESCALE_INTERCEPT,
    tags::RESCALE_SLOPE,
    tags::RED_PALETTE_COLOR_LOOKUP_TABLE_DESCRIPTOR,
    tags::RED_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    tags::GREEN_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    tags::BLUE_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    tags::SEGMENTED_RED_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    tags::SEGMENTED_GREEN_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    tags::SEGMENTED_BLUE_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    tags::MODALITY_LUT_SEQUENCE,
    tags::PIXEL_MEASURES_SEQUENCE,
    tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE,
    tags::DETECTOR_INFORMATION_SEQUENCE,
    tags::SLICE_VECTOR,
    tags::GRID_FRAME_OFFSET_VECTOR,
    tags::DOSE_GRID_SCALING,
    tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE,
    tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE,
    tags::EXTENDED_OFFSET_TABLE,
];

/// A data set, or an item of a sequence.
#[derive(Debug, Default)]
pub(super) struct Dataset {
    elements: Vec<(Tag, Value)>,
}

#[derive(Debug)]
enum Value {
    Bytes(VR, ByteOrder, Vec<u8>),
    Items(Vec<Dataset>),
}

/// Where the pixels begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pixels {
    /// As they are: from a byte on, so many bytes.
    Native {
        /// The first byte.
        offset: u64,
        /// How many are declared.
        bytes: u64,
        /// Whether they come in words of two.
        words: bool,
    },
    /// Items of compressed bytes, the first of which begins at a byte.
    Encapsulated {
        /// The first byte of the first item's header.
        offset: u64,
    },
}

/// Why a data set cannot be read on.
#[derive(Debug)]
pub(super) struct Damage {
    /// What is wrong.
    pub what: String,
    /// At which byte.
    pub byte: u64,
}

impl Dataset {
    /// The data set from `source`'s position up to its pixels, and where those are; `None` without any.
    pub(super) fn read<S: Read + Seek>(
        source: S,
        syntax: &TransferSyntax,
        order: ByteOrder,
    ) -> Result<(Self, Option<Pixels>), Damage> {
        let mut reader = LazyDataSetReader::new_with_ts(source, syntax).map_err(|e| Damage {
            what: e.to_string(),
            byte: 0,
        })?;
        let mut tree = Tree::new(order);
        let end = loop {
            match reader.advance() {
                None => break Ok(None),
                Some(Err(e)) => break Err(format!("its elements are damaged: {e}")),
                Some(Ok(token)) => match tree.take(token) {
                    Ok(Step::On) => {}
                    Ok(Step::Native(pixels)) => break Ok(Some(pixels)),
                    Ok(Step::Encapsulated) => break Ok(Some(Pixels::Encapsulated { offset: 0 })),
                    Ok(Step::Past) => break Ok(None),
                    Err(what) => break Err(what),
                },
            }
        };
        let byte = reader.into_decoder().position();
        let pixels = end.map_err(|what| Damage { what, byte })?;
        let pixels = pixels.map(|pixels| match pixels {
            Pixels::Encapsulated { .. } => Pixels::Encapsulated { offset: byte },
            native => native,
        });
        Ok((tree.root(), pixels))
    }

    fn value(&self, tag: Tag) -> Option<&Value> {
        self.elements.iter().find(|(t, _)| *t == tag).map(|(_, value)| value)
    }

    /// The items of a sequence; none where it is missing.
    pub(super) fn items(&self, tag: Tag) -> &[Dataset] {
        match self.value(tag) {
            Some(Value::Items(items)) => items,
            _ => &[],
        }
    }

    /// The bytes of an element, and their order.
    pub(super) fn bytes(&self, tag: Tag) -> Option<(&[u8], ByteOrder)> {
        match self.value(tag) {
            Some(Value::Bytes(_, order, bytes)) => Some((bytes, *order)),
            _ => None,
        }
    }

    /// The text of an element without the white space and zeros around it; what is no UTF-8 is replaced.
    pub(super) fn text(&self, tag: Tag) -> Option<String> {
        let (bytes, _) = self.bytes(tag)?;
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
        (!text.is_empty()).then(|| text.to_owned())
    }

    /// The numbers of an element, in binary or text; none where it is missing or no numbers.
    pub(super) fn numbers(&self, tag: Tag) -> Vec<f64> {
        let Some(Value::Bytes(vr, order, bytes)) = self.value(tag) else {
            return Vec::new();
        };
        match kind(tag, *vr) {
            VR::US => chunks(bytes, *order, |b| f64::from(u16::from_le_bytes(b))),
            VR::SS => chunks(bytes, *order, |b| f64::from(i16::from_le_bytes(b))),
            VR::UL => chunks(bytes, *order, |b| f64::from(u32::from_le_bytes(b))),
            VR::SL => chunks(bytes, *order, |b| f64::from(i32::from_le_bytes(b))),
            VR::FL => chunks(bytes, *order, |b| f64::from(f32::from_le_bytes(b))),
            VR::FD => chunks(bytes, *order, f64::from_le_bytes),
            VR::OV | VR::UV => chunks(bytes, *order, |b| u64::from_le_bytes(b) as f64),
            _ => text_numbers(bytes),
        }
    }

    /// The first number of an element, where it is finite.
    pub(super) fn number(&self, tag: Tag) -> Option<f64> {
        self.numbers(tag).first().copied().filter(|v| v.is_finite())
    }

    /// The first `N` numbers of an element, where there are as many and all are finite.
    pub(super) fn vector<const N: usize>(&self, tag: Tag) -> Option<[f64; N]> {
        let numbers = self.numbers(tag);
        let first: [f64; N] = numbers.get(..N)?.try_into().ok()?;
        first.iter().all(|v| v.is_finite()).then_some(first)
    }
}

/// The representation that an element's bytes have: its own, but where that says nothing the dictionary's.
fn kind(tag: Tag, vr: VR) -> VR {
    match vr {
        VR::UN | VR::OB | VR::OW => match StandardDataDictionary.by_tag(tag).map(|entry| entry.vr) {
            Some(VirtualVr::Exact(known)) => known,
            Some(_) => VR::US,
            None => vr,
        },
        vr => vr,
    }
}

fn chunks<const N: usize>(bytes: &[u8], order: ByteOrder, number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    let little = |chunk: &[u8]| {
        let mut little: [u8; N] = std::array::from_fn(|i| chunk[i]);
        if order == ByteOrder::Big {
            little.reverse();
        }
        number(little)
    };
    bytes.chunks_exact(N).map(little).collect()
}

/// Numbers separated by backslashes; up to the first that is none. Some writers use a comma for the point.
fn text_numbers(bytes: &[u8]) -> Vec<f64> {
    let text = String::from_utf8_lossy(bytes).replace(',', ".");
    let number = |word: &str| word.trim_matches(|c: char| c.is_whitespace() || c == '\0').parse().ok();
    text.split('\\').map_while(number).collect()
}

/// What follows from a token.
enum Step {
    On,
    Native(Pixels),
    Encapsulated,
    Past,
}

/// The tree as far as it has been read.
struct Tree {
    order: ByteOrder,
    /// The data set and the open items in it.
    open: Vec<Dataset>,
    /// The open sequences: one less than data sets, or as many between two items.
    sequences: Vec<(Tag, Vec<Dataset>)>,
}

impl Tree {
    fn new(order: ByteOrder) -> Self {
        Self {
            order,
            open: vec![Dataset::default()],
            sequences: Vec::new(),
        }
    }

    fn root(mut self) -> Dataset {
        self.open.swap_remove(0)
    }

    fn take<S: StatefulDecode>(&mut self, token: LazyDataToken<&mut S>) -> Result<Step, String> {
        let outermost = self.sequences.is_empty();
        match token {
            LazyDataToken::ElementHeader(_) => {}
            LazyDataToken::LazyValue { header, decoder } => {
                let bytes = header.len.get().unwrap_or(0);
                if outermost && header.tag == tags::PIXEL_DATA {
                    let offset = decoder.position();
                    return Ok(Step::Native(Pixels::Native {
                        offset,
                        bytes: u64::from(bytes),
                        words: header.vr == VR::OW,
                    }));
                }
                if outermost && header.tag > tags::PIXEL_DATA {
                    return Ok(Step::Past);
                }
                self.value(header.tag, header.vr, bytes, decoder)?;
            }
            LazyDataToken::PixelSequenceStart if outermost => return Ok(Step::Encapsulated),
            LazyDataToken::PixelSequenceStart => self.sequence(tags::PIXEL_DATA)?,
            LazyDataToken::SequenceStart { tag, .. } => self.sequence(tag)?,
            LazyDataToken::ItemStart { .. } => self.open.push(Dataset::default()),
            LazyDataToken::ItemEnd => self.end_item()?,
            LazyDataToken::SequenceEnd => self.end_sequence()?,
            LazyDataToken::LazyItemValue { len, decoder } => decoder.skip_bytes(len).map_err(|e| e.to_string())?,
            _ => {}
        }
        Ok(Step::On)
    }

    fn value(&mut self, tag: Tag, vr: VR, bytes: u32, decoder: &mut impl StatefulDecode) -> Result<(), String> {
        if !WANTED.contains(&tag) || bytes > MAX_VALUE {
            return decoder.skip_bytes(bytes).map_err(|e| e.to_string());
        }
        let mut value = Vec::new();
        decoder.read_to(bytes, &mut value).map_err(|e| e.to_string())?;
        match value.len() == bytes as usize {
            true => self.put(tag, Value::Bytes(vr, self.order, value)),
            false => Err(format!("the file ends within element {tag}")),
        }
    }

    fn put(&mut self, tag: Tag, value: Value) -> Result<(), String> {
        let dataset = self.open.last_mut().ok_or("an item ends that never began")?;
        dataset.elements.push((tag, value));
        Ok(())
    }

    fn sequence(&mut self, tag: Tag) -> Result<(), String> {
        if self.sequences.len() >= MAX_DEPTH {
            return Err(format!("its sequences nest more than {MAX_DEPTH} deep"));
        }
        self.sequences.push((tag, Vec::new()));
        Ok(())
    }

    fn end_item(&mut self) -> Result<(), String> {
        let item = self.open.pop().filter(|_| !self.open.is_empty());
        let (sequence, item) = (self.sequences.last_mut().zip(item)).ok_or("an item ends that never began")?;
        if WANTED.contains(&sequence.0) {
            sequence.1.push(item);
        }
        Ok(())
    }

    fn end_sequence(&mut self) -> Result<(), String> {
        let (tag, items) = self.sequences.pop().ok_or("a sequence ends that never began")?;
        match WANTED.contains(&tag) {
            true => self.put(tag, Value::Items(items)),
            false => Ok(()),
        }
    }
}
