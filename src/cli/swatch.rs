//! A sheet of presets: for each its name, its colours and opacities, and a picture drawn with it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use font8x8::{BASIC_FONTS, UnicodeFonts};

use super::CliError;
use super::job::{model_bounds, statistics};
use crate::gpu::{Device, DeviceSelector, Instance, Validation};
use crate::image::{Frame, Rgba, save};
use crate::projection::presets::{DataStatistics, Kind, Preset};
use crate::projection::{FrameSpec, Settings, SoftNormals};
use crate::render::{PagedTarget, SliceRenderer, soft_normals};
use crate::scene::{NoVolumes, Scene, VolumeFiles};
use crate::target::Target;
use crate::volume::io::ReadOptions;

/// Pixels of a picture, and of the colours beside it.
const PICTURE: [u32; 2] = [96, 80];
const GAP: u32 = 6;
/// Of the font.
const LETTER: u32 = 8;
const CELL: [u32; 2] = [2 * PICTURE[0] + 3 * GAP, PICTURE[1] + LETTER + 3 * GAP];
const COLUMNS: u32 = 4;

const PAPER: Rgba = [0.12, 0.12, 0.13, 1.0];
const INK: Rgba = [0.9, 0.9, 0.9, 1.0];

/// The rows below the opacities that are filled with the colours alone.
const BAR: u32 = 14;

/// Voxels along a subject's diagonal: as many as a picture can show.
const VOXELS: f64 = 160.0;

/// Pictures are small, so their margins are too.
const CLOSER: f64 = 1.25;

const PHANTOM: &str = include_str!("../../assets/scenes/phantom.kdl");

/// Writes the sheet of `presets` as `picture`. Each is drawn with the first of `volumes` that suits it, or a phantom.
pub(super) fn write(
    picture: &Path,
    presets: &[&Preset],
    volumes: &[PathBuf],
    device: &DeviceSelector,
) -> Result<(), CliError> {
    let device = Device::open(&Instance::new(Validation::Off)?, device, &SliceRenderer::REQUIREMENTS)?;
    let mut renderer = SliceRenderer::new(&device)?;
    let mut subjects = subjects(presets, volumes)?;
    let columns = COLUMNS.min(presets.len() as u32).max(1);
    let rows = (presets.len() as u32).div_ceil(columns);
    let mut sheet = Frame::transparent(columns * CELL[0], rows * CELL[1]).over([PAPER[0], PAPER[1], PAPER[2]]);
    for (i, preset) in presets.iter().enumerate() {
        let corner = [i as u32 % columns * CELL[0], i as u32 / columns * CELL[1]];
        let at = |x: u32, y: u32| [corner[0] + x, corner[1] + y];
        write_text(&mut sheet, at(GAP, GAP), preset.name());
        paste(&mut sheet, at(GAP, 2 * GAP + LETTER), &ramp(preset));
        let suited = subjects.iter().position(|subject| subject.suits(preset));
        let phantom = subjects.len().saturating_sub(1);
        if let Some(subject) = subjects.get_mut(suited.unwrap_or(phantom)) {
            let drawn = subject.draw(preset, &mut renderer)?;
            paste(&mut sheet, at(2 * GAP + PICTURE[0], 2 * GAP + LETTER), &drawn);
        }
    }
    Ok(save(&sheet, picture, &[("Software", "vcsg")])?)
}

/// The volumes, and the phantom as the last if a preset has none that suits it.
fn subjects(presets: &[&Preset], volumes: &[PathBuf]) -> Result<Vec<Subject>, CliError> {
    let opened = |path: &PathBuf| Subject::of(Scene::open(path, &ReadOptions::default(), &mut VolumeFiles)?);
    let mut subjects = volumes.iter().map(opened).collect::<Result<Vec<_>, _>>()?;
    let lacks_one = |preset: &&Preset| !subjects.iter().any(|subject| subject.suits(preset));
    if presets.iter().any(lacks_one) {
        let phantom = Scene::parse("phantom.kdl", PHANTOM, ".".as_ref(), &mut NoVolumes)?;
        subjects.push(Subject::of(phantom)?);
    }
    Ok(subjects)
}

