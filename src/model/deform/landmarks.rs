//! Landmarks, and which sets of them make a spline.

use glam::DVec3;

/// A point and where it goes, millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// What messages call it.
    pub name: String,
    /// Where it is.
    pub from: DVec3,
    /// Where it goes.
    pub to: DVec3,
}

/// How a spline goes between landmarks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Smoothness {
    /// 0 takes every landmark exactly to its target; the larger, the more landmarks may miss theirs for a smoother map. For the
    /// thin plate in millimetres: each misses by this times its weight.
    pub stiffness: f64,
    /// How far a landmark's movement reaches, millimetres; everywhere if `None`.
    pub support_mm: Option<f64>,
}

/// Why landmarks make no spline.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplineError {
    /// Not enough.
    #[error("{0} landmarks are too few: a deformation needs at least {least}", least = Landmark::FEWEST)]
    TooFew(usize),
    /// Too many.
    #[error("{0} landmarks are too many: a deformation takes at most {most}", most = Landmark::MOST)]
    TooMany(usize),
    /// A coordinate that is no number, or one beyond all use.
    #[error("landmark {0} has a coordinate that is not a number, or beyond a million millimetres")]
    NotFinite(String),
    /// Two landmarks at one place that go to two.
    #[error("landmarks {0} and {1} are at one place and go to two: remove one of them")]
    Torn(String, String),
    /// All at one place.
    #[error("all landmarks are at one place: a translation does that")]
    OnePlace,
    /// A stiffness or support that cannot be.
    #[error("a stiffness must be 0 or above, and a support above 0")]
    Smoothness,
    /// Numbers too far apart.
    #[error(
        "the landmarks' equations cannot be solved: {0} and {1} are next to each other and go far apart; remove one of \
         them or raise the stiffness"
    )]
    Unsolvable(String, String),
}

impl Landmark {
    /// The fewest that make a deformation.
    pub const FEWEST: usize = 3;

    /// The most.
    pub const MOST: usize = 2000;

    /// The largest coordinate, millimetres.
    const FARTHEST_MM: f64 = 1e6;

    fn is_usable(&self) -> bool {
        let usable = |p: DVec3| p.is_finite() && p.abs().max_element() <= Self::FARTHEST_MM;
        usable(self.from) && usable(self.to)
    }
}

/// The landmarks without those that say again what an earlier one says.
pub(super) fn distinct(landmarks: &[Landmark]) -> Result<Vec<&Landmark>, SplineError> {
    if landmarks.len() < Landmark::FEWEST {
        return Err(SplineError::TooFew(landmarks.len()));
    }
    if landmarks.len() > Landmark::MOST {
        return Err(SplineError::TooMany(landmarks.len()));
    }
    if let Some(bad) = landmarks.iter().find(|l| !l.is_usable()) {
        return Err(SplineError::NotFinite(bad.name.clone()));
    }
    let mut kept: Vec<&Landmark> = Vec::with_capacity(landmarks.len());
    for landmark in landmarks {
        match kept.iter().find(|k| k.from == landmark.from) {
            Some(same) if same.to != landmark.to => {
                return Err(SplineError::Torn(same.name.clone(), landmark.name.clone()));
            }
            Some(_) => {}
            None => kept.push(landmark),
        }
    }
    match kept.len() {
        1 => Err(SplineError::OnePlace),
        _ => Ok(kept),
    }
}

/// The two landmarks that a spline has most trouble with: those that are moved apart the most for their distance.
pub(super) fn most_torn<'a>(landmarks: &[&'a Landmark]) -> [&'a str; 2] {
    let strain = |a: &Landmark, b: &Landmark| ((a.to - a.from) - (b.to - b.from)).length() / a.from.distance(b.from);
    let mut worst = (f64::NEG_INFINITY, ["", ""]);
    for (n, a) in landmarks.iter().enumerate() {
        for b in &landmarks[n + 1..] {
            if strain(a, b) > worst.0 {
                worst = (strain(a, b), [&a.name, &b.name]);
            }
        }
    }
    worst.1
}
