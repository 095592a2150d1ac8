//! Template ray casting on the processor (VCSG §3.3.1).
//!
//! *Theory.* Blocks are visited from front to back, and each is cast on its own: its template says which pixels it covers and, for
//! each of them, the interval of covered sampling points. What blocks give is composited block by block.
//! *Changes from the paper.* Sampling points lie where rays meet the global [`Planes`](super::Planes), so the ray caster takes the
//! slices' samples. VCSG moves a template by the displacement of a block and leaves to SFH97 what the parts of a pixel and
//! of a step mean, by which blocks are rarely apart. Here no interval is moved: what all boxes share are the rays, and a
//! template finds where a ray crosses a face from the face's place alone. Two boxes that share a face ask the same question,
//! so each sampling point is in exactly one of them, at any displacement, parallel or not. A block goes on with what the
//! blocks before it left of a pixel, so one block or many blend the same numbers in the same order: the bits are the same.
//! *Practice.* The frame is cut in parts of a few tiles, each the work of one thread, and tiles in packets of 4×4 pixels, or of 8×8 where
//! those are not far apart; of each block the box of what shows is cast. All packets are one template, moved. A packet takes the samples
//! of its rays at a plane together, and hops over planes at which nothing shows, by distances that are found when the transfer function
//! changes; to what shows first, all packets of a tile hop at once. What is known of a frame before it is cast is its kind, and there is a program for each. A ray ends when it is as opaque as where
//! slices close a pixel, and normals are read where a sample shows.

mod approach;
mod blend;
mod boxes;
mod caster;
mod classify;
mod gaps;
mod kind;
mod levels;
mod light;
mod normals;
mod packet;
mod pixels;
mod places;
mod power;
mod rays;
mod sample;
mod shown;
mod simd;
mod spans;
mod template;
mod tile;
mod voxels;

pub use caster::{PortableRayCaster, RayCaster, accumulate, draw, require_size};
pub use levels::draw_levels;
pub use rays::Depths;
pub use voxels::CastTarget;
