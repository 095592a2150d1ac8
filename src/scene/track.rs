//! One value over time, from its key frames.
//!
//! *Theory.* A smooth track is a cubic between keys that rises where its keys rise, falls where they fall, and goes beyond none of
//! them (Steffen 1990, A simple method for monotonic interpolation in one dimension), so an opacity stays one and a radius above 0. It
//! starts and ends at rest.

use kdl::KdlValue;

use super::element::{Element, Value};
use super::error::{Problem, SceneError};

/// How a value gets from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ease {
    Linear,
    Smooth,
    /// It stays until the next key.
    Step,
}

/// How a value is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Number,
    /// Numbers in a string.
    List,
    /// `"#rrggbb"`.
    Color,
}

/// A value's key frames.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Track {
    /// Numbers, which can lie between keys.
    Numbers {
        form: Form,
        ease: Ease,
        frames: Vec<f64>,
        keys: Vec<Vec<f64>>,
    },
    /// Anything else.
    Steps { frames: Vec<f64>, keys: Vec<KdlValue> },
}

impl Track {
    /// Reads the `at` nodes of a track.
    pub fn read(element: &Element) -> Result<Self, SceneError> {
        let eases = [("linear", Ease::Linear), ("smooth", Ease::Smooth), ("step", Ease::Step)];
        let ease = element.get("ease").map_or(Ok(Ease::Linear), |v| v.one_of(&eases))?;
        let (mut frames, mut keys) = (Vec::new(), Vec::new());
        for key in element.children() {
            let key = key?;
            let frame = key.argument(0);
            if frames
                .last()
                .is_some_and(|&last| frame.number().is_ok_and(|now| now <= last))
            {
                return Err(frame.bad("a later frame than that of the key before"));
            }
            frames.push(frame.number()?);
            keys.push(key.argument(1));
        }
        let Some(first) = keys.first() else {
            let (node, wanted) = (element.name(), "at least one `at` child");
            return Err(element.error(Problem::TooFewChildren { node, wanted, found: 0 }));
        };
        let Some((form, _)) = numbers(first.value()) else {
            let keys = keys.iter().map(|key| key.value().clone()).collect();
            return Ok(Self::Steps { frames, keys });
        };
        let keys = alike(&keys)?;
        Ok(Self::Numbers {
            form,
            ease,
            frames,
            keys,
        })
    }

    /// The value at `frame`; beyond the first and last key it is theirs.
    pub fn at(&self, frame: f64) -> KdlValue {
        match self {
            Self::Steps { frames, keys } => keys[before(frames, frame)].clone(),
            Self::Numbers {
                form,
                ease,
                frames,
                keys,
            } => {
                let number = |n: usize| {
                    let curve: Vec<f64> = keys.iter().map(|key| key[n]).collect();
                    eased(*ease, frames, &curve, frame)
                };
                written(*form, &(0..keys[0].len()).map(number).collect::<Vec<_>>())
            }
        }
    }
}

/// The keys as numbers, if all are written as the first is.
fn alike(keys: &[Value]) -> Result<Vec<Vec<f64>>, SceneError> {
    let shape = |value: &KdlValue| numbers(value).map(|(form, numbers)| (form, numbers.len()));
    let first = shape(keys[0].value());
    keys.iter()
        .map(|key| match numbers(key.value()) {
            Some((_, numbers)) if shape(key.value()) == first => Ok(numbers),
            _ => Err(key.bad("written like the first key's value")),
        })
        .collect()
}

/// A value's numbers and how they are written; `None` if it is none, or not finite.
fn numbers(value: &KdlValue) -> Option<(Form, Vec<f64>)> {
    let (form, numbers) = match value {
        KdlValue::Integer(i) => (Form::Number, vec![*i as f64]),
        KdlValue::Float(f) => (Form::Number, vec![*f]),
        KdlValue::String(text) => match crate::projection::rgb_from_hex(text) {
            Some(rgb) => (Form::Color, rgb.map(|c| f64::from(c) * 255.0).to_vec()),
            None => {
                let words = text.split([' ', '\t', '\n', ',']).filter(|word| !word.is_empty());
                (Form::List, words.map(|word| word.parse().ok()).collect::<Option<_>>()?)
            }
        },
        _ => return None,
    };
    let finite = !numbers.is_empty() && numbers.iter().all(|n| n.is_finite());
    finite.then_some((form, numbers))
}

