//! From samples to what is blended: colours and opacities, lit, or values.

use super::blend::Colours;
use super::light::{Cue, Lights};
use super::power::lengthen;
use super::sample::{BlockVectors, Bundle, Vectors};
use super::simd::{Simd, each, larger, smaller};
use super::voxels::{NONE, ONE};
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

/// What a bundle's samples are classified by.
pub struct Samples<S: Simd, const N: usize> {
    /// Values, or opacities, times coverage, in parts of [`ONE`].
    weighted: [S::Float; N],
    /// Likewise coverage; `None` where it is 1.
    coverage: Option<[S::Float; N]>,
    /// The table's entry for each, of values that are classified.
    entries: [S::Int; N],
    /// Which of them may show.
    shown: [S::Mask; N],
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

    /// The samples of a bundle; `None` if none of them shows.
    #[inline(always)]
    pub fn samples<S: Simd, const N: usize>(&self, bundle: &Bundle<S, N>) -> Option<Samples<S, N>> {
        let mut samples = Samples {
            weighted: stored_numbers(bundle, &bundle.block.weighted),
            coverage: None,
            entries: [S::int(0); N],
            shown: bundle.inside,
        };
        let is_partial = !bundle.block.coverage.is_empty();
        if is_partial && (self.slab_units.is_none() || !self.mode.classifies()) {
            samples.coverage = Some(stored_numbers(bundle, &bundle.block.coverage));
        }
        if !self.mode.classifies() {
            return Some(samples);
        }
        let mut any = 0;
        for n in 0..N {
            let may_show = if self.slab_units.is_some() {
                S::greater(samples.weighted[n], S::float(0.0))
            } else {
                let entries = self.entries::<S, N>(samples.weighted[n], &samples.coverage, n);
                samples.entries[n] = entries;
                !(S::greater_int(S::int(self.shown[0]), entries) | S::greater_int(entries, S::int(self.shown[1])))
            };
            samples.shown[n] = bundle.inside[n] & may_show;
            any |= S::bits(samples.shown[n]);
        }
        (any != 0).then_some(samples)
    }

    /// What is blended of vector `n` of samples; `None` where none of them shows.
    #[inline(always)]
    pub fn sources<S: Simd, const N: usize>(
        &self,
        bundle: &Bundle<S, N>,
        n: usize,
        samples: &Samples<S, N>,
        vectors: &mut BlockVectors<S>,
    ) -> Option<Colours<S>> {
        if !self.mode.classifies() {
            return Some(self.values(bundle, n, samples));
        }
        if S::bits(samples.shown[n]) == 0 {
            return None;
        }
        let colours = match self.slab_units {
            Some(units) => self.colours(bundle, n, samples, &mut vectors.rgb, units),
            None => self.classified(bundle, n, samples)?,
        };
        Some(match self.mode {
            Mode::XRay => [colours[3]; 4],
            _ if self.is_plain() => colours,
            _ => self.lit(bundle, n, colours, &mut vectors.normals),
        })
    }

