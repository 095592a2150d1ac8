//! Transfer-function presets for CT, MR and other data (assets/presets).
//!
//! *Practice.* CT values are Hounsfield units, the same on every scanner, so a CT preset states absolute values. MR and
//! microscopy have no unit, so their presets state fractions of a window, which is fitted to the data's percentiles.

mod read;
mod statistics;

use std::sync::LazyLock;

pub use statistics::DataStatistics;

use super::{ControlPoint, TransferFunction};
use crate::math::Interval;

/// What a preset is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Hounsfield units.
    Ct,
    /// Magnetic resonance: fractions of a window.
    Mr,
    /// Anything else: fractions of a window.
    Any,
}

/// A named transfer function that fits itself to data.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    name: &'static str,
    kind: Kind,
    description: &'static str,
    range: Interval,
    function: TransferFunction,
}

impl Preset {
    /// Its name, like `ct-bone`.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// What it is made for.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// One line on what it shows.
    pub fn description(&self) -> &'static str {
        self.description
    }

    /// The values that a window stretches or moves: Hounsfield units for CT, else 0 to 1.
    pub fn range(&self) -> Interval {
        self.range
    }

    /// The window that this preset has on data with such statistics: its own for CT, else the data's.
    pub fn window_for(&self, data: &DataStatistics) -> Interval {
        match self.kind {
            Kind::Ct => self.range,
            Kind::Mr | Kind::Any => data.window(),
        }
    }

    /// The length that this preset's opacities hold for in a model whose bounds have such a diagonal, millimetres: its own
    /// for patients, a share of the model for what may be of any size.
    pub fn unit_for(&self, diagonal_mm: f64) -> f64 {
        match self.kind {
            Kind::Any if diagonal_mm.is_finite() && diagonal_mm > 0.0 => diagonal_mm / 200.0,
            _ => self.function.unit_mm(),
        }
    }

    /// The transfer function with [`Preset::range`] laid over `window`, and opacities that hold for `unit_mm` millimetres,
    /// above 0.
    pub fn transfer_function(&self, window: Interval, unit_mm: f64) -> TransferFunction {
        let scale = window.width() / self.range.width();
        let moved = |p: &ControlPoint| ControlPoint {
            value: window.lo + (p.value - self.range.lo) * scale,
            ..*p
        };
        let points = match window == self.range {
            true => self.function.points().to_vec(),
            false => self.function.points().iter().map(moved).collect(),
        };
        // A window of no width or of huge values, or a length of 0, makes no function; the preset's own then stands.
        TransferFunction::new(points, unit_mm).unwrap_or_else(|_| self.function.clone())
    }
}

/// All presets: CT, MR, then the rest.
pub fn all() -> &'static [Preset] {
    static PRESETS: LazyLock<Vec<Preset>> = LazyLock::new(|| {
        let read = |&text: &&'static str| read::preset(text).expect("a test reads every embedded preset");
        TEXTS.iter().map(read).collect()
    });
    &PRESETS
}

/// The preset called `name`.
pub fn named(name: &str) -> Option<&'static Preset> {
    all().iter().find(|preset| preset.name == name)
}

/// The preset that a bare volume gets: bone and skin for what looks like CT, else a general one.
pub fn suited_to(data: &DataStatistics) -> &'static Preset {
    let name = if data.looks_like_ct() {
        "ct-muscle-bone"
    } else {
        "mr-default"
    };
    named(name).unwrap_or(&all()[0])
}

const TEXTS: &[&str] = &[
    include_str!("../../../assets/presets/ct-bone.kdl"),
    include_str!("../../../assets/presets/ct-skin.kdl"),
    include_str!("../../../assets/presets/ct-soft-tissue.kdl"),
    include_str!("../../../assets/presets/ct-muscle-bone.kdl"),
    include_str!("../../../assets/presets/ct-lung.kdl"),
    include_str!("../../../assets/presets/ct-airways.kdl"),
    include_str!("../../../assets/presets/ct-vessels.kdl"),
    include_str!("../../../assets/presets/ct-metal.kdl"),
    include_str!("../../../assets/presets/mr-default.kdl"),
    include_str!("../../../assets/presets/mr-skin.kdl"),
    include_str!("../../../assets/presets/mr-brain.kdl"),
    include_str!("../../../assets/presets/mr-tissue.kdl"),
    include_str!("../../../assets/presets/mr-vessels.kdl"),
    include_str!("../../../assets/presets/grey.kdl"),
    include_str!("../../../assets/presets/x-ray.kdl"),
    include_str!("../../../assets/presets/micro.kdl"),
    include_str!("../../../assets/presets/fluorescence.kdl"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_reads_and_has_its_own_name_and_words() {
        assert!(all().len() >= 12);
        for (i, preset) in all().iter().enumerate() {
            assert!(
                all()[..i].iter().all(|other| other.name != preset.name),
                "{}",
                preset.name
            );
            assert!(preset.description.len() > 20, "{}", preset.name);
            assert!(preset.range.width() > 0.0, "{}", preset.name);
            let points = preset.function.points();
            assert!(points.iter().any(|p| p.opacity > 0.0), "{} shows nothing", preset.name);
            assert_eq!(points[0].opacity, 0.0, "{} shows the air around", preset.name);
            assert_eq!(preset.kind == Kind::Ct, preset.name.starts_with("ct-"));
        }
    }

    #[test]
    fn a_window_moves_the_range_and_the_own_range_moves_nothing() {
        let preset = named("mr-brain").unwrap();
        let moved = preset.transfer_function(Interval::new(100.0, 300.0), 2.0);
        assert_eq!(moved.unit_mm(), 2.0);
        for (own, moved) in preset.function.points().iter().zip(moved.points()) {
            // Two roundings of numbers below 512.
            assert!((moved.value - (100.0 + 200.0 * own.value)).abs() <= 2.0 * 512.0 * f32::EPSILON);
        }
        let bone = named("ct-bone").unwrap();
        assert_eq!(bone.transfer_function(bone.range(), 1.0), bone.function);
    }

    #[test]
    fn the_automatic_choice_tells_ct_from_the_rest() {
        let ct = DataStatistics {
            min: -1024.0,
            max: 2976.0,
            low: -1020.0,
            high: 1100.0,
        };
        let mr = DataStatistics {
            min: 0.0,
            max: 255.0,
            low: 0.0,
            high: 180.0,
        };
        assert_eq!(suited_to(&ct).kind(), Kind::Ct);
        assert_eq!(suited_to(&mr).name(), "mr-default");
    }
}
