//! Frames of several levels on a device, under validation.

use std::sync::{Mutex, OnceLock, PoisonError};

use glam::DVec3;
use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
use vcsg::image::Frame;
use vcsg::math::Aabb;
use vcsg::model::{BooleanOp, Family, Model, Node, ValueRule};
use vcsg::projection::levels::{Zone, Zones, footprint};
use vcsg::projection::raycast::{self, CastTarget};
use vcsg::projection::{Camera, ControlPoint, FrameSpec, LevelsFrame, LevelsSpec, Mode, Settings, TransferFunction};
use vcsg::render::{PagedTarget, SliceRenderer, plan, soft_normals};
use vcsg::target::{Levels, Subdivision, Target};
use vcsg::voxelize::{Primitive, Solid};

use crate::row::{eye_at, fence, posts};

fn on_device<T>(test: impl FnOnce(&mut SliceRenderer) -> T) -> T {
    static RENDERER: OnceLock<Mutex<SliceRenderer>> = OnceLock::new();
    let renderer = RENDERER.get_or_init(|| {
        let instance = Instance::new(Validation::On).unwrap_or_else(|error| panic!("{error}: run `make setup`"));
        let device = Device::open(&instance, &DeviceSelector::Default, &SliceRenderer::REQUIREMENTS);
        let device = device.unwrap_or_else(|error| panic!("{error}: run `make setup`"));
        Mutex::new(SliceRenderer::new(&device).expect("a renderer"))
    });
    let mut renderer = renderer.lock().unwrap_or_else(PoisonError::into_inner);
    let result = test(&mut renderer);
    let messages = renderer.device().instance().take_messages();
    assert_eq!(messages, Vec::<String>::new(), "of the validation layer");
    result
}

/// How a model is seen.
pub struct Look {
    transfer: TransferFunction,
    settings: Settings,
}

impl Look {
    /// Lit, and opaque within some millimetres.
    pub fn of_posts(mode: Mode) -> Self {
        let settings = Settings {
            mode,
            ..Settings::default()
        };
        Self {
            transfer: transfer(&[(0.0, 0.0), (1.0, 0.5)]),
            settings,
        }
    }

    /// Not lit, and nearly transparent.
    pub fn of_fog(mode: Mode) -> Self {
        let settings = Settings {
            mode,
            shading: None,
            ..Settings::default()
        };
        Self {
            transfer: transfer(&[(1.0, FOG_OPACITY), (2.0, FOG_OPACITY)]),
            settings,
        }
    }
}

fn transfer(points: &[(f32, f32)]) -> TransferFunction {
    let point = |&(value, opacity)| ControlPoint {
        value,
        color: [0.9, 0.8, 0.6],
        opacity,
    };
    TransferFunction::new(points.iter().map(point).collect(), 1.0).expect("a function")
}

pub fn subdivision() -> Subdivision {
    Subdivision {
        min_block: 8,
        ..Subdivision::default()
    }
}

/// A frame of `count` levels of `model`.
pub fn draw(model: &Model, camera: &Camera, count: u32, look: &Look) -> LevelsFrame {
    let drawn = |spec: &LevelsSpec| on_device(|renderer| renderer.draw_levels(spec)).expect("a frame");
    of_levels(model, camera, count, look, drawn)
}

/// The same by rays on the processor.
pub fn cast(model: &Model, camera: &Camera, count: u32, look: &Look) -> LevelsFrame {
    let cast = |spec: &LevelsSpec| raycast::draw_levels(spec).expect("a frame");
    of_levels(model, camera, count, look, cast)
}

fn of_levels(
    model: &Model,
    camera: &Camera,
    count: u32,
    look: &Look,
    draw: impl Fn(&LevelsSpec) -> LevelsFrame,
) -> LevelsFrame {
    draw(&LevelsSpec {
        levels: &Levels::new(model, Some(1.0), count).expect("levels"),
        subdivision: &subdivision(),
        transfer: &look.transfer,
        camera,
        settings: &look.settings,
    })
}

/// A frame of one target.
pub fn draw_one(model: &Model, camera: &Camera, look: &Look) -> Frame {
    of_one(model, camera, look, |spec| {
        on_device(|renderer| draw_spec(renderer, spec))
    })
}

/// The same by rays on the processor.
pub fn cast_one(model: &Model, camera: &Camera, look: &Look) -> Frame {
    of_one(model, camera, look, |spec| {
        raycast::draw(spec, &CastTarget::of(spec), None).expect("a frame")
    })
}

fn of_one(model: &Model, camera: &Camera, look: &Look, draw: impl Fn(&FrameSpec) -> Frame) -> Frame {
    draw(&FrameSpec {
        target: &Target::build(model, Some(1.0), &subdivision()).expect("a target"),
        transfer: &look.transfer,
        camera,
        settings: &look.settings,
    })
}

