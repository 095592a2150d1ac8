//! Surfaces, normals, mirrored and bent directions of a ball of radius 32, as the paper measures them, and of a cone.

use glam::DVec3;
use vcsg::projection::trace::{Object, Optics, Ray, reflect, refract, surface};

use crate::world::{across_z, rays, solid};

const RADIUS: f64 = 32.0;
const CENTER: DVec3 = DVec3::new(0.3, -0.2, 0.1);

/// Below this cosine a ray is near the silhouette: it runs for several voxels in the soft surface.
const SILHOUETTE: f64 = 0.25;

fn ball() -> Object {
    solid("sphere radius=32 center=\"0.3 -0.2 0.1\"", Optics::default())
}

/// Where a ray meets the ball, and the normal there.
fn truth(ray: &Ray) -> Option<(f64, DVec3)> {
    let way = CENTER - ray.origin;
    let along = way.dot(ray.direction);
    let half2 = RADIUS * RADIUS - (way.length_squared() - along * along);
    (half2 > 0.0).then(|| {
        let mm = along - half2.sqrt();
        (mm, (ray.at(mm) - CENTER) / RADIUS)
    })
}

fn first(object: &Object, ray: &Ray) -> Option<surface::Meeting> {
    surface::next(&mut object.probe(ray), false, 0.0, f64::INFINITY)
}

/// WK94: the surface within 0.2 voxel, the normal within 1.5 degrees. Off the ball's surface everywhere, silhouette or not.
#[test]
fn the_surface_and_normal_of_a_ball() {
    let ball = ball();
    let (mut off, mut along, mut turned) = (0.0f64, 0.0f64, 0.0f64);
    for ray in rays(200, 2.4 * RADIUS) {
        let Some((mm, normal)) = truth(&ray) else { continue };
        let found = first(&ball, &ray).expect("a ray that meets the ball");
        let distance = (ray.at(found.at_mm) - CENTER).length();
        off = off.max((distance - RADIUS).abs());
        if -normal.dot(ray.direction) > SILHOUETTE {
            along = along.max((found.at_mm - mm).abs());
            turned = turned.max(found.normal(&ball.probe(&ray), &ray).angle_between(normal).to_degrees());
            assert!(found.is_full());
        }
    }
    println!("off by {off:.3} voxel, along the ray {along:.3}, the normal by {turned:.2} degrees");
    assert!(off < 0.2 && along < 0.2 && turned < 1.5);
}

/// The same of a cone, but near its apex and rim, which the filter rounds: three voxels from the rim, five from the axis.
#[test]
fn the_surface_and_normal_of_a_cone() {
    let cone = solid("cone radius=32 from=\"0 0 -32\" to=\"0 0 32\"", Optics::default());
    let out = DVec3::new(2.0, 0.0, 1.0).normalize();
    let (mut off, mut turned) = (0.0f64, 0.0f64);
    let mut met = 0;
    for ray in rays(160, 70.0).map(|ray| across_z(&ray)) {
        let Some(found) = first(&cone, &ray).filter(|found| found.is_full()) else {
            continue;
        };
        let at = ray.at(found.at_mm);
        let radial = at.truncate();
        if at.z.abs() > 29.0 || radial.length() < 5.0 {
            continue;
        }
        let across = radial.normalize();
        let normal = DVec3::new(out.x * across.x, out.x * across.y, out.z);
        if -normal.dot(ray.direction) > SILHOUETTE {
            met += 1;
            off = off.max(((radial.length() - (32.0 - at.z) / 2.0) * out.x).abs());
            turned = turned.max(found.normal(&cone.probe(&ray), &ray).angle_between(normal).to_degrees());
        }
    }
    println!("{met} rays: off by {off:.3} voxel, the normal by {turned:.2} degrees");
    assert!(met > 1000 && off < 0.2 && turned < 1.5);
}

#[test]
fn mirrored_and_bent_directions() {
    let ball = ball();
    let mut worst = [0.0f64; 2];
    for ray in rays(200, 2.4 * RADIUS) {
        let Some((_, normal)) = truth(&ray).filter(|(_, normal)| -normal.dot(ray.direction) > SILHOUETTE) else {
            continue;
        };
        let found = first(&ball, &ray).expect("a ray that meets the ball");
        let mirrored = |n: DVec3| reflect(ray.direction, n);
        let bent = |n: DVec3| refract(ray.direction, n, 1.0, 1.5).expect("a way in");
        for (worst, turn) in worst.iter_mut().zip([&mirrored as &dyn Fn(DVec3) -> DVec3, &bent]) {
            *worst = worst.max(
                turn(found.normal(&ball.probe(&ray), &ray))
                    .angle_between(turn(normal))
                    .to_degrees(),
            );
        }
    }
    println!("mirrored within {:.2} degrees, bent within {:.2}", worst[0], worst[1]);
    assert!(worst.iter().all(|worst| *worst < 2.0));
}

/// How much of a ray a silhouette stops follows from how far off it is: half at the silhouette, nothing and all about half a voxel off.
#[test]
fn silhouettes_are_smooth_and_in_their_place() {
    let ball = ball();
    for ray in rays(600, 2.4 * RADIUS) {
        let way = CENTER - ray.origin;
        let off = RADIUS - (way.length_squared() - way.dot(ray.direction).powi(2)).sqrt();
        let opacity = first(&ball, &ray).map_or(0.0, |met| met.opacity);
        // A voxel inwards is an opacity more; the surface is within 0.05 voxel of its place.
        let ideal = (0.5 + off).clamp(0.0, 1.0);
        assert!((opacity - ideal).abs() < 0.15, "{off:.3} voxels inside: {opacity:.3}");
    }
}

/// From within: the far side of the ball, by the same normals.
#[test]
fn a_ray_from_within_meets_the_far_side() {
    let ball = ball();
    for ray in rays(40, 1.6 * RADIUS) {
        let Some((mm, normal)) = truth(&ray) else { continue };
        let bent = refract(ray.direction, normal, 1.0, 1.5).expect("a way in");
        let inner = ray.turned(mm, bent);
        let mut probe = ball.probe(&inner);
        let met = surface::next(&mut probe, true, 0.0, f64::INFINITY).expect("a far side");
        let chord = -2.0 * RADIUS * normal.dot(bent);
        assert!(
            met.is_full() && (met.at_mm - chord).abs() < 0.25,
            "{} for {chord}",
            met.at_mm
        );
        let there = (inner.at(chord) - CENTER) / RADIUS;
        assert!(met.normal(&probe, &inner).angle_between(there).to_degrees() < 1.5);
    }
}
