//! From samples to what is blended: colours and opacities, lit, or values.

use super::blend::{self, Pixels};
use super::bundle::{Lanes, RAYS, SAMPLES, each, whole_f32};
use super::light::{Cue, Lights};
use super::sample::Places;
use super::voxels::{CastBlock, ONE};
use crate::projection::composite::Blending;
use crate::projection::{FrameSpec, Mode, TransferTable};

/// What is blended of each sample: nothing of those that are not in the box.
pub type Sources = [[f32; 4]; SAMPLES];

/// The entry behind a table's last one: nothing shows.
const NOTHING: usize = TransferTable::LEN;

/// A transfer table's entries, and [`NOTHING`].
type Table = [[f32; 4]; TransferTable::LEN + 1];

/// How the samples of a frame are classified and lit.
pub struct Classifier {
    mode: Mode,
    blending: Blending,
    table: Box<Table>,
    /// Entry `i` counts the entries before `i` that show.
    shown_before: Vec<u32>,
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f32>,
    lights: Option<Lights>,
    cue: Cue,
}

/// Where samples of a frame are.
pub struct Bundle<'a> {
    pub block: &'a CastBlock,
    pub places: Places,
    /// Which samples are in the box.
    pub inside: [bool; SAMPLES],
    /// The first plane.
    pub plane: i32,
    /// Millimetres of each ray a millimetre of depth.
    pub paths: [f32; RAYS],
}

impl Classifier {
    /// For the frame of `spec`, with its depth cue.
    pub fn new(spec: &FrameSpec, cue: Cue) -> Self {
        let table = table(spec);
        let counts = table.iter().scan(0, |count, entry| {
            *count += u32::from(entry[3] > 0.0);
            Some(*count)
        });
        let shown_before = std::iter::once(0).chain(counts).collect();
        Self {
            mode: spec.settings.mode,
            blending: spec.settings.mode.blending(),
            shown_before,
            table,
            slab_units: spec.slab_units().map(|units| units as f32),
            lights: spec.shading().map(|shading| Lights::new(spec, shading)),
            cue,
        }
    }

    /// What is blended of samples behind `pixels`; `None` where none of them shows.
    #[inline(always)]
    pub fn sources(&self, bundle: &Bundle, pixels: &Pixels) -> Option<Sources> {
        let weighted = bundle.places.interpolate(bundle.block, &bundle.block.weighted);
        if !self.mode.classifies() {
            return Some(self.values(bundle, &weighted));
        }
        let colours = match self.slab_units {
            Some(units) => self.colours(bundle, &weighted, units),
            None => self.classified(bundle, &weighted),
        }?;
        Some(match self.mode {
            Mode::XRay => colours.map(|c| [c[3]; 4]),
            _ if self.is_plain() => colours,
            _ => self.lit(bundle, pixels, colours),
        })
    }

