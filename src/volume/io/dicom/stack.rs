//! Slices put in their order along the normal, and where that puts their voxels.
//!
//! *Practice.* The third column of the affine is what one slice is from the next, in space: so a tilted gantry's shear stays in
//! it. The frames of one file stay in their order, even where that goes down the normal. Real slices are not quite even; they are taken for even while each is nearer to its place than a quarter of the distance.

use glam::{DAffine3, DMat3, DVec3};

use super::series::{Series, Slice};
use crate::volume::io::error::ReadError;
use crate::volume::io::open::ReadOptions;

/// How far a slice may be from its even place, in distances between slices: nearer to it than to any other, with as much to spare.
const MAX_OFF: f64 = 0.25;

/// From which on a step is one over a missing slice, in usual steps: half way to two.
const GAP: f64 = 1.5;

/// The least angle between the slices' normal and their displacement that is told, in radians: below, 200 slices shift by less
/// than one's distance.
const TOLD_TILT: f64 = 5e-3;

/// Slices in their order.
#[derive(Debug)]
pub(super) struct Stack {
    /// Those of the chosen volume in time.
    pub slices: Vec<Slice>,
    /// How many volumes in time there are.
    pub frames: usize,
    /// Where the grid's slices are among these: a whole number is a slice, others lie between two.
    pub places: Vec<f64>,
    /// LPS millimetres of a voxel's index.
    pub world_from_index: DAffine3,
    /// What should be known of them.
    pub notes: Vec<String>,
}

impl Stack {
    /// The volume of `series` that `options` name.
    pub(super) fn new(series: &Series, options: &ReadOptions) -> Result<Self, ReadError> {
        let mut clusters = clusters(&series.slices);
        let frames = check_counts(&clusters)?;
        let chosen = options.frame.unwrap_or(0);
        if chosen >= frames {
            let what = format!("it has no volume {chosen} in time: it holds {frames}");
            return Err(ReadError::unsupported(series.slices[0].path(), what).hint("count volumes in time from 0 on"));
        }
        let slices: Vec<_> = clusters.iter_mut().map(|slices| slices.swap_remove(chosen)).collect();
        let mut stack = Self {
            places: (0..slices.len()).map(|i| i as f64).collect(),
            world_from_index: DAffine3::IDENTITY,
            frames,
            slices,
            notes: Vec::new(),
        };
        stack.lay(options.resample)?;
        if stack.comes_backwards() {
            stack.turn();
        }
        Ok(stack)
    }

    /// Whether its slices are one file's frames, from the last one on.
    fn comes_backwards(&self) -> bool {
        let is_next =
            |pair: &[Slice]| pair[0].path() == pair[1].path() && pair[0].frame().order[2] > pair[1].frame().order[2];
        self.slices.len() == self.places.len() && self.slices.len() > 1 && self.slices.windows(2).all(is_next)
    }

    /// Counts slices from the other end: they stay where they are.
    fn turn(&mut self) {
        let place = &mut self.world_from_index;
        place.translation += place.matrix3.z_axis * (self.slices.len() - 1) as f64;
        place.matrix3.z_axis = -place.matrix3.z_axis;
        self.slices.reverse();
    }

    /// Finds the affine, and the places of resampled slices.
    fn lay(&mut self, resample: bool) -> Result<(), ReadError> {
        let first = self.slices[0].frame().clone();
        let normal = normal(&first);
        let positions = positions(&self.slices);
        let mut step = normal * first.step;
        if let [a, .., b] = positions[..] {
            step = (b - a) / (positions.len() - 1) as f64;
            let uneven = check_even(&self.slices, &positions, step, normal, &mut self.notes);
            match (uneven, resample) {
                (Ok(()), _) => {}
                (Err(e), false) => return Err(e),
                (Err(_), true) => step = self.resample(&positions, normal)?,
            }
            tell_tilt(step, normal, &mut self.notes);
        }
        let [x, y] = [0, 1].map(|i| first.axes[i] * first.spacing[i]);
        let origin = positions.first().copied().unwrap_or_default();
        self.world_from_index = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, step), origin);
        Ok(())
    }

    /// Lays even places over uneven slices, about their usual step apart; gives the step.
    fn resample(&mut self, positions: &[DVec3], normal: DVec3) -> Result<DVec3, ReadError> {
        let along: Vec<f64> = positions.iter().map(|p| normal.dot(*p - positions[0])).collect();
        let whole = positions[positions.len() - 1] - positions[0];
        let span = along[along.len() - 1];
        let count = (span / usual_step(&along)).round().max(1.0);
        // Even places per slice there is: beyond, the usual step tells nothing.
        if count > 64.0 * along.len() as f64 {
            let what = format!("its slices cover {span:.1} mm with gaps so wide that even ones would be {count}");
            return Err(ReadError::unsupported(self.slices[0].path(), what).hint("choose slices that belong together"));
        }
        let lateral = |i: usize| positions[i] - positions[0] - whole * (along[i] / span);
        for (i, slice) in self.slices.iter().enumerate() {
            check_lateral(slice, lateral(i))?;
        }
        let place = |k: usize| {
            let at = span * (k as f64 / count);
            let i = along.partition_point(|&a| a <= at).clamp(1, along.len() - 1) - 1;
            i as f64 + ((at - along[i]) / (along[i + 1] - along[i])).clamp(0.0, 1.0)
        };
        self.places = (0..=count as usize).map(place).collect();
        let notice = format!(
            "{} uneven slices were resampled to {} even ones",
            along.len(),
            self.places.len()
        );
        self.notes.push(notice);
        Ok(whole / count)
    }
}

