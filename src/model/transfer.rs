//! Transfer functions: values to colour and opacity.
//!
//! *Practice.* Colour and opacity are piecewise linear between control points. Opacity is stated for a unit length, and a
//! slab of another thickness gets `1 − (1−α)^(length/unit)`.

use crate::math::Interval;

/// One point of a transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// The data value.
    pub value: f32,
    /// Straight display-referred RGB in [0, 1].
    pub color: [f32; 3],
    /// Opacity over one unit length, in [0, 1].
    pub opacity: f32,
}

/// A transfer function.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
    unit_mm: f64,
}

/// Why a transfer function cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// No control point.
    #[error("a transfer function needs at least one point")]
    Empty,
    /// Values fall.
    #[error("point {index}: value {value} lies below its predecessor's; list points by rising value")]
    Unordered {
        /// Which point, from 0.
        index: usize,
        /// Its value.
        value: f32,
    },
    /// A number out of its range.
    #[error("point {index}: {what} is {found}, not {allowed}")]
    OutOfRange {
        /// Which point, from 0.
        index: usize,
        /// Which number.
        what: &'static str,
        /// What it is.
        found: f32,
        /// What it may be.
        allowed: &'static str,
    },
    /// The unit length is not above 0.
    #[error("the opacity unit is {0} mm; it must be above 0")]
    Unit(f64),
}

impl TransferFunction {
    /// A function through `points`, whose opacities hold for `unit_mm` millimetres. Two points of one value make a step.
    ///
    /// # Errors
    /// If there is no point, values fall, or a number is out of range.
    pub fn new(points: Vec<ControlPoint>, unit_mm: f64) -> Result<Self, TransferError> {
        if points.is_empty() {
            return Err(TransferError::Empty);
        }
        if !(unit_mm.is_finite() && unit_mm > 0.0) {
            return Err(TransferError::Unit(unit_mm));
        }
        for (index, point) in points.iter().enumerate() {
            point.check(index)?;
            if index > 0 && point.value < points[index - 1].value {
                return Err(TransferError::Unordered {
                    index,
                    value: point.value,
                });
            }
        }
        Ok(Self { points, unit_mm })
    }

    /// The control points, by rising value.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// The length that opacities hold for, millimetres.
    pub fn unit_mm(&self) -> f64 {
        self.unit_mm
    }

    /// The values between the first and the last point: what greys span.
    pub fn window(&self) -> Interval {
        let end = |p: Option<&ControlPoint>| p.map_or(0.0, |p| p.value);
        Interval::new(end(self.points.first()), end(self.points.last()))
    }

    /// Straight colour and unit-length opacity at `value`.
    pub fn evaluate(&self, value: f32) -> ([f32; 3], f32) {
        let after = self.points.partition_point(|p| p.value <= value);
        let a = &self.points[after.saturating_sub(1)];
        let b = &self.points[after.min(self.points.len() - 1)];
        let t = if b.value > a.value {
            ((value - a.value) / (b.value - a.value)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let mix = |x: f32, y: f32| x + t * (y - x);
        let color = std::array::from_fn(|c| mix(a.color[c], b.color[c]));
        (color, mix(a.opacity, b.opacity))
    }
}

impl ControlPoint {
    fn check(&self, index: usize) -> Result<(), TransferError> {
        let out = |what, found, allowed| TransferError::OutOfRange {
            index,
            what,
            found,
            allowed,
        };
        if !self.value.is_finite() {
            return Err(out("value", self.value, "a finite number"));
        }
        if !(0.0..=1.0).contains(&self.opacity) {
            return Err(out("opacity", self.opacity, "in 0..1"));
        }
        match self.color.iter().find(|c| !(0.0..=1.0).contains(*c)) {
            Some(&found) => Err(out("colour", found, "in 0..1")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> TransferFunction {
        let point = |value, opacity| ControlPoint {
            value,
            color: [1.0, 0.5, 0.0],
            opacity,
        };
        TransferFunction::new(vec![point(0.0, 0.0), point(100.0, 0.5)], 1.0).unwrap()
    }

    #[test]
    fn evaluation_is_linear_between_points_and_constant_beyond() {
        assert_eq!(ramp().evaluate(50.0), ([1.0, 0.5, 0.0], 0.25));
        assert_eq!(ramp().evaluate(-1.0).1, 0.0);
        assert_eq!(ramp().evaluate(1e9).1, 0.5);
    }

    #[test]
    fn bad_points_are_refused_by_index() {
        let mut points = ramp().points().to_vec();
        points.reverse();
        assert!(matches!(
            TransferFunction::new(points, 1.0),
            Err(TransferError::Unordered { index: 1, .. })
        ));
        let mut points = ramp().points().to_vec();
        points[1].opacity = f32::NAN;
        assert!(matches!(
            TransferFunction::new(points, 1.0),
            Err(TransferError::OutOfRange { index: 1, .. })
        ));
    }
}