    /// Whether colours are what the table says.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.lights.is_none() && self.cue.strength == 0.0
    }

    /// What value modes accumulate: see [`value_source`](crate::projection::composite::value_source).
    #[inline(always)]
    fn values(&self, bundle: &Bundle, weighted: &Lanes) -> Sources {
        let coverage = bundle.coverage().unwrap_or([ONE; SAMPLES]);
        let mut sources = [[0.0; 4]; SAMPLES];
        for n in 0..SAMPLES {
            let (weighted, coverage) = (weighted[n] / ONE, coverage[n] / ONE);
            let path = bundle.paths[n % RAYS];
            let (value, weight) = match self.mode {
                Mode::MinIp => (coverage - weighted, coverage),
                Mode::Average => (weighted * path, coverage * path),
                _ => (weighted, coverage),
            };
            if bundle.inside[n] {
                sources[n] = [value, value, value, weight];
            }
        }
        sources
    }

    /// Table entries for the path, times coverage.
    #[inline(always)]
    fn classified(&self, bundle: &Bundle, weighted: &Lanes) -> Option<Sources> {
        let coverage = bundle.coverage();
        let entries = self.entries(bundle, weighted, coverage.as_ref())?;
        let mut sources = entries.map(|entry| self.table[(entry as usize).min(NOTHING)]);
        if bundle.paths != [1.0; RAYS] {
            for (n, source) in sources.iter_mut().enumerate() {
                *source = lengthened(*source, bundle.paths[n % RAYS]);
            }
        }
        if let Some(coverage) = &coverage {
            for (source, coverage) in sources.iter_mut().zip(coverage) {
                *source = source.map(|c| c * (coverage / ONE));
            }
        }
        Some(sources)
    }

    /// The table's entry for each sample; `None` if none of those between the least and the greatest shows.
    #[inline(always)]
    fn entries(&self, bundle: &Bundle, weighted: &Lanes, coverage: Option<&Lanes>) -> Option<[i32; SAMPLES]> {
        const LAST: f32 = (TransferTable::LEN - 1) as f32;
        let places = match coverage {
            None => each(|n| weighted[n] * (LAST / ONE)),
            // Where nothing is covered the quotient is any number, and its colour weighs nothing.
            Some(c) => each(|n| smaller(weighted[n] / larger(c[n], f32::MIN_POSITIVE), 1.0) * LAST),
        };
        let (mut least, mut greatest) = (NOTHING as i32, 0);
        let mut entries = [0; SAMPLES];
        for n in 0..SAMPLES {
            let entry = whole_f32(places[n]);
            entries[n] = if bundle.inside[n] { entry } else { NOTHING as i32 };
            least = least.min(entries[n]);
            greatest = greatest.max(if bundle.inside[n] { entry } else { 0 });
        }
        let before = |entry: i32| self.shown_before[(entry as usize).min(NOTHING)];
        (before(greatest + 1) > before(least)).then_some(entries)
    }

    /// Colours that are classified already, for a path of so many unit lengths a millimetre of depth.
    #[inline(always)]
    fn colours(&self, bundle: &Bundle, weighted: &Lanes, units: f32) -> Option<Sources> {
        let mut sources = [[0.0; 4]; SAMPLES];
        let mut shows = false;
        for n in 0..SAMPLES {
            if bundle.inside[n] && weighted[n] > 0.0 {
                let [r, g, b, _] = bundle.places.vector(bundle.block, &bundle.block.rgb, n);
                // Rounding may bring a colour above its opacity.
                let [r, g, b] = [r, g, b].map(|c| smaller(c, weighted[n]));
                let colour = [r, g, b, weighted[n]].map(|c| c / ONE);
                sources[n] = lengthened(colour, units * bundle.paths[n % RAYS]);
                shows = true;
            }
        }
        shows.then_some(sources)
    }

    /// Colours with light and depth cue, where they show.
    #[inline(always)]
    fn lit(&self, bundle: &Bundle, pixels: &Pixels, colours: Sources) -> Sources {
        let (factor, highlight) = match &self.lights {
            Some(lights) => {
                let shown = blend::shown(self.blending, pixels, &colours);
                lights.response(&bundle.normals(&shown))
            }
            None => ([1.0; SAMPLES], [0.0; SAMPLES]),
        };
        let cue = each(|n| self.cue.at(bundle.plane + (n / RAYS) as i32));
        let mut lit = [[0.0; 4]; SAMPLES];
        for n in 0..SAMPLES {
            let [r, g, b, a] = colours[n];
            let light = |c: f32| cue[n] * (factor[n] * c + highlight[n] * a);
            lit[n] = [light(r), light(g), light(b), a];
        }
        lit
    }
}

impl Bundle<'_> {
    /// The coverage of each sample in parts of [`ONE`]; `None` where it is 1.
    #[inline(always)]
    fn coverage(&self) -> Option<Lanes> {
        let coverage = &self.block.coverage;
        (!coverage.is_empty()).then(|| self.places.interpolate(self.block, coverage))
    }

    /// The soft normals of the samples that show.
    #[inline(always)]
    fn normals(&self, shown: &[bool; SAMPLES]) -> [[f32; 4]; SAMPLES] {
        let stored = &self.block.normals[..];
        let mut normals = [[0.0; 4]; SAMPLES];
        for (n, normal) in normals.iter_mut().enumerate() {
            if shown[n] {
                *normal = self.places.vector(self.block, stored, n);
            }
        }
        normals
    }
}

/// The table of a frame, and [`NOTHING`].
fn table(spec: &FrameSpec) -> Box<Table> {
    let mut table = Box::new([[0.0; 4]; TransferTable::LEN + 1]);
    for (entry, of) in table.iter_mut().zip(spec.table().entries()) {
        *entry = *of;
    }
    table
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

/// The smaller of two numbers. What `f32::min` makes of NaN costs more.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
