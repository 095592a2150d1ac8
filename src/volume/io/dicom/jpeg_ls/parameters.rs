//! What a scan's numbers mean: how many levels there are, and where gradients are small, middling and large (C.2.4.1, A.2).

/// Preset coding parameters, of which 0 is the usual one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Preset {
    pub most: i32,
    pub thresholds: [i32; 3],
    pub reset: i32,
}

/// The parameters of a scan.
pub(super) struct Parameters {
    /// The largest value.
    pub most: i32,
    /// By how much a sample may be wrong; 0 is lossless.
    pub near: i32,
    /// How many errors differ.
    pub range: i32,
    /// The most bits of a number in Golomb's code.
    pub limit: u32,
    /// Bits of an error that is written as it is.
    pub whole_bits: u32,
    /// After so many samples a context forgets half.
    pub reset: i32,
    thresholds: [i32; 3],
}

impl Parameters {
    /// Of samples of `precision` bits; `None` where they contradict each other.
    pub(super) fn new(precision: u32, near: i32, preset: Preset) -> Option<Self> {
        let largest = (1 << precision) - 1;
        let most = if preset.most == 0 { largest } else { preset.most };
        if !(1..=largest).contains(&most) || !(0..=(most / 2).min(255)).contains(&near) {
            return None;
        }
        let range = (most + 2 * near) / (2 * near + 1) + 1;
        let bits = |levels: i32| 32 - (levels - 1).leading_zeros();
        let sample_bits = bits(most + 1).max(2);
        let usual = usual_thresholds(most, near);
        let thresholds: [i32; 3] = std::array::from_fn(|i| match preset.thresholds[i] {
            0 => usual[i],
            said => said,
        });
        let reset = if preset.reset == 0 { 64 } else { preset.reset };
        let are_sound = thresholds.is_sorted() && near < thresholds[0] && thresholds[2] <= most;
        let is_sound = are_sound && (3..=largest.max(255)).contains(&reset);
        is_sound.then_some(Self {
            most,
            near,
            range,
            limit: 2 * (sample_bits + sample_bits.max(8)),
            whole_bits: bits(range),
            reset,
            thresholds,
        })
    }

    /// What a quantised error stands for, of 1.
    pub(super) fn step(&self) -> i32 {
        2 * self.near + 1
    }

    /// What contexts begin with.
    pub(super) fn first_sizes(&self) -> i32 {
        ((self.range + 32) / 64).max(2)
    }

    /// A gradient's size and sign, from −4 to 4.
    #[inline]
    pub(super) fn quantized(&self, gradient: i32) -> i32 {
        let size = gradient.abs();
        let [small, middling, large] = self.thresholds;
        let level = i32::from(size > self.near)
            + i32::from(size >= small)
            + i32::from(size >= middling)
            + i32::from(size >= large);
        level * gradient.signum()
    }

    /// The sample that is predicted as `prediction`, `error` quantised steps off.
    #[inline]
    pub(super) fn sample(&self, prediction: i32, error: i32) -> i32 {
        let sample = prediction + error * self.step();
        let turn = self.range * self.step();
        let sample = match sample {
            low if low < -self.near => low + turn,
            high if high > self.most + self.near => high - turn,
            sample => sample,
        };
        sample.clamp(0, self.most)
    }
}

fn usual_thresholds(most: i32, near: i32) -> [i32; 3] {
    let [small, middling, large] = match most >= 128 {
        true => {
            let factor = (most.min(4095) + 128) / 256;
            [
                factor + 2 + 3 * near,
                4 * factor + 3 + 5 * near,
                17 * factor + 4 + 7 * near,
            ]
        }
        false => {
            let factor = 256 / (most + 1);
            let at_least = |least: i32, threshold: i32| threshold.max(least);
            [
                at_least(2, 3 / factor + 3 * near),
                at_least(3, 7 / factor + 5 * near),
                at_least(4, 21 / factor + 7 * near),
            ]
        }
    };
    let within = |threshold: i32, least: i32| match (least..=most).contains(&threshold) {
        true => threshold,
        false => least,
    };
    let small = within(small, near + 1);
    let middling = within(middling, small);
    [small, middling, within(large, middling)]
}
