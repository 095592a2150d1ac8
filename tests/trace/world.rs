//! Small worlds to trace.

use glam::{DAffine3, DVec3};
use vcsg::image::Frame;
use vcsg::projection::trace::{Look, Object, Optics, Ray, Sampling, Source, World, draw};
use vcsg::projection::{Camera, ControlPoint, Lens, Material, TransferFunction};
use vcsg::scene::{NoVolumes, Scene};
use vcsg::target::{Subdivision, Target};

/// The target of the shapes in a scene's text, one voxel a millimetre.
pub fn target(shapes: &str) -> Target {
    target_of(shapes, &Subdivision::default())
}

/// The same, subdivided in another way.
pub fn target_of(shapes: &str, subdivision: &Subdivision) -> Target {
    let text = format!("scene {{ {shapes} }}");
    let scene = Scene::parse("test.kdl", &text, ".".as_ref(), &mut NoVolumes).expect("a scene");
    Target::build(&scene.model, Some(1.0), subdivision).expect("a target")
}

/// All values of one colour and opacity a millimetre.
pub fn even(color: [f32; 3], opacity: f32) -> TransferFunction {
    let point = ControlPoint {
        value: 0.0,
        color,
        opacity,
    };
    TransferFunction::new(vec![point], 1.0).expect("a transfer function")
}

/// A white solid of these shapes.
pub fn solid(shapes: &str, optics: Optics) -> Object {
    Object::new(&target(shapes), &even([1.0; 3], 1.0), Some(optics))
}

/// A medium of these shapes.
pub fn medium(shapes: &str, color: [f32; 3], opacity: f32) -> Object {
    Object::new(&target(shapes), &even(color, opacity), None)
}

/// A surface that lets everything through, bent by an index.
pub fn glass(index: f64) -> Optics {
    Optics::new(0.0, 1.0, index).expect("optics")
}

/// A surface that mirrors a share.
pub fn mirror(share: f64) -> Optics {
    Optics::new(share, 0.0, 1.0).expect("optics")
}

/// A world whose surfaces scatter all light without shine.
pub fn world(objects: Vec<Object>, lights: Vec<Source>, environment: Option<[f64; 3]>) -> World {
    let material = Material {
        ambient: 0.0,
        diffuse: 1.0,
        specular: 0.0,
        shininess_log2: 0,
    };
    let look = Look {
        material: Some(material),
        soft_gradient: 0.02,
        samples_per_voxel: 2.0,
        environment,
    };
    World::new(objects, lights, look).expect("a world")
}

/// A camera of parallel rays along z that sees `width_mm` about the origin in `pixels`.
pub fn along_z(pixels: u32, width_mm: f64) -> Camera {
    Camera {
        eye_from_world: DAffine3::from_translation(DVec3::new(0.0, 0.0, 500.0)),
        lens: Lens::Orthographic {
            pixels_per_mm: f64::from(pixels) / width_mm,
        },
        size: [pixels; 2],
    }
}

/// The rays of its pixels.
pub fn rays(pixels: u32, width_mm: f64) -> impl Iterator<Item = Ray> {
    let camera = along_z(pixels, width_mm);
    let middle = move |n: u32| [n % pixels, n / pixels].map(|n| f64::from(n) + 0.5);
    (0..pixels * pixels).map(move |n| Ray::of_pixel(&camera, middle(n), 400.0))
}

/// A ray along z turned so that it goes along −y, aslant.
pub fn across_z(ray: &Ray) -> Ray {
    let turn = glam::DMat3::from_rotation_z(0.4) * glam::DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2 + 0.2);
    Ray {
        origin: turn * ray.origin,
        direction: turn * ray.direction,
        ..*ray
    }
}

/// What `samples` samples a pixel see.
pub fn picture(world: &World, camera: &Camera, samples: u32) -> Frame {
    let sampling = Sampling {
        samples,
        ..Sampling::default()
    };
    draw(world, camera, sampling, &|_| {}).expect("a frame")
}
