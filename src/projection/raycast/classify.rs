//! From samples to what is blended: colours and opacities, lit, or values.

use super::blend::Colours;
use super::kind::Kind;
use super::light::{Cue, Lights};
use super::power::lengthen;
use super::sample::{Bundle, Normals, Numbers};
use super::simd::{PAIRS, Sampling, each, larger, smaller};
use super::template::pairs;
use super::voxels::{ONE, PER_ENTRY};
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
    /// The least and the largest number that is stored for plain values that show.
    shown_values: [i16; 2],
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f32>,
    lights: Option<Lights>,
    cue: Cue,
}

/// What a bundle's samples are classified by.
pub struct Samples<S: Sampling, const N: usize> {
    /// Values, or opacities, times coverage, in parts of [`ONE`].
    weighted: [S::Short; PAIRS],
    /// Coverage, likewise; `None` where it is 1.
    coverage: Option<[S::Short; PAIRS]>,
    /// Colours of a target of colours times opacity and coverage, likewise.
    rgb: Option<[[S::Short; PAIRS]; 3]>,
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
            shown_values: values(first, last),
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
    pub fn any_may_show<S: Sampling, K: Kind>(&self, weighted: &Numbers<S>) -> bool {
        !K::PLAIN || weighted.any_at_least(self.shown_values[0])
    }

    /// The samples of a bundle; `None` if none of them shows.
    #[inline(always)]
    pub fn samples<S: Sampling, K: Kind, const N: usize>(&self, bundle: &Bundle<S, K, N>) -> Option<Samples<S, N>> {
        let covered =
            !K::PLAIN && !bundle.voxels.coverage.is_empty() && (self.slab_units.is_none() || !self.mode.classifies());
        let coverage = if covered {
            Some(bundle.sampled(&bundle.numbers(bundle.voxels.coverage)))
        } else {
            None
        };
        let mut samples = Samples {
            weighted: bundle.sampled(&bundle.weighted),
            coverage,
            rgb: None,
            shown: bundle.inside,
            any: 0,
        };
        for m in 0..pairs(N) {
            let may_show = self.may_show::<S, K, N>(m, &samples);
            for n in 2 * m..N.min(2 * m + 2) {
                samples.shown[n] = samples.shown[n] & may_show[n % 2];
                samples.any |= u32::from(S::bits(samples.shown[n]) != 0) << n;
            }
        }
        if !K::PLAIN && self.slab_units.is_some() && samples.any != 0 {
            let rgb = bundle.voxels.rgb;
            samples.rgb = Some(each!(part of [0, 1, 2] => bundle.sampled(&bundle.numbers(rgb[part]))));
        }
        (samples.any != 0).then_some(samples)
    }

    /// Which samples of pair `m` of vectors may show.
    #[inline(always)]
    fn may_show<S: Sampling, K: Kind, const N: usize>(&self, m: usize, samples: &Samples<S, N>) -> [S::Mask; 2] {
        if !K::PLAIN && !self.mode.classifies() {
            return [!S::none(); 2];
        }
        if !K::PLAIN && self.slab_units.is_some() {
            return S::in_range(samples.weighted[m], [1, i16::MAX]);
        }
        match &samples.coverage {
            Some(coverage) if !K::PLAIN => each!(n of [2 * m, (2 * m + 1).min(N - 1)] => {
                let entries = self.entries::<S, N>(&samples.weighted, Some(coverage), n);
                !(S::greater_int(S::int(self.shown[0]), entries) | S::greater_int(entries, S::int(self.shown[1])))
            }),
            _ => S::in_range(samples.weighted[m], self.shown_values),
        }
    }

