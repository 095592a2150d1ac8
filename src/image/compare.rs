//! Comparing frames: by a derived bound, never by how alike they look.

use std::path::Path;

use thiserror::Error;

use super::frame::Rgba;
use super::{EncodeError, Frame, save};

/// Why a comparison failed, or could not be made.
#[derive(Debug, Error)]
pub enum CompareError {
    /// Frames of different sizes.
    #[error("frames of different sizes: {} x {} and {} x {}", left[0], left[1], right[0], right[1])]
    Size {
        /// Width and height of the first.
        left: [u32; 2],
        /// Width and height of the other.
        right: [u32; 2],
    },
    /// Channels outside their bounds.
    #[error("{outside}; expected | difference | actual is in {picture}")]
    Outside {
        /// What is outside.
        outside: Outside,
        /// The picture that shows it.
        picture: String,
    },
    /// The picture of a failed comparison could not be written.
    #[error("{outside}; its picture could not be written: {source}")]
    Picture {
        /// What is outside.
        outside: Outside,
        /// Why there is no picture.
        source: Box<EncodeError>,
    },
}

/// One channel of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Column from the left.
    pub x: u32,
    /// Row from the top.
    pub y: u32,
    /// 0 red, 1 green, 2 blue, 3 alpha.
    pub channel: usize,
}

/// The channels of a frame that are outside their bounds.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "{channels} channels are out of bounds, the worst by {excess:e} in channel {} of column {}, row {}: \
     {value} is not in [{low}, {high}]",
    worst.channel, worst.x, worst.y
)]
pub struct Outside {
    /// How many channels are.
    pub channels: usize,
    /// The first, row by row, of those that are out the most.
    pub worst: Place,
    /// How far it is out: above 0, and infinite where it or a bound is NaN.
    pub excess: f32,
    /// What it is.
    pub value: f32,
    /// The least that it may be.
    pub low: f32,
    /// The most that it may be.
    pub high: f32,
}

/// The largest absolute difference of any channel; infinite if one is NaN in either frame.
///
/// # Errors
/// [`CompareError::Size`].
pub fn max_difference(left: &Frame, right: &Frame) -> Result<f32, CompareError> {
    require_same_size(left, right)?;
    let channels = left.pixels().as_flattened().iter();
    let differences = channels
        .zip(right.pixels().as_flattened())
        .map(|(l, r)| finite_or_infinite((l - r).abs()));
    Ok(differences.fold(0.0, f32::max))
}

/// What of `actual` is not within `[low, high]`, channel by channel, ends included; `None` if all is.
///
/// # Errors
/// [`CompareError::Size`].
pub fn outside(actual: &Frame, low: &Frame, high: &Frame) -> Result<Option<Outside>, CompareError> {
    require_same_size(actual, low)?;
    require_same_size(actual, high)?;
    let mut found: Option<Outside> = None;
    for i in 0..actual.pixels().len() * 4 {
        let at = |frame: &Frame| frame.pixels()[i / 4][i % 4];
        let (value, low, high) = (at(actual), at(low), at(high));
        if (low..=high).contains(&value) {
            continue;
        }
        let here = Outside {
            channels: 1 + found.map_or(0, |f| f.channels),
            worst: place(actual, i),
            excess: excess(value, low, high),
            value,
            low,
            high,
        };
        found = Some(match found {
            Some(worst) if worst.excess >= here.excess => Outside {
                channels: here.channels,
                ..worst
            },
            _ => here,
        });
    }
    Ok(found)
}

/// Requires `actual` to be within `[low, high]`; if it is not, writes [`panels`] of the bounds' middle and it to `picture`.
///
/// # Errors
/// [`CompareError`]: sizes that differ, or channels out of bounds.
pub fn require_within(actual: &Frame, low: &Frame, high: &Frame, picture: &Path) -> Result<(), CompareError> {
    let Some(outside) = outside(actual, low, high)? else {
        return Ok(());
    };
    let saved = save(&panels(&middle(low, high), actual)?, picture, &[]);
    Err(match saved {
        Ok(()) => CompareError::Outside {
            outside,
            picture: picture.display().to_string(),
        },
        Err(source) => CompareError::Picture {
            outside,
            source: Box::new(source),
        },
    })
}

