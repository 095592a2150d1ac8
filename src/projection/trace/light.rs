//! Lights: far ones, points, and areas.
//!
//! *Practice.* Light does not thin out with distance: the intensity is what arrives. An area is seen through points of it, one for
//! each of a square's equal parts, shifted by a hash within their part; the mean over samples of a pixel is as smooth as there are
//! samples.

use glam::DVec3;

use super::sampling::Stream;

/// A light in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    shape: Shape,
    intensity: f64,
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// From a direction, of length 1 and towards the light.
    Far(DVec3),
    /// From a point.
    Point(DVec3),
    /// From a parallelogram: its middle and two edges.
    Area([DVec3; 3]),
}

/// A light that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// An intensity that is not finite or below 0.
    #[error("a light's intensity is {0}; it must be finite and not below 0")]
    Intensity(f64),
    /// A place or a direction that is not finite.
    #[error("a light is not at a finite place")]
    Place,
    /// No direction.
    #[error("a light comes from a direction of length 0")]
    Direction,
    /// Edges along one line.
    #[error(
        "the edges {u} and {v} of an area light span no area: take edges that are not along one line, or a point light"
    )]
    NoArea {
        /// An edge.
        u: DVec3,
        /// The other.
        v: DVec3,
    },
}

/// Light on its way to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Towards the light, of length 1.
    pub towards: DVec3,
    /// How far away the light is, millimetres.
    pub distance_mm: f64,
    /// What arrives if nothing is in the way.
    pub intensity: f64,
}

impl Source {
    /// A light so far away that its rays are parallel; `towards` it.
    ///
    /// # Errors
    /// If it has no direction, or a number is not finite.
    pub fn far(towards: DVec3, intensity: f64) -> Result<Self, SourceError> {
        finite(&[towards])?;
        let towards = towards.try_normalize().ok_or(SourceError::Direction)?;
        Self::new(Shape::Far(towards), intensity)
    }

    /// A point that shines in all directions.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn point(at: DVec3, intensity: f64) -> Result<Self, SourceError> {
        finite(&[at])?;
        Self::new(Shape::Point(at), intensity)
    }

    /// A parallelogram with its middle `at` a place, which shines on both sides.
    ///
    /// # Errors
    /// If its edges span no area, or a number is not finite.
    pub fn area(at: DVec3, u: DVec3, v: DVec3, intensity: f64) -> Result<Self, SourceError> {
        finite(&[at, u, v])?;
        let sin = u.normalize_or_zero().cross(v.normalize_or_zero()).length();
        // A rounding of an edge's direction turns it by less.
        if sin < 1e-9 {
            return Err(SourceError::NoArea { u, v });
        }
        Self::new(Shape::Area([at, u, v]), intensity)
    }

    fn new(shape: Shape, intensity: f64) -> Result<Self, SourceError> {
        match intensity.is_finite() && intensity >= 0.0 {
            true => Ok(Self { shape, intensity }),
            false => Err(SourceError::Intensity(intensity)),
        }
    }

    /// How much light it gives.
    pub fn intensity(&self) -> f64 {
        self.intensity
    }

    /// Its beams to the point `p`, an area's seen through `parts` times `parts` of it.
    pub fn beams(&self, p: DVec3, parts: u32, stream: &mut Stream) -> Vec<Beam> {
        match self.shape {
            Shape::Far(towards) => vec![Beam {
                towards,
                distance_mm: f64::INFINITY,
                intensity: self.intensity,
            }],
            Shape::Point(at) => vec![self.beam(p, at, 1)],
            Shape::Area([at, u, v]) => {
                let parts = parts.max(1);
                let place = |n: u32| {
                    let [x, y] = stream.point();
                    let part = |n: u32, within: f64| (f64::from(n) + within) / f64::from(parts) - 0.5;
                    at + u * part(n % parts, x) + v * part(n / parts, y)
                };
                let places: Vec<DVec3> = (0..parts * parts).map(place).collect();
                places.into_iter().map(|at| self.beam(p, at, parts * parts)).collect()
            }
        }
    }

    /// One of `count` beams, from a place of the light. A light at the point itself shines from above.
    fn beam(&self, p: DVec3, at: DVec3, count: u32) -> Beam {
        let way = at - p;
        Beam {
            towards: way.normalize_or(DVec3::Z),
            distance_mm: way.length(),
            intensity: self.intensity / f64::from(count),
        }
    }
}

fn finite(vectors: &[DVec3]) -> Result<(), SourceError> {
    match vectors.iter().all(|v| v.is_finite()) {
        true => Ok(()),
        false => Err(SourceError::Place),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degenerate_lights_are_refused() {
        let nan = DVec3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(Source::far(DVec3::ZERO, 1.0), Err(SourceError::Direction));
        assert_eq!(Source::far(nan, 1.0), Err(SourceError::Place));
        assert_eq!(Source::point(nan, 1.0), Err(SourceError::Place));
        assert_eq!(Source::point(DVec3::ZERO, -1.0), Err(SourceError::Intensity(-1.0)));
        assert!(matches!(
            Source::point(DVec3::ZERO, f64::NAN),
            Err(SourceError::Intensity(_))
        ));
        for v in [DVec3::ZERO, DVec3::X, -2.0 * DVec3::X] {
            let flat = Source::area(DVec3::ZERO, DVec3::X, v, 1.0);
            assert!(matches!(flat, Err(SourceError::NoArea { .. })), "{v}");
        }
        // A light may be as small and as far away as it likes.
        assert!(Source::area(DVec3::splat(1e9), 1e-9 * DVec3::X, 1e-9 * DVec3::Y, 1.0).is_ok());
    }

    #[test]
    fn an_areas_beams_come_from_each_part_and_sum_up() {
        let light = Source::area(DVec3::Z, 2.0 * DVec3::X, 2.0 * DVec3::Y, 3.0).expect("a light");
        let beams = light.beams(DVec3::ZERO, 2, &mut Stream::new(0, [3, 4], 0));
        assert!((beams.iter().map(|b| b.intensity).sum::<f64>() - 3.0).abs() < 1e-12);
        let quarter = |beam: &Beam| [beam.towards.x > 0.0, beam.towards.y > 0.0];
        let quarters: Vec<_> = beams.iter().map(quarter).collect();
        assert_eq!(quarters, [[false, false], [true, false], [false, true], [true, true]]);
    }

    #[test]
    fn a_light_at_the_point_itself_is_no_light_of_nowhere() {
        let light = Source::point(DVec3::ONE, 1.0).expect("a light");
        let [beam] = light.beams(DVec3::ONE, 1, &mut Stream::new(0, [0, 0], 0))[..] else {
            panic!("one beam");
        };
        assert!(beam.towards.is_finite() && beam.distance_mm == 0.0);
    }
}
