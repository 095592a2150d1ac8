//! From samples to what is blended: colours and opacities, lit, or values.

use super::blend::Colours;
use super::kind::Kind;
use super::light::{Cue, Lights};
use super::power::lengthen;
use super::sample::{BlockVectors, Bundle, Numbers, Vectors};
use super::simd::{ONE_WEIGHT, Simd, each, larger, smaller};
use super::voxels::{NONE, ONE};
use crate::projection::composite::Blending;
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
    /// No sample shows of plain values that are all less.
    least: i16,
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f32>,
    lights: Option<Lights>,
    cue: Cue,
}

/// What a bundle's samples are classified by.
pub struct Samples<S: Simd, const N: usize> {
    /// Values, or opacities, times coverage, as they are sampled.
    weighted: [S::Float; N],
    /// Coverage, in parts of [`ONE`]; `None` where it is 1.
    coverage: Option<[S::Float; N]>,
    /// The table's entry for each, of values that are classified.
    entries: [S::Int; N],
    /// Which of them may show.
    shown: [S::Mask; N],
    /// A bit for each vector of which any may.
    pub any: u32,
}

impl Classifier {
    /// For the frame of `spec`, with its depth cue.
    pub fn new(spec: &FrameSpec, table: &TransferTable, cue: Cue) -> Self {
        let mut entries = Box::new([[0.0; 4]; TransferTable::LEN + 1]);
        entries[..NOTHING].copy_from_slice(table.entries());
        let shows = |entry: &[f32; 4]| entry[3] > 0.0;
        let last = entries.iter().rposition(shows).unwrap_or(0);
        let first = entries.iter().position(shows).unwrap_or(NOTHING);
        Self {
            mode: spec.settings.mode,
            shown: [first, last].map(|entry| entry as i32),
            least: least(first),
            table: entries,
            slab_units: spec.slab_units().map(|units| units as f32),
            lights: spec.shading().map(|shading| Lights::new(spec, shading)),
            cue,
        }
    }

    /// Whether frames are plain, of voxels that all are covered: see [`Kind::PLAIN`].
    pub fn is_plain(&self) -> bool {
        let by_table = self.mode.classifies() && self.mode != Mode::XRay && self.slab_units.is_none();
        by_table && self.mode.blending() == Blending::Over && !self.cue.is_there()
    }

    /// Whether any sample of values may show, with these round it.
    #[inline(always)]
    pub fn any_may_show<S: Simd, K: Kind>(&self, weighted: &Numbers<S>) -> bool {
        !K::PLAIN || weighted.any_at_least(self.least)
    }

    /// The samples of a bundle; `None` if none of them shows.
    #[inline(always)]
    pub fn samples<S: Simd, K: Kind, const N: usize>(&self, bundle: &Bundle<S, K, N>) -> Option<Samples<S, N>> {
        let nothing = [S::float(0.0); N];
        let mut samples = Samples {
            weighted: nothing,
            coverage: None,
            entries: [S::int(0); N],
            shown: bundle.inside,
            any: 0,
        };
        if !K::PLAIN && !bundle.voxels.coverage.is_empty() && (self.slab_units.is_none() || !self.mode.classifies()) {
            let coverage = bundle.numbers(bundle.voxels.coverage);
            let mut all = nothing;
            for (n, of) in all.iter_mut().enumerate() {
                *of = ones::<S>(bundle.sampled(n, &coverage));
            }
            samples.coverage = Some(all);
        }
        for n in 0..N {
            samples.weighted[n] = bundle.sampled(n, &bundle.weighted);
            samples.shown[n] = bundle.inside[n] & self.may_show::<S, K, N>(n, &mut samples);
            samples.any |= u32::from(S::bits(samples.shown[n]) != 0) << n;
        }
        (samples.any != 0).then_some(samples)
    }

    /// Which samples of vector `n` may show, their entries found if values are classified by the table.
    #[inline(always)]
    fn may_show<S: Simd, K: Kind, const N: usize>(&self, n: usize, samples: &mut Samples<S, N>) -> S::Mask {
        if !K::PLAIN && !self.mode.classifies() {
            return !S::none();
        }
        if !K::PLAIN && self.slab_units.is_some() {
            return S::greater(ones::<S>(samples.weighted[n]), S::float(0.0));
        }
        let entries = self.entries::<S, N>(samples.weighted[n], &samples.coverage, n);
        samples.entries[n] = entries;
        !(S::greater_int(S::int(self.shown[0]), entries) | S::greater_int(entries, S::int(self.shown[1])))
    }

