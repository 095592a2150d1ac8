//! What the pixels of opaque meshes may be.
//!
//! *Theory.* A pixel shows one of the triangles that may cover its centre and that no other is surely in front of. For each of them
//! the shader's steps are walked in intervals over the part that the pixel may show.
//! *Practice.* Where no triangle covers the centre wherever its corners are put, the background may show too.

use glam::DVec2;
use rayon::prelude::*;

use super::mesh_paint::{Paint, tested};
use super::outline::{Outline, Seen};
use super::precision::{Precision, ULP};
use super::source::Spans;
use super::span::Span;
use crate::image::Frame;
use crate::projection::Mode;
use crate::render::DepthScale;
use crate::surface::{Mesh, MeshLook, SurfaceView};

/// What one triangle may look like at one pixel.
#[derive(Clone, Copy, Debug)]
struct Choice {
    /// Its number in depth tests.
    tested: Span,
    depth_mm: Span,
    color: [Span; 3],
    covers: bool,
}

impl Choice {
    const ANYTHING: Self = Self {
        tested: Span::ALL,
        depth_mm: Span::ALL,
        color: [Span::ALL; 3],
        covers: false,
    };
}

/// What each pixel of some meshes may be.
pub struct MeshBounds {
    pixels: Vec<Vec<Choice>>,
    scale: DepthScale,
}

impl MeshBounds {
    /// The bounds of `meshes`, seen in `view` by a device of `precision` that tests depths on `scale`.
    pub fn new(view: &SurfaceView, meshes: &[(&Mesh, MeshLook)], scale: &DepthScale, precision: &Precision) -> Self {
        let paints: Vec<Paint> = meshes
            .iter()
            .flat_map(|(mesh, look)| {
                (0..mesh.triangles.len()).filter_map(|n| Paint::new(view, mesh, look, n, scale, precision))
            })
            .collect();
        let [width, height] = view.camera.size;
        let rows = (0..height).into_par_iter();
        let pixels = rows.flat_map_iter(|y| {
            let mut row = vec![Vec::new(); width as usize];
            for paint in &paints {
                add(&mut row, y, paint, view.camera.size);
            }
            row.into_iter().map(possible)
        });
        Self {
            pixels: pixels.collect(),
            scale: *scale,
        }
    }

    /// How many pixels of `frame` (see [`SliceRenderer::draw_meshes`](crate::render::SliceRenderer::draw_meshes)) cannot be so.
    pub fn pixels_outside(&self, frame: &Frame) -> usize {
        let pixels = self.pixels.iter().zip(frame.pixels());
        pixels.filter(|(choices, pixel)| !admits(choices, pixel)).count()
    }

    /// How many of `depths_mm` (infinite where there is no mesh) cannot be so.
    pub fn depths_outside(&self, depths_mm: &[f32]) -> usize {
        let admitted = |choices: &[Choice], depth: f32| {
            if depth == f32::INFINITY {
                return may_be_empty(choices);
            }
            choices.iter().any(|choice| holds(choice.depth_mm, depth))
        };
        let pixels = self.pixels.iter().zip(depths_mm);
        pixels.filter(|(choices, depth)| !admitted(choices, **depth)).count()
    }

    /// How many pixels surely show a mesh.
    pub fn covered(&self) -> usize {
        self.pixels.iter().filter(|choices| !may_be_empty(choices)).count()
    }

    /// The mean width of the colours of pixels that surely show one triangle.
    pub fn mean_width(&self) -> f64 {
        let single = self
            .pixels
            .iter()
            .filter(|choices| choices.len() == 1 && choices[0].covers);
        let widths: Vec<f64> = single.flat_map(|choices| choices[0].color.map(Span::width)).collect();
        widths.iter().sum::<f64>() / widths.len().max(1) as f64
    }

    /// What pixel `n`, counted from the top left, may be if what is in front of the meshes is `front`.
    pub(super) fn behind(&self, n: usize, mode: Mode, front: &Spans) -> Spans {
        let choices = &self.pixels[n];
        let mut pixel = if may_be_empty(choices) {
            *front
        } else {
            [Span::EMPTY; 4]
        };
        for choice in choices {
            let composed = over_surface(mode, front, &choice.color);
            pixel = std::array::from_fn(|c| pixel[c].hull(composed[c]));
        }
        pixel
    }

    /// How often a slice at a depth that is off by `off_mm` at most is drawn at pixel `n`, at least and at most.
    pub(super) fn times(&self, n: usize, depth_mm: f64, off_mm: f64) -> [u32; 2] {
        let slice = tested(&self.scale, depth_mm, off_mm);
        let choices = &self.pixels[n];
        let empty = if may_be_empty(choices) { Span::ONE } else { Span::EMPTY };
        let held = choices.iter().fold(empty, |all, choice| all.hull(choice.tested));
        [u32::from(slice.hi < held.lo), u32::from(slice.lo < held.hi)]
    }
}

/// The interval extension of [`composite::over_surfaces`](crate::projection::composite::over_surfaces) for one pixel: a difference, a
/// product and a sum in single precision.
fn over_surface(mode: Mode, front: &Spans, surface: &[Span; 3]) -> Spans {
    let through = match mode {
        Mode::Composite => Span::ONE - front[3],
        Mode::Additive => Span::ONE,
        Mode::Mip | Mode::MinIp | Mode::Average | Mode::XRay => Span::ONE - front[0],
    };
    let [r, g, b] = [0, 1, 2].map(|c| {
        let passed = (through * surface[c]).relaxed(2.0 * ULP);
        (front[c] + passed).relaxed(ULP).rounded()
    });
    [r, g, b, Span::ONE]
}

/// Adds what `paint` may be in row `y`.
fn add(row: &mut [Vec<Choice>], y: u32, paint: &Paint, size: [u32; 2]) {
    let outline: &Outline = &paint.outline;
    let [columns, rows] = outline.reach(size);
    if !(rows[0]..rows[1]).contains(&y) {
        return;
    }
    for x in columns[0]..columns[1] {
        let center = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        match outline.seen(center) {
            Seen::Nothing => {}
            Seen::Anything => row[x as usize].push(Choice::ANYTHING),
            Seen::Part(part) => row[x as usize].push(Choice {
                tested: paint.tested(&part),
                depth_mm: paint.depth(&part),
                color: paint.color(&part, center),
                covers: outline.covers(center),
            }),
        }
    }
}

/// The choices that none covers from in front.
fn possible(mut choices: Vec<Choice>) -> Vec<Choice> {
    let covering = choices.iter().filter(|choice| choice.covers);
    let nearest = covering.map(|choice| choice.tested.hi).fold(f64::INFINITY, f64::min);
    choices.retain(|choice| choice.tested.lo <= nearest);
    choices
}

fn may_be_empty(choices: &[Choice]) -> bool {
    !choices.iter().any(|choice| choice.covers)
}

fn admits(choices: &[Choice], pixel: &[f32; 4]) -> bool {
    let [r, g, b, alpha] = *pixel;
    if alpha == 0.0 {
        return may_be_empty(choices) && [r, g, b] == [0.0; 3];
    }
    let shows = |choice: &Choice| choice.color.iter().zip([r, g, b]).all(|(span, c)| holds(*span, c));
    alpha == 1.0 && choices.iter().any(shows)
}

/// Whether `span` has a number that is stored as `v`.
fn holds(span: Span, v: f32) -> bool {
    (span.lo as f32).next_down() <= v && v <= (span.hi as f32).next_up()
}
