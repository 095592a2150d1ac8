//! The widest vectors that the processor has, or arrays: the same bits.

use std::sync::Arc;

use glam::DAffine3;
use vcsg::math::Interval;
use vcsg::model::{Boundary, Model, Node, VolumeLeaf};
use vcsg::projection::raycast::{PortableRayCaster, RayCaster};
use vcsg::projection::{ControlPoint, FrameSpec, Projector, Settings, Shading, TransferFunction, View};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::{Bricks, Grid, Voxels};

use super::picture::{nearer, picture, same};
use crate::random::Random;
use crate::support::scenes::{scene, subdivision};
use crate::support::seeded;

/// The same frame, cast in both ways.
fn both(spec: &FrameSpec) -> Result<(), String> {
    let widest = RayCaster.project(spec).expect("a frame");
    same(&widest, &PortableRayCaster.project(spec).expect("a frame"))
}

/// From afar, as every picture is, and from so near that the voxels of a packet are few: those come from registers.
#[test]
fn any_vectors_give_the_same_bits() {
    for seed in 0..160 {
        let target = seeded(&scene(), seed).target(&seeded(&subdivision(Boundary::Exact), seed));
        seeded(&picture(), seed).of(&target, |spec| {
            for times in [1.0, 3.0, 12.0] {
                let camera = &nearer(spec, times);
                let nearer = FrameSpec { camera, ..*spec };
                assert_eq!(both(&nearer), Ok(()), "seed {seed}, {times} times as near");
            }
        });
    }
}

/// A volume all of which is covered: dots up to 255 among what is less than 60.
fn dotted(random: &mut Random) -> Target {
    let dims = [30, 24, 27];
    let voxel = |_| match random.below(40) {
        0 => random.between(60.0, 256.0) as u8,
        _ => random.between(0.0, 60.0) as u8,
    };
    let voxels = (0..dims.iter().product()).map(voxel).collect();
    let grid = Grid::new(dims, DAffine3::IDENTITY, Voxels::U8(voxels)).expect("a grid");
    let mut model = Model::default();
    model.push(Node::Volume(VolumeLeaf {
        bricks: Arc::new(Bricks::new(&grid)),
        window: Interval::ALL,
    }));
    Target::build(&model, None, &Subdivision::default()).expect("a target")
}

/// Plain frames, for which widest vectors have a program of their own and arrays have not: only what is above some value shows, and most is not.
#[test]
fn plain_frames_are_those_of_any_program() {
    let random = &mut Random(11);
    for n in 0..24 {
        let target = dotted(random);
        let least = random.between(40.0, 200.0) as f32;
        let point = |(value, opacity): (f32, f32)| ControlPoint {
            value,
            color: [1.0, 0.5, 0.25],
            opacity,
        };
        let points = [(0.0, 0.0), (least, 0.0), (least + 20.0, 0.7), (255.0, 0.9)].map(point);
        let settings = Settings {
            shading: (n % 2 == 0).then(Shading::default),
            ..Settings::default()
        };
        let view = View {
            azimuth_deg: random.between(-180.0, 180.0),
            elevation_deg: random.between(-90.0, 90.0),
            ..View::default()
        };
        let spec = FrameSpec {
            target: &target,
            transfer: &TransferFunction::new(points.to_vec(), 1.0).expect("a transfer function"),
            camera: &view.camera(&target.lattice.world_bounds(), [40, 36]),
            settings: &settings,
        };
        for times in [1.0, 3.0, 12.0] {
            let camera = &nearer(&spec, times);
            let nearer = FrameSpec { camera, ..spec };
            assert_eq!(both(&nearer), Ok(()), "volume {n}, {times} times as near");
        }
    }
}
