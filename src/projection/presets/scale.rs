//! What the numbers of a preset are, and which values of some data they mean.

use super::DataStatistics;
use crate::math::Interval;
use crate::model::ControlPoint;

/// What the values of a preset's points are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Values themselves: Hounsfield units, or levels of an 8-bit image.
    Absolute,
    /// 0 and 1 are the ends of the data's window.
    Window,
    /// −1, 0 and 1 are minus the largest magnitude, 0 and the largest magnitude of the data's window.
    Signed,
    /// 0, 1 and 2 are modes of the data's histogram: of the background, and of the two tissues that there is most of.
    Modes,
}

impl Scale {
    /// The scales' names in the files of presets.
    pub const NAMES: &[(&str, Self)] = &[
        ("absolute", Self::Absolute),
        ("window", Self::Window),
        ("signed", Self::Signed),
        ("modes", Self::Modes),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        let named = Self::NAMES.iter().find(|(_, scale)| *scale == self);
        named.map_or("absolute", |(name, _)| name)
    }

    /// The values that a preset's numbers mean in `data`: pairs of a number and its value, both rising; empty for what means
    /// itself.
    pub(super) fn anchors(self, data: &DataStatistics) -> Vec<(f32, f32)> {
        let window = data.window();
        match self {
            Self::Absolute => Vec::new(),
            Self::Window => vec![(0.0, window.lo), (1.0, window.hi)],
            Self::Signed => {
                let largest = window.lo.abs().max(window.hi.abs());
                vec![(-1.0, -largest), (1.0, largest)]
            }
            Self::Modes => {
                let modes = data.modes();
                let [first, second] = modes.tissues;
                vec![(0.0, modes.background), (1.0, first), (2.0, second)]
            }
        }
    }
}

/// The anchors that lay `range` over `window`.
pub(super) fn window_anchors(range: Interval, window: Interval) -> Vec<(f32, f32)> {
    match range == window {
        true => Vec::new(),
        false => vec![(range.lo, window.lo), (range.hi, window.hi)],
    }
}

/// `point`, its value on the line between the anchors about it, or beyond the last ones on the lines through them.
pub(super) fn moved(point: &ControlPoint, anchors: &[(f32, f32)]) -> ControlPoint {
    let Some(last) = anchors.len().checked_sub(2) else {
        return *point;
    };
    let pair = anchors[1..].partition_point(|anchor| anchor.0 <= point.value).min(last);
    let ((from, to_from), (until, to_until)) = (anchors[pair], anchors[pair + 1]);
    let scale = (to_until - to_from) / (until - from);
    ControlPoint {
        value: to_from + (point.value - from) * scale,
        ..*point
    }
}
