//! JPEG-LS, lossless and near-lossless.
//!
//! *Theory.* ITU-T T.87: a sample is predicted from its neighbours, the prediction is corrected by what samples with alike gradients
//! taught, and the error is written in Golomb's code of a parameter learnt likewise; where all is flat, runs are.
//!
//! *Practice.* Each sample takes a bounded number of steps whatever the bits are, and errors that no encoder makes are refused. Mapping
//! tables, oversize images and HP's transforms of colours are not read; nothing in DICOM writes them.

mod bits;
mod contexts;
mod parameters;
mod scan;

use self::bits::{Bits, Damaged};
use self::parameters::{Parameters, Preset};
use self::scan::Scan;

/// A decoded image.
#[derive(Debug, PartialEq)]
pub(super) struct Image {
    /// Bits of a sample.
    pub precision: u32,
    /// Its samples, those of a pixel together.
    pub samples: Vec<u16>,
}

/// What a frame header says.
#[derive(Debug)]
struct Frame {
    precision: u32,
    width: usize,
    height: usize,
    /// The components' names, in their order.
    components: Vec<u8>,
}

/// How a scan's components follow each other.
#[derive(Clone, Copy)]
enum Interleaving {
    /// Line by line; there may be one component alone.
    Lines,
    /// Pixel by pixel.
    Samples,
}

/// What lies between the start of the image and its end.
struct Decoder<'a> {
    stream: &'a [u8],
    frame: Frame,
    preset: Preset,
    /// Lines between restarts; 0 without any.
    restart: usize,
    samples: Vec<u16>,
}

const START: u8 = 0xd8;
const END: u8 = 0xd9;
const FRAME: u8 = 0xf7;
const PRESET: u8 = 0xf8;
const SCAN: u8 = 0xda;
const RESTART: u8 = 0xdd;

/// The image in `stream`, if its width, height and number of components are `wanted`: only then is there room made for it.
pub(super) fn decode(stream: &[u8], wanted: impl Fn([usize; 3]) -> Result<(), String>) -> Result<Image, String> {
    if !stream.starts_with(&[0xff, START]) {
        return Err("it is no JPEG-LS stream".to_owned());
    }
    let (mut at, mut preset, mut restart) = (2, Preset::default(), 0);
    let frame = loop {
        let (marker, segment, end) = next_segment(stream, at)?;
        at = end;
        match marker {
            FRAME => break Frame::read(segment).ok_or("its JPEG-LS frame header is damaged")?,
            _ => other(marker, segment, &mut preset, &mut restart)?,
        }
    };
    wanted([frame.width, frame.height, frame.components.len()])?;
    let samples = vec![0; frame.width * frame.height * frame.components.len()];
    let mut decoder = Decoder {
        stream,
        frame,
        preset,
        restart,
        samples,
    };
    decoder.scans(at)?;
    Ok(Image {
        precision: decoder.frame.precision,
        samples: decoder.samples,
    })
}

/// The marker from `at` on, its segment, and where that ends.
fn next_segment(stream: &[u8], at: usize) -> Result<(u8, &[u8], usize), String> {
    let missing = || "its JPEG-LS stream ends before its samples".to_owned();
    let rest = stream.get(at..).unwrap_or_default();
    let before = (rest
        .windows(2)
        .position(|pair| pair[0] == 0xff && pair[1] >= 0x80 && pair[1] != 0xff))
    .ok_or_else(missing)?;
    let (marker, start) = (rest[before + 1], before + 2);
    if marker == END {
        return Err(missing());
    }
    if let START | 0xd0..=0xd7 = marker {
        return Ok((marker, &[], at + start));
    }
    let length = rest.get(start..start + 2).ok_or_else(missing)?;
    let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
    let segment = rest.get(start + 2..start + length).ok_or_else(missing)?;
    Ok((marker, segment, at + start + length))
}

