//! Design law 2 on the CPU: the picture does not depend on the subdivision, nor on what visibility leaves out.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::image::Frame;
use vcsg::model::{Boundary, Tree};
use vcsg::projection::{DrawCost, FrameSpec, Settings, ShownCells, Visibility, VisibleBox, VisibleValues, reference};
use vcsg::target::{OctreeNode, Subdivision, Target, VoxelTarget};

use crate::order::cells_of;
use crate::path::same_bits;
use crate::support::scenes::{Scene, scene, subdivision};
use crate::support::views::{Eye, Look, eye, look, settings};
use crate::support::{cases, seeded};

/// A random way to look at a target.
#[derive(Clone, Debug)]
struct Picture {
    eye: Eye,
    look: Look,
    settings: Settings,
}

fn picture() -> impl Strategy<Value = Picture> {
    (eye(), look(), settings()).prop_map(|(eye, look, settings)| Picture { eye, look, settings })
}

impl Picture {
    /// Gives `draw` the frame to draw of `target`.
    fn of<T>(&self, target: &Target, draw: impl Fn(&FrameSpec) -> T) -> T {
        draw(&FrameSpec {
            target,
            transfer: &self.look.transfer(target.value_range),
            camera: &self.eye.camera(&target.lattice.world_bounds()),
            settings: &self.settings,
        })
    }

    fn reference(&self, target: &Target) -> Frame {
        self.of(target, |spec| reference::render(&VoxelTarget::new(target), spec))
    }

    /// The frame made only of samples in `boxes`.
    fn within(&self, target: &Target, boxes: &[VisibleBox]) -> Frame {
        let bounds: Vec<_> = boxes.iter().map(VisibleBox::bounds).collect();
        let shown = |p: DVec3| bounds.iter().any(|b| b.contains(p));
        self.of(target, |spec| {
            reference::render_where(&VoxelTarget::new(target), spec, &shown)
        })
    }

    /// The boxes that are drawn of `target`.
    fn boxes(&self, target: &Target) -> Vec<VisibleBox> {
        self.of(target, |spec| {
            let cells = cells_of(target);
            let visibility = Visibility {
                target,
                shown: &ShownCells::new(&cells, &VisibleValues::in_frame(spec, &spec.table())),
                min_cube: 8,
                remaining: None,
                cost: DrawCost::VOXELS,
            };
            let lattice_from_world = target.lattice.world_from_lattice.inverse();
            let viewpoint = spec.camera.viewpoint().transformed(&lattice_from_world);
            visibility.boxes_back_to_front(viewpoint)
        })
    }
}

/// Whether two frames have the same bits.
fn same(a: &Frame, b: &Frame) -> Result<(), String> {
    let differ = |(p, q): (&[f32; 4], &[f32; 4])| !p.iter().zip(q).all(|(&p, &q)| same_bits(p, q));
    let pixels = a.pixels().iter().zip(b.pixels());
    match pixels.enumerate().find(|(_, pair)| differ(*pair)) {
        Some((n, (p, q))) => Err(format!("pixel {n} is {p:?} and {q:?}")),
        None if a.pixels().len() != b.pixels().len() => Err("sizes differ".into()),
        None => Ok(()),
    }
}

fn one_block() -> Subdivision {
    Subdivision {
        min_block: 64,
        max_block: 64,
        ..Subdivision::default()
    }
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn one_block_or_many(scene in scene(), subdivision in subdivision(Boundary::Exact), picture in picture()) {
        let (one, many) = (scene.target(&one_block()), scene.target(&subdivision));
        prop_assert!(one.blocks.len() <= 1);
        prop_assert_eq!(one.value_range, many.value_range);
        prop_assert_eq!(same(&picture.reference(&one), &picture.reference(&many)), Ok(()));
    }

    #[test]
    fn what_is_left_out_does_not_show(scene in scene(), subdivision in subdivision(Boundary::Exact), picture in picture()) {
        let target = scene.target(&subdivision);
        let drawn = picture.within(&target, &picture.boxes(&target));
        prop_assert_eq!(same(&picture.reference(&target), &drawn), Ok(()));
    }
}

/// How many of some scenes give another picture when `mutate` makes a mistake.
fn seen(mistaken: impl Fn(&Picture, &Scene) -> Frame) -> usize {
    let shows = |seed: &u64| {
        let (scene, picture) = (seeded(&scene(), *seed), seeded(&picture(), *seed));
        same(
            &picture.reference(&scene.target(&small_blocks())),
            &mistaken(&picture, &scene),
        )
        .is_err()
    };
    (0..24).filter(shows).count()
}

fn small_blocks() -> Subdivision {
    Subdivision {
        min_block: 8,
        max_block: 8,
        ..Subdivision::default()
    }
}

#[test]
fn a_dropped_block_a_shift_and_a_dropped_cube_are_seen() {
    assert_eq!(
        seen(|picture, scene| picture.reference(&scene.target(&small_blocks()))),
        0
    );
    let dropped = seen(|picture, scene| {
        let mut target = scene.target(&small_blocks());
        let half = target.blocks.len() as u32 / 2;
        let drop = |node: &mut OctreeNode| {
            if matches!(*node, OctreeNode::Block(b) if b >= half) {
                *node = OctreeNode::Empty;
            }
        };
        target.octree.nodes.iter_mut().for_each(drop);
        picture.reference(&target)
    });
    assert!(dropped > 4, "{dropped} of 24");
    let shifted = seen(|picture, scene| {
        let mut target = scene.target(&small_blocks());
        let frame = *scene.lattice.world_from_grid() * glam::DAffine3::from_translation(DVec3::X);
        target.tree = Tree::new(&scene.model, &frame).expect("a small tree");
        picture.reference(&target)
    });
    assert!(shifted > 4, "{shifted} of 24");
    let uncovered = seen(|picture, scene| {
        let target = scene.target(&small_blocks());
        let boxes = picture.boxes(&target);
        picture.within(&target, &boxes[..boxes.len() / 2])
    });
    assert!(uncovered > 4, "{uncovered} of 24");
}
