//! How two pictures of a surface differ.

use std::path::PathBuf;

use vcsg::image::{Frame, save};

use crate::pictures::{Depths, SIZE_PX};

/// How slices and a mesh differ.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Pixels in which only one sees something.
    pub in_mask: usize,
    /// Those of them that are more than a pixel from the mesh's edge.
    pub off_edge: usize,
    /// Pixels in which both see something.
    pub shared: usize,
    /// The mean of how far depths are apart there.
    pub mean_depth_mm: f64,
}

/// The difference of `slices` and `meshed`.
pub fn difference(slices: &Depths, meshed: &Depths) -> Difference {
    let there = |depths: &Depths| depths.iter().map(|d| d.is_finite()).collect::<Vec<_>>();
    let (sliced_mask, mesh_mask) = (there(slices), there(meshed));
    let differing: Vec<usize> = (0..mesh_mask.len())
        .filter(|n| sliced_mask[*n] != mesh_mask[*n])
        .collect();
    let pairs = slices
        .iter()
        .zip(meshed)
        .filter(|(a, b)| a.is_finite() && b.is_finite());
    let apart: Vec<f64> = pairs.map(|(a, b)| f64::from((a - b).abs())).collect();
    Difference {
        in_mask: differing.len(),
        off_edge: differing.iter().filter(|n| !is_at_edge(&mesh_mask, **n)).count(),
        shared: apart.len(),
        mean_depth_mm: apart.iter().sum::<f64>() / apart.len().max(1) as f64,
    }
}

/// Whether both kinds of pixels are among pixel `n` and its eight neighbours.
fn is_at_edge(mask: &[bool], n: usize) -> bool {
    let side = SIZE_PX as usize;
    let round = |at: usize| at.saturating_sub(1)..(at + 2).min(side);
    let (x, y) = (n % side, n / side);
    let mut near = round(y).flat_map(|y| round(x).map(move |x| y * side + x));
    near.any(|other| mask[other] != mask[n])
}

impl Difference {
    /// An error if it is not what LC87's picture test allows.
    pub fn acceptable(&self, voxel_mm: f64) -> Result<(), String> {
        let pixels = (SIZE_PX * SIZE_PX) as usize;
        if self.shared < pixels / 20 {
            return Err(format!("only {} of {pixels} pixels show the surface", self.shared));
        }
        if self.off_edge > 0 {
            let all = self.in_mask;
            return Err(format!("{} of {all} differing pixels are off the edge", self.off_edge));
        }
        if self.mean_depth_mm >= 0.5 * voxel_mm {
            return Err(format!("depths are {} voxels apart", self.mean_depth_mm / voxel_mm));
        }
        Ok(())
    }
}

/// Writes a picture of what is only in slices (red), only in the mesh (green), or in both (grey by depth), and says where it is.
pub fn leave(name: &str, slices: &Depths, meshed: &Depths) -> PathBuf {
    let both = || {
        slices
            .iter()
            .zip(meshed)
            .filter(|(a, b)| a.is_finite() && b.is_finite())
    };
    let nearest = both().map(|(a, _)| *a).fold(f32::INFINITY, f32::min);
    let farthest = both().map(|(a, _)| *a).fold(f32::NEG_INFINITY, f32::max);
    let pixel = |(a, b): (&f32, &f32)| match (a.is_finite(), b.is_finite()) {
        (true, true) => {
            let grey = 1.0 - 0.8 * (a - nearest) / (farthest - nearest);
            [grey, grey, grey, 1.0]
        }
        (true, false) => [1.0, 0.0, 0.0, 1.0],
        (false, true) => [0.0, 1.0, 0.0, 1.0],
        (false, false) => [0.0, 0.0, 0.0, 1.0],
    };
    let pixels = slices.iter().zip(meshed).map(pixel).collect();
    let frame = Frame::from_pixels(SIZE_PX, SIZE_PX, pixels).expect("a square of pixels");
    let file: String = name
        .chars()
        .map(|c| if c.is_alphanumeric() { c } else { '_' })
        .collect();
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{file}.png"));
    save(&frame, &path, &[]).expect("a picture");
    path
}