/// What a segment that is neither a frame's header nor a scan's says.
fn other(marker: u8, segment: &[u8], preset: &mut Preset, restart: &mut usize) -> Result<(), String> {
    let number = |at: usize| {
        segment
            .get(at..at + 2)
            .map(|b| i32::from(u16::from_be_bytes([b[0], b[1]])))
    };
    match (marker, segment.first()) {
        (PRESET, Some(1)) => {
            let numbers: Option<Vec<i32>> = (0..5).map(|i| number(1 + 2 * i)).collect();
            let [most, small, middling, large, reset] = numbers.unwrap_or_default()[..] else {
                return Err("its JPEG-LS coding parameters are damaged".to_owned());
            };
            *preset = Preset {
                most,
                thresholds: [small, middling, large],
                reset,
            };
            Ok(())
        }
        (PRESET, _) => Err("mapping tables and large sizes of JPEG-LS are not read".to_owned()),
        (RESTART, _) => {
            *restart = segment
                .iter()
                .fold(0, |sum: usize, byte| (sum << 8 | usize::from(*byte)) & 0xffff_ffff);
            Ok(())
        }
        // Hewlett-Packard's: a transform of colours but the first, which is none.
        (0xe8, _) if segment.starts_with(b"mrfx") && segment.get(4).is_some_and(|transform| *transform != 0) => {
            Err("transforms of colours in JPEG-LS are not read".to_owned())
        }
        _ => Ok(()),
    }
}

impl Frame {
    fn read(segment: &[u8]) -> Option<Self> {
        let (&[precision, h1, h0, w1, w0, count], components) = segment.split_first_chunk()?;
        let frame = Self {
            precision: u32::from(precision),
            width: usize::from(u16::from_be_bytes([w1, w0])),
            height: usize::from(u16::from_be_bytes([h1, h0])),
            components: components.chunks_exact(3).map(|component| component[0]).collect(),
        };
        let is_sound = (2..=16).contains(&precision) && frame.width > 0 && frame.height > 0;
        (is_sound && (1..=4).contains(&count) && frame.components.len() == usize::from(count)).then_some(frame)
    }
}

impl Decoder<'_> {
    /// Decodes scans from `at` on until each component has come.
    fn scans(&mut self, mut at: usize) -> Result<(), String> {
        let mut left = self.frame.components.len();
        while left > 0 {
            let (marker, segment, end) = next_segment(self.stream, at)?;
            at = end;
            match marker {
                SCAN => {
                    let (components, parameters, interleaving) =
                        self.scan_header(segment).ok_or("its JPEG-LS scan header is damaged")?;
                    let damaged = |_: Damaged| "the coded samples of its JPEG-LS stream are damaged".to_owned();
                    at = self.scan(at, &components, &parameters, interleaving).map_err(damaged)?;
                    left = left.saturating_sub(components.len());
                }
                _ => other(marker, segment, &mut self.preset, &mut self.restart)?,
            }
        }
        Ok(())
    }

    /// The scan's components, its parameters, and how the components follow each other.
    fn scan_header(&self, segment: &[u8]) -> Option<(Vec<usize>, Parameters, Interleaving)> {
        let (&count, rest) = segment.split_first()?;
        let (selectors, rest) = rest.split_at_checked(2 * usize::from(count))?;
        let [near, mode, ..] = *rest else { return None };
        let index = |name: u8| self.frame.components.iter().position(|component| *component == name);
        let components: Option<Vec<usize>> = selectors.chunks_exact(2).map(|selector| index(selector[0])).collect();
        let components = components.filter(|all| !all.is_empty() && (all.len() == 1 || mode > 0))?;
        let parameters = Parameters::new(self.frame.precision, i32::from(near), self.preset)?;
        let interleaving = match mode {
            0 | 1 => Interleaving::Lines,
            2 => Interleaving::Samples,
            _ => return None,
        };
        Some((components, parameters, interleaving))
    }

    /// Decodes the scan at `at`; where it ends.
    fn scan(
        &mut self,
        mut at: usize,
        components: &[usize],
        parameters: &Parameters,
        interleaving: Interleaving,
    ) -> Result<usize, Damaged> {
        let Frame { width, height, .. } = self.frame;
        let interval = if self.restart == 0 { height } else { self.restart };
        for first in (0..height).step_by(interval) {
            if first > 0 {
                let (marker, _, end) = next_segment(self.stream, at).map_err(|_| Damaged)?;
                at = if (0xd0..=0xd7).contains(&marker) {
                    end
                } else {
                    return Err(Damaged);
                };
            }
            let mut scan = Scan::new(Bits::new(self.stream, at), parameters, width, components.len());
            for y in first..height.min(first + interval) {
                match interleaving {
                    Interleaving::Samples => put(&mut self.samples, &self.frame, y, components, scan.by_sample()?),
                    Interleaving::Lines => put(&mut self.samples, &self.frame, y, components, scan.by_line()?),
                }
            }
            at = scan.bits.end();
        }
        Ok(at)
    }
}

