//! Landmarks that make no spline, and splines that fold.

use glam::{DVec3, dvec3};
use vcsg::math::Aabb;
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline, SplineError, WarpError};
use vcsg::model::{Model, Node, Tree, TreeError};
use vcsg::voxelize::{Primitive, Solid};

fn landmark(name: &str, from: DVec3, to: DVec3) -> Landmark {
    Landmark {
        name: name.into(),
        from,
        to,
    }
}

fn still(name: &str, place: DVec3) -> Landmark {
    landmark(name, place, place)
}

/// The corners of a cube of 100 mm, where they are.
fn corners() -> Vec<Landmark> {
    let cube = Aabb::new(DVec3::splat(-50.0), DVec3::splat(50.0));
    cube.corners()
        .iter()
        .enumerate()
        .map(|(n, c)| still(&format!("corner {n}"), *c))
        .collect()
}

fn refusal(landmarks: &[Landmark]) -> SplineError {
    Spline::new(landmarks, &Smoothness::default()).expect_err("no spline")
}

#[test]
fn landmarks_that_make_no_spline_are_named() {
    assert_eq!(refusal(&corners()[..2]), SplineError::TooFew(2));
    let many: Vec<_> = (0..2001).map(|n| still("a", DVec3::X * n as f64)).collect();
    assert_eq!(refusal(&many), SplineError::TooMany(2001));
    let here = DVec3::ONE;
    assert_eq!(
        refusal(&[still("a", here), still("b", here), still("c", here)]),
        SplineError::OnePlace
    );
    let torn = [
        corners(),
        vec![landmark("nose", here, here), landmark("chin", here, 2.0 * here)],
    ]
    .concat();
    assert_eq!(refusal(&torn), SplineError::Torn("nose".into(), "chin".into()));
    let endless = [corners(), vec![landmark("tip", here, DVec3::splat(f64::NAN))]].concat();
    assert_eq!(refusal(&endless), SplineError::NotFinite("tip".into()));
    for (stiffness, support_mm) in [
        (-1.0, None),
        (f64::NAN, None),
        (0.0, Some(0.0)),
        (0.0, Some(f64::INFINITY)),
    ] {
        let made = Spline::new(&corners(), &Smoothness { stiffness, support_mm });
        assert_eq!(made.expect_err("no spline"), SplineError::Smoothness);
    }
}

#[test]
fn a_landmark_said_twice_counts_once() {
    let twice = [corners(), corners()].concat();
    let spline = Spline::new(&twice, &Smoothness::default()).expect("a spline");
    assert_eq!(spline.landmarks(), 8);
    assert!(spline.point(DVec3::ONE).distance(DVec3::ONE) < 1e-12);
}

#[test]
fn a_fold_is_named_with_its_place() {
    let within = Aabb::new(DVec3::splat(-50.0), DVec3::splat(50.0));
    // Two neighbours that change places turn space over between them.
    let crossing = [
        landmark("left", dvec3(-10.0, 0.0, 0.0), dvec3(10.0, 0.0, 0.0)),
        landmark("right", dvec3(10.0, 0.0, 0.0), dvec3(-10.0, 0.0, 0.0)),
    ];
    let crossing = [corners(), crossing.to_vec()].concat();
    let spline = Spline::new(&crossing, &Smoothness::default()).expect("a spline");
    let fold = Morph::new(spline.clone(), within).expect_err("a fold");
    assert!(fold.determinant <= 0.0);
    assert!(fold.place_mm.length() < 30.0, "{fold}");
    assert!(["left", "right"].contains(&&*fold.nearest), "{fold}");
    // Far from them nothing folds.
    let corner = Aabb::new(DVec3::splat(40.0), DVec3::splat(50.0));
    assert!(Morph::new(spline, corner).is_ok());
    let stiff = Smoothness {
        stiffness: 1000.0,
        support_mm: None,
    };
    assert!(Morph::new(Spline::new(&crossing, &stiff).expect("a spline"), within).is_ok());
    // A mirror image has a determinant below 0 everywhere.
    let mirrored: Vec<_> = corners()
        .iter()
        .map(|l| landmark(&l.name, l.from, l.from * dvec3(-1.0, 1.0, 1.0)))
        .collect();
    let spline = Spline::new(&mirrored, &Smoothness::default()).expect("a spline");
    assert!(Morph::new(spline, within).is_err());
}

/// At a landmark of a thin plate the gradient jumps: it may fold there alone.
#[test]
fn a_fold_at_a_single_landmark_is_seen() {
    let within = Aabb::new(DVec3::splat(-51.0), DVec3::splat(49.0));
    let pushed = |by: f64| {
        let landmarks = [corners(), vec![landmark("tip", DVec3::ZERO, DVec3::X * by)]].concat();
        Morph::new(
            Spline::new(&landmarks, &Smoothness::default()).expect("a spline"),
            within,
        )
    };
    let folds_from = (1..100)
        .map(f64::from)
        .find(|by| pushed(*by).is_err())
        .expect("it folds in the end");
    let fold = pushed(folds_from).expect_err("a fold");
    assert_eq!(fold.nearest, "tip");
    assert!(fold.place_mm.length() < 1.0, "{fold}");
    // Just before it, the determinant beside the landmark is small and no more.
    assert!((20.0..80.0).contains(&folds_from), "{folds_from}");
}

fn deformed(solid: Solid, times: usize) -> Result<Tree, TreeError> {
    let within = Aabb::new(DVec3::splat(-50.0), DVec3::splat(50.0));
    let spline = Spline::new(&corners(), &Smoothness::default()).expect("a spline");
    let morph = std::sync::Arc::new(Morph::new(spline, within).expect("no fold"));
    let mut model = Model::default();
    let mut child = model.push(Node::Primitive(Primitive::crisp(solid, 1.0)));
    for _ in 0..times {
        let morph = std::sync::Arc::clone(&morph);
        child = model.push(Node::Deform {
            child,
            morph,
            error_voxels: 0.1,
        });
    }
    Tree::in_world(&model, 1.0)
}

#[test]
fn what_cannot_be_tabulated_is_refused() {
    let ball = Solid::Sphere {
        center: DVec3::ZERO,
        radius: 3.0,
    };
    assert!(deformed(ball.clone(), 3).is_ok());
    assert!(matches!(deformed(ball, 17), Err(TreeError::Warp(WarpError::Nested))));
    assert!(matches!(
        deformed(Solid::Everything, 1),
        Err(TreeError::Warp(WarpError::Endless))
    ));
}
