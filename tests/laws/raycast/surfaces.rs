//! Opaque meshes in what is cast: rays end at them, within the bounds that slices and meshes on a device are held to.

use vcsg::image::Frame;
use vcsg::projection::Mode;
use vcsg::projection::raycast::CastTarget;
use vcsg::surface::cast;

use super::drawing::drawing;
use super::picture::same;
use crate::inside::Case;

fn draw(case: &Case) -> Frame {
    let spec = case.scene.spec();
    cast(&spec, &CastTarget::of(&spec), &case.borrowed()).expect("a frame")
}

#[test]
fn rays_stop_at_meshes() {
    let (mut with_meshes, mut worst) = (0, 0.0f64);
    for seed in 2000..2060 {
        let case = Case::new(seed);
        let bounds = case.bounds(&drawing(&case.scene.spec()));
        let frame = draw(&case);
        let what = format!(
            "{:?} {seed} with {} meshes",
            case.scene.settings.mode,
            case.meshes.len()
        );
        assert_eq!(bounds.pixels_outside(&case.reference()), 0, "the reference of {what}");
        assert_eq!(bounds.pixels_outside(&frame), 0, "{what}");
        let finite = bounds.deviations(&frame).into_iter().filter(|d| d.is_finite());
        worst = finite.fold(worst, f64::max);
        with_meshes += usize::from(!case.meshes.is_empty());
    }
    println!("{with_meshes} of 60 scenes have meshes; at most {worst:.3} of the bounds' half width");
    assert!(with_meshes > 40, "{with_meshes} scenes have meshes");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    for seed in 2000..2012 {
        let case = Case::new(seed);
        let [one, two, three] = [1, 2, 3].map(|threads| pool(threads).expect("threads").install(|| draw(&case)));
        assert_eq!(same(&one, &two), Ok(()), "seed {seed}");
        assert_eq!(same(&one, &three), Ok(()), "seed {seed}");
    }
}

/// Law 9: rays that end two samples too far back are out of bounds.
#[test]
fn a_mesh_too_far_back_is_out_of_bounds() {
    let (mut shown, mut outside) = (0, 0);
    for seed in (2004..2034).step_by(Mode::ALL.len()) {
        let case = Case::new(seed);
        let spec = case.scene.spec();
        let bounds = case.bounds(&drawing(&spec));
        let away = spec.camera.eye_from_world.matrix3.transpose().z_axis * 2.0 * spec.planes().step_mm;
        let mut moved = Case::new(seed);
        for position in moved.meshes.iter_mut().flat_map(|(mesh, _)| mesh.positions.iter_mut()) {
            *position = std::array::from_fn(|a| position[a] + away[a] as f32);
        }
        let wrong = draw(&moved);
        outside += bounds.pixels_outside(&wrong);
        shown += wrong.pixels().iter().filter(|pixel| pixel[3] == 1.0).count();
    }
    println!("two slabs too far back: {outside} of {shown} pixels are out of bounds");
    assert!(10 * outside > shown, "{outside} of {shown}");
}
