//! What is known of a frame before it is cast.
//!
//! *Practice.* What casts a packet is compiled for each kind by itself, so that nothing is asked sample by sample that is the same for all of a frame.

/// A kind of frames.
pub trait Kind: 'static {
    /// Whether all packets are so small that the voxels of a bundle are few, wherever it is.
    const FEW: bool;
    /// Whether values are classified by the table, seen in parallel, nothing is covered in part, no depth is cued, and colours go over those behind.
    const PLAIN: bool;
}

/// Any frames.
pub struct Any;

/// Plain ones.
pub struct Plain;

/// Those of few voxels.
pub struct Few;

/// Plain ones of few voxels.
pub struct FewPlain;

macro_rules! kinds {
    ($($kind:ident: $few:literal, $plain:literal;)*) => {$(
        impl Kind for $kind {
            const FEW: bool = $few;
            const PLAIN: bool = $plain;
        }
    )*};
}

kinds! {
    Any: false, false;
    Plain: false, true;
    Few: true, false;
    FewPlain: true, true;
}
