//! Splines, against vtkThinPlateSplineTransform and what their definition says.

#[path = "../oracle/process.rs"]
mod process;

use glam::{DAffine3, DMat3, DVec3};
use process::Process;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde::Deserialize;
use serde_json::json;
use vcsg::model::deform::{Landmark, Smoothness, Spline};

use crate::random::{landmarks, point};

/// Where VTK takes points.
#[derive(Deserialize)]
struct Moved {
    forward: Vec<DVec3Array>,
    inverse: Vec<DVec3Array>,
}

type DVec3Array = [f64; 3];

struct Oracle(Process);

impl Oracle {
    fn moved(&mut self, landmarks: &[Landmark], points: &[DVec3]) -> Moved {
        let from: Vec<DVec3> = landmarks.iter().map(|l| l.from).collect();
        let to: Vec<DVec3> = landmarks.iter().map(|l| l.to).collect();
        let request = json!({"landmarks": landmarks.len(), "points": points.len()});
        let data = [&from[..], &to, points].map(bytemuck::cast_slice);
        self.0.send(&request, &data);
        let mut answer = serde_json::Deserializer::from_reader(&mut self.0.answers);
        Moved::deserialize(&mut answer).expect("the oracle answers; see its message above")
    }
}

fn thin_plate(landmarks: &[Landmark]) -> Spline {
    Spline::new(landmarks, &Smoothness::default()).expect("landmarks that differ")
}

/// The most, in millimetres, that ours and VTK's points are apart.
fn apart(ours: impl Iterator<Item = DVec3>, theirs: &[DVec3Array]) -> f64 {
    ours.zip(theirs)
        .map(|(o, t)| o.distance(DVec3::from(*t)))
        .fold(0.0, f64::max)
}

/// Landmarks and points are within 100 mm, so a millionth is 1e-4 mm.
const MILLIONTH_MM: f64 = 1e-4;

