//! The widest vectors that the processor has, or arrays: the same bits.

use vcsg::model::Boundary;
use vcsg::projection::raycast::{PortableRayCaster, RayCaster};
use vcsg::projection::{FrameSpec, Projector};

use super::picture::{nearer, picture, same};
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
