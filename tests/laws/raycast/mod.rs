//! The ray caster: the slices' samples, within bounds derived from single precision (design law 3); the same bits for any
//! subdivision in blocks (law 2) and any number of threads; defined results at the edges.

mod agreement;
mod blocks;
mod depths;
mod drawing;
mod edges;
mod picture;
mod surfaces;
mod vectors;
