//! Sparse bricks with a min/max pyramid.

/// A volume in sparse bricks.
#[derive(Debug)]
pub struct Bricks {}
