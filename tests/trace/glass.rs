//! Glass that is a CSG of a scan and primitives: how it bends and mirrors against closed forms, and the scene that shows it.

use std::fs;
use std::process::Command;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use image::Rgba32FImage;
use vcsg::image::Frame;
use vcsg::math::{Aabb, affine};
use vcsg::projection::trace::{Bounds, Look, Object, Optics, Sampling, World, draw, fresnel, refract};
use vcsg::projection::{Camera, ControlPoint, TransferFunction};
use vcsg::scene::{Scene, VolumeLoader, VolumeRequest};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::{Bricks, Grid, Voxels};

use crate::world::{along_z, glass, solid};

/// The radius of the scanned ball, about the origin.
const RADIUS: f64 = 20.0;

/// Voxels along each axis of the scan, 1 mm apart.
const VOXELS: usize = 51;

/// A scanner in which there is nothing but a ball, whose values fall from 200 to 0 across its surface, as a scanner's do.
struct Scanner;

impl VolumeLoader for Scanner {
    fn load(&mut self, _: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        let middle = DVec3::splat(0.5 * (VOXELS - 1) as f64);
        let world_from_index = DAffine3::from_translation(-middle);
        let value = |n: usize| {
            let index = [n % VOXELS, n / VOXELS % VOXELS, n / (VOXELS * VOXELS)].map(|i| i as f64);
            let depth = RADIUS - affine::point(&world_from_index, DVec3::from_array(index)).length();
            (100.0 + 25.0 * depth).clamp(0.0, 200.0) as f32
        };
        let values = (0..VOXELS.pow(3)).map(value).collect();
        let grid = Grid::new([VOXELS; 3], world_from_index, Voxels::F32(values)).map_err(|e| e.to_string())?;
        Ok(Arc::new(Bricks::new(&grid)))
    }
}

/// The part of the scanned ball that is not beyond a plane through its middle.
fn half_ball(normal: &str, optics: Optics) -> Object {
    let text = format!("scene {{ intersect {{ volume \"ball.nrrd\"; half-space normal=\"{normal}\" value=200 }} }}");
    let scene = Scene::parse("half.kdl", &text, ".".as_ref(), &mut Scanner).expect("a scene");
    let target = Target::build(&scene.model, Some(1.0), &Subdivision::default()).expect("a target");
    let point = |value, opacity| ControlPoint {
        value,
        color: [1.0; 3],
        opacity,
    };
    let transfer = TransferFunction::new(vec![point(0.0, 0.0), point(200.0, 1.0)], 1.0).expect("a transfer function");
    Object::new(&target, &transfer, Some(optics))
}

/// A white solid that needs no light.
fn screen(bounds: Aabb) -> Object {
    let [min, max] = [bounds.min, bounds.max].map(|p| format!("{} {} {}", p.x, p.y, p.z));
    solid(&format!("box min=\"{min}\" max=\"{max}\""), Optics::default())
}

/// Flat colours before darkness.
fn dark(objects: Vec<Object>) -> World {
    let look = Look {
        material: None,
        soft_gradient: 1.0,
        samples_per_voxel: 1.0,
        environment: Some([0.0; 3]),
    };
    World::new(objects, Vec::new(), look).expect("a world")
}

/// What a camera sees by rays that are followed however little they matter.
fn seen(world: &World, camera: &Camera) -> Frame {
    let bounds = Bounds {
        depth: 24,
        least_weight: 0.0,
        ..Bounds::default()
    };
    let sampling = Sampling {
        bounds,
        ..Sampling::default()
    };
    draw(world, camera, sampling, &|_| {}).expect("a frame")
}

