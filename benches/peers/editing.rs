//! Edits against building anew: a scene of 20 nodes at 256³, in which a small primitive is moved, and its transfer function changed.

use std::sync::Arc;

use glam::{DAffine3, DVec3, dvec3};
use serde::Serialize;
use vcsg::gpu::Device;
use vcsg::math::{Aabb, Interval, Plane};
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline};
use vcsg::model::{BooleanOp, Family, Model, Node, NodeId, ValueRule, VolumeLeaf};
use vcsg::projection::{ControlPoint, FrameSpec, TransferFunction};
use vcsg::render::{PagedTarget, SliceRenderer, soft_normals};
use vcsg::target::{Lattice, Subdivision, Target, VoxelTarget};
use vcsg::volume::{Bricks, Grid, Voxels};
use vcsg::voxelize::{Primitive, Profile, Solid};

use crate::bar::{Bar, Limit};
use crate::runs::{Run, Summary, timed};
use crate::scene::{self, Look, SIDE};
use crate::{Outcome, memory};

/// The most that moving a small primitive may cost, in full builds.
const MOVE_BAR: f64 = 0.1;

/// The same for a plane that cuts all.
const CUT_BAR: f64 = 1.0;

/// The same where a face of the lattice moves, which blocks of 32³ meet, an eighth of all voxels.
const OUT_BAR: f64 = 0.5;

/// The same where a landmark moves, and a deformation is tabulated anew.
const LANDMARK_BAR: f64 = 0.5;

/// Where the plane is, millimetres from the middle along each axis.
const CUT_AT: f64 = 40.0;

/// How far the ball is moved, millimetres.
const LITTLE: [f64; 3] = [2.0, 1.0, 0.5];
const FAR: [f64; 3] = [37.0, -53.0, 41.0];

/// And beyond the volume.
const OUT: [f64; 3] = [7.0, -3.0, 170.0];

/// The most that a new transfer function may cost before its frame is drawn, in frames.
const TRANSFER_BAR: f64 = 1.0;

/// The most that a subtree used twice may cost, in two subtrees that differ.
const SHARED_BAR: f64 = 0.8;

/// The most that building a scene of little may take at its peak, in grids of all voxels' values and coverages.
const MEMORY_BAR: f64 = 1.0;

/// An edit next to what it saves.
#[derive(Serialize)]
pub struct Comparison {
    what: &'static str,
    edit: Summary,
    anew: Summary,
    /// The ratio of their medians.
    pub bar: Bar,
}

/// Compares all edits; each comparison is printed when it is done.
pub fn compare(device: &Arc<Device>, repetitions: usize) -> Outcome<Vec<Comparison>> {
    println!("\nEdits of 20 nodes at 256³; milliseconds (medians)");
    println!("{:<44} {:>9} {:>9} {:>8}  bar", "", "edit", "anew", "ratio");
    let bricks = waves()?;
    Ok(vec![
        in_memory(
            "moved a little, voxels in memory",
            &moves(&bricks, repetitions, LITTLE)?,
            MOVE_BAR,
        )?,
        in_memory(
            "moved far, voxels in memory",
            &moves(&bricks, repetitions, FAR)?,
            MOVE_BAR,
        )?,
        in_memory(
            "moved out and back, voxels in memory",
            &moves(&bricks, repetitions, OUT)?,
            OUT_BAR,
        )?,
        in_memory(
            "a landmark moved, voxels in memory",
            &landmarks(&bricks, repetitions)?,
            LANDMARK_BAR,
        )?,
        in_memory("cut moved, voxels in memory", &cuts(&bricks, repetitions)?, CUT_BAR)?,
        on_device(
            device,
            &bricks,
            repetitions,
            "moved a little, blocks on the device",
            false,
        )?,
        on_device(
            device,
            &bricks,
            repetitions,
            "moved a little, lit blocks on the device",
            true,
        )?,
        transfer(device, &bricks, repetitions)?,
        shared(repetitions)?,
        little_memory()?,
    ])
}

/// A volume that is everywhere, with values from 20 to 220.
fn waves() -> Outcome<Arc<Bricks>> {
    let voxel = |n: usize| {
        let at = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)].map(|i| i as f32 * 0.07);
        (120.0 + 33.0 * (at[0].sin() + at[1].cos() + (at[2] + at[0]).sin())) as u8
    };
    let voxels = Voxels::U8((0..SIDE.pow(3)).map(voxel).collect());
    Ok(Arc::new(Bricks::new(&Grid::new(
        [SIDE; 3],
        DAffine3::IDENTITY,
        voxels,
    )?)))
}

