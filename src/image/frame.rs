//! A picture in floating point.
//!
//! *Theory.* Porter and Duff, Compositing digital images (SIGGRAPH 1984): premultiplied colours and *over*.
//! *Practice.* Colours are display-referred (sRGB-coded) numbers and are blended as they are, as VTK and 3D Slicer do, so
//! that a preset looks here as it does there. See docs/CONVENTIONS.md.

use thiserror::Error;

/// RGBA, premultiplied: red, green and blue already carry alpha. In `[0, 1]` but for what additive modes sum up.
pub type Rgba = [f32; 4];

/// A number of pixels that is not `width · height`.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("a frame of {width} x {height} pixels cannot be made of {pixels}")]
pub struct FrameSizeError {
    /// Columns asked for.
    pub width: u32,
    /// Rows asked for.
    pub height: u32,
    /// Pixels given.
    pub pixels: usize,
}

/// A picture: [`Rgba`] pixels in rows, the top row first, each row from left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    width: u32,
    height: u32,
    pixels: Vec<Rgba>,
}

impl Frame {
    /// A frame with nothing in it.
    pub fn transparent(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            pixels: vec![[0.0; 4]; width as usize * height as usize],
        }
    }

    /// A frame of the given pixels, top row first.
    ///
    /// # Errors
    /// If there are not exactly `width · height` of them.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<Rgba>) -> Result<Self, FrameSizeError> {
        if pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(FrameSizeError {
                width,
                height,
                pixels: pixels.len(),
            });
        }
        Ok(Self { width, height, pixels })
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, top row first.
    pub fn pixels(&self) -> &[Rgba] {
        &self.pixels
    }

    /// All pixels, top row first.
    pub fn pixels_mut(&mut self) -> &mut [Rgba] {
        &mut self.pixels
    }

    /// The pixel in column `x` and row `y`, or `None` outside the frame.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgba> {
        let inside = x < self.width && y < self.height;
        inside.then(|| self.pixels[y as usize * self.width as usize + x as usize])
    }

    /// The frame *over* an opaque background of display-referred red, green and blue.
    pub fn over(&self, background: [f32; 3]) -> Self {
        let [r, g, b] = background;
        self.map(|p| {
            let through = 1.0 - p[3];
            [
                p[0] + through * r,
                p[1] + through * g,
                p[2] + through * b,
                p[3] + through,
            ]
        })
    }

    /// The frame with `pixel` done to each of its pixels.
    pub fn map(&self, pixel: impl Fn(Rgba) -> Rgba) -> Self {
        Self {
            width: self.width,
            height: self.height,
            pixels: self.pixels.iter().map(|&p| pixel(p)).collect(),
        }
    }

    /// Straight-alpha bytes, RGBA, top row first: halves are rounded up, what is out of range is clamped, NaN is 0, and a
    /// pixel without alpha is transparent black.
    pub fn to_straight_rgba8(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|&p| straight_rgba8(p)).collect()
    }
}

fn straight_rgba8([r, g, b, a]: Rgba) -> [u8; 4] {
    let straight = |c: f32| if a > 0.0 { byte(c / a) } else { 0 };
    [straight(r), straight(g), straight(b), byte(a)]
}

/// `[0, 1]` to `0..=255`. Computed in `f64`, where the product and the sum are exact, so that a half is a half.
fn byte(value: f32) -> u8 {
    // A cast saturates, and makes NaN 0.
    (f64::from(value) * 255.0 + 0.5).floor() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(pixel: Rgba) -> Frame {
        Frame::from_pixels(1, 1, vec![pixel]).expect("one pixel")
    }

    #[test]
    fn the_number_of_pixels_is_checked() {
        let error = Frame::from_pixels(2, 3, vec![[0.0; 4]; 5]).expect_err("five are not six");
        assert_eq!(error.pixels, 5);
        // The product of the sides does not wrap round to the number of pixels.
        assert!(Frame::from_pixels(u32::MAX, u32::MAX, Vec::new()).is_err());
    }

    #[test]
    fn rows_run_from_the_top_and_columns_from_the_left() {
        let mut frame = Frame::transparent(3, 2);
        frame.pixels_mut()[4] = [1.0; 4];
        assert_eq!(frame.pixel(1, 1), Some([1.0; 4]));
        assert_eq!(frame.pixel(3, 0), None);
        assert_eq!(frame.pixel(0, 2), None);
    }

    #[test]
    fn over_mixes_by_what_alpha_lets_through() {
        let half = one([0.25, 0.0, 0.5, 0.5]);
        assert_eq!(half.over([1.0, 0.5, 0.0]), one([0.75, 0.25, 0.5, 1.0]));
        let opaque = one([0.25, 0.5, 0.75, 1.0]);
        assert_eq!(opaque.over([1.0, 1.0, 1.0]), opaque);
    }

    #[test]
    fn bytes_are_straight_and_rounded_half_up() {
        assert_eq!(one([0.25, 0.5, 0.0, 0.5]).to_straight_rgba8(), [128, 255, 0, 128]);
        // 0.5 · 255 is 127.5; the next smaller number falls to the other side.
        assert_eq!(byte(0.5), 128);
        assert_eq!(byte(0.5_f32.next_down()), 127);
    }

    #[test]
    fn bytes_are_clamped_whatever_comes() {
        let wild = one([f32::NAN, -1.0, f32::INFINITY, 1.0]);
        assert_eq!(wild.to_straight_rgba8(), [0, 0, 255, 255]);
        assert_eq!(one([1.0, 1.0, 1.0, 0.0]).to_straight_rgba8(), [0; 4]);
        assert_eq!(one([3.0, 0.0, 0.0, f32::NAN]).to_straight_rgba8(), [0; 4]);
    }
}
