//! From samples to what is blended: colours and opacities, lit, or values.

use std::ops::Range;

use glam::Vec3;

use super::lanes::{LANES, Lanes, each};
use super::rays::Rays;
use super::sample::{Places, Samples};
use super::voxels::CastBlock;
use crate::projection::{FrameSpec, Mode, Shading, TransferTable, eye_from_lattice};

/// What is blended of each sample.
pub type Sources = [[f32; 4]; LANES];

/// How the samples of a frame are classified and lit.
pub struct Classifier {
    mode: Mode,
    table: Vec<[f32; 4]>,
    /// The opacities of the table once more: most samples need no more of it.
    opacities: Vec<f32>,
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f32>,
    lights: Option<Lights>,
    cue: Cue,
}

/// Where samples of a frame are.
pub struct Run<'a> {
    pub block: &'a CastBlock,
    pub places: Places,
    /// The lanes that are samples.
    pub lanes: Range<usize>,
    /// The plane of lane 0.
    pub plane: i32,
    /// Millimetres of ray a millimetre of depth.
    pub path: f32,
}

impl Classifier {
    /// For the frame of `spec`.
    pub fn new(spec: &FrameSpec, rays: &Rays) -> Self {
        let table = spec.table().entries().to_vec();
        Self {
            mode: spec.settings.mode,
            opacities: table.iter().map(|entry| entry[3]).collect(),
            table,
            slab_units: spec.slab_units().map(|units| units as f32),
            lights: spec.shading().map(|shading| Lights::new(spec, shading)),
            cue: Cue::new(spec, rays),
        }
    }

    /// What is blended of samples; `None` where none of them shows.
    #[inline(always)]
    pub fn sources(&self, run: &Run) -> Option<Sources> {
        let samples = Samples::new(run.block, &run.places);
        if !self.mode.classifies() {
            return Some(self.values(run, &samples));
        }
        let colours = match self.slab_units {
            Some(units) => self.colours(run, &samples, units * run.path),
            None => self.classified(run, &samples),
        }?;
        Some(match self.mode {
            Mode::XRay => colours.map(|c| [c[3]; 4]),
            _ if self.is_plain() => colours,
            _ => self.lit(run, colours),
        })
    }

    /// Whether colours are what the table says.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.lights.is_none() && self.cue.strength == 0.0
    }

    /// What value modes accumulate: see [`value_source`](crate::projection::composite::value_source).
    #[inline(always)]
    fn values(&self, run: &Run, samples: &Samples) -> Sources {
        let coverage = samples.coverage.unwrap_or([1.0; LANES]);
        let mut sources = [[0.0; 4]; LANES];
        for n in run.lanes.clone() {
            let (weighted, coverage) = (samples.weighted[n], coverage[n]);
            let (value, weight) = match self.mode {
                Mode::MinIp => (coverage - weighted, coverage),
                Mode::Average => (weighted * run.path, coverage * run.path),
                _ => (weighted, coverage),
            };
            sources[n] = [value, value, value, weight];
        }
        sources
    }

    /// Table entries for the path, times coverage.
    #[inline(always)]
    fn classified(&self, run: &Run, samples: &Samples) -> Option<Sources> {
        const LAST: f32 = (TransferTable::LEN - 1) as f32;
        let fraction = samples.fraction();
        let mut entry = [0usize; LANES];
        for n in 0..LANES {
            entry[n] = (fraction[n].clamp(0.0, 1.0) * LAST + 0.5) as i32 as usize;
        }
        // Lanes that are no samples repeat one that is.
        if !entry.iter().any(|&n| self.opacities[n] > 0.0) {
            return None;
        }
        let mut sources = [[0.0; 4]; LANES];
        for n in 0..LANES {
            sources[n] = self.table[entry[n]];
        }
        if run.path != 1.0 {
            sources = sources.map(|source| lengthened(source, run.path));
        }
        if let Some(coverage) = &samples.coverage {
            for n in 0..LANES {
                sources[n] = sources[n].map(|c| c * coverage[n]);
            }
        }
        Some(sources)
    }

    /// Colours that are classified already, for a path of so many unit lengths.
    #[inline(always)]
    fn colours(&self, run: &Run, samples: &Samples, units: f32) -> Option<Sources> {
        let mut sources = [[0.0; 4]; LANES];
        let mut shows = false;
        for n in run.lanes.clone() {
            let opacity = samples.weighted[n];
            if opacity > 0.0 {
                let [r, g, b, _] = run.places.vector(run.block, &run.block.rgb, n);
                // Rounding may bring a colour above its opacity.
                let [r, g, b] = [r, g, b].map(|c| c.min(opacity));
                sources[n] = lengthened([r, g, b, opacity], units);
                shows = true;
            }
        }
        shows.then_some(sources)
    }

    /// Colours with light and depth cue.
    #[inline(always)]
    fn lit(&self, run: &Run, colours: Sources) -> Sources {
        let (factor, highlight) = match &self.lights {
            Some(lights) => lights.response(&normals(run, &colours)),
            None => ([1.0; LANES], [0.0; LANES]),
        };
        let mut lit = [[0.0; 4]; LANES];
        for n in 0..LANES {
            let [r, g, b, a] = colours[n];
            let cue = self.cue.at(run.plane + n as i32);
            let light = |c: f32| cue * (factor[n] * c + highlight[n] * a);
            lit[n] = [light(r), light(g), light(b), a];
        }
        lit
    }
}

