//! The slice plan: every plane sample inside a drawn cube is covered once, from far to near, by the exact polygon.

use glam::{DAffine3, DVec2, DVec3};
use proptest::prelude::*;
use vcsg::math::{Aabb, affine};
use vcsg::model::Boundary;
use vcsg::projection::bands::{self, Sweep};
use vcsg::projection::{
    BoxView, Camera, DrawCost, OpenTiles, Planes, Planner, Remaining, ShownCells, Slice, SlicePlan, Visibility,
    VisibleBox, VisibleValues,
};
use vcsg::target::Target;

use crate::order::cells_of;
use crate::support::scenes::{scene, subdivision};
use crate::support::views::eye;
use crate::support::{cases, seeded};

/// A plan, what it was made of, and points to try.
struct Planned {
    plan: SlicePlan,
    camera: Camera,
    boxes: Vec<Aabb>,
    lattice_from_eye: DAffine3,
}

/// Depths err by some 1e-13 mm, and a vertex by that over the sine of the angle between its edge and the planes, which is
/// at least [`STEEPEST`] here (or 0, where there is no vertex): 1e-9 voxel. Points this near a face (voxels) are not asked for.
const NEAR: f64 = 1e-7;

/// The smallest depth of a voxel's edge, millimetres, that is not taken as parallel to the planes.
const STEEPEST: f64 = 1e-4;

impl Planned {
    /// `None` where an edge lies too nearly along the planes for the tolerance to hold.
    fn new(target: &Target, camera: Camera, samples_per_voxel: f64) -> Option<Self> {
        let cells = cells_of(target);
        let shown = ShownCells::new(&cells, &VisibleValues::all(target.value_range));
        let visibility = Visibility {
            target,
            shown: &shown,
            min_cube: 8,
            remaining: None,
            cost: DrawCost::VOXELS,
        };
        let planes = Planes::new(&target.lattice, &camera, samples_per_voxel);
        let plan = SlicePlan::new(&visibility, &camera, planes);
        let viewpoint = camera
            .viewpoint()
            .transformed(&target.lattice.world_from_lattice.inverse());
        let visible = visibility.boxes_back_to_front(viewpoint);
        let depths = plan.eye_from_lattice.matrix3.row(2).abs().to_array();
        let steep = !depths.iter().any(|d| (1e-12..STEEPEST).contains(d));
        steep.then(|| Self {
            boxes: visible.iter().map(VisibleBox::bounds).collect(),
            lattice_from_eye: plan.eye_from_lattice.inverse(),
            camera,
            plan,
        })
    }

    /// The same frame planned slab by slab, all of it open.
    fn in_slabs(&mut self, target: &Target) {
        let cells = cells_of(target);
        let shown = ShownCells::new(&cells, &VisibleValues::all(target.value_range));
        let view = BoxView::new(&target.lattice, &self.camera);
        let open = OpenTiles::all(self.camera.size);
        let mut planner = Planner::new(&target.lattice, &self.camera, self.plan.planes);
        self.plan = planner.empty();
        let mut sweep = Sweep::new(&target.lattice, self.plan.planes, &view);
        while let Some(depths_mm) = sweep.next(&open) {
            let remaining = Remaining {
                view: &view,
                depths_mm,
                open: &open,
            };
            let visibility = Visibility {
                target,
                shown: &shown,
                min_cube: 8,
                remaining: Some(remaining),
                cost: DrawCost::VOXELS,
            };
            let mut slab = planner.plan(&visibility);
            slab.slices.reverse();
            self.plan.append(depths_mm[0], slab);
        }
    }

    fn plane_of(&self, slice: &Slice) -> i64 {
        let depth = self.plan.boxes[slice.slice_box as usize].nearest_mm + slice.t_mm;
        self.plane_at(depth)
    }

    fn plane_at(&self, depth: f64) -> i64 {
        ((depth - self.plan.planes.first_mm) / self.plan.planes.step_mm).round() as i64
    }

    /// The points (fractions of each box in turn) moved along the line of sight to the nearest plane, in the eye frame.
    fn samples(&self, fractions: &[DVec3]) -> Vec<DVec3> {
        let place = |(f, b): (&DVec3, &Aabb)| {
            let eye = affine::point(&self.plan.eye_from_lattice, b.min + b.size() * *f);
            eye.with_z(self.plan.planes.depth(self.plane_at(eye.z)))
        };
        let boxes = self.boxes.iter().cycle().take(fractions.len().max(self.boxes.len()));
        fractions.iter().cycle().zip(boxes).map(place).collect()
    }

