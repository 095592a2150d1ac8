//! What one triangle may look like: the mesh shaders' steps, in intervals.

use glam::{DVec2, DVec3};

use super::light::LightSpans;
use super::outline::{Outline, Part};
use super::precision::{Precision, ULP};
use super::span::Span;
use crate::interface::FLAT_ABOVE;
use crate::projection::{Camera, Lens};
use crate::render::DepthScale;
use crate::surface::{Mesh, MeshColor, MeshLook, MeshShading, SurfaceView, unit_normal};

/// What is as good as no normal, see [`FLAT_ABOVE`].
const LEAST: f64 = 1.0 / FLAT_ABOVE as f64;

/// A triangle, and all that its pixels depend on.
pub(super) struct Paint {
    /// Where it is in the frame.
    pub outline: Outline,
    /// World, millimetres.
    places: [DVec3; 3],
    /// World, of length 1, or zero.
    normals: [DVec3; 3],
    rgb: [DVec3; 3],
    depths: [f64; 3],
    shading: MeshShading,
    lights: Option<LightSpans>,
    cue: Cue,
    /// What rounding adds to a place along the cue.
    off_cue: f64,
    scale: DepthScale,
    camera: Camera,
    /// What a depth is off at most, millimetres.
    off_mm: f64,
    /// What interpolation adds, relative to the largest of what is interpolated over w.
    interpolated: f64,
}

#[derive(Clone, Copy)]
struct Cue {
    near_mm: f64,
    span_mm: f64,
    strength: f64,
}

impl Paint {
    /// Triangle `n` of `mesh`; `None` if it is not drawn.
    pub fn new(
        view: &SurfaceView,
        mesh: &Mesh,
        look: &MeshLook,
        n: usize,
        scale: &DepthScale,
        precision: &Precision,
    ) -> Option<Self> {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let triangle = mesh.triangles[n].map(|v| v as usize);
        let places = triangle.map(|v| vector(mesh.positions[v]));
        // Two corners at one place are at one place of the grid too.
        if places[0] == places[1] || places[1] == places[2] || places[2] == places[0] {
            return None;
        }
        let eye = &view.camera.eye_from_world;
        let corners = places.map(|place| eye.transform_point3(place));
        // A product with a rounded factor and a sum for each of the four terms of a part.
        let terms = |p: DVec3| (0..3).map(move |a| eye.matrix3.row(a).abs().dot(p.abs()) + eye.translation[a].abs());
        let off_mm = 8.0 * ULP * places.into_iter().flat_map(terms).fold(0.0, f64::max);
        let outline = Outline::new(view.camera, &corners, off_mm, precision)?;
        let farthest_mm = corners.iter().map(|corner| corner.z.abs()).fold(0.0, f64::max);
        let cue = Cue::new(view);
        let lights = view.settings.shading.as_ref();
        Some(Self {
            // A numerator, a denominator, and their quotient. To begin with a place, two rounded gradients, each times a way.
            interpolated: 2.0 * (precision.interpolated + 4.0 * ULP * outline.heights(view.camera.size)) + 3.0 * ULP,
            outline,
            places,
            normals: triangle.map(|v| mesh.normals.get(v).map_or(DVec3::ZERO, |n| unit_normal(*n))),
            rgb: triangle.map(|v| match look.color {
                MeshColor::Uniform(rgb) => vector(rgb),
                MeshColor::OfVertices => mesh.colors.get(v).map_or(DVec3::ONE, |c| {
                    DVec3::from_array([0, 1, 2].map(|i| f64::from(c[i]) / 255.0))
                }),
            }),
            depths: corners.map(|corner| corner.z),
            shading: look.shading,
            lights: lights.map(|shading| LightSpans::new(view.camera, shading, precision)),
            // Depth, its distance from where the cue begins, and the span of it: three operations on rounded numbers.
            off_cue: (off_mm + 6.0 * ULP * (farthest_mm + cue.near_mm.abs())) / cue.span_mm,
            cue,
            scale: *scale,
            camera: *view.camera,
            off_mm,
        })
    }

