//! A DICOM file's bytes: its preamble, its file meta information, and the data set behind them, inflated if need be.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use dicom_core::VR;
use dicom_encoding::{TransferSyntax, TransferSyntaxIndex};
use dicom_transfer_syntax_registry::TransferSyntaxRegistry;
use flate2::read::DeflateDecoder;

use super::dataset::{Dataset, Pixels};
use crate::volume::io::error::{Problem, ReadError};
use crate::volume::io::stored::ByteOrder;

/// The transfer syntaxes that say how a data set is encoded, when no pixels are compressed.
pub(super) const IMPLICIT_LITTLE: &str = "1.2.840.10008.1.2";
pub(super) const EXPLICIT_LITTLE: &str = "1.2.840.10008.1.2.1";
const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
pub(super) const EXPLICIT_BIG: &str = "1.2.840.10008.1.2.2";

/// Bytes before the file meta information: the preamble and `DICM`.
const PREAMBLE: usize = 132;

/// The most bytes that a deflated data set may have.
const MAX_INFLATED: u64 = 1 << 30;

/// A file whose data set is read.
pub(super) struct Opened {
    /// What the data set says.
    pub dataset: Dataset,
    /// Where its pixels are, among `bytes`.
    pub pixels: Option<Pixels>,
    /// The transfer syntax's UID.
    pub syntax: String,
    /// The byte order of its numbers.
    pub order: ByteOrder,
    /// Its bytes.
    pub bytes: Bytes,
}

/// Where a file's bytes are taken from.
#[derive(Clone, Debug)]
pub(super) enum Bytes {
    /// The file itself, of so many bytes.
    File(u64),
    /// Memory: what a deflated file holds.
    Inflated(Arc<Vec<u8>>),
}

/// Whether a file that starts so is DICOM: `DICM` behind the preamble, or without one a first element of group 2 or 8.
pub(super) fn is_dicom(start: &[u8]) -> bool {
    start.get(128..PREAMBLE) == Some(b"DICM") || Encoding::guess(start).is_some()
}

/// How elements are encoded.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Encoding {
    explicit: bool,
    order: ByteOrder,
}

impl Encoding {
    /// As the first element shows it, which is one of group 2 or 8 with a small number.
    fn guess(start: &[u8]) -> Option<Self> {
        let [a, b, c, d, vr @ .., e, f] = *start.first_chunk::<8>()?;
        let order = match [a, b, d, c] {
            [2 | 8, 0, 0, _] => ByteOrder::Little,
            [0, 2 | 8, _, 0] => ByteOrder::Big,
            _ => return None,
        };
        let explicit = VR::from_binary(vr).is_some();
        // The value of a first element without a representation is short.
        let short = explicit || (order == ByteOrder::Little && [vr[1], e, f] == [0, 0, 0] && vr[0] % 2 == 0);
        short.then_some(Self { explicit, order })
    }

    fn syntax(self) -> &'static str {
        match (self.explicit, self.order) {
            (false, _) => IMPLICIT_LITTLE,
            (true, ByteOrder::Little) => EXPLICIT_LITTLE,
            (true, ByteOrder::Big) => EXPLICIT_BIG,
        }
    }
}

impl Opened {
    /// Reads the file at `path` up to its pixels.
    pub(super) fn read(path: &Path) -> Result<Self, ReadError> {
        let io_error = |e| ReadError::io(path, e);
        let mut file = BufReader::new(File::open(path).map_err(io_error)?);
        let length = file.get_ref().metadata().map_err(io_error)?.len();
        let meta = Meta::read(&mut file).map_err(io_error)?;
        file.seek(SeekFrom::Start(meta.end)).map_err(io_error)?;
        let shown = guess(path, &mut file, meta.end)?;
        let unknown = || {
            let what = "it names no transfer syntax, and its elements do not show how they are encoded";
            ReadError::header(path, what).byte(meta.end)
        };
        let syntax = match (meta.syntax, shown) {
            (Some(syntax), _) => syntax,
            (None, Some(shown)) => shown.syntax().to_owned(),
            (None, None) => return Err(unknown()),
        };
        let known = TransferSyntaxRegistry.get(&syntax);
        let known = known.ok_or_else(|| {
            let what = format!("its transfer syntax `{}` is not known", printable(&syntax));
            ReadError::unsupported(path, what).hint("convert it to Explicit VR Little Endian")
        })?;
        let order = match syntax == EXPLICIT_BIG {
            true => ByteOrder::Big,
            false => ByteOrder::Little,
        };
        if syntax != DEFLATED {
            // Some writers put explicit elements in an implicit data set, and the other way round.
            let shown = shown.filter(|shown| shown.order == ByteOrder::Little && order == ByteOrder::Little);
            let known = shown
                .and_then(|shown| TransferSyntaxRegistry.get(shown.syntax()))
                .unwrap_or(known);
            return Self::of(path, file, known, syntax, order, Bytes::File(length));
        }
        let inflated = Arc::new(inflate(path, file)?);
        let plain = TransferSyntaxRegistry.get(EXPLICIT_LITTLE).unwrap_or(known);
        let bytes = Bytes::Inflated(inflated.clone());
        Self::of(
            path,
            Cursor::new(inflated.as_slice()),
            plain,
            EXPLICIT_LITTLE.into(),
            order,
            bytes,
        )
    }