fn normal(frame: &super::image::Frame) -> DVec3 {
    frame.axes[0].cross(frame.axes[1]).normalize()
}

/// The slices' positions; without any, a step apart.
fn positions(slices: &[Slice]) -> Vec<DVec3> {
    let position = |(i, slice): (usize, &Slice)| {
        let frame = slice.frame();
        frame
            .position
            .unwrap_or_else(|| normal(frame) * (i as f64 * frame.step))
    };
    slices.iter().enumerate().map(position).collect()
}

/// The slices at each place, in the order of the places along the normal, and at each in the order of time. Slices without
/// position are all at places of their own, in the order of their numbers.
fn clusters(slices: &[Slice]) -> Vec<Vec<Slice>> {
    let normal = normal(slices[0].frame());
    let along = |slice: &Slice| slice.frame().position.map_or(0.0, |p| normal.dot(p));
    let mut sorted = slices.to_vec();
    let places = slices[0].frame().position.is_some();
    if !places {
        sorted.sort_by_key(|slice| slice.frame().order);
        return sorted.into_iter().map(|slice| vec![slice]).collect();
    }
    sorted.sort_by(|a, b| along(a).total_cmp(&along(b)));
    // A hundredth of a pixel apart is the same place.
    let same = 0.01 * slices[0].frame().spacing[0].min(slices[0].frame().spacing[1]);
    let mut clusters: Vec<Vec<Slice>> = Vec::new();
    for slice in sorted {
        match clusters.last_mut() {
            Some(cluster) if along(&slice) - along(&cluster[0]) <= same => cluster.push(slice),
            _ => clusters.push(vec![slice]),
        }
    }
    for cluster in &mut clusters {
        cluster.sort_by_key(|slice| slice.frame().order);
    }
    clusters
}

/// How many slices every place has.
fn check_counts(clusters: &[Vec<Slice>]) -> Result<usize, ReadError> {
    let count = clusters[0].len();
    match clusters.iter().find(|cluster| cluster.len() != count) {
        None => Ok(count),
        Some(other) => {
            let place = |cluster: &[Slice]| format!("{} at the place of {}", cluster.len(), cluster[0].name());
            let what = format!(
                "its slices lie over each other unevenly: {}, {}",
                place(&clusters[0]),
                place(other)
            );
            Err(ReadError::unsupported(other[0].path(), what).hint(
                "a volume in time is incomplete, or images of several kinds share a series: put one kind in a folder",
            ))
        }
    }
}

/// The usual step: the lower median.
fn usual_step(along: &[f64]) -> f64 {
    let mut steps: Vec<f64> = along.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps[(steps.len() - 1) / 2]
}

/// Whether the slices at `positions` lie evenly; the worst deviation is told.
fn check_even(
    slices: &[Slice],
    positions: &[DVec3],
    step: DVec3,
    normal: DVec3,
    notes: &mut Vec<String>,
) -> Result<(), ReadError> {
    let along: Vec<f64> = positions.iter().map(|p| normal.dot(*p)).collect();
    let usual = usual_step(&along);
    for (i, pair) in along.windows(2).enumerate() {
        if pair[1] - pair[0] > GAP * usual {
            return Err(gap(&slices[i], &slices[i + 1], [pair[0], pair[1]], usual));
        }
    }
    let mean = normal.dot(step);
    let mut worst = (0.0, 0);
    for (i, slice) in slices.iter().enumerate() {
        let off = positions[i] - (positions[0] + step * i as f64);
        check_lateral(slice, off - normal * normal.dot(off))?;
        if normal.dot(off).abs() > worst.0 {
            worst = (normal.dot(off).abs(), i);
        }
    }
    let (off, slice) = (worst.0, &slices[worst.1]);
    if off > MAX_OFF * mean {
        let what = format!(
            "its slices lie unevenly: {} is {off:.3} mm off its even place, they are {mean:.3} mm apart",
            slice.name()
        );
        return Err(ReadError::unsupported(slice.path(), what).hint("resample them, with --resample"));
    }
    // A thousandth of the distance is the rounding of positions in text.
    if off > 1e-3 * mean {
        notes.push(format!(
            "slices are {mean:.4} mm apart on average; the worst, {}, is {off:.4} mm off its even place",
            slice.name()
        ));
    }
    Ok(())
}

fn gap(before: &Slice, after: &Slice, along: [f64; 2], usual: f64) -> ReadError {
    let what = format!(
        "slices are missing between {} and {}: at {:.3} and {:.3} mm along their normal they are {:.3} mm apart, others {usual:.3} mm",
        before.name(),
        after.name(),
        along[0],
        along[1],
        along[1] - along[0]
    );
    ReadError::unsupported(after.path(), what).hint("add the missing slices, or interpolate them with --resample")
}

/// Whether a slice lies over the others: within a pixel.
fn check_lateral(slice: &Slice, off: DVec3) -> Result<(), ReadError> {
    let frame = slice.frame();
    match off.length() <= frame.spacing[0].max(frame.spacing[1]) {
        true => Ok(()),
        false => {
            let what = format!(
                "{} does not lie over the other slices: it is {:.3} mm aside",
                slice.name(),
                off.length()
            );
            Err(ReadError::unsupported(slice.path(), what).hint("put only slices that belong together in a folder"))
        }
    }
}

fn tell_tilt(step: DVec3, normal: DVec3, notes: &mut Vec<String>) {
    let tilt = normal.angle_between(step);
    if tilt > TOLD_TILT {
        notes.push(format!(
            "slices are tilted by {:.2}° against their normal; the volume is sheared so",
            tilt.to_degrees()
        ));
    }
}
