//! Mesh files: what is written is what other programs read; what cannot be written leaves nothing behind.

mod formats;
mod glb;
mod oracle;
mod refusals;
mod sample;
