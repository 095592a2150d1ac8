//! Meshes on the processor: at each pixel what a ray cast at every triangle meets, to the rounding of double precision; no gaps;
//! the same bits on any number of threads and in any order.

use glam::{DAffine3, DVec3};
use vcsg::conformance::{MeshBounds, Precision};
use vcsg::image::Frame;
use vcsg::math::Aabb;
use vcsg::projection::{Camera, Lens, ProjectError, Settings, View};
use vcsg::render::DepthScale;
use vcsg::surface::raster::{Drawn, draw, draw_alone};
use vcsg::surface::reference::{Hit, hits};
use vcsg::surface::{Mesh, MeshLook, SurfaceView};

use crate::random::Random;
use crate::shapes::{FRAME_PX, Shapes};

fn world(shapes: &Shapes) -> Aabb {
    let positions = shapes.meshes.iter().flat_map(|(mesh, _)| mesh.positions.iter());
    Aabb::of_points(positions.map(|p| DVec3::from_array(p.map(f64::from))))
}

fn view<'a>(shapes: &'a Shapes, world: &Aabb) -> SurfaceView<'a> {
    SurfaceView::alone(&shapes.camera, &shapes.settings, world)
}

fn drawn(shapes: &Shapes) -> Drawn {
    draw(&view(shapes, &world(shapes)), &shapes.borrowed()).expect("a picture")
}

/// What a pixel's ray has of a triangle that it meets, or nearly.
struct Met {
    depth_mm: f64,
    /// What that is off at most.
    off_mm: f64,
    /// Whether rounding decides if it is met.
    unsure: bool,
}

/// Cramer's rule, as the reference has it. With L the farthest corner and E the longest edge, each weight is a quotient by `facing`
/// of products of up to |slope| L E. Both ways of computing it take fewer than 32 roundings of such products, and a depth is a
/// sum of three weights times up to L.
fn met(base: DVec3, slope: DVec3, [a, b, c]: [DVec3; 3]) -> Option<Met> {
    let (ab, ac, to_a) = (b - a, c - a, a - base);
    let facing = slope.dot(ab.cross(ac));
    let far = [a, b, c].map(|p| p.length()).into_iter().fold(0.0, f64::max) + base.length();
    let edge = ab.length().max(ac.length()).max((c - b).length());
    let off = 64.0 * 0.5 * f64::EPSILON * slope.length() * far * edge / facing.abs();
    let across = to_a.cross(slope);
    let (second, third) = (ac.dot(across) / facing, -ab.dot(across) / facing);
    let least = (1.0 - second - third).min(second).min(third);
    // Seen from the side, where there may be no numbers, nothing is sure.
    let is_known = least.is_finite() && off.is_finite();
    let is_met = !is_known || least >= -off;
    is_met.then(|| Met {
        depth_mm: to_a.dot(ab.cross(ac)) / facing,
        off_mm: 3.0 * off * far,
        unsure: !is_known || least <= off,
    })
}

/// Whether no corner is another; where one is, a triangle has no area.
fn has_corners([a, b, c]: &[DVec3; 3]) -> bool {
    a != b && b != c && c != a
}

/// How many pixels differ from the reference, and how many may.
fn differing(shapes: &Shapes, depths_mm: &[f32]) -> [usize; 2] {
    let camera = &shapes.camera;
    let triangles: Vec<[DVec3; 3]> = (shapes.meshes.iter())
        .flat_map(|(mesh, _)| (0..mesh.triangles.len()).map(|n| mesh.corners(n)))
        .map(|corners| {
            corners.map(|p| {
                camera
                    .eye_from_world
                    .transform_point3(DVec3::from_array(p.map(f64::from)))
            })
        })
        .filter(has_corners)
        .collect();
    let reference = hits(&view(shapes, &world(shapes)), &shapes.borrowed());
    let mut found = [0; 2];
    for (n, (hit, depth_mm)) in reference.iter().zip(depths_mm).enumerate() {
        let (x, y) = (n as u32 % camera.size[0], n as u32 / camera.size[0]);
        let base = camera.point_at_depth(x, y, 0.0);
        let slope = camera.point_at_depth(x, y, 1.0) - base;
        let met: Vec<Met> = triangles.iter().filter_map(|t| met(base, slope, *t)).collect();
        if met
            .iter()
            .any(|met| met.unsure || (met.depth_mm - camera.near_mm()).abs() <= met.off_mm)
        {
            found[1] += 1;
            continue;
        }
        let expected = hit.map_or(f64::INFINITY, |hit: Hit| hit.depth_mm);
        // The picture's depth is rounded to single precision.
        let off_mm = met.iter().map(|met| met.off_mm).fold(0.0, f64::max) + f64::from(f32::EPSILON) * expected.abs();
        let same = expected == f64::from(*depth_mm) || (expected - f64::from(*depth_mm)).abs() <= off_mm;
        found[0] += usize::from(!same);
    }
    found
}

