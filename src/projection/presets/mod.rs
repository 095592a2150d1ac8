//! Transfer-function presets for CT, MR and other data (assets/presets).
//!
//! *Practice.* CT values are Hounsfield units, the same on every scanner, so a CT preset states absolute values, by the landmarks of
//! tissues: air −1000, lung −850 to −500, fat −120 to −60, water 0, soft tissue 20 to 80, blood with contrast medium 150 to 400, cancellous
//! bone 200 to 700, cortical bone from 700, metal from 2500. MR and microscopy have no unit, so their presets state fractions of a
//! window, which is fitted to the data's percentiles, or are fitted to modes of the histogram ([`Scale`]).

mod look;
mod modes;
mod read;
mod scale;
mod statistics;

use std::sync::LazyLock;

pub use look::Look;
pub use modes::Modes;
pub use scale::Scale;
pub use statistics::DataStatistics;

use super::TransferFunction;
use crate::math::Interval;

/// What a preset is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Computed tomography, in Hounsfield units.
    Ct,
    /// Magnetic resonance.
    Mr,
    /// Anything else.
    Any,
}

impl Kind {
    /// The kinds' names in the files of presets.
    pub const NAMES: &[(&str, Self)] = &[("ct", Self::Ct), ("mr", Self::Mr), ("any", Self::Any)];

    /// Its name.
    pub fn name(self) -> &'static str {
        let named = Self::NAMES.iter().find(|(_, kind)| *kind == self);
        named.map_or("any", |(name, _)| name)
    }
}

/// A named transfer function that fits itself to data, with the mode and the shading it is meant for.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    name: &'static str,
    text: &'static str,
    kind: Kind,
    scale: Scale,
    description: &'static str,
    range: Interval,
    function: TransferFunction,
    look: Look,
}

