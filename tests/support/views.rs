//! Random cameras, transfer functions and settings.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::{Aabb, Interval};
use vcsg::projection::{
    Camera, ControlPoint, DepthCue, Lens, Light, Material, Mode, Projection, Settings, Shading, TransferFunction, View,
};

use super::parts;

/// Where a random camera stands.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    view: View,
    /// A perspective eye at this fraction of the bounds, or as the view has it.
    within: Option<DVec3>,
    size: [u32; 2],
}

impl Eye {
    /// The camera for `bounds` (world).
    pub fn camera(&self, bounds: &Aabb) -> Camera {
        let camera = self.view.camera(bounds, self.size);
        let Some(fraction) = self.within else {
            return camera;
        };
        let eye = bounds.min + bounds.size() * fraction;
        let mut eye_from_world = camera.eye_from_world;
        eye_from_world.translation = -(eye_from_world.matrix3 * eye);
        Camera {
            eye_from_world,
            lens: Lens::Perspective {
                focal_px: f64::from(self.size[1]),
                near_mm: 1e-3 * bounds.size().length(),
            },
            ..camera
        }
    }
}

/// Cameras of both lenses, from outside and inside, along axes and not.
pub fn eye() -> impl Strategy<Value = Eye> {
    let angle = || prop_oneof![1 => (-4i32..4).prop_map(|n| f64::from(n) * 90.0), 2 => -180.0f64..180.0];
    let projection = prop_oneof![
        Just(Projection::Orthographic),
        (10.0f64..120.0).prop_map(|fov_y_deg| Projection::Perspective { fov_y_deg }),
    ];
    let fraction = prop::array::uniform3(0.0f64..1.0).prop_map(DVec3::from);
    let within = prop::option::weighted(0.25, fraction);
    let size = prop::array::uniform2(1u32..20);
    (angle(), angle(), angle(), 0.5f64..3.0, projection, within, size).prop_map(
        |(azimuth_deg, elevation_deg, roll_deg, zoom, projection, within, size)| Eye {
            view: View {
                azimuth_deg,
                elevation_deg,
                roll_deg,
                zoom,
                focus: None,
                projection,
            },
            within,
            size,
        },
    )
}

/// A transfer function over some value range.
#[derive(Clone, Debug)]
pub struct Look {
    /// Fraction of the value range, colour and opacity of each point.
    points: Vec<(f32, [f32; 3], f32)>,
    unit_mm: f64,
}

impl Look {
    /// The function over `range`.
    pub fn transfer(&self, range: Interval) -> TransferFunction {
        let width = range.width().max(0.0);
        let mut points: Vec<ControlPoint> = self
            .points
            .iter()
            .map(|&(fraction, color, opacity)| ControlPoint {
                value: if range.is_empty() {
                    0.0
                } else {
                    range.lo + fraction * width
                },
                color,
                opacity,
            })
            .collect();
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
        TransferFunction::new(points, self.unit_mm).expect("a valid function")
    }
}

/// Transfer functions, often with transparent stretches and steps.
pub fn look() -> impl Strategy<Value = Look> {
    let opacity = prop_oneof![2 => Just(0.0f32), 1 => 0.0f32..=1.0, 1 => Just(1.0f32)];
    let color = prop::array::uniform3(0.0f32..=1.0);
    let fraction = prop_oneof![4 => -0.1f32..1.1, 1 => Just(0.5f32)];
    let points = prop::collection::vec((fraction, color, opacity), 1..7);
    (points, 0.2f64..5.0).prop_map(|(points, unit_mm)| Look { points, unit_mm })
}

/// Every mode, with and without shading.
pub fn settings() -> impl Strategy<Value = Settings> {
    let mode = prop::sample::select(vec![
        Mode::Composite,
        Mode::Composite,
        Mode::Mip,
        Mode::MinIp,
        Mode::Average,
        Mode::Additive,
        Mode::XRay,
    ]);
    let depth_cue = prop_oneof![Just(0.0f32), 0.0f32..=1.0].prop_map(|strength| DepthCue { strength });
    (mode, prop::option::of(shading()), depth_cue, 0.5f64..2.5).prop_map(
        |(mode, shading, depth_cue, samples_per_voxel)| Settings {
            mode,
            shading,
            depth_cue,
            samples_per_voxel,
            ..Settings::default()
        },
    )
}

fn shading() -> impl Strategy<Value = Shading> {
    let light = (parts::direction(), 0.0f32..=1.0).prop_map(|(towards, intensity)| Light { towards, intensity });
    let lights = prop::collection::vec(light, 1..=Shading::MAX_LIGHTS);
    let factors = prop::array::uniform3(0.0f32..=1.0);
    (lights, factors, 0u32..=10, 0.005f64..0.5).prop_map(
        |(lights, [ambient, diffuse, specular], shininess_log2, soft_gradient)| Shading {
            lights,
            material: Material {
                ambient,
                diffuse,
                specular,
                shininess_log2,
            },
            soft_gradient,
        },
    )
}
