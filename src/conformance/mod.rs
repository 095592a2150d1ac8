//! What a right picture may be: bounds derived from a device's stated precision, and verdicts (design law 3).
//!
//! *Theory.* A frame is a chain of operations, each with a stated error. The chain is walked once more in intervals, from the
//! farthest plane to the nearest, and gives each channel of each pixel the numbers between which every conforming device is.
//! *Practice.* The walk knows nothing of pages, templates or visibility. Of the plan it takes the drawn boxes only, and only
//! to know where a sample lies so near a face between them that it may be drawn by neither or by both.

mod blend;
mod bounds;
mod field;
mod hiding;
mod light;
mod mesh;
mod mesh_paint;
mod normal;
mod outline;
mod place;
mod precision;
mod source;
mod span;
mod storage;
mod table;

pub use bounds::{Drawing, DrawnBox, FrameBounds};
pub use mesh::MeshBounds;
pub use precision::Precision;
pub use span::Span;
pub use storage::Storage;