/// What a preset is drawn with, on the device as each kind of shading needs it.
struct Subject {
    scene: Scene,
    target: Target,
    data: DataStatistics,
    on_device: Vec<(Option<SoftNormals>, PagedTarget)>,
}

impl Subject {
    fn of(mut scene: Scene) -> Result<Self, CliError> {
        let diagonal_mm = model_bounds(&scene).size().length();
        if diagonal_mm.is_finite() && diagonal_mm > 0.0 {
            scene.target.spacing_mm = Some(diagonal_mm / VOXELS);
        }
        let target = scene.target.build(&scene.model)?;
        let data = statistics(&target);
        scene.view.zoom *= CLOSER;
        Ok(Self {
            scene,
            target,
            data,
            on_device: Vec::new(),
        })
    }

    fn suits(&self, preset: &Preset) -> bool {
        match preset.kind() {
            Kind::Ct => self.data.looks_like_ct(),
            Kind::Mr | Kind::Any => !self.data.looks_like_ct(),
        }
    }

    fn draw(&mut self, preset: &Preset, renderer: &mut SliceRenderer) -> Result<Frame, CliError> {
        let bounds = model_bounds(&self.scene);
        let mut settings = Settings::default();
        preset.look().apply(&mut settings);
        let spec = FrameSpec {
            target: &self.target,
            transfer: &preset.fitted(&self.data, preset.unit_for(bounds.size().length())),
            camera: &self.scene.view.camera(&bounds, PICTURE),
            settings: &settings,
        };
        let normals = soft_normals(&spec);
        let there = self.on_device.iter().position(|(of, _)| *of == normals);
        let n = match there {
            Some(n) => n,
            None => {
                let device = Arc::clone(renderer.device());
                let paged = PagedTarget::new(&device, &self.target, normals.as_ref(), &mut |_| {})?;
                self.on_device.push((normals, paged));
                self.on_device.len() - 1
            }
        };
        let (frame, _) = renderer.draw(&spec, &self.on_device[n].1, &[])?;
        Ok(frame.over([0.0; 3]))
    }
}

/// The colours of a preset over the values that it shows, each as high as the square root of its opacity, and in a bar below.
fn ramp(preset: &Preset) -> Frame {
    let [width, height] = PICTURE;
    let function = preset.own_function();
    let (all, shown) = (function.window(), preset.shown());
    let (lo, hi) = (shown.lo.max(all.lo), shown.hi.min(all.hi));
    let mut frame = Frame::transparent(width, height).over([0.0; 3]);
    for (i, pixel) in frame.pixels_mut().iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let ([r, g, b], opacity) = function.evaluate(lo + (hi - lo) * x as f32 / (width - 1) as f32);
        let high = (height - BAR) as f32 * opacity.sqrt();
        let gap = y == height - BAR;
        if (y > height - BAR) || (!gap && (height - BAR - y) as f32 <= high) {
            *pixel = [r, g, b, 1.0];
        }
    }
    frame
}

fn paste(sheet: &mut Frame, [x, y]: [u32; 2], part: &Frame) {
    let (across, width) = (sheet.width(), part.width());
    for (i, &pixel) in part.pixels().iter().enumerate() {
        let (column, row) = (x + i as u32 % width, y + i as u32 / width);
        if column < across
            && let Some(place) = sheet.pixels_mut().get_mut((row * across + column) as usize)
        {
            *place = pixel;
        }
    }
}

fn write_text(sheet: &mut Frame, [x, y]: [u32; 2], text: &str) {
    for (i, letter) in (0..).zip(text.chars()) {
        let rows = BASIC_FONTS.get(letter).unwrap_or_default();
        let mut glyph = Frame::transparent(LETTER, LETTER).over([PAPER[0], PAPER[1], PAPER[2]]);
        for (pixel, place) in glyph.pixels_mut().iter_mut().zip(0..) {
            if rows[place / LETTER as usize] >> (place % LETTER as usize) & 1 == 1 {
                *pixel = INK;
            }
        }
        paste(sheet, [x + i * LETTER, y], &glyph);
    }
}