    /// What is blended of vector `n` of samples; `None` where none of them shows.
    #[inline(always)]
    pub fn sources<S: Simd, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
        vectors: &mut BlockVectors<S>,
    ) -> Option<Colours<S>> {
        if !K::PLAIN && !self.mode.classifies() {
            return Some(self.values(bundle, n, samples));
        }
        if S::bits(samples.shown[n]) == 0 {
            return None;
        }
        let colours = match self.slab_units {
            Some(units) if !K::PLAIN => self.colours(bundle, n, samples, &mut vectors.rgb, units),
            _ => self.classified(bundle, n, samples)?,
        };
        Some(match self.mode {
            Mode::XRay if !K::PLAIN => [colours[3]; 4],
            _ if self.lights.is_none() && (K::PLAIN || !self.cue.is_there()) => colours,
            _ => self.lit(bundle, n, colours, &mut vectors.normals),
        })
    }

    /// What value modes accumulate: see [`value_source`](crate::projection::composite::value_source).
    #[inline(always)]
    fn values<S: Simd, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
    ) -> Colours<S> {
        let one = S::float(1.0);
        let weighted = S::divide(ones::<S>(samples.weighted[n]), S::float(ONE));
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
    fn classified<S: Simd, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
    ) -> Option<Colours<S>> {
        let nothing = S::int(NOTHING as i32);
        let mut sources = S::entries(
            &self.table,
            S::choose_int(samples.shown[n], samples.entries[n], nothing),
        );
        if !K::PLAIN {
            if let Some(paths) = bundle.paths {
                sources = lengthen::<S>(&sources, paths[n]);
            }
            if let Some(coverage) = &samples.coverage {
                let coverage = S::divide(coverage[n], S::float(ONE));
                sources = each!(c of [0, 1, 2, 3] => sources[c] * coverage);
            }
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
            None => S::mul_add(
                weighted,
                S::float(LAST / ONE / ONE_WEIGHT),
                S::float(-NONE * LAST / ONE),
            ),
            // Where nothing is covered the quotient is any number, and its colour weighs nothing.
            Some(coverage) => {
                let value = S::divide(
                    ones::<S>(weighted),
                    larger::<S>(coverage[n], S::float(f32::MIN_POSITIVE)),
                );
                smaller::<S>(value, S::float(1.0)) * S::float(LAST)
            }
        })
    }

    /// Colours that are classified already, for a path of so many unit lengths a millimetre of depth.
    #[inline(always)]
    fn colours<S: Simd, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
        rgb: &mut Vectors<S>,
        units: f32,
    ) -> Colours<S> {
        let opacity = S::choose(samples.shown[n], ones::<S>(samples.weighted[n]), S::float(0.0));
        // Rounding may bring a colour above its opacity.
        let rgb = bundle.vectors(n, rgb, samples.shown[n]);
        let [r, g, b] = each!(c of [0, 1, 2] => smaller::<S>(ones::<S>(rgb[c]), opacity));
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
    fn lit<S: Simd, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
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
        let highlight = highlight * a;
        let mut lit = each!(c of [r, g, b] => S::mul_add(factor, c, highlight));
        if !K::PLAIN {
            let cue = S::float(self.cue.at(bundle.plane));
            lit = each!(c of [0, 1, 2] => cue * lit[c]);
        }
        let [r, g, b] = lit;
        [r, g, b, a]
    }
}

/// What is stored for the least number of which a sample may have table entry `first`: samples are no more than the largest number round them but for
/// rounding, which is less than a step.
fn least(first: usize) -> i16 {
    let step = ONE / (TransferTable::LEN - 1) as f32;
    ((first as f32 - 0.5) * step - 1.0 + NONE) as i16
}

/// What is sampled, in parts of [`ONE`] from [`NONE`] on.
#[inline(always)]
fn ones<S: Simd>(sampled: S::Float) -> S::Float {
    S::mul_add(sampled, S::float(1.0 / ONE_WEIGHT), S::float(-NONE))
}