/// A ray in through the pole of the scanned side meets the cut at 45 degrees, and what is mirrored there leaves by another pole, towards a
/// screen. All is mirrored beyond the critical angle; before it what Fresnel's equations say.
#[test]
fn a_cut_mirrors_what_fresnel_and_total_reflection_say() {
    for index in [1.5, 1.45, 1.3, 1.1] {
        let screen = screen(Aabb::new(DVec3::new(-44.0, -8.0, -8.0), DVec3::new(-40.0, 8.0, 8.0)));
        let world = dark(vec![screen, half_ball("1 0 1", glass(index))]);
        let frame = seen(&world, &along_z(1, 0.1));
        // Of each round from pole to pole the share `pole²` is mirrored back into the next one.
        let pole = fresnel(1.0, 1.0, index);
        let by = |degrees: f64| {
            let cut = fresnel(degrees.to_radians().cos(), index, 1.0);
            (1.0 - pole).powi(2) * cut / (1.0 - (pole * cut).powi(2))
        };
        // The normal of a plane is off by 0.35 degrees at most (`projection/slopes`), at the pole and at the cut.
        let [least, most] = [45.0 - 0.7, 45.0 + 0.7].map(by);
        let [found, ..] = frame.pixels()[0].map(f64::from);
        println!("index {index}: {found:.4}, by closed form {:.4}", by(45.0));
        assert!(
            (least - 1e-3..=most + 1e-3).contains(&found),
            "{index}: {found} of {}",
            by(45.0)
        );
    }
}

/// Where a ray along z, `x` off the axis of the lens, gets to at depth `z` behind it; the lens is the ball before z = 0.
fn behind_the_lens(x: f64, index: f64, z: f64) -> f64 {
    let at = DVec3::new(x, 0.0, -(RADIUS * RADIUS - x * x).sqrt());
    let within = refract(DVec3::Z, at / RADIUS, 1.0, index).expect("a way in");
    let flat = at - within * (at.z / within.z);
    let out = refract(within, -DVec3::Z, index, 1.0).expect("a way out");
    flat.x + out.x / out.z * z
}

/// A screen at depth `z`, black before x = `edge` and white behind.
fn halved(edge: f64, z: f64) -> Object {
    // The second box does not add to the first one: it only says where that is white.
    let far = z + 4.0;
    let text = format!(
        "scene {{ overlay rule=\"max\" {{ box min=\"-20 -6 {z}\" max=\"20 6 {far}\" value=1
        box min=\"{edge} -9 {}\" max=\"24 9 {}\" value=2 }} }}",
        z - 4.0,
        far + 4.0
    );
    let scene = Scene::parse("screen.kdl", &text, ".".as_ref(), &mut Scanner).expect("a scene");
    let target = Target::build(&scene.model, Some(1.0), &Subdivision::default()).expect("a target");
    let point = |value, grey| ControlPoint {
        value,
        color: [grey; 3],
        opacity: 1.0,
    };
    let transfer = TransferFunction::new(vec![point(1.49, 0.0), point(1.51, 1.0)], 1.0).expect("a transfer function");
    Object::new(&target, &transfer, Some(Optics::default()))
}

/// A plano-convex lens, its convex side scanned and its flat side cut, before a screen half black and half white: the edge is
/// seen where Snell's law has it.
#[test]
fn a_lens_of_scan_and_plane_shows_an_edge_where_snell_has_it() {
    const DEPTH: f64 = 10.0;
    const PIXELS: u32 = 320;
    let index = 1.5;
    let mm = |pixel: usize| (pixel as f64 + 0.5) / 8.0 - 20.0;
    for edge in [-4.0, -3.0, 0.0, 1.5, 4.0] {
        let world = dark(vec![halved(edge, DEPTH), half_ball("0 0 1", glass(index))]);
        let mut camera = along_z(PIXELS, f64::from(PIXELS) / 8.0);
        camera.size[1] = 1;
        let frame = seen(&world, &camera);
        let bright = |n: &usize| mm(*n).abs() < 14.0 && frame.pixels()[*n][0] > 0.45;
        let first = (0..PIXELS as usize).find(bright).expect("the white half");
        let seen_at = behind_the_lens(mm(first), index, DEPTH);
        // Heights are the distance r from the middle here, whose third derivatives are at most 1.16/r². Of them smoothed half differences are
        // off by 1/6 along and 2/6 across, and between voxels by 3/8 more, along each of three axes; a plane's normal is off by 0.35
        // degrees at most (`projection/slopes`).
        let [convex, flat] = [3f64.sqrt() * 0.875 * 1.16 / 19.0f64.powi(2), 0.35f64.to_radians()];
        // For rays up to 14 mm off the axis Snell's law turns by 0.46 of what the convex normal is turned, over 22 mm to the flat side, and
        // 1.6 times as much behind it, over 12.2/10 of the depth; and by 0.6 of what the flat one is turned.
        let behind = 1.22 * DEPTH;
        let turned = convex * 0.46 * (22.0 + 1.6 * behind) + flat * 0.6 * behind;
        // Surfaces are met within 0.05 mm (`closed_forms`), a pixel is 1/8 mm and moves half of that on the screen.
        let within = turned + 2.0 * 0.05 + 0.0625;
        println!("an edge at {edge} is seen at {seen_at:.3}, within {within:.3}");
        assert!((seen_at - edge).abs() < within, "{seen_at} of {edge}, within {within}");
    }
}