#[test]
fn points_go_where_vtk_takes_them_and_come_from_where_it_says() {
    let mut oracle = Oracle(Process::start("tests/oracle/thin_plate.py"));
    let config = Config {
        cases: 24,
        failure_persistence: None,
        ..Config::default()
    };
    let few = landmarks(4..40, 8.0);
    let many = landmarks(200..400, 1.5);
    let cases = (
        prop_oneof![3 => few.boxed(), 1 => many.boxed()],
        prop::collection::vec(point(100.0), 100),
    );
    let check = |(landmarks, points): (Vec<Landmark>, Vec<DVec3>)| {
        let spline = thin_plate(&landmarks);
        let theirs = oracle.moved(&landmarks, &points);
        let forward = apart(points.iter().map(|p| spline.point(*p)), &theirs.forward);
        prop_assert!(forward < MILLIONTH_MM, "forward {forward} mm apart");
        // Where the map folds there are several; there each is held to its own definition.
        for (p, theirs) in points.iter().zip(&theirs.inverse) {
            let theirs = DVec3::from(*theirs);
            let folds = spline.point_and_jacobian(theirs).1.determinant() < 0.3;
            let ours = spline.inverse(*p);
            let same = ours.is_some_and(|ours| ours.distance(theirs) < MILLIONTH_MM);
            prop_assert!(same || folds, "{p} comes from {ours:?}, not {theirs}");
        }
        Ok(())
    };
    let check = std::cell::RefCell::new(check);
    let mut runner = TestRunner::new(config);
    let result = runner.run(&cases, |case| (check.borrow_mut())(case));
    assert!(result.is_ok(), "{result:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn landmarks_go_to_their_targets(landmarks in landmarks(3..60, 30.0), support in 30.0f64..300.0) {
        for support_mm in [None, Some(support)] {
            let spline = Spline::new(&landmarks, &Smoothness { stiffness: 0.0, support_mm }).expect("a spline");
            for l in &landmarks {
                prop_assert!(spline.point(l.from).distance(l.to) < 1e-8);
            }
        }
    }

    /// The stiffer, the farther from targets; each landmark misses by the stiffness times its weight, which is what this tells
    /// from the residuals: they are as the weights orthogonal to every affine function.
    #[test]
    fn what_stiffness_leaves_is_orthogonal_to_affine_maps(landmarks in landmarks(5..60, 10.0), stiffness in 0.1f64..100.0) {
        let fitted = |stiffness| Spline::new(&landmarks, &Smoothness { stiffness, support_mm: None }).expect("a spline");
        let spline = fitted(stiffness);
        let missed: Vec<DVec3> = landmarks.iter().map(|l| l.to - spline.point(l.from)).collect();
        let sum: DVec3 = missed.iter().sum();
        let moment = landmarks.iter().zip(&missed).map(|(l, m)| l.from.x * *m).sum::<DVec3>();
        prop_assert!(sum.length() < 1e-7 && moment.length() < 1e-5, "{sum} {moment}");
        prop_assert!(spline.residual_mm() > 0.0);
        prop_assert!(fitted(2.0 * stiffness).residual_mm() >= 0.99 * spline.residual_mm());
    }

    #[test]
    fn an_affine_movement_is_an_affine_map(
        landmarks in landmarks(4..30, 1.0), point in point(150.0), m in prop::array::uniform9(-0.3f64..0.3), by in point(50.0),
    ) {
        let map = DAffine3 { matrix3: DMat3::IDENTITY + DMat3::from_cols_array(&m), translation: by };
        let moved = |l: &Landmark| Landmark { to: map.transform_point3(l.from), ..l.clone() };
        let landmarks: Vec<_> = landmarks.iter().map(moved).collect();
        let spline = thin_plate(&landmarks);
        // Four random points may be nearly in a plane; what they leave open then is large beside the rounding.
        prop_assert!(spline.point(point).distance(map.transform_point3(point)) < 1e-6);
    }

    #[test]
    fn the_jacobian_is_the_difference_quotient(landmarks in landmarks(3..30, 10.0), x in point(100.0), support in 50.0f64..300.0) {
        const H: f64 = 1e-4;
        for support_mm in [None, Some(support)] {
            let spline = Spline::new(&landmarks, &Smoothness { stiffness: 0.0, support_mm }).expect("a spline");
            let near = landmarks.iter().any(|l| l.from.distance(x) < 1.0);
            let jacobian = spline.point_and_jacobian(x).1;
            for axis in DVec3::AXES {
                let quotient = (spline.point(x + H * axis) - spline.point(x - H * axis)) / (2.0 * H);
                prop_assert!(near || quotient.distance(jacobian * axis) < 1e-6);
            }
        }
    }

    #[test]
    fn beyond_its_support_nothing_moves(landmarks in landmarks(3..30, 10.0), x in point(100.0), support in 5.0f64..60.0) {
        let spline = Spline::new(&landmarks, &Smoothness { stiffness: 0.0, support_mm: Some(support) }).expect("a spline");
        let beyond = landmarks.iter().all(|l| l.from.distance(x) > support);
        prop_assert!(!beyond || spline.point(x) == x);
    }

    /// In a plane or on a line: across it nothing is turned, and space is not squeezed flat.
    #[test]
    fn landmarks_in_a_plane_leave_the_rest_of_space(landmarks in landmarks(4..20, 5.0), line in any::<bool>()) {
        let flat = |p: DVec3| DVec3::new(p.x, if line { 0.0 } else { p.y }, 0.0);
        let landmarks: Vec<_> = landmarks
            .iter()
            .map(|l| Landmark { from: flat(l.from), to: flat(l.from) + 0.2 * (l.to - l.from), ..l.clone() })
            .collect();
        let spline = thin_plate(&landmarks);
        prop_assert_eq!(spline.rank(), if line { 1 } else { 2 });
        let far = spline.point_and_jacobian(DVec3::new(0.0, 0.0, 1e5)).1;
        prop_assert!((far.z_axis - DVec3::Z).length() < 0.05, "{far}");
    }
}
