//! From samples to what is blended: colours and opacities, lit, or values.

use super::blend::Colours;
use super::light::{Cue, Lights};
use super::power::lengthen;
use super::sample::Places;
use super::simd::{Simd, each, larger, smaller};
use super::voxels::{CastBlock, NONE, ONE};
use crate::projection::{FrameSpec, Mode, TransferTable};

/// The entry behind a table's last one: nothing shows.
const NOTHING: usize = TransferTable::LEN;

/// A transfer table's entries, and [`NOTHING`].
type Table = [[f32; 4]; TransferTable::LEN + 1];

/// How the samples of a frame are classified and lit.
pub struct Classifier {
    mode: Mode,
    table: Box<Table>,
    /// The first entry that shows, and the last one; none does if the one is not before the other.
    shown: [i32; 2],
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f32>,
    lights: Option<Lights>,
    cue: Cue,
}

/// The samples of a packet at a plane, those of one block.
pub struct Bundle<'a, S: Simd> {
    pub block: &'a CastBlock,
    pub places: Places<S>,
    /// Which samples are in the box.
    pub inside: S::Mask,
    /// Which of them nothing is seen of.
    pub hidden: S::Mask,
    pub plane: i32,
    /// Millimetres of each ray a millimetre of depth; `None` where all are 1.
    pub paths: Option<S::Float>,
}

impl Classifier {
    /// For the frame of `spec`, with its depth cue.
    pub fn new(spec: &FrameSpec, table: &TransferTable, cue: Cue) -> Self {
        let mut entries = Box::new([[0.0; 4]; TransferTable::LEN + 1]);
        entries[..NOTHING].copy_from_slice(table.entries());
        let shows = |entry: &[f32; 4]| entry[3] > 0.0;
        let last = entries.iter().rposition(shows).unwrap_or(0);
        Self {
            mode: spec.settings.mode,
            shown: [entries.iter().position(shows).unwrap_or(NOTHING), last].map(|entry| entry as i32),
            table: entries,
            slab_units: spec.slab_units().map(|units| units as f32),
            lights: spec.shading().map(|shading| Lights::new(spec, shading)),
            cue,
        }
    }

    /// What is blended of samples; `None` where none of them shows.
    #[inline(always)]
    pub fn sources<S: Simd>(&self, bundle: &Bundle<S>) -> Option<Colours<S>> {
        let weighted = bundle.numbers(&bundle.block.weighted);
        if !self.mode.classifies() {
            return Some(self.values(bundle, weighted));
        }
        let colours = match self.slab_units {
            Some(units) => self.colours(bundle, weighted, units),
            None => self.classified(bundle, weighted),
        }?;
        Some(match self.mode {
            Mode::XRay => [colours[3]; 4],
            _ if self.is_plain() => colours,
            _ => self.lit(bundle, colours),
        })
    }

