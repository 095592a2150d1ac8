//! The hierarchy in rays: which level a ray takes follows from how wide its pixel is.

use glam::DVec3;
use vcsg::math::affine;
use vcsg::projection::trace::{Object, Optics, Ray, surface};
use vcsg::scene::{NoVolumes, Scene};
use vcsg::target::{Lattice, Target};

use crate::world::{even, rays, target};

/// A ball on a lattice of its own, filtered as a volume-sampled one is.
struct Ball {
    radius_mm: f64,
    spacing_mm: f64,
    target: Target,
}

/// Three levels that can be told apart.
fn balls() -> [Ball; 3] {
    [(20.0, 1.0), (22.0, 2.0), (24.0, 4.0)].map(|(radius_mm, spacing_mm)| {
        let text = format!("scene {{ sphere radius={radius_mm} }}");
        let scene = Scene::parse("t.kdl", &text, ".".as_ref(), &mut NoVolumes).expect("a scene");
        let target = Target::build(&scene.model, Some(spacing_mm), &Default::default()).expect("a target");
        Ball {
            radius_mm,
            spacing_mm,
            target,
        }
    })
}

fn object([fine, coarse, coarsest]: &[Ball; 3]) -> Object {
    Object::new(&fine.target, &even([1.0; 3], 1.0), Some(Optics::default()))
        .with_level(&coarse.target)
        .with_level(&coarsest.target)
}

impl Ball {
    /// The part of the filter, a cone of weight 3/π (1 − ρ) in units of its radius, that is in the ball if its middle is `from_middle`
    /// off. Of the sphere of radius ρ the part (1 − cos)/2 is in the ball, cos being that of the circle in which both meet; all or
    /// nothing is where they do not meet. Densities are its integral.
    fn density(&self, from_middle: f64) -> f64 {
        let filter = 2.0 * self.spacing_mm;
        let [d, radius] = [from_middle, self.radius_mm].map(|mm| mm / filter);
        let meets = (d - radius).abs().min(1.0);
        let whole = if d < radius {
            12.0 * (meets.powi(3) / 3.0 - meets.powi(4) / 4.0)
        } else {
            0.0
        };
        // 6 (1 − ρ) (ρ² − ρ (d² − radius²)/2d − ρ³/2d), integrated.
        let [a, b] = [(d * d - radius * radius) / (2.0 * d), 1.0 / (2.0 * d)];
        let up_to = |p: f64| {
            let square = p.powi(3) / 3.0 - p.powi(4) / 4.0;
            let line = p.powi(2) / 2.0 - p.powi(3) / 3.0;
            let cube = p.powi(4) / 4.0 - p.powi(5) / 5.0;
            6.0 * (square - a * line - b * cube)
        };
        whole + up_to(1.0) - up_to(meets)
    }

    /// The density at a place, trilinear between the voxels of the lattice.
    fn sampled(&self, world: DVec3) -> f64 {
        let lattice: &Lattice = &self.target.lattice;
        let at = affine::point(&lattice.world_from_lattice.inverse(), world);
        let (base, t) = (at.floor(), at - at.floor());
        let corner = |n: usize| {
            let by = DVec3::from_array([n & 1, n >> 1 & 1, n >> 2].map(|b| b as f64));
            let weight: f64 = (0..3).map(|a| if by[a] > 0.0 { t[a] } else { 1.0 - t[a] }).product();
            weight * self.density(affine::point(&lattice.world_from_lattice, base + by).length())
        };
        (0..8).map(corner).sum()
    }
}

/// Where a ray of this width meets the balls at their middle.
fn met(object: &Object, width_mm: f64, spread: f64) -> DVec3 {
    let middle = rays(1, 1.0).next().expect("a ray");
    let ray = Ray {
        width_mm,
        spread,
        ..middle
    };
    let met = surface::next(&mut object.probe(&ray), false, 0.0, f64::INFINITY).expect("a ball");
    ray.at(met.at_mm)
}

/// How near to density ½ a surface is looked for; what single precision makes of densities is a thousandth of it.
const NEAR: f64 = 1e-4 + 1e-7;

/// The surface is where the densities of the two levels, in their shares, are ½: no other tolerance.
#[test]
fn wide_rays_take_coarse_levels() {
    let balls = balls();
    let object = object(&balls);
    let between = (0..=20).map(|n| 2f64.powf(0.1 * f64::from(n)));
    for width_mm in [0.1, 50.0].into_iter().chain(between) {
        let octaves = width_mm.log2().clamp(0.0, 2.0);
        let fine = (octaves as usize).min(1);
        let part = octaves - fine as f64;
        let at = met(&object, width_mm, 0.0);
        let [fine, coarse] = [&balls[fine], &balls[fine + 1]].map(|ball| ball.sampled(at));
        let density = fine + part * (coarse - fine);
        assert!((density - 0.5).abs() < NEAR, "{density} at {at}, {width_mm} mm wide");
    }
}

/// Coarse balls are a little smaller: density is ½ at √(r² − 0.3 h²), h being the radius of the filter, if also those of its spheres were cut
/// by the ball's surface that are smaller than that is far away, p filters. Of them the integral has
/// 6 ∫ (1 − ρ) (ρ² − ρ (r² − d²)/2d + ρ³/2d) too little, in size at most p³ (1 + 3 p/d), lengths in filters.
#[test]
fn a_ball_is_smaller_by_what_its_filter_sees_of_the_outside() {
    for ball in balls() {
        let filter = 2.0 * ball.spacing_mm;
        let half = (ball.radius_mm.powi(2) - 0.3 * filter * filter).sqrt();
        let [p, d] = [(ball.radius_mm - half) / filter, half / filter];
        let off = (ball.density(half) - 0.5).abs();
        assert!(off < p.powi(3) * (1.0 + 3.0 * p / d), "{off}");
        assert!(ball.density(ball.radius_mm - filter) > 1.0 - 1e-12 && ball.density(ball.radius_mm + filter) < 1e-12);
    }
}

#[test]
fn distance_widens_rays_and_turns_widen_them_more() {
    let balls = balls();
    let middle = rays(1, 1.0).next().expect("a ray");
    let at = met(&object(&balls), 0.0, 2.0 / middle.origin.length());
    assert!((balls[1].sampled(at) - 0.5).abs() < NEAR);
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
    assert_eq!(met(&object, 0.1, 0.0), met(&object, 100.0, 0.0));
}
