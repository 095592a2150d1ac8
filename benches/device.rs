//! What a device can do at best: 256 full-screen quads of 512 × 512 pixels through one 3D texture of 256³ texels, one stage
//! of the work after another. `cargo bench --bench device [-- PART OF A NAME]`.
//!
//! The rates are the ceiling that drawing a volume is measured against, and the reason for the formats it uses.

use std::cell::RefCell;
use std::f32::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

use vcsg::gpu::{
    Binding, BindingKind, Bindings, Blend, Buffer, Device, DeviceSelector, Draw, Elements, Extent,
    Filter, Format, GpuError, GraphicsPipeline, Image, ImageRole, Instance, Load, PipelineDesc,
    Push, Recording, RenderPass, Requirements, Sampler, Target, Topology, Validation,
};

mod shaders {
    include!(concat!(env!("OUT_DIR"), "/bench_shaders.rs"));
}

fn shader(file: &str) -> &'static [u32] {
    let found = shaders::ALL.iter().find(|shader| shader.0 == file);
    found.map_or(&[], |shader| shader.1)
}

const EDGE: u32 = 256;
const LAYERS: u32 = 256;
const TARGET_EDGE: u32 = 512;
/// Layers a submission: short ones find quiet moments on a busy host.
const STEP: u32 = 32;
const ROUNDS: usize = 5;

const VALUE: u32 = 0;
const TABLE: u32 = 1;
const SKIP: u32 = 2;
const SHADE: u32 = 3;
const CORRECT: u32 = 4;

/// One thing to time. Specialization constants as in `layers.frag`.
#[derive(Clone)]
struct Case {
    name: String,
    values: Format,
    table: Format,
    table_width: u32,
    target: Format,
    blend: Option<Blend>,
    /// The part of the texels that the table shows.
    visible: f32,
    constants: Vec<(u32, u32)>,
}

fn case(name: &str, change: impl FnOnce(&mut Case)) -> Case {
    let mut case = Case {
        name: name.to_owned(),
        values: Format::R8_UNORM,
        table: Format::R8G8B8A8_UNORM,
        table_width: 256,
        target: Format::R32G32B32A32_SFLOAT,
        blend: Some(Blend::Over),
        visible: 1.0,
        constants: Vec::new(),
    };
    change(&mut case);
    case
}

fn main() -> Result<(), GpuError> {
    let instance = Instance::new(Validation::Off)?;
    let device = Device::open(
        &instance,
        &DeviceSelector::Default,
        &Requirements::default(),
    )?;
    let info = device.info();
    println!(
        "{}, {} {}: {TARGET_EDGE}² × {LAYERS} samples, {ROUNDS} rounds",
        info.name, info.driver, info.driver_version
    );
    println!(
        "{:<58} {:>8} {:>10} {:>8} {:>9} {:>12}",
        "", "min ms", "median ms", "Msam/s", "CPU ms", "Msam/s @2CPU"
    );
    let part = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with("--"))
        .unwrap_or_default();
    let scene = Scene::new(&device);
    for case in cases().into_iter().filter(|case| case.name.contains(&part)) {
        let Times {
            least,
            median,
            processor,
        } = scene.time(&case)?;
        let rate =
            |milliseconds: f64| f64::from(TARGET_EDGE * TARGET_EDGE * LAYERS) / milliseconds / 1e3;
        let (wall, quiet) = (rate(least), rate(processor / 2.0));
        println!(
            "{:<58} {least:8.1} {median:10.1} {wall:8.1} {processor:9.1} {quiet:12.1}",
            case.name
        );
    }
    Ok(())
}

/// Milliseconds of a case: the sum of each submission's least and the median round by the wall clock, and the sum of the
/// least processor times, which says on a device that is the host's processor what the wall clock would say were nothing
/// else running.
struct Times {
    least: f64,
    median: f64,
    processor: f64,
}