fn draw_spec(renderer: &mut SliceRenderer, spec: &FrameSpec) -> Frame {
    let normals = soft_normals(spec);
    let device = std::sync::Arc::clone(renderer.device());
    let paged = PagedTarget::new(&device, spec.target, normals.as_ref(), &mut |_| {}).expect("a target on the device");
    // (What is planned slab by slab is in other boxes, and so rounded otherwise.)
    let plan = plan(spec, &paged);
    renderer.draw_plan(spec, &paged, &plan, &[]).expect("a frame").0
}

/// A frame whose levels switch where zones meet: each zone's own level alone.
fn draw_switched(model: &Model, camera: &Camera, count: u32) -> Frame {
    let levels = Levels::new(model, Some(1.0), count).expect("levels");
    let look = Look::of_posts(Mode::Composite);
    let zones = Zones::new(&levels, camera, look.settings.samples_per_voxel);
    let [width, height] = camera.size;
    let mut frame = Frame::transparent(width, height);
    for zone in zones.zones.iter().rev() {
        let alone = Levels::new(model, Some(levels.voxel_mm(zone.level)), 1).expect("a level");
        let Some(target) = part(&alone, zone, camera) else {
            continue;
        };
        let settings = zone.settings(&look.settings, &zones.comb, &levels.base, &target.lattice);
        let spec = FrameSpec {
            target: &target,
            transfer: &look.transfer,
            camera,
            settings: &settings,
        };
        let nearer = on_device(|renderer| draw_spec(renderer, &spec));
        for (pixel, source) in frame.pixels_mut().iter_mut().zip(nearer.pixels()) {
            *pixel = std::array::from_fn(|c| source[c] + (1.0 - source[3]) * pixel[c]);
        }
    }
    frame
}

/// What a zone holds of a level, cut at its own faces.
fn part(alone: &Levels, zone: &Zone, camera: &Camera) -> Option<Target> {
    let sides = zone.sides(camera, 0.0);
    alone
        .part(0, &footprint(camera), &sides, &subdivision())
        .expect("a target")
}

pub fn largest_change(a: &Frame, b: &Frame) -> f32 {
    let pixels = a.pixels().iter().zip(b.pixels());
    pixels
        .flat_map(|(a, b)| (0..4).map(move |c| (a[c] - b[c]).abs()))
        .fold(0.0, f32::max)
}

fn mean_square(a: &Frame, b: &Frame) -> f64 {
    let pixels = a.pixels().iter().zip(b.pixels());
    let sum: f64 = pixels.map(|(a, b)| f64::from(a[3] - b[3]).powi(2)).sum();
    sum / a.pixels().len() as f64
}

/// `frame` with each `by` · `by` pixels averaged.
fn averaged(frame: &Frame, by: u32) -> Frame {
    let (width, height) = (frame.width() / by, frame.height() / by);
    let pixel = |n: u32| {
        let (x, y) = (n % width * by, n / width * by);
        let inner = (0..by * by).map(|m| frame.pixel(x + m % by, y + m / by).expect("a pixel"));
        let sum = inner.fold([0.0f32; 4], |sum, p| std::array::from_fn(|c| sum[c] + p[c]));
        sum.map(|c| c / (by * by) as f32)
    };
    Frame::from_pixels(width, height, (0..width * height).map(pixel).collect()).expect("a frame")
}

#[test]
fn one_level_is_the_target_alone() {
    // All of the model is in the frame, so its part is the whole and the frames are the same to the bit.
    let model = posts(6, 30.0);
    let camera = eye_at(-80.0, 64);
    for mode in Mode::ALL {
        let look = Look::of_posts(mode);
        let (one, levels) = (draw_one(&model, &camera, &look), draw(&model, &camera, 1, &look));
        assert_eq!(levels.zones.len(), 1);
        assert_eq!(largest_change(&one, &levels.frame), 0.0, "{mode:?}");
    }
}

/// How deep the fog is before the eye, millimetres.
pub const FOG_MM: f64 = 150.0;

/// Its opacity a millimetre.
pub const FOG_OPACITY: f32 = 5e-4;

/// Fog of value 1 round the eye, and of value 2 in its far half.
fn fog() -> Model {
    let mut model = Model::default();
    let of = |near: f64, value| {
        let bounds = Aabb::new(DVec3::new(-90.0, near, -90.0), DVec3::new(90.0, FOG_MM, 90.0));
        Node::Primitive(Primitive::soft(Solid::Box(bounds), value))
    };
    let [thin, thick] = [of(-20.0, 1.0), of(0.5 * FOG_MM, 2.0)].map(|node| model.push(node));
    let (op, rule, family) = (BooleanOp::Union, ValueRule::Max, Family::MinMax);
    model.fold(op, rule, family, [thin, thick]);
    model
}

/// A pixel beside the middle of the fog's frame.
fn pixel_in_fog(camera: &Camera, count: Option<u32>, mode: Mode) -> [f32; 4] {
    let frame = match count {
        Some(count) => draw(&fog(), camera, count, &Look::of_fog(mode)).frame,
        None => draw_one(&fog(), camera, &Look::of_fog(mode)),
    };
    frame.pixel(8, 8).expect("a pixel")
}