/// Puts line `y` of some components among all samples.
fn put<'a>(samples: &mut [u16], frame: &Frame, y: usize, components: &[usize], lines: impl Iterator<Item = &'a [i32]>) {
    let step = frame.components.len();
    let row = &mut samples[y * frame.width * step..][..frame.width * step];
    for (component, line) in components.iter().zip(lines) {
        let places = row.iter_mut().skip(*component).step_by(step);
        places.zip(line).for_each(|(place, sample)| *place = *sample as u16);
    }
}

#[cfg(test)]
mod tests {
    use charls::{CharLS, FrameInfo, InterleaveMode};
    use proptest::prelude::*;

    use super::*;

    fn encoded(size: [usize; 3], precision: u32, near: i32, mode: InterleaveMode, samples: &[u16]) -> Vec<u8> {
        let info = FrameInfo {
            width: size[0] as u32,
            height: size[1] as u32,
            bits_per_sample: precision as i32,
            component_count: size[2] as i32,
        };
        let planar = |i: usize| samples[i % (size[0] * size[1]) * size[2] + i / (size[0] * size[1])];
        let ordered: Vec<u16> = match mode {
            InterleaveMode::None => (0..samples.len()).map(planar).collect(),
            _ => samples.to_vec(),
        };
        let bytes: Vec<u8> = match precision {
            ..=8 => ordered.iter().map(|v| *v as u8).collect(),
            _ => ordered.iter().flat_map(|v| v.to_ne_bytes()).collect(),
        };
        let mut encoder = CharLS::default();
        encoder.set_interleave_mode(mode).unwrap();
        encoder.encode(info, near, &bytes).unwrap()
    }

    /// Steps, slopes, noise and flat parts.
    fn picture([width, height, components]: [usize; 3], precision: u32, seed: u32) -> Vec<u16> {
        let most = (1_u32 << precision) - 1;
        let mut state = seed;
        let mut noise = |size: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % size.max(1)
        };
        let rough = noise(most + 1);
        let value = |i: usize, noise: &mut dyn FnMut(u32) -> u32| {
            let (x, y) = (i / components % width, i / components / width);
            let flat = (x / 5 + y / 3) as u32 % 4 * (most / 5);
            let detail = if (x / 7 + y / 4).is_multiple_of(3) {
                noise(rough + 1)
            } else {
                0
            };
            (flat + detail + (x * y) as u32 / 9 * u32::from(x % 11 > 5)).min(most) as u16
        };
        (0..width * height * components).map(|i| value(i, &mut noise)).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