/// Processor time of all threads of this process so far, milliseconds; 0 where Linux' /proc is not.
fn processor_ms() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task")
        .into_iter()
        .flatten()
        .flatten();
    let nanoseconds = |text: String| {
        text.split(' ')
            .next()
            .and_then(|first| first.parse::<f64>().ok())
    };
    let statistics =
        threads.filter_map(|thread| std::fs::read_to_string(thread.path().join("schedstat")).ok());
    statistics.filter_map(nanoseconds).sum::<f64>() / 1e6
}

fn cases() -> Vec<Case> {
    let mut cases = vec![
        case("f: blend alone", |case| case.constants = vec![(VALUE, 0)]),
        case("f: blend alone, RGBA16F target", |case| {
            (case.constants, case.target) = (vec![(VALUE, 0)], Format::R16G16B16A16_SFLOAT);
        }),
        case("f: blend alone, RGBA8 target", |case| {
            (case.constants, case.target) = (vec![(VALUE, 0)], Format::R8G8B8A8_UNORM);
        }),
        case("f: write without blend", |case| {
            (case.constants, case.blend) = (vec![(VALUE, 0)], None)
        }),
        case("f: max instead of over", |case| {
            (case.constants, case.blend) = (vec![(VALUE, 0)], Some(Blend::Max))
        }),
    ];
    cases.extend(VALUE_FORMATS.map(|values| {
        case(&format!("a: fetch + over, {values:?}"), |case| {
            case.values = values
        })
    }));
    cases.extend(value_and_table());
    cases.extend(targets());
    cases.extend(skipping());
    cases.extend(shading());
    cases
}

const VALUE_FORMATS: [Format; 9] = [
    Format::R8_UNORM,
    Format::R16_UNORM,
    Format::R16_SFLOAT,
    Format::R32_SFLOAT,
    Format::R8G8_UNORM,
    Format::R16G16_UNORM,
    Format::R8G8B8A8_UNORM,
    Format::R16G16B16A16_UNORM,
    Format::R16G16B16A16_SFLOAT,
];

fn value_and_table() -> Vec<Case> {
    let float = Format::R32G32B32A32_SFLOAT;
    let tables = [
        ("linear RGBA8, 256 entries", 1, Format::R8G8B8A8_UNORM, 256),
        (
            "linear RGBA16F, 256 entries",
            1,
            Format::R16G16B16A16_SFLOAT,
            256,
        ),
        ("linear RGBA32F, 256 entries", 1, float, 256),
        ("linear RGBA32F, 1024 entries", 1, float, 1024),
        ("texelFetch, 1024 RGBA32F", 2, float, 1024),
        ("2 texelFetch + mix, 1024 RGBA32F", 3, float, 1024),
        ("uniform array, 1024 vec4", 4, float, 1024),
        ("storage array, 1024 vec4", 5, float, 1024),
        ("2 uniform reads + mix", 6, float, 1024),
        ("2 storage reads + mix", 7, float, 1024),
        ("arithmetic ramp, no table", 8, float, 1024),
    ];
    let with = |values: Format, short: &'static str| {
        tables.map(|(name, kind, table, width)| {
            case(&format!("b: {short} fetch + {name} + over"), |case| {
                (case.values, case.table, case.table_width) = (values, table, width);
                case.constants = vec![(TABLE, kind)];
            })
        })
    };
    let few = with(Format::R16_UNORM, "R16").into_iter().step_by(3);
    with(Format::R8_UNORM, "R8")
        .into_iter()
        .chain(few)
        .collect()
}

fn targets() -> Vec<Case> {
    [
        Format::R8G8B8A8_UNORM,
        Format::R16G16B16A16_SFLOAT,
        Format::R32G32B32A32_SFLOAT,
    ]
    .map(|target| {
        case(
            &format!("c: R8 fetch + storage array + over into {target:?}"),
            |case| {
                (case.target, case.constants) = (target, vec![(TABLE, 5)]);
            },
        )
    })
    .into()
}

