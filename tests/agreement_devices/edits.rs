//! Law 5 on a device: pages that follow edits show what the edited target is.

use vcsg::model::{Model, Node};
use vcsg::projection::{FrameSpec, Mode};
use vcsg::render::{PagedTarget, plan, soft_normals};
use vcsg::target::{Lattice, Target, Update};
use vcsg::volume::VoxelType;
use vcsg::voxelize::Solid;

use crate::device::{Bench, Prepared, on_device};
use crate::random::Random;
use crate::scene::{Content, Recipe, Scene};

fn recipe(seed: u64) -> Recipe {
    Recipe {
        seed,
        voxels: VoxelType::U8,
        content: [Content::Carved, Content::United][seed as usize % 2],
        mode: [Mode::Composite, Mode::Average][seed as usize / 2 % 2],
        lit: seed.is_multiple_of(3),
        perspective: seed % 3 == 1,
        blocks: [[8, 8], [8, 16]][seed as usize % 2],
    }
}

/// The model with its ball moved.
fn moved(model: &Model, random: &mut Random) -> Model {
    let mut edited = Model::default();
    for node in model.nodes() {
        let mut node = node.clone();
        if let Node::Primitive(primitive) = &mut node
            && let Solid::Sphere { center, radius } = &mut primitive.solid
        {
            center[random.below(3)] += random.between(-0.5, 0.5) * *radius;
        }
        edited.push(node);
    }
    edited
}

/// The scene with another target.
fn with_target(scene: &Scene, target: Target) -> Scene {
    Scene {
        target,
        transfer: scene.transfer.clone(),
        camera: scene.camera,
        settings: scene.settings.clone(),
    }
}

/// Draws a scene and edits of it, each from the pages before, as `mistake` leaves the updates. Those out of bounds are counted, and those
/// that move a face of the lattice.
fn follow(bench: &mut Bench, seed: u64, mistake: impl Fn(&Target, Update) -> Update) -> [usize; 2] {
    let mut random = Random(seed);
    let mut model = recipe(seed).model(&mut random);
    let mut scene = recipe(seed).scene();
    let mut prepared = bench.prepare(&scene.spec());
    let (mut wrong, mut moved_faces) = (0, 0);
    for _ in 0..4 {
        model = moved(&model, &mut random);
        let before = &scene.target;
        let lattice = Lattice::of_model(&model, None).expect("a lattice");
        let update = before.updated(&model, lattice, &before.subdivision).expect("a target");
        assert_eq!(update.target.value_range, before.value_range);
        moved_faces += usize::from(lattice != before.lattice);
        let update = mistake(before, update);
        let normals = soft_normals(&scene.spec());
        let device = std::sync::Arc::clone(bench.renderer.device());
        let paged: PagedTarget = (prepared.paged)
            .updated(&device, before, &update, normals.as_ref(), &mut |_| {})
            .expect("a target on the device");
        scene = with_target(&scene, update.target);
        let spec: FrameSpec = scene.spec();
        prepared = Prepared {
            plan: plan(&spec, &paged),
            paged,
        };
        let (frame, bounds) = (bench.draw(&spec, &prepared), bench.bounds(&spec, &prepared));
        wrong += usize::from(bounds.pixels_outside(&frame) > 0);
    }
    [wrong, moved_faces]
}

pub fn pages_follow_edits() {
    on_device(|bench| {
        let mut moved = 0;
        for seed in 60..66 {
            let [wrong, moved_faces] = follow(bench, seed, |_, update| update);
            assert_eq!(wrong, 0, "seed {seed}");
            moved += moved_faces;
        }
        assert!(moved > 5, "{moved} of 24 edits move a face of the lattice");
    });
}

pub fn blocks_that_should_have_been_made_anew_are_out_of_bounds() {
    on_device(|bench| {
        let stale = |before: &Target, update: Update| {
            let cube = |target: &Target, b: &vcsg::target::Block| {
                let first = target.lattice.first().to_array();
                let origin = [0, 1, 2].map(|a| b.origin[a] as i64 + first[a]);
                (origin, b.extent, b.size, b.layout)
            };
            let kept = update.target.blocks.iter().map(|block| {
                let is_same = |old: &vcsg::target::Block| cube(before, old) == cube(&update.target, block);
                let same = before.blocks.iter().position(is_same);
                same.map(|old| old as u32)
            });
            Update {
                kept: kept.collect(),
                ..update
            }
        };
        let wrong: usize = (60..66).map(|seed| follow(bench, seed, stale)[0]).sum();
        assert!(wrong > 12, "{wrong} of 24");
    });
}
