//! Random solids, each with a second statement of what is inside it, straight from its definition.

use glam::{DAffine3, DQuat, DVec2, DVec3, EulerRot};
use vcsg::math::{Aabb, Plane};
use vcsg::voxelize::{Polyhedron, Profile, Relief, RoundedBox, Solid, Thread, Waves};

/// A generator of numbers: splitmix64.
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in `lo..hi`.
    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point of a box.
    pub fn point(&mut self, bounds: &Aabb) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|a| self.within(bounds.min[a], bounds.max[a])))
    }

    /// A rotation and a shift.
    pub fn pose(&mut self) -> DAffine3 {
        let mut angle = || self.within(-3.1, 3.1);
        let turn = DQuat::from_euler(EulerRot::XYZ, angle(), angle(), angle());
        DAffine3::from_rotation_translation(turn, DVec3::from_array(std::array::from_fn(|_| self.within(-5.0, 5.0))))
    }
}

/// What is inside, in the solid's frame.
pub type Inside = Box<dyn Fn(DVec3) -> bool + Send + Sync>;

/// A solid and what is inside it.
pub struct Case {
    pub solid: Solid,
    pub inside: Inside,
}

/// A kind of primitive: its name, and one of random sizes, in millimetres; the filters that it meets have a radius of 2.
pub type Kind = (&'static str, fn(&mut Random) -> Case);

fn case(solid: Solid, inside: impl Fn(DVec3) -> bool + Send + Sync + 'static) -> Case {
    Case {
        solid,
        inside: Box::new(inside),
    }
}

fn sphere(r: &mut Random) -> Case {
    let radius = r.within(0.3, 20.0);
    let solid = Solid::Sphere {
        center: DVec3::X,
        radius,
    };
    case(solid, move |p| (p - DVec3::X).length() < radius)
}

fn cuboid(r: &mut Random) -> Case {
    let half = DVec3::new(r.within(0.3, 12.0), r.within(0.3, 12.0), r.within(0.3, 12.0));
    case(Solid::Box(Aabb::new(-half, half)), move |p| p.abs().cmplt(half).all())
}

fn half_space(r: &mut Random) -> Case {
    let plane = Plane::through(DVec3::splat(r.within(-2.0, 2.0)), DVec3::new(1.0, 2.0, -0.5)).expect("a plane");
    case(Solid::HalfSpace(plane), move |p| plane.normal.dot(p) < -plane.offset)
}

fn cylinder(r: &mut Random) -> Case {
    let (radius, height) = (r.within(0.5, 16.0), r.within(0.5, 30.0));
    let solid = Solid::revolved(Profile::cylinder(radius, height));
    case(solid, move |p| {
        p.truncate().length() < radius && p.z.abs() < 0.5 * height
    })
}

fn frustum(r: &mut Random) -> Case {
    let (bottom, height) = (r.within(1.0, 16.0), r.within(2.0, 30.0));
    let top = r.within(-6.0, 12.0).max(0.0);
    let solid = Solid::revolved(Profile::frustum(bottom, top, height));
    case(solid, move |p| {
        let t = p.z / height + 0.5;
        (0.0..1.0).contains(&t) && p.truncate().length() < bottom + t * (top - bottom)
    })
}

fn torus(r: &mut Random) -> Case {
    let ring = r.within(2.0, 16.0);
    let tube = ring * r.within(0.1, 0.95);
    case(Solid::revolved(Profile::torus(ring, tube)), move |p| {
        DVec2::new(p.truncate().length() - ring, p.z).length() < tube
    })
}

fn capsule(r: &mut Random) -> Case {
    let (radius, length) = (r.within(0.5, 12.0), r.within(0.5, 20.0));
    case(Solid::revolved(Profile::capsule(radius, length)), move |p| {
        let on_axis = DVec3::Z * p.z.clamp(-0.5 * length, 0.5 * length);
        p.distance(on_axis) < radius
    })
}

fn prism(r: &mut Random) -> Case {
    let sides = 3 + r.within(0.0, 6.0) as usize;
    let (radius, height) = (r.within(1.0, 14.0), r.within(0.5, 20.0));
    let apothem = radius * (std::f64::consts::PI / sides as f64).cos();
    case(Solid::Polyhedron(Polyhedron::prism(sides, radius, height)), move |p| {
        let behind = |n: usize| {
            let normal = DVec2::from_angle((n as f64 + 0.5) * std::f64::consts::TAU / sides as f64);
            normal.dot(p.truncate()) < apothem
        };
        p.z.abs() < 0.5 * height && (0..sides).all(behind)
    })
}

fn tetrahedron(r: &mut Random) -> Case {
    let bounds = Aabb::new(DVec3::splat(-10.0), DVec3::splat(10.0));
    let corners: [DVec3; 4] = std::array::from_fn(|_| r.point(&bounds));
    let Some(hull) = Polyhedron::hull(&corners) else {
        return tetrahedron(r);
    };
    let [a, b, c, d] = corners;
    let weights = glam::DMat3::from_cols(b - a, c - a, d - a).inverse();
    case(Solid::Polyhedron(hull), move |p| {
        let w = weights * (p - a);
        w.min_element() > 0.0 && w.element_sum() < 1.0
    })
}

fn rounded_box(r: &mut Random) -> Case {
    let half = DVec3::new(r.within(1.0, 10.0), r.within(1.0, 10.0), r.within(1.0, 10.0));
    let radius = half.min_element() * r.within(0.1, 1.0);
    case(
        Solid::Relief(Relief::RoundedBox(RoundedBox { half, radius })),
        move |p| {
            let core = (half - radius).max(DVec3::ZERO);
            p.distance(p.clamp(-core, core)) < radius
        },
    )
}

fn waves(r: &mut Random) -> Case {
    let waves = Waves {
        size: DVec2::new(r.within(10.0, 30.0), r.within(10.0, 30.0)),
        depth: r.within(4.0, 8.0),
        amplitude: r.within(0.0, 3.0),
        wavelength: DVec2::new(r.within(10.0, 30.0), r.within(10.0, 30.0)),
    };
    case(Solid::Relief(Relief::Waves(waves)), move |p| {
        let k = std::f64::consts::TAU / waves.wavelength;
        let top = waves.amplitude * (k.x * p.x).cos() * (k.y * p.y).cos();
        2.0 * p.x.abs() < waves.size.x && 2.0 * p.y.abs() < waves.size.y && -waves.depth < p.z && p.z < top
    })
}

fn helix(r: &mut Random) -> Case {
    let (ring, pitch) = (r.within(4.0, 12.0), r.within(2.0, 12.0));
    let (tube, turns) = (ring * r.within(0.1, 0.4), r.within(0.3, 3.0));
    let profile = Profile::torus(ring, tube);
    screwed(profile, pitch, turns, move |rho, z| {
        DVec2::new(rho - ring, z).length() < tube
    })
}

fn thread(r: &mut Random) -> Case {
    let (root, depth, pitch) = (r.within(4.0, 12.0), r.within(1.0, 3.0), r.within(2.0, 8.0));
    let (foot, crest, turns) = (0.45 * pitch, 0.1 * pitch, r.within(0.3, 4.0));
    let corners = [
        (0.5 * root, -foot),
        (root, -foot),
        (root + depth, -crest),
        (root + depth, crest),
        (root, foot),
        (0.5 * root, foot),
    ];
    let profile = Profile::polygon(&corners.map(DVec2::from));
    screwed(profile, pitch, turns, move |rho, z| {
        let t = ((rho - root) / depth).max(0.0);
        rho > 0.5 * root && t < 1.0 && z.abs() < foot + t * (crest - foot)
    })
}

fn screwed(
    profile: Profile,
    pitch: f64,
    turns: f64,
    outline: impl Fn(f64, f64) -> bool + Send + Sync + 'static,
) -> Case {
    case(Solid::Thread(Thread::new(profile, pitch, turns).into()), move |p| {
        let flat = p.truncate();
        let start = flat.to_angle().rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
        (0..12)
            .map(|turn| start + f64::from(turn))
            .any(|turned| turned <= turns && outline(flat.length(), p.z - pitch * turned))
    })
}

/// Every kind of primitive.
pub const KINDS: [Kind; 13] = [
    ("sphere", sphere),
    ("box", cuboid),
    ("half-space", half_space),
    ("cylinder", cylinder),
    ("cone", frustum),
    ("torus", torus),
    ("capsule", capsule),
    ("prism", prism),
    ("polyhedron", tetrahedron),
    ("rounded box", rounded_box),
    ("waves", waves),
    ("helix", helix),
    ("thread", thread),
];