fn skipping() -> Vec<Case> {
    [1.0, 0.3]
        .into_iter()
        .flat_map(|visible| {
            [
                ("blend all", 0),
                ("discard if alpha <= 0", 1),
                ("return if alpha <= 0", 2),
            ]
            .map(|(name, skip)| {
                case(
                    &format!(
                        "d: R8 + storage array, {:.0} % visible, {name}",
                        visible * 100.0
                    ),
                    |case| {
                        (case.visible, case.constants) = (visible, vec![(TABLE, 5), (SKIP, skip)]);
                    },
                )
            })
        })
        .chain([1.0, 0.3].map(|visible| {
            case(
                &format!(
                    "d: R8 + storage array, {:.0} % visible, pow, return",
                    visible * 100.0
                ),
                |case| {
                    (case.visible, case.constants) =
                        (visible, vec![(TABLE, 5), (SKIP, 2), (CORRECT, 1)]);
                },
            )
        }))
        .collect()
}

fn shading() -> Vec<Case> {
    let kinds = [
        ("RGBA8 normal fetch", 1, Format::R8_UNORM),
        ("6 taps", 2, Format::R8_UNORM),
        ("3 taps", 3, Format::R8_UNORM),
        ("normal and value in one RGBA8", 4, Format::R8G8B8A8_UNORM),
        (
            "normal and value in one RGBA16",
            4,
            Format::R16G16B16A16_UNORM,
        ),
        (
            "normal and value in one RGBA16F",
            4,
            Format::R16G16B16A16_SFLOAT,
        ),
        ("6 taps, R16", 2, Format::R16_UNORM),
        ("RGBA8 normal fetch, R16", 1, Format::R16_UNORM),
    ];
    let shaded = |name: &str, shade: u32, values: Format, visible: f32, skip: u32| {
        let branch = ["no branch", "discard", "return"][skip as usize];
        let percent = visible * 100.0;
        case(
            &format!("e: shaded, {name}, {percent:.0} % visible, {branch}"),
            |case| {
                (case.values, case.visible) = (values, visible);
                case.constants = vec![(TABLE, 5), (SKIP, skip), (SHADE, shade)];
            },
        )
    };
    let (name, shade, values) = kinds[0];
    let branches = [(1.0, 0), (1.0, 1), (0.3, 0), (0.3, 1)];
    let branches = branches.map(|(visible, skip)| shaded(name, shade, values, visible, skip));
    let kinds = kinds.into_iter().flat_map(|(name, shade, values)| {
        [1.0, 0.3].map(|visible| shaded(name, shade, values, visible, 2))
    });
    kinds.chain(branches).collect()
}

/// What all cases draw.
struct Scene {
    device: Arc<Device>,
    values: Vec<f32>,
    sorted: Vec<f32>,
    cubes: RefCell<Vec<Arc<Image>>>,
}

impl Scene {
    fn new(device: &Arc<Device>) -> Self {
        let values = smooth_values();
        let mut sorted: Vec<f32> = values.iter().step_by(997).copied().collect();
        sorted.sort_by(f32::total_cmp);
        Self {
            device: Arc::clone(device),
            values,
            sorted,
            cubes: RefCell::default(),
        }
    }