    /// Whether colours are what the table says.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.lights.is_none() && self.cue.strength == 0.0
    }

    /// What value modes accumulate: see [`value_source`](crate::projection::composite::value_source).
    #[inline(always)]
    fn values<S: Simd>(&self, bundle: &Bundle<S>, weighted: S::Float) -> Colours<S> {
        let one = S::float(1.0);
        let weighted = S::divide(weighted, S::float(ONE));
        let coverage = match bundle.coverage() {
            Some(coverage) => S::divide(coverage, S::float(ONE)),
            None => one,
        };
        let path = bundle.paths.unwrap_or(one);
        let (value, weight) = match self.mode {
            Mode::MinIp => (coverage - weighted, coverage),
            Mode::Average => (weighted * path, coverage * path),
            _ => (weighted, coverage),
        };
        let [value, weight] = each!(of of [value, weight] => S::choose(bundle.inside, of, S::float(0.0)));
        [value, value, value, weight]
    }

    /// Table entries for the path, times coverage.
    #[inline(always)]
    fn classified<S: Simd>(&self, bundle: &Bundle<S>, weighted: S::Float) -> Option<Colours<S>> {
        let coverage = bundle.coverage();
        let entries = self.entries::<S>(weighted, coverage);
        let beyond = S::greater_int(S::int(self.shown[0]), entries) | S::greater_int(entries, S::int(self.shown[1]));
        let seen = bundle.inside & !bundle.hidden & !beyond;
        if S::bits(seen) == 0 {
            return None;
        }
        let mut sources = S::entries(&self.table, S::choose_int(seen, entries, S::int(NOTHING as i32)));
        if let Some(paths) = bundle.paths {
            sources = lengthen::<S>(&sources, paths);
        }
        if let Some(coverage) = coverage {
            let coverage = S::divide(coverage, S::float(ONE));
            sources = each!(c of [0, 1, 2, 3] => sources[c] * coverage);
        }
        (S::bits(S::greater(sources[3], S::float(0.0))) != 0).then_some(sources)
    }

    /// The table's entry for each sample.
    #[inline(always)]
    fn entries<S: Simd>(&self, weighted: S::Float, coverage: Option<S::Float>) -> S::Int {
        const LAST: f32 = (TransferTable::LEN - 1) as f32;
        S::whole(match coverage {
            None => weighted * S::float(LAST / ONE),
            // Where nothing is covered the quotient is any number, and its colour weighs nothing.
            Some(coverage) => {
                let value = S::divide(weighted, larger::<S>(coverage, S::float(f32::MIN_POSITIVE)));
                smaller::<S>(value, S::float(1.0)) * S::float(LAST)
            }
        })
    }

    /// Colours that are classified already, for a path of so many unit lengths a millimetre of depth.
    #[inline(always)]
    fn colours<S: Simd>(&self, bundle: &Bundle<S>, weighted: S::Float, units: f32) -> Option<Colours<S>> {
        let shown = bundle.inside & !bundle.hidden & S::greater(weighted, S::float(0.0));
        if S::bits(shown) == 0 {
            return None;
        }
        let opacity = S::choose(shown, weighted, S::float(0.0));
        // Rounding may bring a colour above its opacity.
        let rgb = bundle.vectors(&bundle.block.rgb, shown);
        let [r, g, b] = each!(c of [0, 1, 2] => smaller::<S>(rgb[c] - S::float(NONE), opacity));
        let sources = each!(c of [r, g, b, opacity] => S::divide(c, S::float(ONE)));
        let units = S::float(units);
        let lengths = match bundle.paths {
            Some(paths) => units * paths,
            None => units,
        };
        Some(lengthen::<S>(&sources, lengths))
    }

    /// Colours with light and depth cue, where they show.
    #[inline(always)]
    fn lit<S: Simd>(&self, bundle: &Bundle<S>, colours: Colours<S>) -> Colours<S> {
        let [r, g, b, a] = colours;
        let (factor, highlight) = match &self.lights {
            Some(lights) => {
                let shown = S::greater(a, S::float(0.0)) & !bundle.hidden;
                lights.response::<S>(&bundle.vectors(&bundle.block.normals, shown))
            }
            None => (S::float(1.0), S::float(0.0)),
        };
        let cue = S::float(self.cue.at(bundle.plane));
        let [r, g, b] = each!(c of [r, g, b] => cue * (factor * c + highlight * a));
        [r, g, b, a]
    }
}

impl<S: Simd> Bundle<'_, S> {
    /// The samples of numbers, in parts of [`ONE`].
    #[inline(always)]
    fn numbers(&self, numbers: &[i16]) -> S::Float {
        self.places.numbers(numbers) - S::float(NONE)
    }

    /// The coverage of each sample in parts of [`ONE`]; `None` where it is 1.
    #[inline(always)]
    fn coverage(&self) -> Option<S::Float> {
        let coverage = &self.block.coverage;
        if coverage.is_empty() {
            return None;
        }
        Some(self.numbers(coverage))
    }

    /// The samples of vectors that are `shown`, in steps of what is stored.
    #[inline(always)]
    fn vectors(&self, vectors: &[[i16; 4]], shown: S::Mask) -> [S::Float; 3] {
        self.places.vectors(vectors, shown)
    }
}