    fn of(
        path: &Path,
        source: impl Read + Seek,
        known: &TransferSyntax,
        syntax: String,
        order: ByteOrder,
        bytes: Bytes,
    ) -> Result<Self, ReadError> {
        let (dataset, pixels) = Dataset::read(source, known, order).map_err(|damage| {
            ReadError::header(path, damage.what)
                .byte(damage.byte)
                .hint("the file is incomplete or damaged: copy or export it again")
        })?;
        Ok(Self {
            dataset,
            pixels,
            syntax,
            order,
            bytes,
        })
    }
}

/// Text from a file without what would upset a terminal.
pub(super) fn printable(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(80).collect()
}

/// How the elements from byte `at` on are encoded, if they show it. The file is there afterwards.
fn guess(path: &Path, file: &mut BufReader<File>, at: u64) -> Result<Option<Encoding>, ReadError> {
    let mut start = Vec::new();
    let read = (file.by_ref().take(8).read_to_end(&mut start)).and_then(|_| file.seek(SeekFrom::Start(at)));
    read.map_err(|e| ReadError::io(path, e))?;
    Ok(Encoding::guess(&start))
}

fn inflate(path: &Path, file: impl Read) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    let mut stream = DeflateDecoder::new(file).take(MAX_INFLATED + 1);
    let read = stream.read_to_end(&mut bytes);
    read.map_err(|e| ReadError::new(path, Problem::Compressed(e)).hint("copy or export the file again"))?;
    match bytes.len() as u64 > MAX_INFLATED {
        true => Err(ReadError::unsupported(path, "it inflates to more than a gibibyte").hint("store it uncompressed")),
        false => Ok(bytes),
    }
}

/// The file meta information.
struct Meta {
    syntax: Option<String>,
    /// Where the data set starts.
    end: u64,
}

impl Meta {
    /// Elements of group 2 in explicit little endian, whatever their declared group length.
    fn read(file: &mut BufReader<File>) -> io::Result<Self> {
        let mut start = Vec::new();
        file.by_ref().take(PREAMBLE as u64).read_to_end(&mut start)?;
        let mut end = if start.ends_with(b"DICM") && start.len() == PREAMBLE {
            PREAMBLE as u64
        } else {
            0
        };
        let mut syntax = None;
        loop {
            file.seek(SeekFrom::Start(end))?;
            let mut header = [0; 12];
            let there = file.by_ref().take(12).read(&mut header)?;
            if there < 8 || header[..2] != [2, 0] {
                return Ok(Self { syntax, end });
            }
            let long = matches!(&header[4..6], b"OB" | b"OW" | b"UN" | b"UT" | b"SQ");
            let (skip, bytes) = match long {
                true => (12, u32::from_le_bytes([header[8], header[9], header[10], header[11]])),
                false => (8, u32::from(u16::from_le_bytes([header[6], header[7]]))),
            };
            if header[2..4] == [0x10, 0] && !long {
                let mut value = Vec::new();
                file.seek(SeekFrom::Start(end + skip))?;
                file.by_ref().take(u64::from(bytes)).read_to_end(&mut value)?;
                let text = String::from_utf8_lossy(&value);
                let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
                syntax = (!text.is_empty()).then(|| text.to_owned());
            }
            end += skip + u64::from(bytes);
        }
    }
}

impl Bytes {
    /// How many there are.
    pub(super) fn len(&self) -> u64 {
        match self {
            Self::File(length) => *length,
            Self::Inflated(bytes) => bytes.len() as u64,
        }
    }

    /// Those of `ranges`, one after the other. They were found there when the file was opened.
    pub(super) fn read(&self, path: &Path, ranges: &[Range<u64>]) -> Result<Vec<u8>, ReadError> {
        let total: u64 = ranges.iter().map(|range| range.end - range.start).sum();
        let mut bytes = Vec::new();
        let memory = |_| ReadError::new(path, Problem::Memory(total));
        bytes.try_reserve_exact(total as usize).map_err(memory)?;
        match self {
            Self::Inflated(all) => {
                for range in ranges {
                    bytes.extend_from_slice(&all[range.start as usize..range.end as usize]);
                }
            }
            Self::File(_) => {
                let mut file = File::open(path).map_err(|e| ReadError::io(path, e))?;
                for range in ranges {
                    let read = (file.seek(SeekFrom::Start(range.start)))
                        .and_then(|_| file.by_ref().take(range.end - range.start).read_to_end(&mut bytes));
                    read.map_err(|e| ReadError::io(path, e))?;
                }
            }
        }
        match bytes.len() as u64 == total {
            true => Ok(bytes),
            false => Err(ReadError::new(
                path,
                Problem::Truncated {
                    expected: total,
                    found: bytes.len() as u64,
                },
            )),
        }
    }
}
