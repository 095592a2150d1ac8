//! Frames as files: PNG for looking at, OpenEXR for computing with.

use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};

use ::image::codecs::openexr::OpenExrEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use thiserror::Error;

use super::Frame;
use crate::output::{OutputError, write_whole};

/// Why a frame could not be made a file.
#[derive(Debug, Error)]
pub enum EncodeError {
    /// The name does not say which format is meant.
    #[error("{}: a picture's name must end in one of {}", path.display(), FileFormat::suffixes())]
    UnknownSuffix {
        /// The name.
        path: PathBuf,
    },
    /// Neither format can hold it, and the OpenEXR encoder would panic.
    #[error("a frame of {width} x {height} pixels has nothing to write")]
    NoPixels {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The PNG encoder refused, for instance a keyword that PNG does not allow.
    #[error("cannot encode a frame of {width} x {height} pixels as PNG: {source}")]
    Png {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// What the encoder said.
        source: png::EncodingError,
    },
    /// The OpenEXR encoder refused.
    #[error("cannot encode a frame of {width} x {height} pixels as OpenEXR: {source}")]
    Exr {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// What the encoder said.
        source: ::image::ImageError,
    },
    /// The file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What a frame can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// 8 bits a channel, straight alpha.
    Png,
    /// 32-bit float, premultiplied alpha as OpenEXR wants it; the numbers are the frame's own, display-referred.
    Exr,
}

impl FileFormat {
    /// Every format.
    pub const ALL: [Self; 2] = [Self::Png, Self::Exr];

    /// The suffix, without its dot.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    /// The format that the suffix of `path` names, in either case.
    ///
    /// # Errors
    /// [`EncodeError::UnknownSuffix`], which lists the known ones.
    pub fn of(path: &Path) -> Result<Self, EncodeError> {
        let suffix = path.extension().unwrap_or_default();
        Self::ALL
            .into_iter()
            .find(|format| suffix.eq_ignore_ascii_case(format.suffix()))
            .ok_or_else(|| EncodeError::UnknownSuffix { path: path.to_owned() })
    }