    /// What is interpolated of `corners` over a part of the triangle.
    fn over(&self, part: &Part, corners: [f64; 3]) -> Span {
        let at = |w: &DVec3| w.dot(DVec3::from_array(corners));
        let all = part.weights.iter().fold(Span::EMPTY, |all, w| all.with(at(w)));
        let largest = corners.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        all.widened((part.w_ratio * self.interpolated + ULP) * largest)
    }

    /// Depth, millimetres.
    pub fn depth(&self, part: &Part) -> Span {
        self.over(part, self.depths).widened(self.off_mm)
    }

    /// The number for depth tests: a product, a sum and a quotient with rounded factors, interpolated.
    pub fn tested(&self, part: &Part) -> Span {
        let mut all = Span::EMPTY;
        for w in &part.weights {
            let depth = w.dot(DVec3::from_array(self.depths));
            all = all.hull(tested(&self.scale, depth, self.off_mm));
        }
        all.widened(self.interpolated + ULP)
    }

    /// Red, green and blue at the pixel with this centre.
    pub fn color(&self, part: &Part, center: DVec2) -> [Span; 3] {
        let has = self.normals.map(|n| f64::from(u8::from(n != DVec3::ZERO)));
        let has = self.over(part, has);
        let (normal, size) = self.mean_normal(part);
        let phong = self.shading == MeshShading::Phong;
        let may_be_flat = has.lo <= 1.0 - LEAST || phong && size.lo <= LEAST;
        let may_be_round = has.hi > 1.0 - LEAST && !(phong && size.hi <= LEAST);
        let mut color = [Span::EMPTY; 3];
        let mut add = |other: [Span; 3]| color = std::array::from_fn(|c| color[c].hull(other[c]));
        if may_be_flat {
            add(self.lit_at(part, &self.plane(part, center)));
        }
        if may_be_round && phong {
            add(self.lit_at(part, &normal));
        }
        if may_be_round && !phong {
            add(self.gouraud(part));
        }
        color
    }

    /// The mean normal at length 1, and its length before.
    fn mean_normal(&self, part: &Part) -> ([Span; 3], Span) {
        let mean = [0, 1, 2].map(|a| self.over(part, self.normals.map(|n| n[a])));
        let squares = mean.map(Span::squared);
        let size = (squares[0] + squares[1] + squares[2])
            .rising(f64::sqrt)
            .relaxed(6.0 * ULP);
        if size.lo <= 0.0 {
            return ([Span::new(-1.0, 1.0); 3], size);
        }
        let one_over = Span::new(size.hi.recip(), size.lo.recip());
        (mean.map(|part| (part * one_over).relaxed(4.0 * ULP)), size)
    }

    /// The triangle's plane, of which a device has differences between neighbouring pixels. Each is off by what two interpolated
    /// places are.
    fn plane(&self, part: &Part, center: DVec2) -> [Span; 3] {
        let [a, b, c] = self.places;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let farthest = self.places.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let off_mm = 2.0 * 3f64.sqrt() * (part.w_ratio * self.interpolated + ULP) * farthest;
        let eye_normal = self.camera.eye_from_world.matrix3 * normal;
        let corner = self.camera.eye_from_world.transform_point3(a);
        // The product of two differences a and b is off by (|a| + |b|) · off and off², relative to itself. A triangle that is not thin
        // keeps half its area on the grid, and a vector at length 1 is off by twice what it is off relatively.
        let off = off_mm * across(&self.camera, eye_normal, corner, center);
        let by = 4.0 * (off + off * off) + 8.0 * ULP;
        // (A comparison with what is no number is false.)
        if by < 1.0 && !self.outline.is_thin() {
            normal.to_array().map(|part| Span::around(part, by))
        } else {
            [Span::new(-1.0, 1.0); 3]
        }
    }

    fn lit_at(&self, part: &Part, normal: &[Span; 3]) -> [Span; 3] {
        let rgb = [0, 1, 2].map(|c| self.over(part, self.rgb.map(|rgb| rgb[c])));
        self.lit(
            rgb,
            normal,
            self.over(part, self.depths.map(|depth| self.cue.along(depth))),
        )
    }