/// Three pictures side by side, opaque on black: expected, the difference of the premultiplied channels (alpha's added to
/// all three colours) stretched so that the largest is white, and actual.
///
/// # Errors
/// [`CompareError::Size`].
pub fn panels(expected: &Frame, actual: &Frame) -> Result<Frame, CompareError> {
    let difference = difference(expected, actual)?;
    let black = [0.0; 3];
    let thirds = [expected.over(black), difference, actual.over(black)];
    let width = expected.width() as usize;
    let mut pixels = Vec::with_capacity(3 * expected.pixels().len());
    for y in 0..expected.height() as usize {
        for third in &thirds {
            pixels.extend_from_slice(&third.pixels()[y * width..(y + 1) * width]);
        }
    }
    Frame::from_pixels(3 * expected.width(), expected.height(), pixels).map_err(|_| size_error(expected, actual))
}

fn difference(expected: &Frame, actual: &Frame) -> Result<Frame, CompareError> {
    let largest = max_difference(expected, actual)?;
    let scale = if largest > 0.0 { largest.recip() } else { 0.0 };
    Ok(joined(expected, actual, |e, a| {
        let [r, g, b, alpha] = [0, 1, 2, 3].map(|c| scale * (e[c] - a[c]).abs());
        [r + alpha, g + alpha, b + alpha, 1.0]
    }))
}

fn middle(low: &Frame, high: &Frame) -> Frame {
    joined(low, high, |l, h| [0, 1, 2, 3].map(|c| f32::midpoint(l[c], h[c])))
}

/// Two frames of the same size made one, pixel by pixel.
fn joined(left: &Frame, right: &Frame, pixel: impl Fn(Rgba, Rgba) -> Rgba) -> Frame {
    let mut joined = left.clone();
    for (l, r) in joined.pixels_mut().iter_mut().zip(right.pixels()) {
        *l = pixel(*l, *r);
    }
    joined
}

fn require_same_size(left: &Frame, right: &Frame) -> Result<(), CompareError> {
    let same = left.width() == right.width() && left.height() == right.height();
    if same { Ok(()) } else { Err(size_error(left, right)) }
}

fn size_error(left: &Frame, right: &Frame) -> CompareError {
    CompareError::Size {
        left: [left.width(), left.height()],
        right: [right.width(), right.height()],
    }
}

fn place(frame: &Frame, channel_index: usize) -> Place {
    let (pixel, width) = (channel_index / 4, frame.width() as usize);
    Place {
        x: (pixel % width) as u32,
        y: (pixel / width) as u32,
        channel: channel_index % 4,
    }
}

fn excess(value: f32, low: f32, high: f32) -> f32 {
    let [below, above] = [low - value, value - high].map(finite_or_infinite);
    below.max(above)
}