fn written(form: Form, numbers: &[f64]) -> KdlValue {
    let byte = |n: f64| n.round().clamp(0.0, 255.0) as u8;
    match form {
        Form::Number if numbers[0].fract() == 0.0 && numbers[0].abs() < 2f64.powi(53) => {
            KdlValue::Integer(numbers[0] as i128)
        }
        Form::Number => KdlValue::Float(numbers[0]),
        Form::List => {
            let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
            KdlValue::String(words.join(" "))
        }
        Form::Color => {
            let hex: String = numbers.iter().map(|&n| format!("{:02x}", byte(n))).collect();
            KdlValue::String(format!("#{hex}"))
        }
    }
}

/// The last key at or before `frame`, or the first.
fn before(frames: &[f64], frame: f64) -> usize {
    frames.partition_point(|&at| at <= frame).saturating_sub(1)
}

fn eased(ease: Ease, frames: &[f64], keys: &[f64], frame: f64) -> f64 {
    let key = before(frames, frame);
    let next = key + 1;
    if frame <= frames[0] || next == keys.len() || ease == Ease::Step {
        return keys[key];
    }
    let width = frames[next] - frames[key];
    let t = (frame - frames[key]) / width;
    let rise = keys[next] - keys[key];
    if ease == Ease::Linear {
        return keys[key] + t * rise;
    }
    let (from, to) = (width * slope(frames, keys, key), width * slope(frames, keys, next));
    // Hermite's cubic.
    keys[key] + t * (from + t * ((3.0 * rise - 2.0 * from - to) + t * (from + to - 2.0 * rise)))
}

/// Steffen's slope at a key: 0 where the keys turn, and at both ends.
fn slope(frames: &[f64], keys: &[f64], key: usize) -> f64 {
    if key == 0 || key + 1 == keys.len() {
        return 0.0;
    }
    let [before, after] = [key - 1, key].map(|k| (frames[k + 1] - frames[k], keys[k + 1] - keys[k]));
    let [s, r] = [before, after].map(|(width, rise)| rise / width);
    if s * r <= 0.0 {
        return 0.0;
    }
    let parabola = (s * after.0 + r * before.0) / (before.0 + after.0);
    let least = s.abs().min(r.abs()).min(0.5 * parabola.abs());
    2.0 * least.copysign(s)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn lines_are_straight_and_steps_wait() {
        let (frames, keys) = ([0.0, 10.0, 20.0], [0.0, 5.0, -5.0]);
        let at = |ease, frame| eased(ease, &frames, &keys, frame);
        assert_eq!(
            [-3.0, 0.0, 5.0, 10.0, 15.0, 20.0, 99.0].map(|f| at(Ease::Linear, f)),
            [0.0, 0.0, 2.5, 5.0, 0.0, -5.0, -5.0]
        );
        assert_eq!([0.0, 9.9, 10.0, 25.0].map(|f| at(Ease::Step, f)), [0.0, 0.0, 5.0, -5.0]);
        assert_eq!([0.0, 10.0, 20.0].map(|f| at(Ease::Smooth, f)), keys);
    }

    #[test]
    fn values_are_written_as_they_were() {
        let text = |value: &str| numbers(&value.into()).map(|(form, numbers)| written(form, &numbers));
        assert_eq!(text("1, 2.5  -3"), Some("1 2.5 -3".into()));
        assert_eq!(text("#10ff80"), Some("#10ff80".into()));
        assert_eq!(text("ct-bone"), None);
        assert_eq!(written(Form::Number, &[3.0]), KdlValue::Integer(3));
        assert_eq!(written(Form::Number, &[0.5]), KdlValue::Float(0.5));
    }

    proptest! {
        #[test]
        fn a_smooth_track_stays_between_its_keys(
            steps in prop::collection::vec((0.1f64..9.0, -50.0f64..50.0), 2..7),
            t in 0.0f64..=1.0,
        ) {
            let mut frame = 0.0;
            let frames: Vec<f64> = steps.iter().map(|step| { frame += step.0; frame }).collect();
            let keys: Vec<f64> = steps.iter().map(|step| step.1).collect();
            for key in 1..keys.len() {
                let (lo, hi) = (keys[key - 1].min(keys[key]), keys[key - 1].max(keys[key]));
                let at = frames[key - 1] + t * (frames[key] - frames[key - 1]);
                let found = eased(Ease::Smooth, &frames, &keys, at);
                let rounding = 1e-12 * (lo.abs() + hi.abs());
                prop_assert!(lo - rounding <= found && found <= hi + rounding, "{} not in {}..{}", found, lo, hi);
            }
        }
    }
}
