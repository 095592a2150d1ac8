//! Full-screen quads: 256 of them, 512 × 512 pixels each, through one 3D texture of 256³ texels; what a device can do at best.

pub mod processor;

use std::cell::RefCell;
use std::f32::consts::TAU;
use std::sync::Arc;
use std::time::Instant;

use vcsg::gpu::{
    Binding, BindingKind, Bindings, Blend, Buffer, Device, Draw, Elements, Extent, Filter, Format, GpuError,
    GraphicsPipeline, Image, ImageRole, Load, PipelineDesc, Push, Recording, RenderPass, Sampler, Target, Topology,
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

/// Samples of a round.
pub const SAMPLES: u32 = TARGET_EDGE * TARGET_EDGE * LAYERS;

/// One thing to time. Specialization constants as in `layers.frag`.
#[derive(Clone)]
pub struct Case {
    /// What it is called.
    pub name: String,
    /// The texels of the volume.
    pub values: Format,
    /// The texels of the table.
    pub table: Format,
    /// Entries of the table.
    pub table_width: u32,
    /// What is read between them.
    pub table_filter: Filter,
    /// What is drawn into.
    pub target: Format,
    /// How; written over when `None`.
    pub blend: Option<Blend>,
    /// The part of the texels that the table shows.
    pub visible: f32,
    /// Specialization constants.
    pub constants: Vec<(u32, u32)>,
}

/// A case that differs from the simplest by `change`.
pub fn case(name: &str, change: impl FnOnce(&mut Case)) -> Case {
    let mut case = Case {
        name: name.to_owned(),
        values: Format::R8_UNORM,
        table: Format::R8G8B8A8_UNORM,
        table_width: 256,
        table_filter: Filter::Linear,
        target: Format::R32G32B32A32_SFLOAT,
        blend: Some(Blend::Over),
        visible: 1.0,
        constants: Vec::new(),
    };
    change(&mut case);
    case
}

/// Milliseconds of a case: the sum of each submission's least and the median round by the wall clock, and the sum of the
/// least processor times, which says on a device that is the host's processor what the wall clock would say were nothing
/// else running.
pub struct Times {
    /// By the wall clock, at best.
    pub least: f64,
    /// By the wall clock, usually.
    pub median: f64,
    /// Of processors, at best.
    pub processor: f64,
}

/// What all cases draw.
pub struct Scene {
    device: Arc<Device>,
    values: Vec<f32>,
    sorted: Vec<f32>,
    cubes: RefCell<Vec<Arc<Image>>>,
}

impl Scene {
    /// The volume, ready to be made a texture of.
    pub fn new(device: &Arc<Device>) -> Self {
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

    /// A case ready to be timed: its first round, which compiles and warms, is over.
    ///
    /// # Errors
    /// If the device refuses.
    pub fn rounds(&self, case: &Case) -> Result<Rounds, GpuError> {
        let recordings = self.recordings(case)?;
        recordings
            .iter()
            .try_for_each(|recording| self.device.submit(recording)?.wait())?;
        Ok(Rounds {
            device: Arc::clone(&self.device),
            steps: vec![(f64::INFINITY, f64::INFINITY); recordings.len()],
            recordings,
            walls: Vec::new(),
        })
    }

    /// The layers in order, some a recording; the first clears.
    fn recordings(&self, case: &Case) -> Result<Vec<Recording>, GpuError> {
        let device = &self.device;
        let extent = Extent::D2(TARGET_EDGE, TARGET_EDGE);
        let target = Image::new(device, "target", ImageRole::ColorTarget, case.target, extent)?;
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
                ..PipelineDesc::default()
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
            let load = if first == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
            let targets = vec![Target {
                image: Arc::clone(&target),
                load,
            }];
            let draws = vec![Draw {
                instances: first..first + STEP,
                ..draw.clone()
            }];
            let mut recording = Recording::new();
            recording.render(RenderPass {
                targets,
                depth: None,
                draws,
            });
            recording
        };
        Ok((0..LAYERS).step_by(STEP as usize).map(part).collect())
    }

    fn bindings(&self, case: &Case) -> Result<Arc<Bindings>, GpuError> {
        let device = &self.device;
        let linear = Sampler::new(device, Filter::Linear)?;
        let threshold = self.sorted[((1.0 - case.visible) * (self.sorted.len() - 1) as f32) as usize];
        let table = |width: u32| -> Vec<[f32; 4]> { (0..width).map(|entry| shown(entry, width, threshold)).collect() };
        let buffer = Buffer::with_data(device, "table", &table(1024))?;
        let entries = encoded(case.table, table(case.table_width).into_iter());
        let table = filled(device, case.table, Extent::D2(case.table_width, 1), &entries)?;
        let entries = [
            Binding::SampledImage(self.cube(case.values)?, Arc::clone(&linear)),
            Binding::SampledImage(table, Sampler::new(device, case.table_filter)?),
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
        let texels = encoded(format, self.values.iter().map(|&value| [value, 0.7, 0.4, value]));
        let image = filled(&self.device, format, Extent::D3(EDGE, EDGE, EDGE), &texels)?;
        self.cubes.borrow_mut().push(Arc::clone(&image));
        Ok(image)
    }
}

/// A case that is drawn again and again.
pub struct Rounds {
    device: Arc<Device>,
    recordings: Vec<Recording>,
    /// The least milliseconds of each submission, by the wall clock and of processors.
    steps: Vec<(f64, f64)>,
    /// Milliseconds of each round.
    walls: Vec<f64>,
}

impl Rounds {
    /// Draws all layers once more.
    ///
    /// # Errors
    /// If the device fails.
    pub fn round(&mut self) -> Result<(), GpuError> {
        let mut round = 0.0;
        for (recording, least) in self.recordings.iter().zip(&mut self.steps) {
            let (start, used) = (Instant::now(), processor::used_ms());
            self.device.submit(recording)?.wait()?;
            let wall = start.elapsed().as_secs_f64() * 1e3;
            *least = (least.0.min(wall), least.1.min(processor::used_ms() - used));
            round += wall;
        }
        self.walls.push(round);
        Ok(())
    }

    /// The milliseconds of the rounds so far, of which there is at least one.
    pub fn times(&self) -> Times {
        let mut walls = self.walls.clone();
        walls.sort_by(f64::total_cmp);
        let add = |sum: (f64, f64), step: &(f64, f64)| (sum.0 + step.0, sum.1 + step.1);
        let (least, processor) = self.steps.iter().fold((0.0, 0.0), add);
        Times {
            least,
            median: walls[walls.len() / 2],
            processor,
        }
    }
}

/// A cloud of blobs with values in [0, 1], 64 texels apart.
fn smooth_values() -> Vec<f32> {
    let wave: Vec<f32> = (0..EDGE).map(|place| (place as f32 * TAU / 64.0).sin()).collect();
    let line = |z: usize, y: usize| wave.iter().map(move |x| (x, y, z));
    let edge = EDGE as usize;
    let texels = (0..edge).flat_map(|z| (0..edge).flat_map(move |y| line(z, y)));
    texels.map(|(x, y, z)| 0.5 + 0.165 * (x + wave[y] + wave[z])).collect()
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
            17 => bytes.extend_from_slice(&((value.to_bits() >> 13).saturating_sub(112 << 10) as u16).to_ne_bytes()),
            _ => bytes.extend_from_slice(&value.to_ne_bytes()),
        }
    }
    bytes
}

fn filled(device: &Arc<Device>, format: Format, extent: Extent, bytes: &[u8]) -> Result<Arc<Image>, GpuError> {
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
    [column(x), column(y), column(z), [start(0), start(1), start(2), 1.0]]
}
