//! The density of a thread away from its ends, from a table.
//!
//! *Theory.* A turn about its axis with the rise that goes with it moves an endless thread onto itself, and the filter's ball onto
//! another ball. So a density depends on two numbers: the distance from the axis, and the height above the outline that has
//! risen to the sample's direction, of which a whole pitch more is the same place (WK94's table of a feature, for a screw).
//! *Changes from the paper.* The table is a thread's own, made when it is first asked, and interpolated by cubics.
//! *Practice.* Threads that are alike and sampled alike, as the bolts of a row are, share one table while one of them lives.

use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use super::cubic;
use super::profile::Profile;

/// The table of an outline that rises by a pitch each turn, for a filter of one radius.
#[derive(Debug)]
pub struct Screw {
    profile: Profile,
    pitch: f64,
    /// The filter's radius.
    pub reach: f64,
    /// The distance from the axis of the first entries; just below 0 where the axis is near, so that cubics go through it.
    first: f64,
    /// Entries away from the axis, and along a pitch.
    counts: [usize; 2],
    entries: OnceLock<Vec<f32>>,
}

impl PartialEq for Screw {
    fn eq(&self, other: &Self) -> bool {
        self.is_of(&other.profile, other.pitch, other.reach)
    }
}

/// Entries for a filter's radius. Cubics err by at most 3/128 of the fourth power of the step times the fourth derivative, below 40
/// for a density with the radius as unit (see `apex`): 2.3e-4 by each of the two numbers.
const ENTRIES_A_RADIUS: f64 = 8.0;

/// A larger table would take longer than the samples that are likely to be asked for.
const MOST_ENTRIES: f64 = 65536.0;

static ALIVE: Mutex<Vec<Weak<Screw>>> = Mutex::new(Vec::new());

impl Screw {
    /// The table that all such threads share; `None` where it would be too large.
    pub fn shared(profile: &Profile, pitch: f64, reach: f64) -> Option<Arc<Self>> {
        let mut alive = ALIVE.lock().unwrap_or_else(PoisonError::into_inner);
        alive.retain(|screw| screw.strong_count() > 0);
        let known = alive.iter().filter_map(Weak::upgrade);
        if let Some(screw) = known.into_iter().find(|screw| screw.is_of(profile, pitch, reach)) {
            return Some(screw);
        }
        let screw = Arc::new(Self::new(profile, pitch, reach)?);
        alive.push(Arc::downgrade(&screw));
        Some(screw)
    }

    fn new(profile: &Profile, pitch: f64, reach: f64) -> Option<Self> {
        let (lo, hi) = profile.bounds();
        let step = reach / ENTRIES_A_RADIUS;
        let first = (lo.x - reach).max(-step);
        let radii = ((hi.x + reach - first) / step).ceil() + 1.0;
        let phases = (pitch / step).ceil().max(4.0);
        (radii * phases <= MOST_ENTRIES).then(|| Self {
            profile: profile.clone(),
            pitch,
            reach,
            first,
            counts: [radii as usize, phases as usize],
            entries: OnceLock::new(),
        })
    }

    fn is_of(&self, profile: &Profile, pitch: f64, reach: f64) -> bool {
        (self.pitch, self.reach) == (pitch, reach) && self.profile == *profile
    }

    /// The density at distance `rho` from the axis, `height` above the risen outline's origin. `integrate` tells it exactly where the
    /// direction is that of the thread's beginning; of a negative distance, the opposite one.
    pub fn density(&self, rho: f64, height: f64, integrate: impl Fn(f64, f64) -> f64) -> f64 {
        let entries = self.entries.get_or_init(|| self.fill(integrate));
        let [radii, phases] = self.counts;
        let (away, by_rho) = cubic::clamped((rho - self.first) * ENTRIES_A_RADIUS / self.reach, radii);
        let (along, by_height) = cubic::periodic(height / self.pitch * phases as f64, phases);
        let row = |a: usize| cubic::weigh(along.map(|n| f64::from(entries[a * phases + n])), by_height);
        cubic::weigh(away.map(row), by_rho).clamp(0.0, 1.0)
    }

    fn fill(&self, integrate: impl Fn(f64, f64) -> f64) -> Vec<f32> {
        let [radii, phases] = self.counts;
        let rho = |n: usize| self.first + n as f64 * self.reach / ENTRIES_A_RADIUS;
        let height = |n: usize| self.pitch * n as f64 / phases as f64;
        let places = (0..radii * phases).map(|n| (rho(n / phases), height(n % phases)));
        places.map(|(rho, height)| integrate(rho, height) as f32).collect()
    }
}
