//! Frames of several levels on a device, under validation.

use std::sync::{Mutex, OnceLock, PoisonError};

use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
use vcsg::image::Frame;
use vcsg::model::Model;
use vcsg::projection::levels::{Zone, Zones, footprint};
use vcsg::projection::{Camera, ControlPoint, FrameSpec, Mode, Settings, TransferFunction};
use vcsg::render::{LevelsFrame, LevelsSpec, PagedTarget, SliceRenderer, soft_normals};
use vcsg::target::{Levels, Subdivision, Target};

use crate::row::{eye_at, posts};

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

fn transfer() -> TransferFunction {
    let point = |value, opacity| ControlPoint {
        value,
        color: [0.9, 0.8, 0.6],
        opacity,
    };
    TransferFunction::new(vec![point(0.0, 0.0), point(1.0, 0.5)], 1.0).expect("a function")
}

fn subdivision() -> Subdivision {
    Subdivision {
        min_block: 8,
        ..Subdivision::default()
    }
}

fn settings(mode: Mode) -> Settings {
    Settings {
        mode,
        ..Settings::default()
    }
}

/// A frame of `count` levels of `model`.
fn draw(model: &Model, camera: &Camera, count: u32, mode: Mode) -> LevelsFrame {
    let levels = Levels::new(model, Some(1.0), count).expect("levels");
    let spec = LevelsSpec {
        levels: &levels,
        subdivision: &subdivision(),
        transfer: &transfer(),
        camera,
        settings: &settings(mode),
    };
    on_device(|renderer| renderer.draw_levels(&spec)).expect("a frame")
}

/// A frame of one target.
fn draw_one(model: &Model, camera: &Camera, mode: Mode) -> Frame {
    let target = Target::build(model, Some(1.0), &subdivision()).expect("a target");
    let spec = FrameSpec {
        target: &target,
        transfer: &transfer(),
        camera,
        settings: &settings(mode),
    };
    on_device(|renderer| draw_spec(renderer, &spec))
}

fn draw_spec(renderer: &mut SliceRenderer, spec: &FrameSpec) -> Frame {
    let normals = soft_normals(spec);
    let device = std::sync::Arc::clone(renderer.device());
    let paged = PagedTarget::new(&device, spec.target, normals.as_ref(), &mut |_| {}).expect("a target on the device");
    renderer.draw(spec, &paged, &[]).expect("a frame").0
}

/// A frame whose levels switch where zones meet: each zone's own level alone.
fn draw_switched(model: &Model, camera: &Camera, count: u32) -> Frame {
    let levels = Levels::new(model, Some(1.0), count).expect("levels");
    let settings = settings(Mode::Composite);
    let zones = Zones::new(&levels, camera, settings.samples_per_voxel);
    let [width, height] = camera.size;
    let mut frame = Frame::transparent(width, height);
    for zone in zones.zones.iter().rev() {
        let alone = Levels::new(model, Some(levels.voxel_mm(zone.level)), 1).expect("a level");
        let Some(target) = part(&alone, zone, camera) else {
            continue;
        };
        let settings = zone.settings(&settings, &zones.comb, &levels.base, &target.lattice);
        let spec = FrameSpec {
            target: &target,
            transfer: &transfer(),
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

fn largest_change(a: &Frame, b: &Frame) -> f32 {
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
    let model = posts(6, 30.0);
    let camera = eye_at(-40.0, 64);
    for mode in Mode::ALL {
        let (one, levels) = (draw_one(&model, &camera, mode), draw(&model, &camera, 1, mode));
        assert_eq!(levels.zones.len(), 1);
        // The planes are the same; the target is cropped to what is seen, so its boxes and their rounding are not: 8-bit weights
        // of filters move a sample by some 1/256 of a voxel's change.
        let change = largest_change(&one, &levels.frame);
        assert!(change < 0.02, "{mode:?}: {change}");
    }
}

#[test]
fn zones_join_in_every_mode() {
    // Beyond all blending the eye sees one level whether it is drawn as one zone or as several.
    let model = posts(24, 30.0);
    let camera = eye_at(-40.0, 64);
    for mode in Mode::ALL {
        let drawn = draw(&model, &camera, 4, mode);
        assert!(drawn.zones.len() > 2, "{:?}", drawn.zones);
        assert!(
            drawn
                .zones
                .windows(2)
                .all(|pair| pair[0].zone.level < pair[1].zone.level)
        );
        let one = draw_one(&model, &camera, mode);
        let difference = mean_square(&one, &drawn.frame).sqrt();
        println!("{mode:?}: alpha differs by {difference:.4} from that of one level");
        assert!(difference < 0.15, "{mode:?}: {difference}");
    }
}

#[test]
fn levels_are_nearer_to_the_supersampled_picture() {
    const BY: u32 = 8;
    let model = posts(60, 16.0);
    let camera = eye_at(-40.0, 64);
    let truth = averaged(&draw_one(&model, &eye_at(-40.0, 64 * BY), Mode::Composite), BY);
    let one = mean_square(&truth, &draw_one(&model, &camera, Mode::Composite));
    let several = mean_square(&truth, &draw(&model, &camera, 4, Mode::Composite).frame);
    println!("mean square error of alpha: one level {one:.2e}, four {several:.2e}");
    assert!(several < one, "{several} and not {one}");
}

#[test]
fn nothing_pops_when_the_eye_moves() {
    const STEPS: u32 = 40;
    let model = posts(12, 40.0);
    let eyes: Vec<Camera> = (0..STEPS).map(|n| eye_at(-60.0 - 0.2 * f64::from(n), 64)).collect();
    let worst = |frame: &dyn Fn(&Camera) -> Frame| {
        let frames: Vec<Frame> = eyes.iter().map(frame).collect();
        frames
            .windows(2)
            .map(|pair| largest_change(&pair[0], &pair[1]))
            .fold(0.0, f32::max)
    };
    let blended = worst(&|eye| draw(&model, eye, 4, Mode::Composite).frame);
    let switched = worst(&|eye| draw_switched(&model, eye, 4));
    println!("largest change of a pixel: blended {blended:.4}, switched {switched:.4}");
    assert!(blended < 0.5 * switched, "{blended} and {switched}");
}