    fn time(&self, case: &Case) -> Result<Times, GpuError> {
        let recordings = self.recordings(case)?;
        // The first round compiles and warms.
        recordings
            .iter()
            .try_for_each(|recording| self.device.submit(recording)?.wait())?;
        let mut steps = vec![(f64::INFINITY, f64::INFINITY); recordings.len()];
        let mut rounds = Vec::new();
        for _ in 0..ROUNDS {
            let mut round = 0.0;
            for (recording, least) in recordings.iter().zip(&mut steps) {
                let (start, used) = (Instant::now(), processor_ms());
                self.device.submit(recording)?.wait()?;
                let (wall, processor) =
                    (start.elapsed().as_secs_f64() * 1e3, processor_ms() - used);
                *least = (least.0.min(wall), least.1.min(processor));
                round += wall;
            }
            rounds.push(round);
        }
        rounds.sort_by(f64::total_cmp);
        let (least, processor) = steps
            .iter()
            .fold((0.0, 0.0), |sum, step| (sum.0 + step.0, sum.1 + step.1));
        Ok(Times {
            least,
            median: rounds[ROUNDS / 2],
            processor,
        })
    }

    /// The layers in order, some a recording; the first clears.
    fn recordings(&self, case: &Case) -> Result<Vec<Recording>, GpuError> {
        let device = &self.device;
        let extent = Extent::D2(TARGET_EDGE, TARGET_EDGE);
        let target = Image::new(
            device,
            "target",
            ImageRole::ColorTarget,
            case.target,
            extent,
        )?;
        let bindings = self.bindings(case)?;
        let kinds: Vec<BindingKind> = bindings.entries().iter().map(Binding::kind).collect();
        let pipeline = GraphicsPipeline::new(
            device,
            &PipelineDesc {
                label: &case.name,
                vertex_spirv: shader("layers.vert"),
                fragment_spirv: shader("layers.frag"),
                specialization: &case.constants,
                color_targets: &[(case.target, case.blend)],
                bindings: &kinds,
                push_bytes: 64,
                topology: Topology::TriangleStrip,
                vertex_input: None,
            },
        )?;
        let draw = Draw {
            pipeline,
            bindings: Some(bindings),
            push: Push::of(&cube_from_quad()),
            stream: None,
            elements: Elements::Vertices(0..4),
            instances: 0..0,
        };
        let part = |first: u32| {
            let load = if first == 0 {
                Load::Clear([0.0; 4])
            } else {
                Load::Keep
            };
            let targets = vec![Target {
                image: Arc::clone(&target),
                load,
            }];
            let draws = vec![Draw {
                instances: first..first + STEP,
                ..draw.clone()
            }];
            let mut recording = Recording::new();
            recording.render(RenderPass { targets, draws });
            recording
        };
        Ok((0..LAYERS).step_by(STEP as usize).map(part).collect())
    }

    fn bindings(&self, case: &Case) -> Result<Arc<Bindings>, GpuError> {
        let device = &self.device;
        let linear = Sampler::new(device, Filter::Linear)?;
        let threshold =
            self.sorted[((1.0 - case.visible) * (self.sorted.len() - 1) as f32) as usize];
        let table = |width: u32| -> Vec<[f32; 4]> {
            (0..width)
                .map(|entry| shown(entry, width, threshold))
                .collect()
        };
        let buffer = Buffer::with_data(device, "table", &table(1024))?;
        let entries = encoded(case.table, table(case.table_width).into_iter());
        let table = filled(
            device,
            case.table,
            Extent::D2(case.table_width, 1),
            &entries,
        )?;
        let entries = [
            Binding::SampledImage(self.cube(case.values)?, Arc::clone(&linear)),
            Binding::SampledImage(table, Arc::clone(&linear)),
            Binding::SampledImage(self.cube(Format::R8G8B8A8_UNORM)?, linear),
            Binding::Uniform(Arc::clone(&buffer)),
            Binding::Storage(buffer),
        ];
        Bindings::new(device, &case.name, &entries)
    }

    /// The values as a 3D texture; made once a format.
    fn cube(&self, format: Format) -> Result<Arc<Image>, GpuError> {
        let made = self
            .cubes
            .borrow()
            .iter()
            .find(|image| image.format() == format)
            .cloned();
        if let Some(image) = made {
            return Ok(image);
        }
        let texels = encoded(
            format,
            self.values.iter().map(|&value| [value, 0.7, 0.4, value]),
        );
        let image = filled(&self.device, format, Extent::D3(EDGE, EDGE, EDGE), &texels)?;
        self.cubes.borrow_mut().push(Arc::clone(&image));
        Ok(image)
    }
}