    /// How many polygons must cover a sample: `None` when it lies too near a face, or where nothing is asked for.
    fn wanted(&self, eye: DVec3) -> Option<usize> {
        let at = affine::point(&self.lattice_from_eye, eye);
        let depth_in = |b: &Aabb| (at - b.min).min(b.max - at).min_element();
        if self.boxes.iter().any(|b| depth_in(b).abs() < NEAR) {
            return None;
        }
        let inside = self.boxes.iter().filter(|b| depth_in(b) > 0.0).count();
        if eye.z < self.camera.near_mm() {
            return Some(0);
        }
        let px = self.camera.project(eye);
        let size = DVec2::new(f64::from(self.camera.size[0]), f64::from(self.camera.size[1]));
        let in_frame = px.cmpge(DVec2::ZERO).all() && px.cmple(size).all();
        (in_frame || inside == 0).then_some(inside)
    }

    fn covering(&self, eye: DVec3) -> usize {
        let plane = self.plane_at(eye.z);
        let covers = |slice: &&Slice| self.plane_of(slice) == plane && holds(&self.seen(slice), eye.truncate());
        self.plan.slices.iter().filter(covers).count()
    }

    /// A slice's polygon as the eye sees it, millimetres across the line of sight.
    fn seen(&self, slice: &Slice) -> Vec<DVec2> {
        let to_eye = |p: &DVec3| affine::point(&self.plan.eye_from_lattice, *p).truncate();
        self.plan.polygon(slice).iter().map(to_eye).collect()
    }

    fn samples_are_covered_once(&self, samples: &[DVec3]) -> Result<(), String> {
        for &eye in samples {
            let Some(wanted) = self.wanted(eye) else {
                continue;
            };
            let found = self.covering(eye);
            if found != wanted {
                return Err(format!("{found} polygons instead of {wanted} at {eye} (eye frame)"));
            }
        }
        Ok(())
    }

    /// Boxes come one after another, and the planes of each from far to near.
    fn runs_from_far_to_near(&self) -> Result<(), String> {
        self.in_order(|a, b| match a.slice_box == b.slice_box {
            true => a.t_mm > b.t_mm,
            false => a.slice_box < b.slice_box,
        })
    }

    /// Bands come one after another, the nearest first, in each of them boxes, and the planes of each box from near to far.
    fn runs_from_near_to_far(&self) -> Result<(), String> {
        self.in_order(|a, b| {
            let bands = [a, b].map(|slice| self.plan.band(slice));
            match a.slice_box == b.slice_box {
                _ if bands[0] != bands[1] => bands[0] < bands[1],
                true => a.t_mm < b.t_mm,
                false => a.slice_box > b.slice_box,
            }
        })
    }

    /// Each slice may be drawn before the next.
    fn in_order(&self, may_follow: impl Fn(&Slice, &Slice) -> bool) -> Result<(), String> {
        let wrong = |pair: &&[Slice]| !may_follow(&pair[0], &pair[1]);
        match self.plan.slices.windows(2).find(wrong) {
            Some(pair) => Err(format!("{pair:?} are out of order")),
            None => Ok(()),
        }
    }

    /// The part of the frame that each band may be seen in holds what its polygons show of the frame.
    fn bands_are_seen_where_they_are(&self) -> Result<(), String> {
        let size = DVec2::from(self.camera.size.map(f64::from));
        let matrix = self.plan.eye_from_lattice.matrix3;
        let voxel_mm = [0, 1, 2]
            .map(|a| matrix.col(a).length())
            .into_iter()
            .fold(0.0, f64::max);
        for band in bands::ranges(&self.plan) {
            let [least, greatest] = bands::seen_px(&self.plan, band.clone());
            let vertices = self.plan.slices[band].iter().flat_map(|slice| self.plan.polygon(slice));
            for vertex in vertices {
                let eye = affine::point(&self.plan.eye_from_lattice, vertex);
                let near_px = NEAR * voxel_mm * self.camera.pixels_per_mm(eye.z);
                let shown = self.camera.project(eye).clamp(DVec2::ZERO, size);
                if shown.cmplt(least - near_px).any() || shown.cmpgt(greatest + near_px).any() {
                    return Err(format!("{shown} is not within {least} and {greatest}"));
                }
            }
        }
        Ok(())
    }

    /// Each polygon lies in its plane and box, and has the area of the plane's square clipped by the box.
    fn polygons_are_exact(&self) -> Result<(), String> {
        self.plan
            .slices
            .iter()
            .try_for_each(|slice| self.polygon_is_exact(slice))
    }

