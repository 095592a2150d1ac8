//! Rows of posts: one that goes away from the eye, one across.

use glam::{DAffine3, DVec3};
use vcsg::math::Aabb;
use vcsg::model::{BooleanOp, Family, Model, Node, ValueRule};
use vcsg::projection::{Camera, Lens};
use vcsg::voxelize::{Primitive, Solid};

/// Focal length of the row's cameras, pixels.
pub const FOCAL_PX: f64 = 96.0;

/// `count` posts of 4 · 4 · 24 mm, `apart` mm from each other along y, to the left and right of the line of sight in turn.
pub fn posts(count: u32, apart: f64) -> Model {
    at_places(
        12.0,
        (0..count).map(|n| {
            let aside = if n % 2 == 0 { -5.0 } else { 5.0 };
            DVec3::new(aside, f64::from(n) * apart, 0.0)
        }),
    )
}

/// Posts of 4 · 4 mm, `half_height` up and down, side by side across the line of sight, 6 mm of air between them.
pub fn fence(count: u32, half_height: f64) -> Model {
    at_places(
        half_height,
        (0..count).map(|n| DVec3::new(10.0 * (f64::from(n) - 0.5 * f64::from(count)), 0.0, 0.0)),
    )
}

fn at_places(half_height: f64, places: impl Iterator<Item = DVec3>) -> Model {
    let mut model = Model::default();
    let half = DVec3::new(2.0, 2.0, half_height);
    let post = model.push(Node::Primitive(Primitive::soft(
        Solid::Box(Aabb::new(-half, half)),
        1.0,
    )));
    let placed: Vec<_> = places
        .map(|place| {
            model.push(Node::Transform {
                child: post,
                parent_from_child: DAffine3::from_translation(place),
            })
        })
        .collect();
    model.fold(BooleanOp::Union, ValueRule::First, Family::MinMax, placed);
    model
}

/// An eye at `y` that looks along the row, with a frame of `edge` pixels a side.
pub fn eye_at(y: f64, edge: u32) -> Camera {
    let (right, down, forward) = (DVec3::X, -DVec3::Z, DVec3::Y);
    let matrix3 = glam::DMat3::from_cols(right, down, forward).transpose();
    Camera {
        eye_from_world: DAffine3 {
            matrix3,
            translation: -(matrix3 * DVec3::new(0.0, y, 0.0)),
        },
        lens: Lens::Perspective {
            focal_px: FOCAL_PX * f64::from(edge) / 96.0,
            near_mm: 1.0,
        },
        size: [edge; 2],
    }
}
