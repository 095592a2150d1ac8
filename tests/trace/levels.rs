//! The hierarchy in rays: which level a ray takes follows from how wide its pixel is.

use vcsg::projection::trace::{Object, Optics, Ray, surface};

use crate::world::{even, rays, target};

/// Three levels that can be told apart: balls of 20, 22 and 24 voxels radius, of 1, 2 and 4 mm voxels.
fn telltale() -> Object {
    let [fine, coarse, coarsest] = [(20, 1), (22, 2), (24, 4)].map(|(radius, spacing)| {
        let text = format!("scene {{ sphere radius={radius} }}");
        let scene =
            vcsg::scene::Scene::parse("t.kdl", &text, ".".as_ref(), &mut vcsg::scene::NoVolumes).expect("a scene");
        vcsg::target::Target::build(&scene.model, Some(f64::from(spacing)), &Default::default()).expect("a target")
    });
    Object::new(&fine, &even([1.0; 3], 1.0), Some(Optics::default()))
        .with_level(&coarse)
        .with_level(&coarsest)
}

/// The radius of the ball that a ray of this width meets at its middle.
fn radius(object: &Object, width_mm: f64, spread: f64) -> f64 {
    let middle = rays(1, 1.0).next().expect("a ray");
    let ray = Ray {
        width_mm,
        spread,
        ..middle
    };
    let met = surface::next(&mut object.probe(&ray), &ray, false, 0.0, f64::INFINITY).expect("a ball");
    ray.at(met.at_mm).length()
}

#[test]
fn wide_rays_take_coarse_levels() {
    let object = telltale();
    // A filter of 2 voxels sees more of what is outside of a ball of few voxels: its surface is a part of a voxel further in.
    for (width_mm, expected, near) in [
        (0.1, 20.0, 0.1),
        (1.0, 20.0, 0.1),
        (2.0, 22.0, 0.2),
        (4.0, 24.0, 0.6),
        (50.0, 24.0, 0.6),
    ] {
        let found = radius(&object, width_mm, 0.0);
        assert!((found - expected).abs() < near, "{found} at {width_mm} mm");
    }
    // Between two levels densities are blended, and so are the balls.
    let between: Vec<f64> = (0..=20)
        .map(|n| radius(&object, 2f64.powf(0.1 * f64::from(n)), 0.0))
        .collect();
    assert!(
        between
            .windows(2)
            .all(|pair| (-0.02..0.6).contains(&(pair[1] - pair[0]))),
        "{between:?}"
    );
}

#[test]
fn distance_widens_rays_and_turns_widen_them_more() {
    let object = telltale();
    let middle = rays(1, 1.0).next().expect("a ray");
    let way_mm = middle.origin.length();
    assert!((radius(&object, 0.0, 2.0 / way_mm) - 22.0).abs() < 0.2);
    let turned = Ray {
        width_mm: 0.5,
        spread: 0.01,
        ..middle
    }
    .turned(50.0, middle.direction);
    assert_eq!((turned.width_mm, turned.spread), (2.0, 0.02));
}

/// One level is what it is, however wide the ray.
#[test]
fn an_object_of_one_level_is_never_coarser() {
    let object = Object::new(
        &target("sphere radius=20"),
        &even([1.0; 3], 1.0),
        Some(Optics::default()),
    );
    assert_eq!(radius(&object, 0.1, 0.0), radius(&object, 100.0, 0.0));
}
