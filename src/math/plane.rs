//! Oriented planes.

use glam::DVec3;

/// An oriented plane. Its normal points to what is taken away: a point is kept where
/// `normal · p + offset ≤ 0` (VCSG §2.2 with the sign chosen so that cuts and half-spaces have outward normals).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal, in the frame of the node's child.
    pub normal: DVec3,
    /// Signed distance of the origin, millimetres.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with outward `normal` (any length above 0), or `None` for a zero or non-finite normal.
    pub fn through(point: DVec3, normal: DVec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let offset = -normal.dot(point);
        offset.is_finite().then_some(Self { normal, offset })
    }

    /// Signed distance of `p`, above 0 on the side that is taken away.
    #[inline]
    pub fn distance(&self, p: DVec3) -> f64 {
        linear(self.normal, self.offset, p)
    }
}

/// `normal · p + offset`, in the one order in which tree and paths compute it.
#[inline]
pub fn linear(normal: DVec3, offset: f64, p: DVec3) -> f64 {
    normal.x * p.x + (normal.y * p.y + (normal.z * p.z + offset))
}
