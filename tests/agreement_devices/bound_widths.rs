//! Bounds that hold everything prove nothing: in a smooth scene they are as narrow as first principles say.
//!
//! A ramp of fractions 0 to 1 across the frame, its opacity A rising linearly with it, seen straight on, without a face in
//! view. Each sample is known up to Δf = 2 (e + G d): G is the ramp's rise a voxel, d what a device's position may be off in
//! voxels, e what it may read wrong; so its opacity is known up to ΔA = A' Δf, and its colour, which is at most 1, up to as
//! much. One of n samples of opacity A moves the pixel by no more than (1 − A)^k (ΔA + ΔA) for the k samples before it, and
//! all of them by at most 2 ΔA / A.

use std::sync::Arc;

use glam::DAffine3;
use vcsg::interface::HIDES_ALL_BUT;
use vcsg::math::Interval;
use vcsg::model::{Model, Node, VolumeLeaf};
use vcsg::projection::{ControlPoint, Lens, Mode, Settings, TransferFunction, View};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::{Bricks, Grid, Voxels};

use crate::device::on_device;
use crate::scene::{FRAME_PX, Scene};

const VOXELS: usize = 32;
const OPACITY: [f32; 2] = [0.2, 0.6];

fn ramp() -> Scene {
    let values = (0..VOXELS.pow(3)).map(|n| (n % VOXELS) as f32).collect();
    let grid = Grid::new([VOXELS; 3], DAffine3::IDENTITY, Voxels::F32(values)).expect("a grid");
    let mut model = Model::default();
    model.push(Node::Volume(VolumeLeaf {
        bricks: Arc::new(Bricks::new(&grid)),
        window: Interval::ALL,
    }));
    let target = Target::build(&model, None, &Subdivision::default()).expect("a target");
    let point = |value, opacity| ControlPoint {
        value,
        color: [1.0, 0.8, 0.6],
        opacity,
    };
    let points = vec![point(0.0, OPACITY[0]), point((VOXELS - 1) as f32, OPACITY[1])];
    let view = View {
        zoom: 3.0,
        ..View::default()
    };
    Scene {
        transfer: TransferFunction::new(points, 1.0).expect("rising values"),
        camera: view.camera(&target.lattice.world_bounds(), FRAME_PX),
        settings: Settings {
            mode: Mode::Composite,
            shading: None,
            ..Settings::default()
        },
        target,
    }
}

pub fn a_smooth_scene_has_narrow_bounds() {
    on_device(|bench| {
        let scene = ramp();
        let spec = scene.spec();
        let prepared = bench.prepare(&spec);
        let bounds = bench.bounds(&spec, &prepared);
        let frame = bench.draw(&spec, &prepared);
        bench.require_within("a ramp", &frame, &bounds);
        let Lens::Orthographic { pixels_per_mm } = scene.camera.lens else {
            unreachable!("the default view is parallel")
        };
        let p = &bench.precision;
        // A page is the block and its apron; a voxel is a millimetre.
        let edge = (VOXELS + 2) as f64;
        let position = p.weight + edge * (p.interpolated + p.coordinate) + p.vertex_px / pixels_per_mm;
        let read = (0.5 + p.sum_steps) / 65535.0 + p.sum;
        let rise = 1.0 / (VOXELS - 1) as f64;
        let entry = (p.weight + 4096.0 * p.coordinate) / 4095.0;
        let fraction = 2.0 * (read + rise * position + entry);
        let [least, most] = OPACITY.map(f64::from);
        // What is hidden may be left out.
        let hidden = 1.0 / f64::from(HIDES_ALL_BUT);
        let derived = 2.0 * (most - least) * fraction / least + hidden;
        let mean = bounds.mean_width();
        println!("mean width {mean:.2e}, derived {derived:.2e}");
        assert!(mean <= derived, "{mean} is above {derived}");
    });
}