/// The soft normals of the samples that show, axis by axis.
#[inline(always)]
fn normals(run: &Run, colours: &Sources) -> [Lanes; 3] {
    let mut normals = [[0.0; LANES]; 3];
    for n in run.lanes.clone() {
        if colours[n][3] > 0.0 {
            let [x, y, z, _] = run.places.vector(run.block, &run.block.normals, n);
            [normals[0][n], normals[1][n], normals[2][n]] = [x, y, z];
        }
    }
    normals
}

/// See [`lengthened`](crate::projection::table::lengthened).
#[inline(always)]
fn lengthened([r, g, b, a]: [f32; 4], length: f32) -> [f32; 4] {
    if length == 1.0 || a <= 0.0 {
        return [r, g, b, a];
    }
    let longer = 1.0 - (1.0 - a).max(0.0).powf(length);
    let scale = longer / a;
    [r * scale, g * scale, b * scale, longer]
}

/// Lights and material, for normals in the world: see [`Shading::response`].
struct Lights {
    /// Towards each light, half-way between light and eye, and intensity.
    lights: Vec<(Vec3, Vec3, f32)>,
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess_log2: u32,
}

impl Lights {
    fn new(spec: &FrameSpec, shading: &Shading) -> Self {
        let world_from_eye = spec.camera.eye_from_world.matrix3.transpose();
        let light = |light: &crate::projection::Light| {
            let half_way = (light.towards - glam::DVec3::Z).normalize_or_zero();
            let [towards, half_way] = [light.towards, half_way].map(|v| (world_from_eye * v).as_vec3());
            (towards, half_way, light.intensity)
        };
        let material = &shading.material;
        Self {
            lights: shading.lights.iter().map(light).collect(),
            ambient: material.ambient,
            diffuse: material.diffuse,
            specular: material.specular,
            shininess_log2: material.shininess_log2,
        }
    }

    /// The factor of a colour and the white highlight for each soft normal.
    #[inline(always)]
    fn response(&self, m: &[Lanes; 3]) -> (Lanes, Lanes) {
        let along = |v: &Vec3| each(|n| (m[0][n] * v.x + m[1][n] * v.y + m[2][n] * v.z).abs());
        let (mut diffuse, mut specular) = ([0.0; LANES], [0.0; LANES]);
        for (towards, half_way, intensity) in &self.lights {
            let facing = along(towards);
            let mut shine = along(half_way);
            for _ in 0..self.shininess_log2 {
                shine = each(|n| shine[n] * shine[n]);
            }
            diffuse = each(|n| diffuse[n] + intensity * facing[n]);
            specular = each(|n| specular[n] + intensity * shine[n]);
        }
        let length = each(|n| (m[0][n] * m[0][n] + m[1][n] * m[1][n] + m[2][n] * m[2][n]).sqrt());
        let factor = each(|n| (1.0 - length[n]) + self.ambient * length[n] + self.diffuse * diffuse[n]);
        (factor, each(|n| self.specular * specular[n]))
    }
}

/// The depth cue by plane number: see [`DepthCue::factor`](crate::projection::DepthCue::factor).
struct Cue {
    strength: f32,
    /// How far the first plane is on the way from the nearest to the farthest point, and how far a plane is from the next.
    first: f32,
    step: f32,
}

impl Cue {
    fn new(spec: &FrameSpec, rays: &Rays) -> Self {
        let lattice = &spec.target.lattice;
        let depths = lattice.bounds().transformed(&eye_from_lattice(lattice, spec.camera));
        let span = (depths.max.z - depths.min.z).max(f64::MIN_POSITIVE);
        let [first_mm, step_mm] = rays.depth_mm();
        Self {
            strength: spec.settings.depth_cue.strength,
            first: ((first_mm - depths.min.z) / span) as f32,
            step: (step_mm / span) as f32,
        }
    }

    #[inline(always)]
    fn at(&self, plane: i32) -> f32 {
        let t = self.first + plane as f32 * self.step;
        1.0 - self.strength * t.clamp(0.0, 1.0)
    }
}