    /// Whether colours are what the table says.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.lights.is_none() && self.cue.strength == 0.0
    }

    /// What value modes accumulate: see [`value_source`](crate::projection::composite::value_source).
    #[inline(always)]
    fn values<S: Simd, const N: usize>(&self, bundle: &Bundle<S, N>, n: usize, samples: &Samples<S, N>) -> Colours<S> {
        let one = S::float(1.0);
        let weighted = S::divide(samples.weighted[n], S::float(ONE));
        let coverage = match &samples.coverage {
            Some(coverage) => S::divide(coverage[n], S::float(ONE)),
            None => one,
        };
        let path = match bundle.paths {
            Some(paths) => paths[n],
            None => one,
        };
        let (value, weight) = match self.mode {
            Mode::MinIp => (coverage - weighted, coverage),
            Mode::Average => (weighted * path, coverage * path),
            _ => (weighted, coverage),
        };
        let [value, weight] = each!(of of [value, weight] => S::choose(bundle.inside[n], of, S::float(0.0)));
        [value, value, value, weight]
    }

    /// Table entries for the path, times coverage.
    #[inline(always)]
    fn classified<S: Simd, const N: usize>(
        &self,
        bundle: &Bundle<S, N>,
        n: usize,
        samples: &Samples<S, N>,
    ) -> Option<Colours<S>> {
        let nothing = S::int(NOTHING as i32);
        let mut sources = S::entries(
            &self.table,
            S::choose_int(samples.shown[n], samples.entries[n], nothing),
        );
        if let Some(paths) = bundle.paths {
            sources = lengthen::<S>(&sources, paths[n]);
        }
        if let Some(coverage) = &samples.coverage {
            let coverage = S::divide(coverage[n], S::float(ONE));
            sources = each!(c of [0, 1, 2, 3] => sources[c] * coverage);
        }
        (S::bits(S::greater(sources[3], S::float(0.0))) != 0).then_some(sources)
    }

    /// The table's entry for each sample of vector `n`.
    #[inline(always)]
    fn entries<S: Simd, const N: usize>(
        &self,
        weighted: S::Float,
        coverage: &Option<[S::Float; N]>,
        n: usize,
    ) -> S::Int {
        const LAST: f32 = (TransferTable::LEN - 1) as f32;
        S::whole(match coverage {
            None => weighted * S::float(LAST / ONE),
            // Where nothing is covered the quotient is any number, and its colour weighs nothing.
            Some(coverage) => {
                let value = S::divide(weighted, larger::<S>(coverage[n], S::float(f32::MIN_POSITIVE)));
                smaller::<S>(value, S::float(1.0)) * S::float(LAST)
            }
        })
    }

    /// Colours that are classified already, for a path of so many unit lengths a millimetre of depth.
    #[inline(always)]
    fn colours<S: Simd, const N: usize>(
        &self,
        bundle: &Bundle<S, N>,
        n: usize,
        samples: &Samples<S, N>,
        rgb: &mut Vectors<S>,
        units: f32,
    ) -> Colours<S> {
        let opacity = S::choose(samples.shown[n], samples.weighted[n], S::float(0.0));
        // Rounding may bring a colour above its opacity.
        let rgb = bundle.vectors(n, rgb, samples.shown[n]);
        let [r, g, b] = each!(c of [0, 1, 2] => smaller::<S>(rgb[c] - S::float(NONE), opacity));
        let sources = each!(c of [r, g, b, opacity] => S::divide(c, S::float(ONE)));
        let units = S::float(units);
        let lengths = match bundle.paths {
            Some(paths) => units * paths[n],
            None => units,
        };
        lengthen::<S>(&sources, lengths)
    }

    /// Colours with light and depth cue, where they show.
    #[inline(always)]
    fn lit<S: Simd, const N: usize>(
        &self,
        bundle: &Bundle<S, N>,
        n: usize,
        colours: Colours<S>,
        normals: &mut Vectors<S>,
    ) -> Colours<S> {
        let [r, g, b, a] = colours;
        let (factor, highlight) = match &self.lights {
            Some(lights) => {
                let shown = S::greater(a, S::float(0.0));
                lights.response::<S>(&bundle.vectors(n, normals, shown))
            }
            None => (S::float(1.0), S::float(0.0)),
        };
        let cue = S::float(self.cue.at(bundle.plane));
        let [r, g, b] = each!(c of [r, g, b] => cue * (factor * c + highlight * a));
        [r, g, b, a]
    }
}

/// The samples of numbers, in parts of [`ONE`].
#[inline(always)]
fn stored_numbers<S: Simd, const N: usize>(bundle: &Bundle<S, N>, numbers: &[i16]) -> [S::Float; N] {
    let mut all = bundle.numbers(numbers);
    for one in &mut all {
        *one = *one - S::float(NONE);
    }
    all
}