/// The volume, cut `at` a distance from its middle; four parts taken from it, four more united with it, and a small ball: 20 nodes.
fn twenty_nodes(bricks: &Arc<Bricks>, at: f64, ball: impl FnOnce(&mut Model) -> Outcome<NodeId>) -> Outcome<Model> {
    let mut model = Model::default();
    let window = Interval::ALL;
    let child = model.push(Node::Volume(VolumeLeaf {
        bricks: Arc::clone(bricks),
        window,
    }));
    let plane = Plane::through(scene::middle() + at, dvec3(1.0, 1.0, 1.0)).ok_or("a plane needs a direction")?;
    let cut = model.push(Node::Cut { child, plane });
    let part = |model: &mut Model, n: usize| {
        let center = dvec3(
            40.0 + 50.0 * (n % 4) as f64,
            60.0 + 30.0 * (n % 3) as f64,
            50.0 + 20.0 * n as f64,
        );
        let solid = match n % 2 {
            0 => Solid::Sphere { center, radius: 14.0 },
            _ => Solid::Box(Aabb::new(center - 12.0, center + 12.0)),
        };
        model.push(Node::Primitive(Primitive::soft(solid, 50.0 + 10.0 * n as f32)))
    };
    let taken: Vec<NodeId> = (0..4).map(|n| part(&mut model, n)).collect();
    let (first, minmax) = (ValueRule::First, Family::MinMax);
    let carved = model.fold(BooleanOp::Subtraction, first, minmax, [&[cut][..], &taken].concat());
    let mut united: Vec<NodeId> = carved.into_iter().chain((4..7).map(|n| part(&mut model, n))).collect();
    let cylinder = Solid::revolved(Profile::cylinder(8.0, 40.0));
    let child = model.push(Node::Primitive(Primitive::soft(cylinder, 90.0)));
    let parent_from_child = DAffine3::from_translation(dvec3(180.0, 60.0, 80.0));
    united.push(model.push(Node::Transform {
        child,
        parent_from_child,
    }));
    united.push(ball(&mut model)?);
    model.fold(BooleanOp::Union, ValueRule::Second, minmax, united);
    Ok(model)
}

fn ball(center: DVec3, radius: f64) -> impl FnOnce(&mut Model) -> Outcome<NodeId> {
    let solid = Solid::Sphere { center, radius };
    move |model| Ok(model.push(Node::Primitive(Primitive::soft(solid, 200.0))))
}

/// A ball that landmarks at the corners of its box deform; one of them goes `by` millimetres.
fn deformed_ball(by: f64) -> impl FnOnce(&mut Model) -> Outcome<NodeId> {
    let bounds = Aabb::new(dvec3(70.0, 130.0, 80.0), dvec3(110.0, 170.0, 120.0));
    move |model| {
        let child = ball(bounds.center(), 15.0)(model)?;
        let landmark = |(n, from): (usize, DVec3)| Landmark {
            name: n.to_string(),
            from,
            to: from + if n == 0 { by } else { 0.0 },
        };
        let landmarks: Vec<Landmark> = bounds.corners().into_iter().enumerate().map(landmark).collect();
        let spline = Spline::new(&landmarks, &Smoothness::default())?;
        Ok(model.push(Node::Deform {
            child,
            morph: Arc::new(Morph::new(spline, bounds).map_err(|_| "the ball folds")?),
            error_voxels: 0.1,
        }))
    }
}

/// The models before and after each of some moves of a landmark.
fn landmarks(bricks: &Arc<Bricks>, count: usize) -> Outcome<Vec<Model>> {
    let model = |n: usize| twenty_nodes(bricks, CUT_AT, deformed_ball(3.0 + 0.2 * n as f64));
    (0..=count).map(model).collect()
}

/// The models before and after each of some moves: forth and back, so that all are alike.
fn moves(bricks: &Arc<Bricks>, count: usize, by: [f64; 3]) -> Outcome<Vec<Model>> {
    let start = dvec3(90.0, 150.0, 100.0);
    let place = |n: usize| start + DVec3::from(by) * (n % 2) as f64 + DVec3::splat(n as f64);
    (0..=count)
        .map(|n| twenty_nodes(bricks, CUT_AT, ball(place(n), 5.0)))
        .collect()
}

/// The models before and after each of some moves of the plane.
fn cuts(bricks: &Arc<Bricks>, count: usize) -> Outcome<Vec<Model>> {
    let at = |n: usize| CUT_AT - n as f64;
    (0..=count)
        .map(|n| twenty_nodes(bricks, at(n), ball(scene::middle(), 5.0)))
        .collect()
}

/// The volume's, and what of its grid a model needs beyond it.
fn lattice(model: &Model) -> Outcome<Lattice> {
    Ok(Lattice::of_model(model, None)?)
}

