//! Closed-form fields against their own definition: gradients against central differences, ranges against samples.

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use vcsg::math::Aabb;
use vcsg::volume::analytic::{Analytic, Ball, ClosedForm, Constant, MarschnerLobb, Ramp, Trilinear};
use vcsg::volume::{Bricks, Field, Grid};

const BOUNDS: Aabb = Aabb::new(DVec3::splat(-1.5), DVec3::splat(1.5));

fn forms() -> [(&'static str, Box<dyn ClosedForm>); 5] {
    let slope = DVec3::new(0.5, -2.0, 1.5);
    let ball = Ball {
        center: DVec3::new(0.3, -0.2, 0.1),
        radius: 1.0,
    };
    let offset = DVec3::new(0.4, 1.0, -0.3);
    [
        ("constant", Box::new(Constant(3.7))),
        ("ramp", Box::new(Ramp { slope, offset: 2.0 })),
        ("ball", Box::new(ball)),
        ("Marschner-Lobb", Box::new(MarschnerLobb)),
        ("trilinear", Box::new(Trilinear { slope, offset })),
    ]
}

fn point() -> impl Strategy<Value = DVec3> {
    [-1.5..1.5f64, -1.5..1.5f64, -1.5..1.5f64].prop_map(DVec3::from_array)
}

proptest! {
    #[test]
    fn gradients_are_central_differences(p in point()) {
        // A central difference of step h is off by h²/6 of the third derivative. Marschner–Lobb's is at most
        // α/(2(1+α))·(π² f_M)³ = 2e4 and its curvature terms of the same order; the ball's grows as 1/r² towards the centre,
        // which the points kept away have below 1e4. With h = 1e-5: 1e-6, and rounding 1e-15/h = 1e-10.
        prop_assume!(p.distance(DVec3::new(0.3, -0.2, 0.1)) > 1e-2 && p.truncate().length() > 1e-2);
        let h = 1e-5;
        for (name, form) in forms() {
            let difference = DVec3::from_array(DVec3::AXES.map(|axis| {
                (form.value(p + axis * h) - form.value(p - axis * h)) / (2.0 * h)
            }));
            let gradient = form.gradient(p);
            prop_assert!((gradient - difference).length() < 1e-5, "{name}: {gradient} {difference}");
        }
    }

    #[test]
    fn ranges_hold_their_samples(a in point(), b in point(), f in [0.0..=1.0f64, 0.0..=1.0, 0.0..=1.0]) {
        let region = Aabb::of_points([a, b]);
        let p = (region.min + region.size() * DVec3::from_array(f)).clamp(region.min, region.max);
        for (name, form) in forms() {
            let span = form.range(&region);
            let v = form.value(p);
            prop_assert!(span.lo - 1e-12 <= v && v <= span.hi + 1e-12, "{name}: {v} in {span:?}");
        }
        let field = Analytic { form: MarschnerLobb, bounds: MarschnerLobb::BOUNDS };
        prop_assert!(field.range(&region).contains(field.sample(p)));
    }

    #[test]
    fn ranges_are_attained(a in point(), b in point()) {
        // Each form is monotone or unimodal in what its range is made of: on a box 1e-6 wide the range is as narrow as the
        // steepest slope (π² f_M = 60 for Marschner–Lobb) lets it be.
        let region = Aabb::of_points([a, a + (b - a).normalize_or(DVec3::X) * 1e-6]);
        for (name, form) in forms() {
            let span = form.range(&region);
            prop_assert!(span.hi - span.lo < 1e-3, "{name}: {span:?}");
        }
    }

    #[test]
    fn bricks_reproduce_a_trilinear_product(p in point()) {
        let form = Trilinear { slope: DVec3::new(0.5, -2.0, 1.5), offset: DVec3::new(0.4, 1.0, -0.3) };
        let truth = Analytic { form, bounds: BOUNDS };
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::splat(3.0 / 40.0), Default::default(), BOUNDS.min,
        );
        let bricks = Bricks::new(&Grid::from_field(&truth, [41; 3], place).unwrap());
        // Values are below 14: rounding the voxels is half an ε of that, interpolation 7.5 ε (see volume_bricks), positions
        // 2⁻²⁴ voxel.
        let error = f64::from(bricks.sample(p).value) - truth.form.value(p);
        prop_assert!(error.abs() < 8.0 * f64::from(f32::EPSILON) * 14.0, "{error}");
    }
}

#[test]
fn outside_its_box_a_field_is_empty() {
    let field = Analytic {
        form: Constant(2.0),
        bounds: BOUNDS,
    };
    let out = DVec3::splat(1.6);
    assert_eq!(field.sample(out).coverage, 0.0);
    assert_eq!(field.gradient(out), DVec3::ZERO);
    let around = field.range(&Aabb::new(DVec3::ZERO, out));
    assert!(around.contains(field.sample(out)) && around.contains(field.sample(DVec3::ZERO)));
}