#[test]
fn the_nearest_triangle_is_where_a_ray_meets_it() {
    let (mut covered, mut unsure) = (0, 0);
    for seed in 0..150 {
        let shapes = Shapes::random(seed);
        let depths_mm = drawn(&shapes).depths_mm;
        let [differing, may_differ] = differing(&shapes, &depths_mm);
        assert_eq!(differing, 0, "scene {seed}");
        unsure += may_differ;
        covered += depths_mm.iter().filter(|mm| mm.is_finite()).count();
    }
    println!("{covered} pixels covered; rounding decides in {unsure}");
    assert!(covered > 150 * 500 && 1000 * unsure < covered, "{covered} and {unsure}");
}

/// Colours and depths are within what meshes on a device of single precision may be.
#[test]
fn colours_are_within_the_bounds_of_meshes() {
    let mut faults = [0; 2];
    for seed in 0..40 {
        let shapes = Shapes::random(seed);
        let world = world(&shapes);
        let scale = DepthScale::new(&shapes.camera, &world.transformed(&shapes.camera.eye_from_world));
        let bounds = MeshBounds::new(&view(&shapes, &world), &shapes.borrowed(), &scale, &Precision::EXACT);
        let Drawn { frame, depths_mm } = drawn(&shapes);
        assert_eq!(bounds.pixels_outside(&frame), 0, "scene {seed}");
        assert_eq!(bounds.depths_outside(&depths_mm), 0, "depths of scene {seed}");
        let alone = draw_alone(&shapes.camera, &shapes.settings, &shapes.borrowed()).expect("a frame");
        assert!(alone == frame, "a cue that spans the meshes");
        let mut shifted = frame.clone();
        shifted.pixels_mut().rotate_right(1);
        faults[0] += bounds.pixels_outside(&shifted);
        let mut less = Shapes::random(seed);
        let last = less.meshes.len() - 1;
        less.meshes[last].0.triangles.to_mut().pop();
        let less = draw(&view(&shapes, &world), &less.borrowed()).expect("a picture");
        faults[1] += bounds.pixels_outside(&less.frame);
    }
    assert!(
        faults.iter().all(|pixels| *pixels > 300),
        "shifted, a triangle less: {faults:?}"
    );
}

#[test]
fn threads_and_order_make_no_difference() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    for seed in 0..30 {
        let mut shapes = Shapes::random(seed);
        let [one, two, three] = [1, 2, 3].map(|threads| pool(threads).expect("threads").install(|| drawn(&shapes)));
        assert!(one == two && one == three, "scene {seed}");
        for (mesh, _) in &mut shapes.meshes {
            mesh.triangles.reverse();
        }
        assert!(
            drawn(&shapes).depths_mm == one.depths_mm,
            "scene {seed} the other way round"
        );
    }
}

