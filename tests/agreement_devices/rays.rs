//! Law 3, directly: what slices on a device draw and what rays on the processor draw.
//!
//! Both frames lie between bounds of their own, and both bounds hold the exact picture. So at each channel the two are no farther
//! apart than the hull of both bounds is wide.

use std::path::PathBuf;

use vcsg::conformance::FrameBounds;
use vcsg::image::{Frame, compare, save};
use vcsg::projection::Projector;
use vcsg::projection::raycast::{CastTarget, RayCaster};
use vcsg::surface::cast;

use crate::device::{Bench, on_device};
use crate::drawing::drawing;
use crate::inside::Case;
use crate::meshes::OnDevice;
use crate::meshes_inside::{bands_of, bounds, draw, prepared};
use crate::scene::Recipe;

/// Names the variable with the number of random scenes, for longer runs.
const SCENES: &str = "VCSG_TEST_SCENES";

/// How many pictures are left of those that differ the most.
const PICTURES: usize = 3;

/// One scene, drawn twice.
struct Pair {
    what: String,
    slices: Frame,
    rays: Frame,
    /// What the two may be apart in each channel.
    most: Vec<f64>,
}

impl Pair {
    fn new(what: String, slices: (Frame, FrameBounds), rays: (Frame, FrameBounds)) -> Self {
        let channels = |frame: &Frame| frame.pixels().as_flattened().to_vec();
        let ends = |one: &Frame, other: &Frame, of: fn(f32, f32) -> f32| -> Vec<f32> {
            let both = channels(one).into_iter().zip(channels(other));
            both.map(|(a, b)| of(a, b)).collect()
        };
        let low = ends(&slices.1.low, &rays.1.low, f32::min);
        let high = ends(&slices.1.high, &rays.1.high, f32::max);
        Self {
            what,
            slices: slices.0,
            rays: rays.0,
            most: low
                .iter()
                .zip(&high)
                .map(|(lo, hi)| f64::from(*hi) - f64::from(*lo))
                .collect(),
        }
    }

    fn differences(&self) -> Vec<f64> {
        let channels = self.slices.pixels().as_flattened().iter();
        let both = channels.zip(self.rays.pixels().as_flattened());
        both.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs()).collect()
    }

    /// How many channels are farther apart than they may be.
    fn outside(&self) -> usize {
        let all = self.differences().into_iter().zip(&self.most);
        all.filter(|(difference, most)| difference.is_nan() || difference > *most)
            .count()
    }

    fn worst(&self) -> f64 {
        self.differences().into_iter().fold(0.0, f64::max)
    }
}

/// Requires that all agree, says how well, and leaves pictures of the worst: rays | difference | slices.
fn require_agreement(bench: &Bench, name: &str, mut pairs: Vec<Pair>) {
    pairs.sort_by(|a, b| b.worst().total_cmp(&a.worst()));
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("agreement");
    std::fs::create_dir_all(&folder).expect("a folder for pictures");
    for (n, pair) in pairs.iter().take(PICTURES).enumerate() {
        let device: String = bench
            .renderer
            .device()
            .info()
            .name
            .chars()
            .filter(|c| c.is_alphanumeric())
            .collect();
        let file = folder.join(format!("{device}-{name}-{n}.png"));
        let panels = compare::panels(&pair.rays, &pair.slices).expect("frames of one size");
        save(&panels, &file, &[]).expect("a picture");
        println!(
            "{name}: {} apart by {:.2e}, see {}",
            pair.what,
            pair.worst(),
            file.display()
        );
    }
    let differences: Vec<f64> = pairs.iter().flat_map(Pair::differences).collect();
    let allowed = pairs.iter().flat_map(|pair| &pair.most).sum::<f64>() / differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    println!(
        "{name}: {} scenes, {mean:.2e} apart in the mean where {allowed:.2e} is allowed",
        pairs.len()
    );
    for pair in &pairs {
        assert_eq!(pair.outside(), 0, "channels of {}", pair.what);
    }
}

fn scenes(few: u64) -> u64 {
    std::env::var(SCENES).map_or(few, |n| n.parse().expect("a number of scenes"))
}

fn pair(bench: &mut Bench, seed: u64) -> Pair {
    let recipe = Recipe::random(seed);
    let scene = recipe.scene();
    let spec = scene.spec();
    let prepared = bench.prepare(&spec);
    let slices = (bench.draw(&spec, &prepared), bench.bounds(&spec, &prepared));
    let rays = RayCaster.project(&spec).expect("a frame");
    Pair::new(
        format!("{recipe:?}"),
        slices,
        (rays, FrameBounds::new(&spec, &drawing(&spec))),
    )
}

pub fn slices_and_rays_agree() {
    on_device(|bench| {
        let pairs = (3000..3000 + scenes(24)).map(|seed| pair(bench, seed)).collect();
        require_agreement(bench, "slices and rays", pairs);
    });
}

pub fn slices_and_rays_agree_among_meshes() {
    on_device(|bench| {
        let mut drawn = |seed: u64| {
            let case = Case::new(seed);
            let spec = case.scene.spec();
            let prepared = prepared(bench, &case, bands_of(seed));
            let on_device = OnDevice::new(bench, &case.borrowed());
            let slices = (
                draw(bench, &case, &prepared, &on_device),
                bounds(bench, &case, &prepared),
            );
            let rays = cast(&spec, &CastTarget::of(&spec), &case.borrowed()).expect("a frame");
            let what = format!("{:?} {seed} with {} meshes", spec.settings.mode, case.meshes.len());
            Pair::new(what, slices, (rays, case.bounds(&drawing(&spec))))
        };
        let pairs = (3000..3000 + scenes(12)).map(&mut drawn).collect();
        require_agreement(bench, "slices and rays among meshes", pairs);
    });
}

/// Law 9: a comparator that cannot fail holds nothing.
pub fn a_shifted_pixel_is_seen_between_them() {
    on_device(|bench| {
        let mut outside = 0;
        for seed in 3000..3006 {
            let mut pair = pair(bench, seed);
            pair.rays.pixels_mut().rotate_right(1);
            outside += pair.outside();
        }
        println!("rays shifted by a pixel: {outside} channels are too far from slices");
        assert!(outside > 1000, "{outside}");
    });
}
