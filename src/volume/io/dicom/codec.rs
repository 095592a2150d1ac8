//! Compressed frames, through the crates that decode them.
//!
//! *Practice.* Each stream's own header is read first, and must declare the image that the data set declares: so no codec makes
//! room for another, and what that takes was checked against the bytes there. RLE is 20 lines, and here, since the crates' readers of it trust a declared number of segments.

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};
use jpeg_decoder::{CodingProcess, ColorTransform, Decoder, PixelFormat};

use super::jpeg_ls;
use super::jpeg12;
use super::layout::{Colour, Layout};
use crate::volume::io::caught::caught;

/// How frames are compressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Codec {
    /// Not at all.
    Native,
    /// Runs of bytes.
    Rle,
    /// JPEG: baseline, extended, lossless.
    Jpeg,
    /// JPEG-LS.
    JpegLs,
    /// JPEG 2000.
    Jpeg2000,
}

/// A decoded frame.
pub(super) struct Frame {
    /// Its samples, those of a pixel together.
    samples: Vec<i64>,
    /// How many bits the stream gives each.
    precision: u32,
    /// Whether luma and chromas have become red, green and blue.
    pub is_rgb: bool,
}

impl Codec {
    /// That of a transfer syntax; `None` for one that is not read.
    pub(super) fn of(syntax: &str) -> Option<Self> {
        let syntax = syntax.strip_prefix("1.2.840.10008.1.2")?;
        Some(match syntax {
            "" | ".1" | ".2" => Self::Native,
            ".5" => Self::Rle,
            ".4.50" | ".4.51" | ".4.53" | ".4.55" | ".4.57" | ".4.70" => Self::Jpeg,
            ".4.80" | ".4.81" => Self::JpegLs,
            ".4.90" | ".4.91" | ".4.92" | ".4.93" => Self::Jpeg2000,
            _ => return None,
        })
    }

    /// The most samples that `bytes` of it are believed to hold. RLE makes at most 64 bytes of one, a JPEG block of 64 samples
    /// takes two bits. The others code empty areas in next to nothing: of them, 4096² samples are always believed.
    pub(super) fn can_hold(self, bytes: u64) -> u64 {
        match self {
            Self::Native | Self::Rle => bytes.saturating_mul(64),
            Self::Jpeg => bytes.saturating_mul(256),
            Self::JpegLs | Self::Jpeg2000 => bytes.saturating_mul(1024).max(1 << 24),
        }
    }

    /// The stored values of a compressed frame, and whether its chromas are gone.
    pub(super) fn decode(self, stream: &[u8], layout: &Layout) -> Result<(Vec<i64>, bool), String> {
        let frame = caught(|| match self {
            Self::Native => Err("it is not compressed".into()),
            Self::Rle => rle(stream, layout),
            Self::Jpeg if jpeg12::is_twelve_bit(stream) => twelve_bit(stream, layout),
            Self::Jpeg => jpeg(stream, layout),
            Self::JpegLs => near_lossless(stream, layout),
            Self::Jpeg2000 => jpeg_2000(stream, layout),
        })?;
        let expected = layout.pixels() * layout.samples;
        if frame.samples.len() != expected {
            return Err(format!("it holds {} samples of {expected}", frame.samples.len()));
        }
        // A stream of just the bits that count has nothing below them.
        let shift = if frame.precision > layout.stored {
            layout.shift()
        } else {
            0
        };
        let values = frame.samples.into_iter().map(|v| layout.value(v, shift)).collect();
        Ok((values, frame.is_rgb))
    }
}

fn check(layout: &Layout, [width, height, samples]: [usize; 3]) -> Result<(), String> {
    let expected = [layout.columns, layout.rows, layout.samples];
    match [width, height, samples] == expected {
        true => Ok(()),
        false => Err(format!(
            "its stream is an image of {width} x {height} x {samples}, its header says {} x {} x {}",
            expected[0], expected[1], expected[2]
        )),
    }
}