fn finite_or_infinite(difference: f32) -> f32 {
    if difference.is_nan() { f32::INFINITY } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: u32 = 8;
    const HEIGHT: u32 = 5;

    /// A frame in which every pixel differs from its neighbours.
    fn slope() -> Frame {
        let pixels = (0..WIDTH * HEIGHT)
            .map(|i| [i as f32 / 64.0, 0.5, (i % 3) as f32 / 4.0, 1.0])
            .collect();
        Frame::from_pixels(WIDTH, HEIGHT, pixels).expect("its size")
    }

    fn shifted(frame: &Frame) -> Frame {
        let mut shifted = frame.clone();
        shifted.pixels_mut().rotate_right(1);
        shifted
    }

    fn moved_by(frame: &Frame, by: f32) -> Frame {
        frame.map(|p| p.map(|c| c + by))
    }

    #[test]
    fn a_frame_equals_itself() {
        let frame = slope();
        assert_eq!(max_difference(&frame, &frame).expect("same size"), 0.0);
        assert_eq!(outside(&frame, &frame, &frame).expect("same size"), None);
    }

    #[test]
    fn a_shift_by_one_pixel_is_red() {
        let (low, high) = (moved_by(&slope(), -0.001), moved_by(&slope(), 0.001));
        let found = outside(&shifted(&slope()), &low, &high).expect("same size");
        assert!(found.is_some_and(|o| o.channels > WIDTH as usize));
        assert!(max_difference(&slope(), &shifted(&slope())).expect("same size") > 0.01);
    }

    #[test]
    fn one_channel_of_one_pixel_is_found() {
        let mut wrong = slope();
        wrong.pixels_mut()[(2 * WIDTH + 3) as usize][1] = 0.75;
        wrong.pixels_mut()[(4 * WIDTH + 7) as usize][1] = 0.25;
        let found = outside(&wrong, &slope(), &slope()).expect("same size");
        let expected = Outside {
            channels: 2,
            worst: Place { x: 3, y: 2, channel: 1 },
            excess: 0.25,
            value: 0.75,
            low: 0.5,
            high: 0.5,
        };
        assert_eq!(found, Some(expected));
    }

    #[test]
    fn the_ends_of_a_bound_belong_to_it() {
        let frame = slope();
        let above = moved_by(&frame, 0.25);
        assert_eq!(outside(&above, &frame, &above).expect("same size"), None);
        assert_eq!(outside(&frame, &frame, &above).expect("same size"), None);
        let beyond = above.map(|p| p.map(f32::next_up));
        assert!(outside(&beyond, &frame, &above).expect("same size").is_some());
    }

    #[test]
    fn nan_is_red_wherever_it_is() {
        let mut broken = slope();
        broken.pixels_mut()[0][3] = f32::NAN;
        let (good, bad) = (slope(), broken);
        for [actual, low, high] in [[&bad, &good, &good], [&good, &bad, &good], [&good, &good, &bad]] {
            let found = outside(actual, low, high).expect("same size");
            assert!(found.is_some_and(|o| o.excess == f32::INFINITY && o.channels == 1));
        }
        assert_eq!(max_difference(&good, &bad).expect("same size"), f32::INFINITY);
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, tall) = (Frame::transparent(2, 3), Frame::transparent(3, 2));
        assert!(max_difference(&wide, &tall).is_err());
        assert!(outside(&wide, &wide, &tall).is_err());
        assert!(panels(&wide, &tall).is_err());
    }

    #[test]
    fn panels_show_expected_difference_and_actual() {
        let mut wrong = slope();
        wrong.pixels_mut()[0] = [0.25, 0.5, 0.0, 1.0];
        let shown = panels(&slope(), &wrong).expect("same size");
        assert_eq!((shown.width(), shown.height()), (3 * WIDTH, HEIGHT));
        assert_eq!(shown.pixel(0, 0), Some([0.0, 0.5, 0.0, 1.0]));
        assert_eq!(shown.pixel(WIDTH, 0), Some([1.0, 0.0, 0.0, 1.0]));
        assert_eq!(shown.pixel(WIDTH + 1, 0), Some([0.0, 0.0, 0.0, 1.0]));
        assert_eq!(shown.pixel(2 * WIDTH, 0), Some([0.25, 0.5, 0.0, 1.0]));
    }

    #[test]
    fn a_failure_leaves_a_picture_and_a_success_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let picture = folder.path().join("shift.png");
        let frame = slope();
        require_within(&frame, &frame, &frame, &picture).expect("within");
        assert!(!picture.exists());
        let error = require_within(&shifted(&frame), &frame, &frame, &picture).expect_err("a shift");
        assert!(error.to_string().contains("shift.png"), "{error}");
        assert!(picture.exists());
    }
}