    fn suffixes() -> String {
        Self::ALL.map(|format| format!(".{}", format.suffix())).join(", ")
    }
}

/// Writes `frame` in the format that `path`'s suffix names, whole or not at all. `notes` are keywords (1 to 79 Latin-1
/// characters) and texts that a PNG carries along; OpenEXR goes without them.
///
/// # Errors
/// An unknown suffix, a frame without pixels, a bad keyword, or a place that cannot be written.
pub fn save(frame: &Frame, path: &Path, notes: &[(&str, &str)]) -> Result<(), EncodeError> {
    let bytes = match FileFormat::of(path)? {
        FileFormat::Png => encode_png(frame, notes)?,
        FileFormat::Exr => encode_exr(frame)?,
    };
    Ok(write_whole(path, |out| out.write_all(&bytes))?)
}

/// The frame as a PNG: 8 bits, straight alpha, with `notes` as international text chunks before the pixels.
///
/// # Errors
/// [`EncodeError::NoPixels`], or [`EncodeError::Png`] for a keyword that PNG does not allow.
pub fn encode_png(frame: &Frame, notes: &[(&str, &str)]) -> Result<Vec<u8>, EncodeError> {
    require_pixels(frame)?;
    let mut bytes = Vec::new();
    write_png(frame, notes, &mut bytes).map_err(|source| EncodeError::Png {
        width: frame.width(),
        height: frame.height(),
        source,
    })?;
    Ok(bytes)
}

fn require_pixels(frame: &Frame) -> Result<(), EncodeError> {
    if frame.pixels().is_empty() {
        let (width, height) = (frame.width(), frame.height());
        return Err(EncodeError::NoPixels { width, height });
    }
    Ok(())
}

fn write_png(frame: &Frame, notes: &[(&str, &str)], out: impl Write) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, frame.width(), frame.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (keyword, text) in notes {
        encoder.add_itxt_chunk((*keyword).to_owned(), (*text).to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&frame.to_straight_rgba8())?;
    writer.finish()
}

/// The frame as OpenEXR: RGBA, 32-bit float, premultiplied.
///
/// # Errors
/// [`EncodeError::NoPixels`], or [`EncodeError::Exr`] with what the encoder says.
pub fn encode_exr(frame: &Frame) -> Result<Vec<u8>, EncodeError> {
    require_pixels(frame)?;
    let mut bytes = Cursor::new(Vec::new());
    write_exr(frame, &mut bytes).map_err(|source| EncodeError::Exr {
        width: frame.width(),
        height: frame.height(),
        source,
    })?;
    Ok(bytes.into_inner())
}

fn write_exr(frame: &Frame, out: impl Write + io::Seek) -> ::image::ImageResult<()> {
    OpenExrEncoder::new(out).write_image(
        bytemuck::cast_slice(frame.pixels()),
        frame.width(),
        frame.height(),
        ExtendedColorType::Rgba32F,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels whose channels all differ, one of them half transparent.
    fn frame() -> Frame {
        let pixels = vec![[0.25, 0.125, 0.5, 0.5], [1.0, 0.0, 0.2, 1.0]];
        Frame::from_pixels(2, 1, pixels).expect("two pixels")
    }

    #[test]
    fn a_png_reads_back_straight() {
        let bytes = encode_png(&frame(), &[]).expect("encoded");
        let read = ::image::load_from_memory(&bytes).expect("a PNG");
        assert_eq!(read.color(), ::image::ColorType::Rgba8);
        assert_eq!(read.as_bytes(), [128, 64, 255, 128, 255, 0, 51, 255]);
    }

    #[test]
    fn a_png_carries_its_notes() {
        let bytes = encode_png(&frame(), &[("Scene", "tête.kdl")]).expect("encoded");
        let reader = png::Decoder::new(Cursor::new(bytes)).read_info().expect("a PNG");
        let notes = &reader.info().utf8_text;
        assert_eq!(notes[0].keyword, "Scene");
        assert_eq!(notes[0].get_text().expect("text"), "tête.kdl");
    }

    #[test]
    fn an_exr_keeps_every_bit() {
        let wild = Frame::from_pixels(2, 1, vec![[1e-30, 7.5, -0.1, 0.3], [0.1, 0.2, 0.3, 1.0]]).expect("two pixels");
        let read = ::image::load_from_memory(&encode_exr(&wild).expect("encoded"));
        let read = read.expect("an EXR").into_rgba32f().into_raw();
        assert_eq!(read, bytemuck::cast_slice::<_, f32>(wild.pixels()));
    }

    #[test]
    fn the_same_frame_gives_the_same_bytes() {
        let large = Frame::transparent(300, 200).map(|_| [0.1, 0.2, 0.3, 0.4]);
        assert_eq!(
            encode_exr(&large).expect("encoded"),
            encode_exr(&large).expect("encoded")
        );
        assert_eq!(
            encode_png(&large, &[]).expect("encoded"),
            encode_png(&large, &[]).expect("encoded")
        );
    }

    #[test]
    fn the_suffix_chooses_in_either_case() {
        assert_eq!(FileFormat::of(Path::new("a.b/c.PNG")).ok(), Some(FileFormat::Png));
        assert_eq!(FileFormat::of(Path::new("c.exr")).ok(), Some(FileFormat::Exr));
    }

    #[test]
    fn an_unknown_suffix_lists_the_known_ones() {
        for name in ["a.jpg", "a", ".png", ""] {
            let error = FileFormat::of(Path::new(name)).expect_err(name);
            assert!(error.to_string().contains(".png, .exr"), "{error}");
        }
    }

    #[test]
    fn bad_input_is_an_error_and_leaves_no_file() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.png", "a.exr"] {
            let empty = Frame::transparent(0, 5);
            save(&empty, &folder.path().join(name), &[]).expect_err("no pixels");
        }
        let long = "k".repeat(80);
        save(&frame(), &folder.path().join("b.png"), &[(&long, "")]).expect_err("a long keyword");
        let left = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 0);
    }

    #[test]
    fn saving_writes_the_format_of_the_suffix() {
        let folder = tempfile::tempdir().expect("a folder");
        for format in FileFormat::ALL {
            let path = folder.path().join("a").with_extension(format.suffix());
            save(&frame(), &path, &[]).expect("saved");
            ::image::open(&path).expect("a picture");
        }
    }
}