/// A cloud of blobs with values in [0, 1], 64 texels apart.
fn smooth_values() -> Vec<f32> {
    let wave: Vec<f32> = (0..EDGE)
        .map(|place| (place as f32 * TAU / 64.0).sin())
        .collect();
    let line = |z: usize, y: usize| wave.iter().map(move |x| (x, y, z));
    let edge = EDGE as usize;
    let texels = (0..edge).flat_map(|z| (0..edge).flat_map(move |y| line(z, y)));
    texels
        .map(|(x, y, z)| 0.5 + 0.165 * (x + wave[y] + wave[z]))
        .collect()
}

/// A table's entry: a colour of alpha 1⁄64 above the threshold, nothing below.
fn shown(entry: u32, width: u32, threshold: f32) -> [f32; 4] {
    let value = entry as f32 / (width - 1) as f32;
    if value < threshold {
        [0.0; 4]
    } else {
        [value, 1.0 - value, 0.5, 1.0].map(|part| part / 64.0)
    }
}

/// Texels' bytes. Half floats by cutting, for values that are 0 or at least 2⁻¹⁴.
fn encoded(format: Format, colors: impl Iterator<Item = [f32; 4]>) -> Vec<u8> {
    let (bits, channels) = match format {
        Format::R8_UNORM => (8, 1),
        Format::R8G8_UNORM => (8, 2),
        Format::R8G8B8A8_UNORM => (8, 4),
        Format::R16_UNORM => (16, 1),
        Format::R16G16_UNORM => (16, 2),
        Format::R16G16B16A16_UNORM => (16, 4),
        Format::R16_SFLOAT => (17, 1),
        Format::R16G16B16A16_SFLOAT => (17, 4),
        Format::R32_SFLOAT => (32, 1),
        _ => (32, 4),
    };
    let mut bytes = Vec::new();
    for value in colors.flat_map(|color| color.into_iter().take(channels)) {
        match bits {
            8 => bytes.push((value * 255.0 + 0.5) as u8),
            16 => bytes.extend_from_slice(&((value * 65535.0 + 0.5) as u16).to_ne_bytes()),
            17 => bytes.extend_from_slice(
                &((value.to_bits() >> 13).saturating_sub(112 << 10) as u16).to_ne_bytes(),
            ),
            _ => bytes.extend_from_slice(&value.to_ne_bytes()),
        }
    }
    bytes
}

fn filled(
    device: &Arc<Device>,
    format: Format,
    extent: Extent,
    bytes: &[u8],
) -> Result<Arc<Image>, GpuError> {
    let image = Image::new(device, "a texture", ImageRole::Sampled, format, extent)?;
    let staging = Buffer::with_data(device, "staging", bytes)?;
    let mut recording = Recording::new();
    recording.upload(&staging, &image);
    device.submit(&recording)?.wait()?;
    Ok(image)
}

/// Turned about two axes and shrunk so that the quads stay within the unit cube; columns.
fn cube_from_quad() -> [[f32; 4]; 4] {
    let (a, b, size) = (0.5f32, 0.35f32, 0.57f32);
    let x = [a.cos(), a.sin() * b.cos(), a.sin() * b.sin()];
    let y = [-a.sin(), a.cos() * b.cos(), a.cos() * b.sin()];
    let z = [0.0, -b.sin(), b.cos()];
    let column = |axis: [f32; 3]| [axis[0] * size, axis[1] * size, axis[2] * size, 0.0];
    let start = |part: usize| 0.5 - 0.5 * size * (x[part] + y[part] + z[part]);
    [
        column(x),
        column(y),
        column(z),
        [start(0), start(1), start(2), 1.0],
    ]
}
