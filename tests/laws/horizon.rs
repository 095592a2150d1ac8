//! What lies behind a horizon does not show: the frame without it lacks no more than passes what hides it.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::image::Frame;
use vcsg::interface::HIDES_ALL_BUT;
use vcsg::math::Aabb;
use vcsg::model::{Boundary, Model, Node};
use vcsg::projection::{Camera, ControlPoint, FrameSpec, Horizon, Lens, Settings, TransferFunction, View, reference};
use vcsg::target::{Subdivision, Target, VoxelTarget};
use vcsg::voxelize::{Primitive, Solid};

use crate::order::cells_of;
use crate::support::scenes::{scene, subdivision};
use crate::support::views::{Eye, Look, eye, look};
use crate::support::{cases, seeded};

/// Edge of the cubes that a horizon is asked for, voxels.
const CUBE: usize = 8;

/// The lengths that opacities are of, millimetres: rays end at once, or little by little.
const UNITS_MM: [f64; 3] = [0.02, 0.3, 1.0];

/// A view of a target in which much is opaque, in pixels as small as voxels.
struct Seen<'a> {
    target: &'a Target,
    transfer: TransferFunction,
    camera: Camera,
}

impl<'a> Seen<'a> {
    fn new(target: &'a Target, eye: &Eye, look: &Look, unit_mm: f64) -> Self {
        let points = look.transfer(target.value_range).points().to_vec();
        Self {
            target,
            transfer: TransferFunction::new(points, unit_mm).expect("the same points"),
            camera: enlarged(eye.camera(&target.lattice.world_bounds())),
        }
    }

    fn spec<'b>(&'b self, settings: &'b Settings) -> FrameSpec<'b> {
        FrameSpec {
            target: self.target,
            transfer: &self.transfer,
            camera: &self.camera,
            settings,
        }
    }

    /// The cubes of the lattice that are hidden as `hides` says.
    fn hidden(&self, hides: impl Fn(&Horizon, &Aabb) -> bool) -> Vec<Aabb> {
        let settings = Settings::default();
        let horizon = Horizon::new(&self.spec(&settings), &cells_of(self.target));
        let [x, y, z] = self.target.lattice.dims.map(|n| n.div_ceil(CUBE));
        let cube = |n: usize| {
            let first = DVec3::new((n % x) as f64, (n / x % y) as f64, (n / (x * y)) as f64) * CUBE as f64 - 0.5;
            Aabb::new(first, first + CUBE as f64)
        };
        (0..x * y * z).map(cube).filter(|cube| hides(&horizon, cube)).collect()
    }

    /// Whether the frame without `hidden` is the whole one, as nearly as it must be: unlit, no colour is above its opacity, and
    /// frames are rounded to single precision.
    fn lacks_little_without(&self, hidden: &[Aabb]) -> Result<(), String> {
        let most = 1.0 / f64::from(HIDES_ALL_BUT) + 2f64.powi(-23);
        let settings = Settings::default();
        let (voxels, spec) = (VoxelTarget::new(self.target), self.spec(&settings));
        let whole = reference::render(&voxels, &spec);
        let shown = |p: DVec3| !hidden.iter().any(|cube| cube.contains(p));
        let part: Frame = reference::render_where(&voxels, &spec, &shown);
        let channels = whole.pixels().as_flattened().iter().zip(part.pixels().as_flattened());
        let lacking = |(n, (whole, part)): (usize, (&f32, &f32))| {
            let lacks = f64::from(*whole) - f64::from(*part);
            (lacks.abs() > most).then(|| format!("channel {n} is {part} instead of {whole}"))
        };
        channels.enumerate().find_map(lacking).map_or(Ok(()), Err)
    }
}

