//! Law 2 on a device: one block or many, the same picture within the bounds.

use vcsg::conformance::FrameBounds;
use vcsg::image::Frame;
use vcsg::projection::Mode;
use vcsg::volume::VoxelType;

use crate::device::{Bench, on_device};
use crate::scene::{Content, Recipe};

fn recipe(seed: u64, blocks: [usize; 2]) -> Recipe {
    Recipe {
        seed,
        voxels: [VoxelType::F32, VoxelType::U8, VoxelType::I16][seed as usize % 3],
        content: if seed.is_multiple_of(5) {
            Content::Blended
        } else {
            Content::Volume
        },
        mode: [Mode::Composite, Mode::Composite, Mode::Mip, Mode::Average][seed as usize % 4],
        lit: seed.is_multiple_of(2),
        perspective: seed % 3 == 1,
        blocks,
    }
}

/// Whether two frames differ in no channel by more than the hull of their bounds is wide.
fn alike(one: &Frame, many: &Frame, widths: &[f64]) -> bool {
    let channels = one.pixels().as_flattened().iter();
    let pairs = channels.zip(many.pixels().as_flattened());
    pairs
        .zip(widths)
        .all(|((a, b), width)| f64::from(a - b).abs() <= *width)
}

/// A recipe's frame and its bounds.
struct Drawn {
    frame: Frame,
    bounds: FrameBounds,
    boxes: usize,
}

fn draw(bench: &mut Bench, recipe: &Recipe) -> Drawn {
    let scene = recipe.scene();
    let spec = scene.spec();
    let prepared = bench.prepare(&spec);
    Drawn {
        bounds: bench.bounds(&spec, &prepared),
        frame: bench.draw(&spec, &prepared),
        boxes: prepared.plan.boxes.len(),
    }
}

fn require_same(bench: &mut Bench, seed: u64, size: usize) {
    let one = draw(bench, &recipe(seed, [64, 64]));
    let many = draw(bench, &recipe(seed, [size, size]));
    assert!(one.boxes < many.boxes, "seed {seed}: one block is in fewer boxes");
    bench.require_within(&format!("seed {seed} in one block"), &one.frame, &one.bounds);
    let what = format!("seed {seed} in blocks of {size}");
    bench.require_within(&what, &many.frame, &many.bounds);
    // Both bounds hold the exact picture, so their hull is no wider than they are together.
    let both = one.bounds.widths().into_iter().zip(many.bounds.widths());
    let widths: Vec<f64> = both.map(|(a, b)| a + b).collect();
    assert!(alike(&one.frame, &many.frame, &widths), "{what}");
}

pub fn one_block_or_many_the_picture_is_the_same() {
    on_device(|bench| {
        for seed in 40..46 {
            for size in [8, 16] {
                require_same(bench, seed, size);
            }
        }
    });
}