/// Annex G of PS3.5: a segment a byte of a sample, the most significant first.
fn rle(stream: &[u8], layout: &Layout) -> Result<Frame, String> {
    let word = |i: usize| {
        stream
            .get(4 * i..4 * i + 4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)
    };
    let bytes = (layout.allocated / 8) as usize;
    let segments = bytes * layout.samples;
    if word(0) != Some(segments) || segments > 15 || bytes == 0 {
        return Err(format!(
            "its frame has not the {segments} RLE segments that its header asks for"
        ));
    }
    let mut samples = vec![0i64; layout.pixels() * layout.samples];
    for segment in 0..segments {
        let start = word(1 + segment).unwrap_or(0);
        let end = (word(2 + segment).filter(|_| segment + 1 < segments)).unwrap_or(stream.len());
        let packed = stream.get(start..end).ok_or("an RLE segment lies outside its frame")?;
        let unpacked = unpack(packed, layout.pixels()).ok_or("an RLE segment is too short")?;
        let places = samples.iter_mut().skip(segment / bytes).step_by(layout.samples);
        places
            .zip(unpacked)
            .for_each(|(sample, byte)| *sample = *sample << 8 | i64::from(byte));
    }
    Ok(Frame {
        samples,
        precision: layout.allocated,
        is_rgb: false,
    })
}

/// `count` bytes of packed runs.
fn unpack(mut packed: &[u8], count: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(count);
    while bytes.len() < count {
        let (&control, rest) = packed.split_first()?;
        packed = match control {
            0..=127 => {
                let (literal, rest) = rest.split_at_checked(usize::from(control) + 1)?;
                bytes.extend_from_slice(literal);
                rest
            }
            128 => rest,
            129..=255 => {
                let (&byte, rest) = rest.split_first()?;
                bytes.extend(std::iter::repeat_n(byte, 257 - usize::from(control)));
                rest
            }
        };
    }
    bytes.truncate(count);
    Some(bytes)
}

fn twelve_bit(stream: &[u8], layout: &Layout) -> Result<Frame, String> {
    let image = jpeg12::decode(stream, |width, height| check(layout, [width, height, 1]).is_ok())?;
    check(layout, [image.width, image.height, 1])?;
    Ok(Frame {
        samples: image.samples.into_iter().map(i64::from).collect(),
        precision: 12,
        is_rgb: false,
    })
}

fn jpeg(stream: &[u8], layout: &Layout) -> Result<Frame, String> {
    let mut decoder = Decoder::new(stream);
    decoder.set_max_decoding_buffer_size(layout.pixels().saturating_mul(8 * layout.samples));
    decoder.read_info().map_err(|e| e.to_string())?;
    let info = decoder.info().ok_or("its JPEG stream has no frame header")?;
    let (samples, precision) = match info.pixel_format {
        PixelFormat::L8 => (1, 8),
        PixelFormat::L16 => (1, 16),
        PixelFormat::RGB24 => (3, 8),
        PixelFormat::CMYK32 => (4, 8),
    };
    check(layout, [info.width.into(), info.height.into(), samples])?;
    // Of the lossless process the components are what the data set says.
    let lossless = info.coding_process == CodingProcess::Lossless;
    if samples == 3 {
        // `None` leaves the components of a row of blocks one behind the other, but those of the lossless process together.
        decoder.set_color_transform(match (lossless, is_rgb(stream, layout)) {
            (true, _) => ColorTransform::None,
            (false, true) => ColorTransform::RGB,
            (false, false) => ColorTransform::YCbCr,
        });
    }
    let bytes = decoder.decode().map_err(|e| e.to_string())?;
    Ok(Frame {
        samples: match precision {
            8 => bytes.into_iter().map(i64::from).collect(),
            _ => words(&bytes),
        },
        precision,
        is_rgb: !lossless,
    })
}

/// Whether the three components of a JPEG stream are red, green and blue, and not luma and chromas. The stream's markers go
/// before what the data set says, which is often wrong.
fn is_rgb(stream: &[u8], layout: &Layout) -> bool {
    let segment = |wanted| jpeg12::segments(stream).find(|s| s.0 == wanted).map(|s| s.1);
    let adobe = segment(0xee).filter(|s| s.len() >= 12 && s.starts_with(b"Adobe"));
    match (segment(0xe0), adobe) {
        (Some([b'J', b'F', b'I', b'F', 0, ..]), _) => false,
        (_, Some(adobe)) => adobe[11] == 0,
        _ => layout.colour == Colour::Rgb,
    }
}

/// Samples of 16 bits in the machine's order.
fn words(bytes: &[u8]) -> Vec<i64> {
    bytes
        .chunks_exact(2)
        .map(|b| i64::from(u16::from_ne_bytes([b[0], b[1]])))
        .collect()
}

fn near_lossless(stream: &[u8], layout: &Layout) -> Result<Frame, String> {
    let image = jpeg_ls::decode(stream, |size| check(layout, size))?;
    Ok(Frame {
        samples: image.samples.into_iter().map(i64::from).collect(),
        precision: image.precision,
        is_rgb: false,
    })
}

