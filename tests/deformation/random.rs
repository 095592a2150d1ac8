//! Random landmarks.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::model::deform::Landmark;

/// Points within `reach` of the origin along each axis.
pub fn point(reach: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..reach).prop_map(DVec3::from)
}

/// `count` landmarks in a cube of 200 mm, that go up to `most` mm along each axis.
pub fn landmarks(count: std::ops::Range<usize>, most: f64) -> impl Strategy<Value = Vec<Landmark>> {
    let pairs = prop::collection::vec((point(100.0), point(most)), count);
    pairs.prop_map(|pairs| pairs.into_iter().enumerate().map(landmark).collect())
}

fn landmark((n, (from, by)): (usize, (DVec3, DVec3))) -> Landmark {
    Landmark {
        name: format!("L{}", n + 1),
        from,
        to: from + by,
    }
}
