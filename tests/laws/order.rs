//! Design law 8: what may hide is drawn after what it hides.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::{Aabb, Viewpoint};
use vcsg::model::Boundary;
use vcsg::projection::{DrawCost, ShownCells, Visibility, VisibleBox, VisibleValues};
use vcsg::target::{Block, BlockVoxels, CellRanges, Layout, Target};

use crate::support::parts::direction;
use crate::support::scenes::{scene, subdivision};
use crate::support::{cases, seeded};

/// The cells of each block of `target`.
pub fn cells_of(target: &Target) -> Vec<CellRanges> {
    let cells = |block: &Block| match block.layout == Layout::Uniform {
        true => CellRanges::uniform(&target.lattice, block),
        false => CellRanges::new(&target.lattice, block, &BlockVoxels::reconstruct(target, block, 1)),
    };
    target.blocks.iter().map(cells).collect()
}

/// Along each ray from the eye, the boxes that it passes through come from far to near.
///
/// Two boxes that do not overlap are parted by a plane on which both have a face; the ray meets it at one quotient, so of
/// intervals that have a length one ends where, or before, the other begins: there is no tolerance.
fn back_to_front(boxes: &[Aabb], viewpoint: Viewpoint, rays: &[DVec3]) -> Result<(), String> {
    for &ray in rays {
        let (from, along) = match viewpoint {
            Viewpoint::Direction(towards) => (ray, -towards),
            Viewpoint::Point(eye) => (eye, ray - eye),
        };
        let behind_eye = if matches!(viewpoint, Viewpoint::Point(_)) {
            0.0
        } else {
            f64::NEG_INFINITY
        };
        let mut nearest = f64::INFINITY;
        for b in boxes {
            let (entry, exit) = passage(b, from, along, behind_eye);
            if entry >= exit {
                continue;
            }
            if exit > nearest {
                return Err(format!("{b:?} is drawn after what it hides, along {along} from {from}"));
            }
            nearest = entry;
        }
    }
    Ok(())
}

/// Where the line `from + t·along` enters and leaves a box, from `begin` on.
fn passage(b: &Aabb, from: DVec3, along: DVec3, begin: f64) -> (f64, f64) {
    (0..3).fold((begin, f64::INFINITY), |(entry, exit), a| {
        if along[a] == 0.0 {
            let within = b.min[a] < from[a] && from[a] < b.max[a];
            return if within { (entry, exit) } else { (f64::INFINITY, exit) };
        }
        let (t0, t1) = ((b.min[a] - from[a]) / along[a], (b.max[a] - from[a]) / along[a]);
        (entry.max(t0.min(t1)), exit.min(t0.max(t1)))
    })
}

fn boxes(visible: &[VisibleBox]) -> Vec<Aabb> {
    visible.iter().map(VisibleBox::bounds).collect()
}

/// Directions along axes and not; points in and round the unit cube.
fn viewpoint() -> impl Strategy<Value = Viewpoint> {
    let point = prop::array::uniform3(-0.7f64..1.7).prop_map(|p| Viewpoint::Point(p.into()));
    prop_oneof![direction().prop_map(Viewpoint::Direction), point]
}

/// A viewpoint with points as fractions of the lattice's box.
fn in_lattice(viewpoint: Viewpoint, bounds: &Aabb) -> Viewpoint {
    match viewpoint {
        Viewpoint::Direction(_) => viewpoint,
        Viewpoint::Point(f) => Viewpoint::Point(bounds.min + bounds.size() * f),
    }
}

fn fractions() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(prop::array::uniform3(0.0f64..=1.0).prop_map(DVec3::from), 80)
}

fn rays(bounds: &Aabb, fractions: &[DVec3]) -> Vec<DVec3> {
    fractions.iter().map(|f| bounds.min + bounds.size() * f).collect()
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn boxes_come_from_back_to_front(
        scene in scene(),
        subdivision in subdivision(Boundary::Exact),
        viewpoint in viewpoint(),
        fractions in fractions(),
        min_cube in (3u32..6).prop_map(|n| 1usize << n),
    ) {
        let target = scene.target(&subdivision);
        let cells = cells_of(&target);
        let shown = ShownCells::new(&cells, &VisibleValues::all(target.value_range));
        let visibility = Visibility { target: &target, shown: &shown, min_cube, remaining: None, cost: DrawCost::VOXELS };
        let bounds = target.lattice.bounds();
        let viewpoint = in_lattice(viewpoint, &bounds);
        let boxes = boxes(&visibility.boxes_back_to_front(viewpoint));
        prop_assert_eq!(back_to_front(&boxes, viewpoint, &rays(&bounds, &fractions)), Ok(()));
    }
}

#[test]
fn two_swapped_boxes_are_seen() {
    let mut swaps = 0;
    for seed in 0..30 {
        let target = seeded(&scene(), seed).target(&seeded(&subdivision(Boundary::Exact), seed));
        let cells = cells_of(&target);
        let shown = ShownCells::new(&cells, &VisibleValues::all(target.value_range));
        let visibility = Visibility {
            target: &target,
            shown: &shown,
            min_cube: 8,
            remaining: None,
            cost: DrawCost::VOXELS,
        };
        let bounds = target.lattice.bounds();
        let rays = rays(&bounds, &seeded(&fractions(), seed));
        let viewpoint = in_lattice(seeded(&viewpoint(), seed), &bounds);
        let mut boxes = boxes(&visibility.boxes_back_to_front(viewpoint));
        assert_eq!(back_to_front(&boxes, viewpoint, &rays), Ok(()));
        if let [first, .., last] = &mut boxes[..] {
            std::mem::swap(first, last);
        }
        swaps += usize::from(back_to_front(&boxes, viewpoint, &rays).is_err());
    }
    assert!(swaps > 5, "{swaps} of 30");
}
