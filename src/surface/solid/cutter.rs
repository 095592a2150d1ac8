//! What a solid is cut by: inside/outside functions (LC87 §5.2).

use glam::{DAffine3, DVec3};

use crate::math::affine;
use crate::volume::Grid;

/// A body with an inside/outside function: a half-space, or where the values of a grid are not below an isovalue.
#[derive(Clone, Copy, Debug)]
pub struct Cutter<'a>(Shape<'a>);

#[derive(Clone, Copy, Debug)]
enum Shape<'a> {
    HalfSpace { through: DVec3, normal: DVec3 },
    Level { grid: &'a Grid, iso: f64 },
}

impl<'a> Cutter<'a> {
    /// What lies on the plane through a point, or on that side of it from which `normal` points away. Both are in world
    /// millimetres; the normal may have any length but 0.
    pub fn half_space(through: DVec3, normal: DVec3) -> Self {
        Self(Shape::HalfSpace {
            through,
            normal: normal.normalize_or_zero(),
        })
    }

    /// Where the values of `grid` are not below `iso`. It may lie on any lattice: between its voxels values are trilinear,
    /// and beyond them nothing is inside.
    pub fn level(grid: &'a Grid, iso: f64) -> Self {
        Self(Shape::Level { grid, iso })
    }

    /// Where a mask of zeros and ones is one: its surface lies half-way between voxels of either kind.
    pub fn mask(grid: &'a Grid) -> Self {
        Self::level(grid, 0.5)
    }

    /// The cutter as seen from a lattice.
    pub(super) fn on(self, world_from_index: &DAffine3) -> Sampler<'a> {
        match self.0 {
            Shape::HalfSpace { through, normal } => Sampler::HalfSpace {
                gradient: -(world_from_index.matrix3.transpose() * normal),
                offset: normal.dot(through - world_from_index.translation),
                normal,
            },
            Shape::Level { grid, iso } => Sampler::Level {
                grid,
                iso,
                cutter_from_index: affine::snapped(&(grid.world_from_index().inverse() * *world_from_index)),
            },
        }
    }
}

/// The inside/outside function of a [`Cutter`] on the index space of a lattice.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sampler<'a> {
    HalfSpace {
        gradient: DVec3,
        offset: f64,
        normal: DVec3,
    },
    Level {
        grid: &'a Grid,
        iso: f64,
        cutter_from_index: DAffine3,
    },
}

/// The largest size of a sample: differences of samples do not overflow.
const MOST: f64 = 1e300;

impl Sampler<'_> {
    /// At least 0 inside and negative outside, never more than [`MOST`] and never NaN, which is outside.
    pub fn at(&self, index: [usize; 3]) -> f64 {
        let [i, j, k] = index.map(|i| i as f64);
        let value = match self {
            Self::HalfSpace { gradient, offset, .. } => gradient.x * i + (gradient.y * j + (gradient.z * k + offset)),
            Self::Level {
                grid,
                iso,
                cutter_from_index,
            } => sample(grid, affine::point(cutter_from_index, DVec3::new(i, j, k))) - iso,
        };
        if value.is_nan() {
            -MOST
        } else {
            value.clamp(-MOST, MOST)
        }
    }

    /// The samples of slice `k` of a lattice of `dims`, appended to `out`.
    pub fn add_slice(&self, [nx, ny, _]: [usize; 3], k: usize, out: &mut Vec<f64>) {
        out.extend((0..ny).flat_map(|j| (0..nx).map(move |i| self.at([i, j, k]))));
    }

    /// The direction in the world in which the cutter ends at a point of the world; zero where it is not known.
    pub fn normal(&self, world: DVec3) -> DVec3 {
        match self {
            Self::HalfSpace { normal, .. } => *normal,
            Self::Level { grid, .. } => {
                let cutter_from_world = grid.world_from_index().inverse();
                let gradient = gradient(grid, affine::point(&cutter_from_world, world));
                -(cutter_from_world.matrix3.transpose() * gradient).normalize_or_zero()
            }
        }
    }
}

/// The trilinear interpolant of a grid at a point of its index space; NaN beyond its voxels. Voxels without weight do not
/// count, so that one that is not finite spoils only what is next to it.
fn sample(grid: &Grid, at: DVec3) -> f64 {
    let last = DVec3::from(grid.dims().map(|n| n as f64 - 1.0));
    if !(at.cmpge(DVec3::ZERO) & at.cmple(last)).all() {
        return f64::NAN;
    }
    let lower = at.floor();
    let fraction = at - lower;
    let base = lower.to_array().map(|v| v as usize);
    let mut value = 0.0;
    for corner in 0..8 {
        let upper = [0, 1, 2].map(|axis| corner >> axis & 1);
        let weight: f64 = [0, 1, 2]
            .map(|axis| {
                if upper[axis] == 1 {
                    fraction[axis]
                } else {
                    1.0 - fraction[axis]
                }
            })
            .iter()
            .product();
        if weight > 0.0 {
            value += weight * grid.value_at([0, 1, 2].map(|axis| base[axis] + upper[axis]));
        }
    }
    value
}

/// The gradient in a grid's index space, from samples half a voxel on either side and no further than its border.
fn gradient(grid: &Grid, at: DVec3) -> DVec3 {
    let last = DVec3::from(grid.dims().map(|n| n as f64 - 1.0));
    let slope = |axis: DVec3| {
        let ends = [at - 0.5 * axis, at + 0.5 * axis].map(|p| p.clamp(DVec3::ZERO, last));
        let run = (ends[1] - ends[0]).dot(axis);
        if run > 0.0 {
            (sample(grid, ends[1]) - sample(grid, ends[0])) / run
        } else {
            0.0
        }
    };
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Voxels;

    #[test]
    fn samples_on_the_cutters_own_lattice_are_its_voxels() {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.7, 1.3, 2.9),
            glam::DQuat::from_rotation_z(0.4),
            DVec3::new(-31.0, 17.0, 5.0),
        );
        let grid = Grid::new([3, 2, 2], place, Voxels::U8((0..12).collect())).expect("a grid");
        let mut samples = Vec::new();
        Cutter::level(&grid, 4.0)
            .on(&place)
            .add_slice([3, 2, 2], 1, &mut samples);
        assert_eq!(samples, [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    }

    #[test]
    fn nothing_is_inside_beyond_a_grid_or_where_it_has_no_number() {
        let grid = Grid::new([2, 1, 1], DAffine3::IDENTITY, Voxels::F32(vec![f32::NAN, 9.0])).expect("a grid");
        let sampler = Cutter::mask(&grid).on(&DAffine3::IDENTITY);
        assert_eq!([0, 1, 2].map(|i| sampler.at([i, 0, 0])), [-MOST, 8.5, -MOST]);
    }

    #[test]
    fn normals_point_out() {
        let grid = Grid::new(
            [3, 1, 1],
            DAffine3::from_scale(DVec3::splat(2.0)),
            Voxels::U8(vec![0, 1, 2]),
        )
        .expect("a grid");
        let at = DVec3::new(2.0, 0.0, 0.0);
        assert_eq!(Cutter::mask(&grid).on(&DAffine3::IDENTITY).normal(at), DVec3::NEG_X);
        let half_space = Cutter::half_space(at, DVec3::new(0.0, 5.0, 0.0));
        assert_eq!(half_space.on(&DAffine3::IDENTITY).normal(at), DVec3::Y);
        assert_eq!(half_space.on(&DAffine3::IDENTITY).at([7, 3, 1]), -3.0);
    }
}
