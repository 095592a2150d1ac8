//! Whether two pictures show the same.

use std::path::Path;

use serde::Serialize;
use vcsg::image::{Frame, compare::panels, save};

use crate::Outcome;

/// How far two pictures on black are apart, in steps of 8 bits, over the channels of all pixels that are not black in both.
#[derive(Serialize)]
pub struct Difference {
    /// The mean.
    pub mean: f64,
    /// What 99 of 100 channels do not exceed.
    pub percentile_99: u8,
    /// The largest.
    pub max: u8,
    /// How many pixels were compared.
    pub pixels: usize,
    /// Theirs, the difference stretched to white, ours, side by side.
    pub picture: String,
}

/// The difference between our frame and their picture; both are shown beside each other in the new file `panels_path`.
pub fn compare(ours: &Frame, theirs: &Frame, panels_path: &str) -> Outcome<Difference> {
    let ours = ours.over([0.0; 3]);
    save(&panels(theirs, &ours)?, Path::new(panels_path), &[])?;
    let bytes = |frame: &Frame| frame.to_straight_rgba8();
    let mut apart = Vec::new();
    for (a, b) in bytes(&ours).chunks(4).zip(bytes(theirs).chunks(4)) {
        if a[..3] != [0; 3] || b[..3] != [0; 3] {
            apart.extend((0..3).map(|c| a[c].abs_diff(b[c])));
        }
    }
    apart.sort_unstable();
    let last = apart.len().saturating_sub(1);
    let at = |n: usize| apart.get(n).copied().unwrap_or(0);
    let sum: f64 = apart.iter().copied().map(f64::from).sum();
    Ok(Difference {
        mean: sum / apart.len().max(1) as f64,
        percentile_99: at(last * 99 / 100),
        max: at(last),
        pixels: apart.len() / 3,
        picture: panels_path.to_owned(),
    })
}

/// A picture file as an opaque frame.
pub fn read(path: &str) -> Outcome<Frame> {
    let picture = image::open(path)?.to_rgb8();
    let opaque = |p: &image::Rgb<u8>| {
        let [r, g, b] = p.0.map(|c| f32::from(c) / 255.0);
        [r, g, b, 1.0]
    };
    let (width, height) = picture.dimensions();
    let pixels = picture.pixels().map(opaque).collect();
    Ok(Frame::from_pixels(width, height, pixels)?)
}