    fn polygon_is_exact(&self, slice: &Slice) -> Result<(), String> {
        let b = &self.plan.boxes[slice.slice_box as usize];
        let bounds = b.visible.bounds();
        let depth = self.plan.planes.depth(self.plane_of(slice));
        let beyond = bounds.expand(DVec3::splat(NEAR));
        for v in self.plan.polygon(slice) {
            let z = affine::point(&self.plan.eye_from_lattice, v).z;
            if !beyond.contains(v) || (z - depth).abs() > NEAR {
                return Err(format!("vertex {v} at depth {z} of {bounds:?}, plane {depth}"));
            }
        }
        let section = self.clipped(&bounds, depth);
        let (found, wanted) = (area(&self.seen(slice)), area(&section));
        // Each vertex is off by NEAR at most, so the area by NEAR times the circumference, which is below 8 diagonals.
        let diagonal = self.eye_size(&bounds);
        if (found - wanted).abs() > NEAR * 8.0 * diagonal {
            return Err(format!("area {found} instead of {wanted} in {bounds:?} at {depth}"));
        }
        Ok(())
    }

    fn eye_size(&self, bounds: &Aabb) -> f64 {
        bounds.transformed(&self.plan.eye_from_lattice).size().length()
    }

    /// A square of the plane at `depth`, larger than the box, clipped by the box's six faces (Sutherland and Hodgman 1974).
    fn clipped(&self, bounds: &Aabb, depth: f64) -> Vec<DVec2> {
        let middle = affine::point(&self.plan.eye_from_lattice, bounds.center()).truncate();
        let reach = self.eye_size(bounds);
        let corner = |x: f64, y: f64| (middle + DVec2::new(x, y) * reach).extend(depth);
        let square = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let within = |face: usize, eye: DVec3| {
            let p = affine::point(&self.lattice_from_eye, eye);
            let axis = face / 2;
            if face & 1 == 0 {
                p[axis] - bounds.min[axis]
            } else {
                bounds.max[axis] - p[axis]
            }
        };
        let polygon = (0..6).fold(square.to_vec(), |polygon, face| clip(&polygon, |p| within(face, p)));
        polygon.into_iter().map(|p| p.truncate()).collect()
    }
}

/// The part of a polygon where `within` is at least 0.
fn clip(polygon: &[DVec3], within: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (n, &a) in polygon.iter().enumerate() {
        let b = polygon[(n + 1) % polygon.len()];
        let (da, db) = (within(a), within(b));
        if da >= 0.0 {
            kept.push(a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            kept.push(a.lerp(b, da / (da - db)));
        }
    }
    kept
}

fn area(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let origin = polygon.first().copied().unwrap_or_default();
    let doubled: f64 = polygon
        .iter()
        .zip(next)
        .map(|(a, b)| (a - origin).perp_dot(b - origin))
        .sum();
    0.5 * doubled.abs()
}

/// Whether a convex polygon holds `p`.
fn holds(polygon: &[DVec2], p: DVec2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let turns: Vec<f64> = polygon.iter().zip(next).map(|(a, b)| (b - a).perp_dot(p - a)).collect();
    polygon.len() > 2 && (turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0))
}