        /// CharLS is the codec of whose kind most files come.
        #[test]
        fn it_decodes_what_charls_encodes(
            width in 1usize..40,
            height in 1usize..30,
            components in prop_oneof![Just(1usize), Just(3)],
            precision in 2u32..=16,
            near in 0i32..4,
            mode in 0usize..3,
            seed in any::<u32>(),
        ) {
            let size = [width, height, components];
            let mode = match components {
                1 => InterleaveMode::None,
                _ => [InterleaveMode::None, InterleaveMode::Line, InterleaveMode::Sample][mode],
            };
            let near = near.min(((1 << precision) - 1) / 2);
            let samples = picture(size, precision, seed);
            let stream = encoded(size, precision, near, mode, &samples);
            let image = decode(&stream, |found| (found == size).then_some(()).ok_or("another size".into())).unwrap();
            prop_assert_eq!(image.precision, precision);
            if near == 0 {
                prop_assert_eq!(image.samples, samples);
            } else {
                let theirs = CharLS::default().decode(&stream).unwrap();
                let theirs: Vec<u16> = match precision {
                    ..=8 => theirs.iter().map(|v| u16::from(*v)).collect(),
                    _ => theirs.chunks_exact(2).map(|b| u16::from_ne_bytes([b[0], b[1]])).collect(),
                };
                let pixels = width * height;
                let ours = |i: usize| match mode {
                    InterleaveMode::None => image.samples[i % pixels * components + i / pixels],
                    _ => image.samples[i],
                };
                prop_assert_eq!((0..theirs.len()).map(ours).collect::<Vec<_>>(), theirs);
            }
        }

        #[test]
        fn damage_is_refused_or_read(at in any::<prop::sample::Index>(), to in any::<u8>(), cut in any::<prop::sample::Index>()) {
            let size = [20, 15, 3];
            let mut stream = encoded(size, 12, 0, InterleaveMode::Line, &picture(size, 12, 7));
            let place = at.index(stream.len());
            stream[place] = to;
            let _ = decode(&stream, |found| (found == size).then_some(()).ok_or(String::new()));
            stream.truncate(cut.index(stream.len()));
            let _ = decode(&stream, |found| (found == size).then_some(()).ok_or(String::new()));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

        /// Among them are those whose contexts learn errors that no samples have, at which a decoder may count for ever.
        #[test]
        fn any_bits_are_samples_or_refused(
            bits in prop::collection::vec(prop_oneof![any::<u8>(), Just(0), Just(0xff), Just(0x7f)], 0..400),
            precision in 2u8..=16,
            components in prop_oneof![Just(1u8), Just(3)],
            near in 0u8..3,
            interleaving in 0u8..3,
        ) {
            let names: Vec<u8> = (1..=components).collect();
            let frame: Vec<u8> = names.iter().flat_map(|name| [*name, 0x11, 0]).collect();
            let scan: Vec<u8> = names.iter().flat_map(|name| [*name, 0]).collect();
            let stream = [
                &[0xff, START, 0xff, FRAME, 0, 8 + 3 * components, precision, 0, 16, 0, 16, components][..],
                &frame,
                &[0xff, SCAN, 0, 6 + 2 * components, components],
                &scan,
                &[near, interleaving, 0],
                &bits,
            ];
            let decoded = decode(&stream.concat(), |_| Ok(()));
            prop_assert!(decoded.is_err() || decoded.is_ok_and(|image| image.samples.len() == 256 * usize::from(components)));
        }
    }

    #[test]
    fn restarts_begin_anew() {
        // Two lines of one sample each, whose second lies behind a restart: both are written against zeros.
        let size = [1, 1, 1];
        let coded = |value: u16| {
            let stream = encoded(size, 8, 0, InterleaveMode::None, &[value]);
            let start = stream.windows(2).position(|pair| pair == [0xff, SCAN]).unwrap() + 10;
            stream[start..stream.len() - 2].to_vec()
        };
        let frame = [0xff, FRAME, 0, 11, 8, 0, 2, 0, 1, 1, 1, 0x11, 0];
        let scan = [0xff, SCAN, 0, 8, 1, 1, 0, 0, 0, 0];
        let stream = [
            &[0xff, START][..],
            &[0xff, RESTART, 0, 4, 0, 1],
            &frame,
            &scan,
            &coded(77),
            &[0xff, 0xd0],
            &coded(12),
            &[0xff, END],
        ];
        let image = decode(&stream.concat(), |_| Ok(())).unwrap();
        assert_eq!(image.samples, [77, 12]);
    }
}