    /// What is blended of vector `n` of samples; `None` where none of them shows.
    #[inline(always)]
    pub fn sources<S: Sampling, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
        normals: &mut Normals<S>,
    ) -> Option<Colours<S>> {
        if !K::PLAIN && !self.mode.classifies() {
            return Some(self.values(bundle, n, samples));
        }
        let colours = match (self.slab_units, &samples.rgb) {
            (Some(units), Some(rgb)) if !K::PLAIN => self.colours(bundle, n, samples, rgb, units),
            _ => self.classified(bundle, n, samples)?,
        };
        Some(match self.mode {
            Mode::XRay if !K::PLAIN => [colours[3]; 4],
            _ if self.lights.is_none() && (K::PLAIN || !self.cue.is_there()) => colours,
            _ => self.lit(bundle, n, colours, normals),
        })
    }

    /// What value modes accumulate: see [`value_source`](crate::projection::composite::value_source).
    #[inline(always)]
    fn values<S: Sampling, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
    ) -> Colours<S> {
        let one = S::float(1.0);
        let weighted = fraction::<S, N>(&samples.weighted, n);
        let coverage = match &samples.coverage {
            Some(coverage) => fraction::<S, N>(coverage, n),
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
    fn classified<S: Sampling, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
    ) -> Option<Colours<S>> {
        let nothing = S::int(NOTHING as i32);
        let entries = self.entries::<S, N>(&samples.weighted, samples.coverage.as_ref(), n);
        let mut sources = S::entries(&self.table, S::choose_int(samples.shown[n], entries, nothing));
        if !K::PLAIN {
            if let Some(paths) = bundle.paths {
                sources = lengthen::<S>(&sources, paths[n]);
            }
            if let Some(coverage) = &samples.coverage {
                let coverage = fraction::<S, N>(coverage, n);
                sources = each!(c of [0, 1, 2, 3] => sources[c] * coverage);
            }
        }
        // In plain frames what is among the entries that show most often does, and is not asked again.
        (K::PLAIN || S::bits(S::greater(sources[3], S::float(0.0))) != 0).then_some(sources)
    }

    /// The table's entry for each sample of vector `n`.
    #[inline(always)]
    fn entries<S: Sampling, const N: usize>(
        &self,
        weighted: &[S::Short; PAIRS],
        coverage: Option<&[S::Short; PAIRS]>,
        n: usize,
    ) -> S::Int {
        const LAST: f32 = (TransferTable::LEN - 1) as f32;
        let weighted = S::wide::<N>(weighted, n);
        match coverage {
            None => S::shift_right(
                weighted + S::int(i32::from(PER_ENTRY) / 2),
                S::int(PER_ENTRY.ilog2() as i32),
            ),
            // Where nothing is covered the quotient is any number, and its colour weighs nothing.
            Some(coverage) => {
                let coverage = S::to_float(S::wide::<N>(coverage, n));
                let value = S::divide(
                    S::to_float(weighted),
                    larger::<S>(coverage, S::float(f32::MIN_POSITIVE)),
                );
                S::whole(smaller::<S>(value, S::float(1.0)) * S::float(LAST))
            }
        }
    }

    /// Colours that are classified already, for a path of so many unit lengths a millimetre of depth.
    #[inline(always)]
    fn colours<S: Sampling, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        samples: &Samples<S, N>,
        rgb: &[[S::Short; PAIRS]; 3],
        units: f32,
    ) -> Colours<S> {
        let opacity = S::choose(samples.shown[n], fraction::<S, N>(&samples.weighted, n), S::float(0.0));
        // Rounding may bring a colour above its opacity.
        let [r, g, b] = each!(c of [0, 1, 2] => smaller::<S>(fraction::<S, N>(&rgb[c], n), opacity));
        let sources = [r, g, b, opacity];
        let units = S::float(units);
        let lengths = match bundle.paths {
            Some(paths) => units * paths[n],
            None => units,
        };
        lengthen::<S>(&sources, lengths)
    }

    /// Colours with light and depth cue, where they show.
    #[inline(always)]
    fn lit<S: Sampling, K: Kind, const N: usize>(
        &self,
        bundle: &Bundle<S, K, N>,
        n: usize,
        colours: Colours<S>,
        normals: &mut Normals<S>,
    ) -> Colours<S> {
        let [r, g, b, a] = colours;
        let (factor, highlight) = match &self.lights {
            Some(lights) => {
                let shown = S::greater(a, S::float(0.0));
                lights.response::<S>(&bundle.normals(n, normals, shown))
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

/// The least and the largest number that is stored for values with entries from `first` to `last` on; larger than all if there are none.
fn values(first: usize, last: usize) -> [i16; 2] {
    if first > last {
        return [i16::MAX; 2];
    }
    let least = |entry: usize| (entry as i32 * i32::from(PER_ENTRY) - i32::from(PER_ENTRY) / 2) as i16;
    [least(first), least(last + 1) - 1]
}

/// What is sampled in parts of [`ONE`], of vector `n`.
#[inline(always)]
fn fraction<S: Sampling, const N: usize>(sampled: &[S::Short; PAIRS], n: usize) -> S::Float {
    S::divide(S::to_float(S::wide::<N>(sampled, n)), S::float(ONE))
}