#[test]
fn fog_is_as_dense_in_zones() {
    // Inside, every level has the same samples, so opacity sums to the same, but for the far end's softness: a slab of 2 mm too
    // many or too few would be more than 1.3 % of it. Slabs of one opacity o a millimetre are 1 - (1 - o)^n: 8 of them and one of 8 differ
    // in the second order, by less than 4 o, here 0.2 %.
    let camera = eye_at(0.0, 16);
    let zones = draw(&fog(), &camera, 4, &Look::of_fog(Mode::Composite)).zones;
    assert_eq!(
        zones.iter().map(|drawn| drawn.zone.level).collect::<Vec<_>>(),
        [0, 1, 2, 3]
    );
    for mode in [Mode::Composite, Mode::XRay, Mode::Additive] {
        let [one, several] = [None, Some(4)].map(|count| pixel_in_fog(&camera, count, mode)[3]);
        println!("{mode:?}: opacity {one} and {several}");
        assert!((several / one - 1.0).abs() < 0.006, "{mode:?}: {one} and {several}");
    }
}

/// Rays end their zones where slices do: between them a slab of 2 mm would be 1.3 % of the opacity. What a device's slab is off by is that of
/// a power near 1, whose logarithm and product are good for 8 steps of single precision together: in parts of the slab's opacity at most
/// 8 steps by the fog's a millimetre. At the far end coverage is rounded to 16 bits, in a few slabs of a hundred.
#[test]
fn rays_take_the_slabs_that_slices_take() {
    let camera = eye_at(0.0, 16);
    let bound = 8.0 * f32::EPSILON / FOG_OPACITY + 2f32.powi(-16);
    for mode in [Mode::Composite, Mode::XRay, Mode::Additive] {
        let look = Look::of_fog(mode);
        let drawn = draw(&fog(), &camera, 4, &look).frame;
        let cast = cast(&fog(), &camera, 4, &look).frame;
        for (drawn, cast) in drawn.pixels().iter().zip(cast.pixels()) {
            let apart = (drawn[3] / cast[3] - 1.0).abs();
            assert!(
                apart <= bound,
                "{mode:?}: {} and {}, {apart} apart, {bound} allowed",
                drawn[3],
                cast[3]
            );
        }
    }
}

#[test]
fn extremes_and_means_know_all_zones() {
    let camera = eye_at(0.0, 16);
    let grey = |count, mode| f64::from(pixel_in_fog(&camera, count, mode)[0]);
    let [least, most] = [Mode::MinIp, Mode::Mip].map(|mode| {
        let (one, several) = (grey(None, mode), grey(Some(4), mode));
        assert!((one - several).abs() < 1e-3, "{mode:?}: {one} and {several}");
        several
    });
    // The second half begins where it is at all there: a filter's radius earlier, up to 16 mm.
    let mean = (grey(Some(4), Mode::Average) - least) / (most - least);
    println!("the mean is {mean} of the way from the least to the most");
    assert!((0.48..0.5 + 0.02 + 16.0 / FOG_MM).contains(&mean), "{mean}");
}

#[test]
fn what_is_far_away_is_nearer_to_the_supersampled_picture() {
    // A pixel covers 8 mm of the fence: a ray of one level meets a post or the air beside it. Posts let most light through: what is
    // filtered is their density, and only then is opacity nearly proportional to it.
    const BY: u32 = 8;
    let look = Look {
        transfer: transfer(&[(0.0, 0.0), (1.0, 0.05)]),
        ..Look::of_fog(Mode::Composite)
    };
    let model = fence(40, 150.0);
    let camera = eye_at(-512.0, 64);
    let truth = averaged(&draw_one(&model, &eye_at(-512.0, 64 * BY), &look), BY);
    let one = mean_square(&truth, &draw_one(&model, &camera, &look));
    let several = mean_square(&truth, &draw(&model, &camera, 4, &look).frame);
    println!("mean square error of opacity: one level {one:.2e}, four {several:.2e}");
    assert!(several < one, "{several} and {one}");
}

#[test]
fn nothing_pops_when_the_eye_moves() {
    // The fence passes from zone 1, which ends where a pixel covers 4 mm, to zone 2.
    const STEPS: u32 = 120;
    let look = Look::of_posts(Mode::Composite);
    let model = fence(12, 12.0);
    let eyes: Vec<Camera> = (0..STEPS).map(|n| eye_at(-244.0 - 0.2 * f64::from(n), 64)).collect();
    let worst = |frame: &dyn Fn(&Camera) -> Frame| {
        let frames: Vec<Frame> = eyes.iter().map(frame).collect();
        let changes = frames.windows(2).map(|pair| largest_change(&pair[0], &pair[1]));
        changes.fold(0.0, f32::max)
    };
    let blended = worst(&|eye| draw(&model, eye, 4, &look).frame);
    let switched = worst(&|eye| draw_switched(&model, eye, 4));
    println!("largest change of a pixel: blended {blended:.4}, switched {switched:.4}");
    assert!(3.0 * blended < switched, "{blended} and {switched}");
}