fn fractions() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(prop::array::uniform3(-0.3f64..1.3).prop_map(DVec3::from), 60)
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn plans_are_right(
        scene in scene(),
        subdivision in subdivision(Boundary::Exact),
        eye in eye(),
        samples_per_voxel in 0.3f64..1.5,
        fractions in fractions(),
    ) {
        let target = scene.target(&subdivision);
        let camera = eye.camera(&target.lattice.world_bounds());
        if let Some(planned) = Planned::new(&target, camera, samples_per_voxel) {
            prop_assert_eq!(planned.samples_are_covered_once(&planned.samples(&fractions)), Ok(()));
            prop_assert_eq!(planned.runs_from_far_to_near(), Ok(()));
            prop_assert_eq!(planned.polygons_are_exact(), Ok(()));
        }
    }

    #[test]
    fn plans_of_slabs_are_right(
        scene in scene(),
        subdivision in subdivision(Boundary::Exact),
        eye in eye(),
        fractions in fractions(),
    ) {
        let target = scene.target(&subdivision);
        let camera = eye.camera(&target.lattice.world_bounds());
        if let Some(mut planned) = Planned::new(&target, camera, 1.0) {
            let samples = planned.samples(&fractions);
            planned.in_slabs(&target);
            prop_assert_eq!(planned.samples_are_covered_once(&samples), Ok(()));
            prop_assert_eq!(planned.runs_from_near_to_far(), Ok(()));
            prop_assert_eq!(planned.bands_are_seen_where_they_are(), Ok(()));
            prop_assert_eq!(planned.polygons_are_exact(), Ok(()));
        }
    }

    #[test]
    fn bands_are_the_same_slices_cut_in_depth(
        scene in scene(),
        subdivision in subdivision(Boundary::Exact),
        eye in eye(),
        count in 2usize..9,
    ) {
        let target = scene.target(&subdivision);
        let camera = eye.camera(&target.lattice.world_bounds());
        if let Some(mut planned) = Planned::new(&target, camera, 1.0) {
            let whole = planned.plan.slices.clone();
            planned.plan = bands::cut_into(planned.plan, count);
            prop_assert_eq!(
                if planned.plan.is_cut() { planned.runs_from_near_to_far() } else { planned.runs_from_far_to_near() },
                Ok(())
            );
            prop_assert_eq!(planned.bands_are_seen_where_they_are(), Ok(()));
            let key = |slice: &Slice| (slice.slice_box, slice.t_mm.to_bits());
            let sorted = |slices: &[Slice]| {
                let mut keys: Vec<_> = slices.iter().map(key).collect();
                keys.sort_unstable();
                keys
            };
            prop_assert_eq!(sorted(&planned.plan.slices), sorted(&whole));
            let ranges = bands::ranges(&planned.plan);
            prop_assert!(ranges.len() <= count, "{} bands", ranges.len());
            let drawn: Vec<usize> = ranges.into_iter().flatten().collect();
            prop_assert_eq!(drawn, (0..whole.len()).collect::<Vec<_>>());
        }
    }
}

#[test]
fn a_slice_in_the_wrong_band_is_seen() {
    let ordered = |planned: &Planned, _: &[DVec3]| planned.runs_from_near_to_far();
    let swapped = |plan: &mut SlicePlan| {
        *plan = bands::cut_into(plan.clone(), 4);
        let one = plan.slices.len().min(1);
        plan.slices.rotate_left(one);
    };
    let cut = |plan: &mut SlicePlan| *plan = bands::cut_into(plan.clone(), 4);
    assert_eq!(seen(cut, ordered), 0);
    let found = seen(swapped, ordered);
    assert!(found > 8, "{found} of 20");
}

/// How many of some plans fail `check` after `mutate`.
fn seen(mutate: impl Fn(&mut SlicePlan), check: impl Fn(&Planned, &[DVec3]) -> Result<(), String>) -> usize {
    let fails = |seed: &u64| {
        let target = seeded(&scene(), *seed).target(&seeded(&subdivision(Boundary::Exact), *seed));
        let camera = seeded(&eye(), *seed).camera(&target.lattice.world_bounds());
        let Some(mut planned) = Planned::new(&target, camera, 1.0) else {
            return false;
        };
        mutate(&mut planned.plan);
        let samples = planned.samples(&seeded(&fractions(), *seed));
        check(&planned, &samples).is_err()
    };
    (0..20).filter(fails).count()
}

#[test]
fn lost_doubled_swapped_and_shifted_slices_are_seen() {
    let covered = |planned: &Planned, samples: &[DVec3]| planned.samples_are_covered_once(samples);
    let ordered = |planned: &Planned, _: &[DVec3]| planned.runs_from_far_to_near();
    let exact = |planned: &Planned, _: &[DVec3]| planned.polygons_are_exact();
    assert_eq!(seen(|_| (), covered) + seen(|_| (), ordered) + seen(|_| (), exact), 0);
    let every_second = |plan: &mut SlicePlan| {
        plan.slices = plan.slices.iter().copied().step_by(2).collect();
    };
    let doubled = |plan: &mut SlicePlan| plan.slices = plan.slices.iter().flat_map(|s| [*s; 2]).collect();
    let moved = |plan: &mut SlicePlan| plan.slices.iter_mut().for_each(|s| s.t_mm += 0.2 * plan.planes.step_mm);
    for (mistake, found) in [
        ("lost", seen(every_second, covered)),
        ("doubled", seen(doubled, covered)),
        ("swapped", seen(|plan| plan.slices.reverse(), ordered)),
        ("shifted", seen(moved, exact)),
    ] {
        assert!(found > 8, "{mistake}: {found} of 20");
    }
}