fn enlarged(camera: Camera) -> Camera {
    const TIMES: u32 = 3;
    let times = f64::from(TIMES);
    Camera {
        lens: match camera.lens {
            Lens::Orthographic { pixels_per_mm } => Lens::Orthographic {
                pixels_per_mm: times * pixels_per_mm,
            },
            Lens::Perspective { focal_px, near_mm } => Lens::Perspective {
                focal_px: times * focal_px,
                near_mm,
            },
        },
        size: camera.size.map(|n| TIMES * n),
        ..camera
    }
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn what_lies_behind_a_horizon_does_not_show(
        scene in scene(),
        subdivision in subdivision(Boundary::Exact),
        eye in eye(),
        look in look(),
        unit_mm in prop::sample::select(&UNITS_MM[..]),
    ) {
        let target = scene.target(&subdivision);
        let seen = Seen::new(&target, &eye, &look, unit_mm);
        let hidden = seen.hidden(Horizon::hides);
        prop_assert_eq!(seen.lacks_little_without(&hidden), Ok(()));
    }
}

/// Of some views those in which something is hidden as `hides` says, and those that lack it.
fn some_views(hides: impl Fn(&Horizon, &Aabb) -> bool + Copy) -> [usize; 2] {
    let views = (0..48).map(|seed| {
        let target = seeded(&scene(), seed).target(&seeded(&subdivision(Boundary::Exact), seed));
        let (eye, look) = (seeded(&eye(), seed), seeded(&look(), seed));
        let seen = Seen::new(&target, &eye, &look, UNITS_MM[seed as usize % UNITS_MM.len()]);
        let hidden = seen.hidden(hides);
        [!hidden.is_empty(), seen.lacks_little_without(&hidden).is_err()]
    });
    views.fold([0, 0], |[some, lack], [is_some, lacks]| {
        [some + usize::from(is_some), lack + usize::from(lacks)]
    })
}

#[test]
fn horizons_too_near_are_seen() {
    let [hiding, lacking] = some_views(Horizon::hides);
    println!("something is hidden in {hiding} of 48 views");
    assert!(hiding > 5 && lacking == 0, "{hiding} hide, {lacking} lack");
    // Cubes beside and before those that are hidden.
    let [_, lacking] = some_views(|horizon, cube| {
        let ends = [DVec3::ZERO, DVec3::ONE, DVec3::NEG_ONE].map(|way| CUBE as f64 * way);
        ends.iter()
            .any(|by| horizon.hides(&Aabb::new(cube.min + *by, cube.max + *by)))
    });
    assert!(lacking > 3, "{lacking} of 48");
}

/// In fog of one opacity a slab the horizon lies behind as many planes as let less than its part pass, and no farther than the first
/// whole cell and the planes that are taken together ask for.
#[test]
fn the_horizon_in_fog_is_where_too_little_passes() {
    const EDGE: f64 = 64.0;
    let mut model = Model::default();
    let fog = Aabb::new(DVec3::ZERO, DVec3::splat(EDGE));
    model.push(Node::Primitive(Primitive::crisp(Solid::Box(fog), 1.0)));
    let target = Target::build(&model, Some(1.0), &Subdivision::default()).expect("a target");
    for opacity in [0.2f32, 0.4, 0.7] {
        let point = ControlPoint {
            value: 1.0,
            color: [1.0; 3],
            opacity,
        };
        let seen = Seen {
            target: &target,
            transfer: TransferFunction::new(vec![point], 1.0).expect("a function"),
            camera: View::default().camera(&target.lattice.world_bounds(), [128; 2]),
        };
        let settings = Settings::default();
        let horizon = Horizon::new(&seen.spec(&settings), &cells_of(&target));
        // The default view looks along y; the fog begins a voxel behind the lattice's face.
        let behind = |planes: i32| {
            let least = DVec3::new(0.5 * EDGE, 0.5 + f64::from(planes), 0.5 * EDGE);
            Aabb::new(least, least + 2.0)
        };
        let found = (0..EDGE as i32).find(|planes| horizon.hides(&behind(*planes)));
        let needed = (f64::from(HIDES_ALL_BUT).ln() / -(1.0 - f64::from(opacity)).ln()).ceil() as i32;
        let found = found.expect("a horizon");
        // A cell and its neighbour's voxel at the face; two planes together, and what is cut of the first two; rounding.
        assert!(
            (needed..=needed + 9).contains(&found),
            "{found} planes, {needed} needed"
        );
    }
}
