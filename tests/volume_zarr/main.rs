//! Zarr arrays against zarr-python, and what images, sparse levels and damaged ones are.

mod damage;
mod folder;
mod images;
mod oracle;
mod sparse;