/// A sheet of triangles whose vertices fall on the centres of pixels, to the last bit or nearly: nothing shows through it.
#[test]
fn triangles_meet_without_gap() {
    let size = [70, 66];
    let settings = Settings {
        shading: None,
        ..Settings::default()
    };
    let random = &mut Random(1);
    for n in 0..40 {
        let bounds = Aabb::new(DVec3::splat(-30.0), DVec3::splat(30.0));
        let lens = match n % 4 {
            0 | 1 => Lens::Orthographic { pixels_per_mm: 1.0 },
            _ => Lens::Perspective {
                focal_px: 64.0,
                near_mm: 1e-3,
            },
        };
        let turned = View {
            azimuth_deg: random.between(-180.0, 180.0),
            elevation_deg: random.between(-80.0, 80.0),
            ..View::default()
        };
        let eye_from_world = match n % 2 {
            0 => DAffine3::IDENTITY,
            _ => turned.camera(&bounds, size).eye_from_world,
        };
        let camera = Camera {
            eye_from_world,
            lens,
            size,
        };
        let mesh = sheet_on_centres(&camera, random);
        let view = SurfaceView::alone(&camera, &settings, &bounds);
        let drawn = draw(&view, &[(&mesh, MeshLook::default())]).expect("a picture");
        let inside =
            |x: usize, y: usize| (3..size[0] as usize - 3).contains(&x) && (3..size[1] as usize - 3).contains(&y);
        let missing = (0..drawn.depths_mm.len()).filter(|n| {
            let (x, y) = (n % size[0] as usize, n / size[0] as usize);
            inside(x, y) && !drawn.depths_mm[*n].is_finite()
        });
        assert_eq!(missing.collect::<Vec<_>>(), Vec::<usize>::new(), "camera {n}");
    }
}

/// Vertices behind the centres of the pixels from the third from the edge on, each as deep as it likes, six triangles a vertex.
fn sheet_on_centres(camera: &Camera, random: &mut Random) -> Mesh {
    let [columns, rows] = camera.size.map(|size| size - 4);
    let world_from_eye = camera.eye_from_world.inverse();
    let mut mesh = Mesh::default();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let depth_mm = 64.0 * (1.0 + random.below(4) as f64);
        let eye = camera.point_at_depth(column + 2, row + 2, depth_mm);
        let place = world_from_eye.transform_point3(eye).as_vec3().to_array();
        mesh.positions.to_mut().push(place);
        if column + 1 < columns && row + 1 < rows {
            let corner = row * columns + column;
            let [beside, below] = [corner + 1, corner + columns];
            mesh.triangles
                .to_mut()
                .extend([[corner, beside, below + 1], [corner, below + 1, below]]);
        }
    }
    mesh
}

#[test]
fn odd_meshes_do_no_harm() {
    let mut shapes = Shapes::random(3);
    let right = drawn(&shapes);
    let mesh = &mut shapes.meshes[0].0;
    let first = mesh.positions.len() as u32;
    mesh.positions
        .to_mut()
        .extend([[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]]);
    mesh.triangles
        .to_mut()
        .extend([[0, 1, first], [first + 1, 1, 2], [0, 1, first + 2], [0, u32::MAX, 1]]);
    let alone = draw_alone(&shapes.camera, &shapes.settings, &shapes.borrowed()).expect("a frame");
    assert!(alone == right.frame, "as without triangles that are nowhere");
    let nothing = Frame::transparent(FRAME_PX[0], FRAME_PX[1]);
    for meshes in [vec![(&Mesh::default(), MeshLook::default())], Vec::new()] {
        let drawn = draw_alone(&shapes.camera, &shapes.settings, &meshes).expect("a frame");
        assert!(drawn == nothing, "nothing is drawn of no triangles");
    }
    let huge = Mesh {
        positions: vec![[f32::MAX; 3], [-f32::MAX, f32::MAX, 0.0], [0.0, -f32::MAX, f32::MAX]].into(),
        triangles: vec![[0, 1, 2], [0, 0, 1], [2, 2, 2]].into(),
        ..Mesh::default()
    };
    let drawn = draw_alone(&shapes.camera, &shapes.settings, &[(&huge, MeshLook::default())]).expect("a frame");
    assert!(drawn.pixels().as_flattened().iter().all(|c| c.is_finite()));
    for size in [[0, 5], [5, 0], [40_000, 1]] {
        let camera = Camera { size, ..shapes.camera };
        let refused = draw_alone(&camera, &shapes.settings, &[]);
        assert!(matches!(refused, Err(ProjectError::FrameSize { .. })), "{size:?}");
    }
}