/// Glass of index 1 without a tint changes nothing but where rays look for the next surface, so all but edges is the same.
#[test]
fn glass_of_index_1_cannot_be_seen() {
    let board = || screen(Aabb::new(DVec3::new(-6.0, -9.0, 24.0), DVec3::new(9.0, 7.0, 28.0)));
    let camera = along_z(64, 50.0);
    let with = seen(&dark(vec![board(), half_ball("2 1 1", glass(1.0))]), &camera);
    let without = seen(&dark(vec![board()]), &camera);
    let at = |n: u32| (f64::from(n) + 0.5 - 32.0) * 50.0 / 64.0;
    for (n, (a, b)) in (0u32..).zip(with.pixels().iter().zip(without.pixels())) {
        let [x, y] = [at(n % 64), at(n / 64)];
        // The filter makes a soft edge of two voxels on each side.
        let near_edge = [x + 6.0, x - 9.0, y + 9.0, y - 7.0].iter().any(|off| off.abs() < 2.0);
        let off = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        assert!(near_edge || off < 1e-6, "{a:?} for {b:?} at {x}, {y}");
    }
}

/// The scene of a head of glass, on coarse lattices so that it is there in a moment.
fn head_of_glass() -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    let text = fs::read_to_string(format!("{root}/assets/scenes/head-glass.kdl")).expect("the scene");
    let coarse = text
        .replace("spacing=2", "spacing=6")
        .replace("spacing=1 ", "spacing=5 ");
    coarse.replace("../../target", &format!("{root}/target"))
}

/// A small picture of a scene's text, as `vcsg render` draws it.
fn rendered(text: &str) -> Rgba32FImage {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("scene.kdl"), text).expect("a file");
    let output = Command::new(env!("CARGO_BIN_EXE_vcsg"))
        .current_dir(folder.path())
        .args([
            "render",
            "scene.kdl",
            "-o",
            "a.exr",
            "--size",
            "69x60",
            "--samples",
            "1",
        ])
        .output()
        .expect("a run");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "is all there that `make setup` fetches? {said}"
    );
    image::open(folder.path().join("a.exr"))
        .expect("a picture")
        .to_rgba32f()
}

/// Its glass bends what is seen through it, and gives no more light than it gets: a surface sends back at most the ambient part of its
/// colour and the rest of what its two lights give, and mirrored, bent and tinted light is a part of what there is.
#[test]
fn the_head_of_glass_bends_light_and_makes_none() {
    let text = head_of_glass();
    let [glass, air] = ["index=1.5", "index=1"].map(|index| rendered(&text.replace("index=1.5", index)));
    let far = |(a, b): (&image::Rgba<f32>, &image::Rgba<f32>)| (a[1] - b[1]).abs() > 0.05;
    let bent = glass.pixels().zip(air.pixels()).filter(|pair| far(*pair)).count();
    println!(
        "{bent} of {} pixels are others with an index of 1",
        glass.pixels().count()
    );
    assert!(bent > 69 * 60 / 5);
    let most = 0.15 + 0.85 * (1.1 + 0.5);
    for picture in [&glass, &air] {
        let brightest = picture.as_raw().iter().fold(0.0f32, |most, c| most.max(*c));
        assert!(
            picture.as_raw().iter().all(|c| *c >= 0.0) && brightest <= most,
            "{brightest}"
        );
    }
}
