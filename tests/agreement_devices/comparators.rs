//! Law 9: every comparison can fail. Each fault that this module makes must put at least eight pixels out of bounds.

use glam::{DAffine3, DVec3};
use vcsg::conformance::FrameBounds;
use vcsg::image::Frame;
use vcsg::model::{Combine, Model, Node};
use vcsg::projection::{Mode, SlicePlan, TransferFunction};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::VoxelType;

use crate::device::{Bench, Prepared, on_device};
use crate::random::Random;
use crate::scene::{Content, Recipe, Scene};

/// A fault that fewer pixels show is not told from chance.
const DISCERNED: usize = 8;

const RECIPE: Recipe = Recipe {
    seed: 7,
    voxels: VoxelType::F32,
    content: Content::Carved,
    mode: Mode::Composite,
    lit: false,
    perspective: false,
    blocks: [8, 8],
};

/// A coloured volume and a coloured ball, one over the other.
const BLENDED: Recipe = Recipe {
    seed: 11,
    content: Content::Blended,
    ..RECIPE
};

/// A scene that is within bounds, ready for a fault.
struct Case {
    scene: Scene,
    prepared: Prepared,
    bounds: FrameBounds,
    right: Frame,
}

impl Case {
    fn new(bench: &mut Bench) -> Self {
        Self::of(bench, &RECIPE)
    }

    fn of(bench: &mut Bench, recipe: &Recipe) -> Self {
        let scene = recipe.scene();
        let prepared = bench.prepare(&scene.spec());
        let bounds = bench.bounds(&scene.spec(), &prepared);
        let right = bench.draw(&scene.spec(), &prepared);
        assert_eq!(bounds.pixels_outside(&right), 0, "before the fault");
        Self {
            scene,
            prepared,
            bounds,
            right,
        }
    }

    fn require_discerned(&self, fault: &str, wrong: &Frame) {
        let outside = self.bounds.pixels_outside(wrong);
        println!("{fault}: {outside} pixels out of bounds");
        assert!(outside >= DISCERNED, "{fault}: {outside}");
    }

    /// Draws a plan that `spoil` has changed.
    fn spoiled(&mut self, bench: &mut Bench, spoil: impl FnOnce(&mut SlicePlan)) -> Frame {
        let plan = self.prepared.plan.clone();
        spoil(&mut self.prepared.plan);
        let frame = bench.draw(&self.scene.spec(), &self.prepared);
        self.prepared.plan = plan;
        frame
    }
}

/// The slices of a plan, box by box.
fn without_box(plan: &mut SlicePlan, dropped: u32) {
    plan.slices.retain(|slice| slice.slice_box != dropped);
}

/// Draws box by box, in the order of what `place` gives for a box's place in the right order.
fn reordered(plan: &mut SlicePlan, place: impl Fn(u32) -> u32) {
    let last = plan.boxes.len() as u32 - 1;
    let nearest_first = plan.is_cut();
    plan.slices.sort_by_key(|slice| match nearest_first {
        true => last - place(slice.slice_box),
        false => place(slice.slice_box),
    });
}

/// Draws the boxes in the opposite order, the slices of each still in the right one.
fn reversed(plan: &mut SlicePlan) {
    let last = plan.boxes.len() as u32 - 1;
    reordered(plan, |n| last - n);
}

/// Draws two boxes in each other's place.
fn swapped(plan: &mut SlicePlan, [a, b]: [u32; 2]) {
    reordered(plan, |n| match n {
        n if n == a => b,
        n if n == b => a,
        n => n,
    });
}

pub fn a_shifted_pixel_is_out_of_bounds() {
    on_device(|bench| {
        let case = Case::new(bench);
        let mut wrong = case.right.clone();
        wrong.pixels_mut().rotate_right(1);
        case.require_discerned("shifted by a pixel", &wrong);
    });
}

pub fn a_dropped_block_is_out_of_bounds() {
    on_device(|bench| {
        let mut case = Case::new(bench);
        let nearest = case.prepared.plan.boxes.len() as u32 - 1;
        let wrong = case.spoiled(bench, |plan| without_box(plan, nearest));
        case.require_discerned("without its nearest box", &wrong);
    });
}

pub fn swapped_blocks_are_out_of_bounds() {
    on_device(|bench| {
        let mut case = Case::new(bench);
        let wrong = case.spoiled(bench, reversed);
        case.require_discerned("boxes in the opposite order", &wrong);
        let in_place = case.spoiled(bench, |plan| swapped(plan, [0, 0]));
        assert_eq!(case.bounds.pixels_outside(&in_place), 0, "box by box");
        // The farthest box and the nearest that lies over it.
        let boxes = case.prepared.plan.boxes.len() as u32;
        let most = (1..boxes)
            .map(|other| {
                let wrong = case.spoiled(bench, |plan| swapped(plan, [0, other]));
                case.bounds.pixels_outside(&wrong)
            })
            .max();
        println!("two boxes swapped: {most:?} pixels out of bounds");
        assert!(most >= Some(DISCERNED), "{most:?}");
    });
}

pub fn flipped_operands_are_out_of_bounds() {
    on_device(|bench| {
        for (recipe, fault) in [
            (RECIPE, "the ball without the volume"),
            (BLENDED, "the colours the other way round"),
        ] {
            let mut case = Case::of(bench, &recipe);
            let lattice = case.scene.target.lattice;
            case.scene.target = Target::on_lattice(&flipped_model(&recipe), lattice, &subdivision()).expect("a target");
            let prepared = bench.prepare(&case.scene.spec());
            let wrong = bench.draw(&case.scene.spec(), &prepared);
            case.require_discerned(fault, &wrong);
        }
    });
}

pub fn other_opacities_are_out_of_bounds() {
    on_device(|bench| {
        let mut case = Case::of(bench, &BLENDED);
        let lattice = case.scene.target.lattice;
        let mut model = Model::default();
        for node in BLENDED.model(&mut Random(BLENDED.seed)).nodes() {
            model.push(match node {
                Node::Classify { child, transfer } => Node::Classify {
                    child: *child,
                    // Opacities for a length that is a twentieth longer.
                    transfer: TransferFunction::new(transfer.points().to_vec(), 1.05 * transfer.unit_mm())
                        .expect("the same points")
                        .into(),
                },
                other => other.clone(),
            });
        }
        case.scene.target = Target::on_lattice(&model, lattice, &subdivision()).expect("a target");
        let prepared = bench.prepare(&case.scene.spec());
        let wrong = bench.draw(&case.scene.spec(), &prepared);
        case.require_discerned("colours a twentieth less opaque", &wrong);
    });
}

pub fn half_a_texel_is_out_of_bounds() {
    on_device(|bench| {
        let mut case = Case::new(bench);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let wrong = case.spoiled(bench, |plan| {
                plan.eye_from_lattice *= DAffine3::from_translation(0.5 * axis);
            });
            case.require_discerned(&format!("half a texel along {axis}"), &wrong);
        }
    });
}

fn subdivision() -> Subdivision {
    let [min_block, max_block] = RECIPE.blocks;
    Subdivision {
        min_block,
        max_block,
        ..Subdivision::default()
    }
}

/// The recipe's model with the operands of its combination exchanged.
fn flipped_model(recipe: &Recipe) -> Model {
    let mut model = Model::default();
    let right = recipe.model(&mut Random(recipe.seed));
    for node in right.nodes() {
        let node = match node {
            Node::Combine(combine) => Node::Combine(Combine {
                first: combine.second,
                second: combine.first,
                ..combine.clone()
            }),
            other => other.clone(),
        };
        model.push(node);
    }
    model
}