impl Preset {
    /// Its name, like `ct-bone`.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Its file.
    pub fn text(&self) -> &'static str {
        self.text
    }

    /// What it is made for.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// What its numbers are.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// One line on what it shows.
    pub fn description(&self) -> &'static str {
        self.description
    }

    /// The mode and the shading it is meant for.
    pub fn look(&self) -> Look {
        self.look
    }

    /// The values that a window stretches or moves, in the preset's own numbers.
    pub fn range(&self) -> Interval {
        self.range
    }

    /// The function in the preset's own numbers.
    pub fn own_function(&self) -> &TransferFunction {
        &self.function
    }

    /// The values, in the preset's own numbers, between which it shows anything: its opacity is 0 below the first and, where it
    /// falls to 0 again, above the second.
    pub fn shown(&self) -> Interval {
        let points = self.function.points();
        let first = points.iter().position(|p| p.opacity > 0.0).unwrap_or(0);
        let last = points.iter().rposition(|p| p.opacity > 0.0).unwrap_or(0);
        let hi = points.get(last + 1).map_or(f32::INFINITY, |p| p.value);
        let lo = first.checked_sub(1).map_or(f32::NEG_INFINITY, |i| points[i].value);
        Interval { lo, hi }
    }

    /// The length that this preset's opacities hold for in a model whose bounds have such a diagonal, millimetres: its own
    /// for patients, a share of the model for what may be of any size.
    pub fn unit_for(&self, diagonal_mm: f64) -> f64 {
        match self.kind {
            Kind::Any if diagonal_mm.is_finite() && diagonal_mm > 0.0 => {
                self.function.unit_mm() * diagonal_mm / Self::SHARES
            }
            _ => self.function.unit_mm(),
        }
    }

    /// A preset for what may be of any size states its unit for a model with a diagonal of so many millimetres.
    const SHARES: f64 = 200.0;

    /// The transfer function for `data`, with opacities that hold for `unit_mm` millimetres, above 0.
    pub fn fitted(&self, data: &DataStatistics, unit_mm: f64) -> TransferFunction {
        self.at_anchors(&self.scale.anchors(data), unit_mm)
    }

    /// The transfer function with [`Preset::range`] laid over `window`, and opacities that hold for `unit_mm` millimetres,
    /// above 0.
    pub fn transfer_function(&self, window: Interval, unit_mm: f64) -> TransferFunction {
        self.at_anchors(&scale::window_anchors(self.range, window), unit_mm)
    }

    fn at_anchors(&self, anchors: &[(f32, f32)], unit_mm: f64) -> TransferFunction {
        let points = self.function.points().iter().map(|p| scale::moved(p, anchors));
        // A window of no width or of huge values, or a length of 0, makes no function; the preset's own then stands.
        TransferFunction::new(points.collect(), unit_mm).unwrap_or_else(|_| self.function.clone())
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
    include_str!("../../../assets/presets/ct-bone-skin.kdl"),
    include_str!("../../../assets/presets/ct-skin.kdl"),
    include_str!("../../../assets/presets/ct-soft-tissue.kdl"),
    include_str!("../../../assets/presets/ct-muscle-bone.kdl"),
    include_str!("../../../assets/presets/ct-muscle.kdl"),
    include_str!("../../../assets/presets/ct-fat.kdl"),
    include_str!("../../../assets/presets/ct-lung.kdl"),
    include_str!("../../../assets/presets/ct-airways.kdl"),
    include_str!("../../../assets/presets/ct-chest.kdl"),
    include_str!("../../../assets/presets/ct-vessels.kdl"),
    include_str!("../../../assets/presets/ct-aorta.kdl"),
    include_str!("../../../assets/presets/ct-cardiac.kdl"),
    include_str!("../../../assets/presets/ct-coronary.kdl"),
    include_str!("../../../assets/presets/ct-pulmonary.kdl"),
    include_str!("../../../assets/presets/ct-liver-vessels.kdl"),
    include_str!("../../../assets/presets/ct-metal.kdl"),
    include_str!("../../../assets/presets/ct-mip.kdl"),
    include_str!("../../../assets/presets/ct-x-ray.kdl"),
    include_str!("../../../assets/presets/mr-default.kdl"),
    include_str!("../../../assets/presets/mr-skin.kdl"),
    include_str!("../../../assets/presets/mr-brain.kdl"),
    include_str!("../../../assets/presets/mr-t1-brain.kdl"),
    include_str!("../../../assets/presets/mr-t1-head.kdl"),
    include_str!("../../../assets/presets/mr-t2.kdl"),
    include_str!("../../../assets/presets/mr-tissue.kdl"),
    include_str!("../../../assets/presets/mr-vessels.kdl"),
    include_str!("../../../assets/presets/mr-mip.kdl"),
    include_str!("../../../assets/presets/grey.kdl"),
    include_str!("../../../assets/presets/grey-8bit.kdl"),
    include_str!("../../../assets/presets/mip.kdl"),
    include_str!("../../../assets/presets/x-ray.kdl"),
    include_str!("../../../assets/presets/micro.kdl"),
    include_str!("../../../assets/presets/fluorescence.kdl"),
    include_str!("../../../assets/presets/electron.kdl"),
    include_str!("../../../assets/presets/ultrasound.kdl"),
    include_str!("../../../assets/presets/signed.kdl"),
    include_str!("../../../assets/presets/spectrum.kdl"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{Material, Mode};

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
            let around = if preset.scale == Scale::Signed {
                0.0
            } else {
                points[0].value
            };
            assert_eq!(
                preset.function.evaluate(around).1,
                0.0,
                "{} shows the air around",
                preset.name
            );
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
            found_modes: None,
        };
        let mr = DataStatistics {
            min: 0.0,
            max: 255.0,
            low: 0.0,
            high: 180.0,
            found_modes: None,
        };
        assert_eq!(suited_to(&ct).kind(), Kind::Ct);
        assert_eq!(suited_to(&mr).name(), "mr-default");
        // What a scene has that says nothing of how it is seen.
        let usual = Look {
            mode: Mode::Composite,
            material: Some(Material::default()),
        };
        assert_eq!([suited_to(&ct), suited_to(&mr)].map(Preset::look), [usual; 2]);
    }

    #[test]
    fn numbers_are_fitted_to_their_anchors() {
        let data = DataStatistics {
            min: -50.0,
            max: 900.0,
            low: -40.0,
            high: 200.0,
            found_modes: Some(Modes {
                background: 10.0,
                tissues: [90.0, 130.0],
            }),
        };
        let first_value = |name: &str| {
            let preset = named(name).unwrap();
            (
                preset.own_function().points()[0].value,
                preset.fitted(&data, 1.0).points()[0].value,
            )
        };
        assert_eq!(first_value("grey"), (0.0, -40.0));
        assert_eq!(first_value("signed"), (-1.0, -200.0));
        assert_eq!(first_value("grey-8bit"), (0.0, 0.0));
        let brain = named("mr-t1-brain").unwrap().fitted(&data, 1.0);
        // 1, 2 and 2.5 of the preset's numbers: the tissues, and half their distance beyond.
        for (at, value) in [(2, 90.0), (5, 130.0), (6, 150.0)] {
            // A product and two sums of numbers below 256.
            assert!((brain.points()[at].value - value).abs() <= 3.0 * 128.0 * f32::EPSILON);
        }
    }
}
