//! Sparse bricks (placeholder until merged).
use crate::math::{Aabb, Interval};
use glam::*;
/// A volume in sparse bricks.
#[derive(Debug)]
pub struct Bricks {}
#[allow(missing_docs, unused)]
impl Bricks {
    pub fn index_bounds(&self) -> Aabb {
        todo!()
    }
    pub fn world_from_index(&self) -> &DAffine3 {
        todo!()
    }
    pub fn range_index(&self, r: &Aabb) -> Interval {
        todo!()
    }
    pub fn has_nan(&self) -> bool {
        todo!()
    }
    pub fn sample_index(&self, p: DVec3) -> f32 {
        todo!()
    }
    pub fn sample_row(&self, m: &DAffine3, row: DVec3, i0: f64, out: &mut [f32]) {
        todo!()
    }
}