/// Samples of a pixel put together that lie in planes.
pub(super) fn interleaved(planes: &[i64], layout: &Layout) -> Vec<i64> {
    let pixels = layout.pixels();
    let sample = |i: usize| planes.get(i % layout.samples * pixels + i / layout.samples).copied();
    (0..planes.len()).map(|i| sample(i).unwrap_or(0)).collect()
}

fn jpeg_2000(stream: &[u8], layout: &Layout) -> Result<Frame, String> {
    let codestream =
        (stream.windows(4).position(|w| w == [0xff, 0x4f, 0xff, 0x51])).ok_or("it is no JPEG 2000 stream")?;
    let main = Main::read(&stream[codestream..]).ok_or("the main header of its JPEG 2000 stream is damaged")?;
    main.check(layout)?;
    let settings = DecodeSettings {
        resolve_palette_indices: false,
        strict: false,
        target_resolution: None,
    };
    // Without the boxes around it: what the colours are, the data set says.
    let image = Image::new(&stream[codestream..], &settings).map_err(|e| e.to_string())?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(|e| e.to_string())?;
    let components = decoded.components();
    let expected = layout.pixels();
    if components.len() != layout.samples || components.iter().any(|c| c.samples().len() != expected) {
        return Err("components of several sizes are not read".into());
    }
    // The codec takes all components for unsigned, and lifts them by half their range.
    let lift = if main.signed { 1i64 << (main.precision - 1) } else { 0 };
    let most = (1i64 << main.precision) - 1;
    let sample = |v: f32| (v.round() as i64).clamp(0, most) - lift;
    let mut samples = vec![0; expected * layout.samples];
    for (i, component) in components.iter().enumerate() {
        let places = samples.iter_mut().skip(i).step_by(layout.samples);
        places.zip(component.samples()).for_each(|(to, &v)| *to = sample(v));
    }
    Ok(Frame {
        samples,
        precision: main.precision,
        is_rgb: true,
    })
}

/// What the main header of a JPEG 2000 codestream says, as far as it tells how much a decoder will keep.
struct Main {
    size: [usize; 2],
    components: usize,
    precision: u32,
    signed: bool,
    tiles: u64,
    /// Precincts of all resolutions together.
    precincts: u64,
}

impl Main {
    fn read(codestream: &[u8]) -> Option<Self> {
        let word = |at: usize| {
            Some(u64::from(u32::from_be_bytes(
                codestream.get(at..at + 4)?.try_into().ok()?,
            )))
        };
        let [width, height] = [word(8)?, word(12)?];
        let size = [width.checked_sub(word(16)?)?, height.checked_sub(word(20)?)?];
        let [tile_width, tile_height] = [word(24)?.max(1), word(28)?.max(1)];
        let depth = *codestream.get(42)?;
        let coding = jpeg12::segments(codestream).find(|s| s.0 == 0x52);
        // Scod, progression, layers, transform of components, levels, code block, style, wavelet; then a precinct a resolution.
        let precincts = match coding {
            Some((_, [scod, rest @ ..], _)) if scod & 1 == 1 => rest.get(9..).unwrap_or_default(),
            _ => &[],
        };
        let count = |(below, &p): (usize, &u8)| {
            let along = |size: u64, exponent: u8| (size >> below.min(63) >> exponent) + 1;
            along(width, p & 15).saturating_mul(along(height, p >> 4))
        };
        Some(Self {
            size: size.map(|v| v as usize),
            components: usize::from(u16::from_be_bytes([*codestream.get(40)?, *codestream.get(41)?])),
            precision: u32::from(depth & 0x7f) + 1,
            signed: depth & 0x80 != 0,
            tiles: width.div_ceil(tile_width).saturating_mul(height.div_ceil(tile_height)),
            precincts: precincts
                .iter()
                .rev()
                .enumerate()
                .map(count)
                .fold(0, u64::saturating_add),
        })
    }

    /// Whether it is the image that is wanted, and has neither so many tiles nor so small precincts that their bookkeeping would
    /// be more than the image.
    fn check(&self, layout: &Layout) -> Result<(), String> {
        check(layout, [self.size[0], self.size[1], self.components])?;
        if self.tiles > 1 << 16 || self.precincts > 1 << 18 || self.precision > 32 {
            return Err("its JPEG 2000 stream has tiles or precincts of a few samples, which no scanner makes".into());
        }
        Ok(())
    }
}
