//! How a tile's packets come to what shows first, all of them at once.
//!
//! *Practice.* A packet hops from cell to cell, and at each hop waits for the number of the cell that it has come to. Sixteen wait no longer
//! than one. Places are in single precision, counted from where each packet meets the box; what they are off is less than the
//! margin that is left round what shows.

use super::boxes::CastBox;
use super::simd::{Simd, each};
use super::spans::Spans;
use super::tile::Scene;
use super::voxels::Voxels;

/// The first plane at which something of a box may show to each packet, of those from where its span begins on, or one that is not before
/// where it ends.
#[inline(always)]
pub fn approach<S: Simd>(scene: &Scene, cast_box: &CastBox, voxels: &Voxels, spans: &Spans<S>) -> S::Int {
    let gaps = &cast_box.shown.gaps;
    let [begins, ends] = spans.any;
    let (scale, begin) = (S::double(gaps.cells_per_voxel()), S::to_double(begins));
    let first_cell = gaps.first_cell();
    // Cells from the first one at the beginning, and from plane to plane.
    let at_begin = each!(axis of [0, 1, 2] => {
        let low = spans.low[axis].origin + begin * spans.low[axis].step;
        S::single((low - S::double(f64::from(voxels.first[axis]) + first_cell[axis])) * scale)
    });
    let step = each!(axis of [0, 1, 2] => S::single(spans.low[axis].step * scale));
    let (mut planes, mut hops) = (S::int(0), S::greater_int(ends, begins));
    loop {
        let gone = S::to_float(planes);
        let free = gaps.free_at::<S>(each!(axis of [0, 1, 2] => S::mul_add(gone, step[axis], at_begin[axis])));
        hops = hops & S::greater_int(free, S::int(0)) & S::greater_int(ends, begins + planes);
        if S::bits(hops) == 0 {
            return begins + planes;
        }
        planes = S::choose_int(hops, planes + S::looked_up(&scene.hops, free), planes);
    }
}

/// The stored voxel that each packet's are counted from at such planes.
#[inline(always)]
pub fn first_voxels<S: Simd>(voxels: &Voxels, spans: &Spans<S>, planes: S::Int) -> S::Int {
    let planes = S::to_double(planes);
    let [x, y, z] = each!(axis of [0, 1, 2] => {
        let at = spans.low[axis].origin + planes * spans.low[axis].step;
        S::whole_double(S::floor_double(at)) - S::int(voxels.first[axis])
    });
    let [row, plane] = each!(stride of [voxels.strides[0], voxels.strides[1]] => S::int(stride as i32));
    x + y * row + z * plane
}
