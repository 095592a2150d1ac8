//! Why our picture of a volume is not VolPack's.

/// What VolPack does in another way than we do.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Voxels are classified, and opacities interpolated; we interpolate values.
    Opacity,
    /// Voxels are lit, and what they send back is interpolated, weighted by opacity; we interpolate normals.
    Light,
    /// Voxels, and samples between them, of opacities up to [`FAINT`] are dropped.
    Faint,
    /// Rays end at an opacity of [`END`]; ours at 1 − 1/1024.
    End,
    /// Samples lie in the slices of voxels across the axis that is nearest to the view's, and beyond the outermost voxels is
    /// nothing; ours lie in planes across the view, one voxel apart, and the outermost voxels go on for half a voxel.
    Slices,
    /// One ray for each voxel of a slice, and their picture interpolated for the frame's pixels; we cast one ray for each pixel.
    Resolution,
    /// It takes central differences, none at the outermost voxels; we smooth them across.
    Differences,
    /// What has no normal gets ambient light only; with us it keeps its own colour.
    NoNormal,
    /// Normals have length one or none, and are those of a table; ours are soft.
    Normals,
    /// Opacities and pixels are bytes, rounded down, and weights between pixels are those of a table; of ours, pixels are bytes,
    /// rounded to the nearest.
    Rounding,
}

impl Cause {
    /// All, as a volume becomes a picture.
    pub const ALL: [Self; 10] = [
        Self::Opacity,
        Self::Light,
        Self::Faint,
        Self::End,
        Self::Slices,
        Self::Resolution,
        Self::Differences,
        Self::NoNormal,
        Self::Normals,
        Self::Rounding,
    ];

    /// VolPack's way.
    pub fn what(self) -> &'static str {
        match self {
            Self::Opacity => "voxels classified, then interpolated",
            Self::Light => "voxels lit, then interpolated",
            Self::Faint => "opacities up to 0.05 dropped",
            Self::End => "rays end at 0.95",
            Self::Slices => "samples in slices",
            Self::Resolution => "a ray a voxel, then warped",
            Self::Differences => "central differences",
            Self::NoNormal => "ambient light without a normal",
            Self::Normals => "normals of a table",
            Self::Rounding => "bytes rounded down, weights of a table",
        }
    }
}

/// VolPack's least opacity.
pub const FAINT: f64 = 0.05;

/// The opacity at which its rays end.
pub const END: f64 = 0.95;