fn built(model: &Model) -> Outcome<Target> {
    Ok(Target::on_lattice(model, lattice(model)?, &Subdivision::default())?)
}

/// The target of a model that has no volume, where one would be.
fn built_alone(model: &Model) -> Outcome<Target> {
    let lattice = Lattice::new([SIDE; 3], DAffine3::IDENTITY);
    Ok(Target::on_lattice(model, lattice, &Subdivision::default())?)
}

fn in_memory(what: &'static str, models: &[Model], limit: f64) -> Outcome<Comparison> {
    let mut target = built(&models[0])?;
    let mut voxels = VoxelTarget::new(&target).voxels;
    let (mut edits, mut anew) = (Vec::new(), Vec::new());
    for model in &models[1..] {
        let (fresh, run) = timed(|| -> Outcome<_> {
            let target = built(model)?;
            let voxels = VoxelTarget::new(&target).voxels;
            Ok((target, voxels))
        });
        let (fresh_target, fresh_voxels) = fresh?;
        anew.push(run);
        let (update, run) = timed(|| -> Outcome<_> {
            let update = target.updated(model, lattice(model)?, &target.subdivision)?;
            let voxels = update.voxels(&target, &voxels);
            Ok((update.target, voxels))
        });
        edits.push(run);
        (target, voxels) = update?;
        if target.octree != fresh_target.octree || voxels != fresh_voxels {
            return Err("an edited target is not the one built anew".into());
        }
    }
    Ok(Comparison::of(what, edits, anew, limit))
}

fn look(lit: bool, opacity: f32) -> Outcome<Look> {
    let point = |value, opacity| ControlPoint {
        value,
        color: [0.9, 0.7, 0.5],
        opacity,
    };
    let points = vec![point(60.0, 0.0), point(120.0, 0.0), point(200.0, opacity)];
    Ok(Look {
        transfer: TransferFunction::new(points, 1.0)?,
        camera: scene::camera(&scene::bounds()),
        settings: scene::settings(lit),
    })
}

fn spec<'a>(target: &'a Target, look: &'a Look) -> FrameSpec<'a> {
    FrameSpec {
        target,
        transfer: &look.transfer,
        camera: &look.camera,
        settings: &look.settings,
    }
}

fn on_device(
    device: &Arc<Device>,
    bricks: &Arc<Bricks>,
    repetitions: usize,
    what: &'static str,
    lit: bool,
) -> Outcome<Comparison> {
    let models = moves(bricks, repetitions, LITTLE)?;
    let look = look(lit, 0.1)?;
    let paged = |target: &Target| {
        let normals = soft_normals(&spec(target, &look));
        PagedTarget::new(device, target, normals.as_ref(), &mut |_| {})
    };
    let mut target = built(&models[0])?;
    let mut pages = paged(&target)?;
    let (mut edits, mut anew) = (Vec::new(), Vec::new());
    for model in &models[1..] {
        let (fresh, run) = timed(|| -> Outcome<_> { Ok(paged(&built(model)?)?) });
        drop(fresh?);
        anew.push(run);
        let (update, run) = timed(|| -> Outcome<_> {
            let update = target.updated(model, lattice(model)?, &target.subdivision)?;
            let normals = soft_normals(&spec(&update.target, &look));
            let pages = pages.updated(device, &target, &update, normals.as_ref(), &mut |_| {})?;
            Ok((update.target, pages))
        });
        edits.push(run);
        (target, pages) = update?;
    }
    Ok(Comparison::of(what, edits, anew, MOVE_BAR))
}

/// What a new transfer function costs before its frame is drawn: a plan of what shows and a table. The target stays.
fn transfer(device: &Arc<Device>, bricks: &Arc<Bricks>, repetitions: usize) -> Outcome<Comparison> {
    let target = built(&twenty_nodes(bricks, CUT_AT, ball(scene::middle(), 5.0))?)?;
    let normals = soft_normals(&spec(&target, &look(true, 0.1)?));
    let paged = PagedTarget::new(device, &target, normals.as_ref(), &mut |_| {})?;
    let mut renderer = SliceRenderer::new(device)?;
    let (mut edits, mut frames) = (Vec::new(), Vec::new());
    for n in 0..=repetitions {
        let look = look(true, 0.05 + 0.01 * n as f32)?;
        let (drawn, run) = timed(|| renderer.draw(&spec(&target, &look), &paged, &[]));
        let (_, timings) = drawn?;
        // The first frame makes the pipelines.
        if n > 0 {
            let wall_s = (timings.plan + timings.prepare).as_secs_f64();
            edits.push(Run { wall_s, cpu_s: wall_s });
            frames.push(run);
        }
    }
    let what = "transfer function, until it is drawn; a frame";
    Ok(Comparison::of(what, edits, frames, TRANSFER_BAR))
}

