//! `vcsg bench figure8`: how far surfaces and normals of a volume-sampled cone are from those of the cone (WK94, figure 8).

use std::path::Path;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde::Serialize;

use super::CliError;
use crate::image::{Frame, Rgba, save};
use crate::projection::trace::{Object, Optics, Ray, surface};
use crate::projection::{Camera, ControlPoint, Lens, TransferFunction};
use crate::scene::{NoVolumes, Scene};
use crate::target::{Subdivision, Target};

/// The cone's base and half its height, voxels, and its apex at the top: those of the paper's table 1.
const RADIUS: f64 = 32.0;

/// Pixels of the pictures, and of a voxel.
const PIXELS: u32 = 320;
const PIXELS_PER_VOXEL: f64 = 4.0;

/// The errors that are shown as full red.
const WORST_VOXELS: f64 = 0.2;
const WORST_DEGREES: f64 = 1.5;

/// How near to the apex and the rim the filter has rounded the cone, voxels.
const ROUNDED: f64 = 5.0;

/// What was found, beside what the paper says: under 0.2 voxel, and under 1.5 degrees but at the apex and the rim.
#[derive(Serialize)]
pub(super) struct Errors {
    rays: u32,
    /// The largest distance from the cone, voxels, and the largest error of a normal, degrees, of rays that fully meet a smooth part of
    /// the cone.
    surface_voxels: f64,
    normal_degrees: f64,
    /// The same with its rim and apex.
    surface_voxels_anywhere: f64,
    normal_degrees_anywhere: f64,
}

/// Measures, and writes the paper's two pictures side by side.
pub(super) fn measure(picture: Option<&Path>) -> Result<Errors, CliError> {
    let object = cone()?;
    let camera = camera();
    let mut frames = [(); 2].map(|()| Frame::transparent(PIXELS, PIXELS).over([1.0; 3]));
    let mut errors = Errors {
        rays: 0,
        surface_voxels: 0.0,
        normal_degrees: 0.0,
        surface_voxels_anywhere: 0.0,
        normal_degrees_anywhere: 0.0,
    };
    for n in 0..PIXELS * PIXELS {
        let pixel = [n % PIXELS, n / PIXELS].map(|at| f64::from(at) + 0.5);
        let ray = Ray::of_pixel(&camera, pixel, 0.0);
        let mut probe = object.probe(&ray);
        let Some(met) = surface::next(&mut probe, false, 0.0, f64::INFINITY) else {
            continue;
        };
        let truth = Truth::nearest(ray.at(met.at_mm));
        let off = [
            truth.distance.abs(),
            met.normal(&probe, &ray).angle_between(truth.normal).to_degrees(),
        ];
        if met.is_full() {
            errors.add(off, truth.is_smooth);
        }
        for ((frame, off), worst) in frames.iter_mut().zip(off).zip([WORST_VOXELS, WORST_DEGREES]) {
            frame.pixels_mut()[n as usize] = shown(off / worst);
        }
    }
    if let Some(picture) = picture {
        save(&beside(&frames), picture, &[("Software", "vcsg")])?;
    }
    Ok(errors)
}

impl Errors {
    fn add(&mut self, [surface, normal]: [f64; 2], is_smooth: bool) {
        self.rays += 1;
        self.surface_voxels_anywhere = self.surface_voxels_anywhere.max(surface);
        self.normal_degrees_anywhere = self.normal_degrees_anywhere.max(normal);
        if is_smooth {
            self.surface_voxels = self.surface_voxels.max(surface);
            self.normal_degrees = self.normal_degrees.max(normal);
        }
    }

    /// As text.
    pub fn table(&self) -> String {
        format!(
            "{} rays that fully meet a cone of radius 32\n\
             {:<34} {:>9} {:>9} {:>9}\n\
             {:<34} {:>9.3} {:>9.3} {:>9}\n\
             {:<34} {:>9.2} {:>9.2} {:>9}",
            self.rays,
            "",
            "smooth",
            "anywhere",
            "WK94",
            "largest error of surface, voxels",
            self.surface_voxels,
            self.surface_voxels_anywhere,
            "< 0.2",
            "largest error of normal, degrees",
            self.normal_degrees,
            self.normal_degrees_anywhere,
            "< 1.5"
        )
    }
}

/// From yellow for no error to red.
fn shown(part: f64) -> Rgba {
    [1.0, 1.0 - part.clamp(0.0, 1.0) as f32, 0.0, 1.0]
}

fn beside(frames: &[Frame; 2]) -> Frame {
    let mut both = Frame::transparent(2 * PIXELS, PIXELS);
    let width = PIXELS as usize;
    for (y, row) in both.pixels_mut().chunks_exact_mut(2 * width).enumerate() {
        for (half, frame) in row.chunks_exact_mut(width).zip(frames) {
            half.copy_from_slice(&frame.pixels()[y * width..(y + 1) * width]);
        }
    }
    both
}

/// A point of the cone's surface, in the half-plane beside its axis.
struct Truth {
    distance: f64,
    normal: DVec3,
    is_smooth: bool,
}

impl Truth {
    /// The surface that is nearest to a point.
    fn nearest(p: DVec3) -> Self {
        let around = p.truncate().normalize_or_zero();
        let beside = DVec2::new(p.truncate().length(), p.z);
        let [rim, apex] = [DVec2::new(RADIUS, 0.0), DVec2::new(0.0, 2.0 * RADIUS)];
        let side = DVec2::new(2.0, 1.0).normalize();
        let (distance, normal) = match ((beside - apex).dot(side), -beside.y) {
            (to_side, to_base) if to_side.abs() < to_base.abs() => (to_side, (around * side.x).extend(side.y)),
            (_, to_base) => (to_base, -DVec3::Z),
        };
        Self {
            distance,
            normal,
            is_smooth: beside.distance(rim) > ROUNDED && (beside.x > ROUNDED || beside.y < RADIUS),
        }
    }
}

fn cone() -> Result<Object, CliError> {
    let text = format!(
        "scene {{ cone radius={RADIUS} from=\"0 0 0\" to=\"0 0 {}\" }}",
        2.0 * RADIUS
    );
    let scene = Scene::parse("figure8.kdl", &text, Path::new(""), &mut NoVolumes)?;
    let target = Target::build(&scene.model, Some(1.0), &Subdivision::default())?;
    let point = ControlPoint {
        value: 0.0,
        color: [1.0; 3],
        opacity: 1.0,
    };
    let opaque = TransferFunction::new(vec![point], 1.0).map_err(|e| CliError::Usage(e.to_string()))?;
    Ok(Object::new(&target, &opaque, Some(Optics::default())))
}

/// Aslant from above, so that sides and lattice lie at all angles.
fn camera() -> Camera {
    let turn =
        DMat3::from_rotation_x(0.5) * DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2) * DMat3::from_rotation_z(0.3);
    Camera {
        eye_from_world: DAffine3 {
            matrix3: turn,
            translation: DVec3::new(0.0, 0.0, 500.0) - turn * DVec3::Z * RADIUS,
        },
        lens: Lens::Orthographic {
            pixels_per_mm: PIXELS_PER_VOXEL,
        },
        size: [PIXELS; 2],
    }
}