    /// Vertices are lit, and their colours interpolated.
    fn gouraud(&self, part: &Part) -> [Span; 3] {
        let corners = [0, 1, 2].map(|v| {
            let rgb = self.rgb[v].to_array().map(Span::point);
            let normal = self.normals[v].to_array().map(|part| Span::point(part).relaxed(ULP));
            self.lit(rgb, &normal, Span::point(self.cue.along(self.depths[v])))
        });
        [0, 1, 2].map(|c| {
            let ends = |end: fn(Span) -> f64| corners.map(|corner| end(corner[c]));
            Span::new(
                self.over(part, ends(|span| span.lo)).lo,
                self.over(part, ends(|span| span.hi)).hi,
            )
        })
    }

    /// What colours of `rgb` become, so far along the depth cue.
    fn lit(&self, rgb: [Span; 3], normal: &[Span; 3], along: Span) -> [Span; 3] {
        let lights = self.lights.as_ref();
        let (factor, highlight) = lights.map_or((Span::ONE, Span::ZERO), |lights| lights.response(normal));
        let cue = self.cue.factor(along.widened(self.off_cue));
        // A rounded colour, two products and a sum.
        rgb.map(|c| {
            (cue * (factor * c.relaxed(ULP) + highlight))
                .relaxed(6.0 * ULP)
                .rounded()
        })
    }
}

impl Cue {
    fn new(view: &SurfaceView) -> Self {
        let [near_mm, far_mm] = view.cue_mm;
        Self {
            near_mm,
            span_mm: (far_mm - near_mm).max(f64::MIN_POSITIVE),
            strength: f64::from(view.settings.depth_cue.strength),
        }
    }

    /// How far along the cue a depth is: 0 where it begins, 1 where it ends.
    fn along(&self, depth_mm: f64) -> f64 {
        (depth_mm - self.near_mm) / self.span_mm
    }

    fn factor(&self, along: Span) -> Span {
        let within = along.rising(|t| t.clamp(0.0, 1.0));
        (Span::ONE - within.scaled(self.strength)).widened(2.0 * ULP)
    }
}

/// The number for depth tests of a depth that is off by `off_mm` at most: factor and summand are rounded, multiplied or divided, and
/// added.
pub(super) fn tested(scale: &DepthScale, depth_mm: f64, off_mm: f64) -> Span {
    let [product, summand] = scale.terms(depth_mm);
    let rounding = 4.0 * ULP * (product.abs() + summand.abs());
    Span::around(product + summand, rounding + scale.slope(depth_mm) * off_mm)
}

/// Of the vectors a and b between the points of a plane at neighbouring pixels, the largest of (|a| + |b|) / |a × b|, for every block of
/// 2 × 2 pixels with this one in it. Infinite where the plane is seen from the side.
fn across(camera: &Camera, normal: DVec3, corner: DVec3, center: DVec2) -> f64 {
    let point = |x: f64, y: f64| {
        let [base, slope] = ray(camera, center + DVec2::new(x, y));
        let depth = normal.dot(corner - base) / normal.dot(slope);
        (depth.is_finite() && depth > camera.near_mm().min(0.0)).then_some(base + depth * slope)
    };
    let mut most: f64 = 0.0;
    for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let [Some(here), Some(beside), Some(above), Some(both)] =
            [point(0.0, 0.0), point(x, 0.0), point(0.0, y), point(x, y)]
        else {
            return f64::INFINITY;
        };
        for a in [beside - here, both - above] {
            for b in [above - here, both - beside] {
                most = most.max((a.length() + b.length()) / a.cross(b).length());
            }
        }
    }
    most
}

/// Where the ray through a point of the frame begins, and how far it goes for each millimetre of depth.
fn ray(camera: &Camera, px: DVec2) -> [DVec3; 2] {
    let [width, height] = camera.size.map(f64::from);
    let off_axis = px - 0.5 * DVec2::new(width, height);
    match camera.lens {
        Lens::Orthographic { pixels_per_mm } => [(off_axis / pixels_per_mm).extend(0.0), DVec3::Z],
        Lens::Perspective { focal_px, .. } => [DVec3::ZERO, (off_axis / focal_px).extend(1.0)],
    }
}
