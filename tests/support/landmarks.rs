//! Random landmarks.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::Aabb;
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline};

/// Landmarks about the origin and how they are interpolated.
#[derive(Clone, Debug)]
pub struct Landmarks {
    pub pairs: Vec<(DVec3, DVec3)>,
    pub smoothness: Smoothness,
    pub error_voxels: f64,
}

impl Landmarks {
    /// The landmarks gone `part` of their way.
    pub fn gone(&self, part: f64) -> Vec<Landmark> {
        let named = |(n, (from, by)): (usize, &(DVec3, DVec3))| Landmark {
            name: format!("{}", n + 1),
            from: *from,
            to: *from + *by * part,
        };
        self.pairs.iter().enumerate().map(named).collect()
    }

    /// Their morph for what lies in `bounds` and somewhat beyond: the landmarks go half their way as often as they fold it.
    pub fn morph(&self, bounds: &Aabb) -> Morph {
        let within = match bounds.is_empty() {
            true => Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)),
            false => bounds.expand(DVec3::splat(3.0)),
        };
        (0..12)
            .map(|halvings| 0.5f64.powi(halvings))
            .filter_map(|part| Spline::new(&self.gone(part), &self.smoothness).ok())
            .find_map(|spline| Morph::new(spline, within).ok())
            .unwrap_or_else(|| {
                panic!(
                    "landmarks that hardly move fold nothing, but {self:?} in {within:?} {:?}",
                    Spline::new(&self.gone(1e-3), &self.smoothness).map(|s| Morph::new(s, within).map(|_| ()))
                )
            })
    }
}

/// 3 to 9 landmarks that go up to 4 mm along each axis.
pub fn landmarks() -> impl Strategy<Value = Landmarks> {
    let point = |reach: f64| prop::array::uniform3(-reach..reach).prop_map(DVec3::from);
    let pairs = prop::collection::vec((point(12.0), point(4.0)), 3..10);
    let stiffness = prop_oneof![2 => Just(0.0), 1 => 0.0f64..5.0];
    let support = prop_oneof![2 => Just(None), 1 => (4.0f64..30.0).prop_map(Some)];
    let error = prop_oneof![2 => Just(0.1), 1 => 0.01f64..2.0];
    // Two that begin in one place would tear it.
    let apart = |(n, (from, by)): (usize, (DVec3, DVec3))| (from + DVec3::X * 0.01 * n as f64, by);
    (pairs, stiffness, support, error).prop_map(move |(pairs, stiffness, support_mm, error_voxels)| Landmarks {
        pairs: pairs.into_iter().enumerate().map(apart).collect(),
        smoothness: Smoothness { stiffness, support_mm },
        error_voxels,
    })
}