/// A dozen tubes, and half of them painted over by the same dozen, or by one of other values.
fn painted_over(other: f32) -> Outcome<Model> {
    let mut model = Model::default();
    let mut tubes = |value: f32| {
        let tube = |n: usize| {
            let profile = Profile::torus(30.0 + 7.0 * n as f64, 6.0);
            let child = model.push(Node::Primitive(Primitive::soft(
                Solid::revolved(profile),
                value + n as f32,
            )));
            let parent_from_child =
                DAffine3::from_translation(scene::middle()) * DAffine3::from_rotation_x(0.5 * n as f64);
            model.push(Node::Transform {
                child,
                parent_from_child,
            })
        };
        let all: Vec<NodeId> = (0..12).map(tube).collect();
        model.fold(BooleanOp::Union, ValueRule::Max, Family::MinMax, all)
    };
    let first = tubes(50.0).ok_or("no tubes")?;
    let child = match other {
        0.0 => first,
        _ => tubes(50.0 + other).ok_or("no tubes")?,
    };
    let plane = Plane::through(scene::middle(), DVec3::X).ok_or("a plane needs a direction")?;
    let half = model.push(Node::Cut { child, plane });
    let (op, rule) = (BooleanOp::SubtractionWithRule, ValueRule::Sum);
    model.fold(op, rule, Family::MinMax, [first, half]);
    Ok(model)
}

/// A subtree that is used twice, and two that differ in their values.
fn shared(repetitions: usize) -> Outcome<Comparison> {
    let (once, twice) = (painted_over(0.0)?, painted_over(0.5)?);
    let voxels = |model: &Model| timed(|| built_alone(model).map(|target| VoxelTarget::new(&target).voxels));
    let (mut shared, mut apart) = (Vec::new(), Vec::new());
    for _ in 0..repetitions {
        for (model, runs) in [(&once, &mut shared), (&twice, &mut apart)] {
            let (made, run) = voxels(model);
            made?;
            runs.push(run);
        }
    }
    Ok(Comparison::of(
        "a subtree used twice; two that differ",
        shared,
        apart,
        SHARED_BAR,
    ))
}

/// What a scene of small things far apart takes at its peak, and what a grid of all voxels would, in MiB for milliseconds.
fn little_memory() -> Outcome<Comparison> {
    let grown: u64 = memory::from_own_process(["--memory-of-balls", "--bench"])?;
    let grid = SIDE.pow(3) * size_of::<[f32; 2]>();
    let mebibytes = |bytes: f64| Run {
        wall_s: bytes / f64::from(1 << 20) / 1e3,
        cpu_s: 0.0,
    };
    let (peak, full) = (mebibytes(grown as f64), mebibytes(grid as f64));
    let what = "balls far apart: peak, and a full grid, MiB";
    Ok(Comparison::of(what, vec![peak], vec![full], MEMORY_BAR))
}

/// Builds twenty balls far apart, moves one, and prints by how many bytes the resident memory grew at most.
pub fn print_growth() -> Outcome<()> {
    let model = |by: f64| {
        let mut model = Model::default();
        let ball = |n: usize| {
            let center = dvec3(
                20.0 + 24.0 * (n % 10) as f64,
                30.0 + 180.0 * (n / 10) as f64,
                40.0 + 9.0 * n as f64,
            );
            let center = if n == 7 { center + by } else { center };
            Primitive::soft(Solid::Sphere { center, radius: 6.0 }, 100.0)
        };
        let balls: Vec<NodeId> = (0..20).map(|n| model.push(Node::Primitive(ball(n)))).collect();
        model.fold(BooleanOp::Union, ValueRule::First, Family::MinMax, balls);
        model
    };
    let (edited, grown) = memory::growth(|| -> Outcome<_> {
        let target = built_alone(&model(0.0))?;
        let voxels = VoxelTarget::new(&target).voxels;
        let update = target.updated(&model(3.0), target.lattice, &target.subdivision)?;
        Ok(update.voxels(&target, &voxels))
    })?;
    edited?;
    println!("{grown}");
    Ok(())
}

impl Comparison {
    fn of(what: &'static str, edit: Vec<Run>, anew: Vec<Run>, limit: f64) -> Self {
        let (edit, anew) = (Summary::of(edit), Summary::of(anew));
        let bar = Bar {
            what: what.into(),
            value: edit.median_s / anew.median_s,
            limit: Limit::AtMost(limit),
        };
        let [edited, full] = [&edit, &anew].map(|summary| summary.median_s * 1e3);
        println!("{what:<44} {edited:>9.2} {full:>9.2} {:>8.3}  {bar}", bar.value);
        Self { what, edit, anew, bar }
    }
}
