//! How a scene wants to be seen: view, lights, material, mode, transfer function.

use std::path::{Path, PathBuf};

use kdl::KdlDocument;

use super::animation::Animation;
use super::element::{Element, Value};
use super::error::{Problem, SceneError};
use super::grammar;
use super::options::TargetOptions;
use super::source::Source;
use super::suggest::nearest;
use super::surface::SurfaceSpec;
use super::trace::{self, TraceSpec};
use super::transfer::{TransferChoice, TransferSpec};
use crate::math::Interval;
use crate::projection::presets;
use crate::projection::volume_property;
use crate::projection::{
    ControlPoint, DepthCue, Light, Material, Mode, Projection, Settings, Shading, TransferFunction, View,
};

type Result<T> = std::result::Result<T, SceneError>;

/// Everything at the top of a scene file but the tree.
#[derive(Clone, Debug, Default)]
pub(super) struct Appearance {
    pub target: TargetOptions,
    pub transfer: Option<TransferSpec>,
    pub surfaces: Vec<SurfaceSpec>,
    pub view: View,
    pub settings: Settings,
    pub frame_size: Option<[u32; 2]>,
    pub trace: TraceSpec,
    pub animation: Option<Animation>,
}

/// Nodes that may be there more than once.
const MANY: [&str; 3] = ["light", "surface", "object"];

impl Appearance {
    /// Reads the top nodes of a document, whose paths start in `base_dir`.
    pub fn read(document: &KdlDocument, source: &Source, base_dir: &Path) -> Result<Self> {
        let mut draft = Draft {
            base_dir: base_dir.to_owned(),
            ..Draft::default()
        };
        let mut seen: Vec<&str> = Vec::new();
        for node in document.nodes() {
            let element = Element::new(node, &[grammar::TOP], source)?;
            if !MANY.contains(&element.name()) && seen.contains(&element.name()) {
                let name = element.name().into();
                return Err(element.error(Problem::Twice { name }));
            }
            draft.read(&element, document)?;
            if !seen.contains(&element.name()) {
                seen.push(element.name());
            }
        }
        Ok(draft.finish())
    }

    /// Whether the top nodes of a document suit a scene of colours.
    pub fn check_colors(document: &KdlDocument, source: &Source) -> Result<()> {
        for node in document.nodes() {
            let element = Element::new(node, &[grammar::TOP], source)?;
            match element.name() {
                "transfer" => {
                    let why = "the scene's samples are colours, by its `classify` nodes: `transfer` has no values to make colours of";
                    return Err(element.error(Problem::Conflict(why)));
                }
                "render" => check_mode(&element)?,
                _ => {}
            }
        }
        Ok(())
    }
}

/// Whether a `render` node's mode shows colours.
fn check_mode(render: &Element) -> Result<()> {
    match render.get("mode") {
        Some(mode) if !mode.one_of(Mode::NAMES)?.classifies() => {
            let why = "this mode shows values, and the scene's samples are colours, by its `classify` nodes";
            Err(mode.error(Problem::Conflict(why)))
        }
        _ => Ok(()),
    }
}

/// What was read so far. What a file says itself goes before what its preset says.
#[derive(Default)]
struct Draft {
    base_dir: PathBuf,
    appearance: Appearance,
    lights: Vec<Light>,
    material: Option<Material>,
    soft_gradient: Option<f64>,
    mode: Option<Mode>,
    shaded: Option<bool>,
}

impl Draft {
    fn read(&mut self, element: &Element, document: &KdlDocument) -> Result<()> {
        match element.name() {
            "scene" => self.appearance.target = TargetOptions::read(element)?,
            "transfer" => self.appearance.transfer = Some(transfer(element, &self.base_dir)?),
            "surface" => self.appearance.surfaces.push(SurfaceSpec::read(element)?),
            "view" => self.appearance.view = view(element)?,
            "light" => self.add_light(element)?,
            "optics" => self.appearance.trace.optics = Some(trace::optics(element)?),
            "trace" => self.appearance.trace.sampling = trace::sampling(element)?,
            // Objects have trees, which are built with the scene's.
            "object" => {}
            "material" => self.material(element)?,
            "depth-cue" => {
                let strength = element.require("strength")?.within(0.0, 1.0)? as f32;
                self.appearance.settings.depth_cue = DepthCue { strength };
            }
            "animation" => self.appearance.animation = Some(Animation::read(element, document)?),
            "background" => self.appearance.settings.background = background(element.argument(0))?,
            _ => self.render(element)?,
        }
        if self.appearance.target.levels > 1 && !self.appearance.surfaces.is_empty() {
            let why = "surfaces are extracted from one level: leave out either `levels` or the `surface` nodes";
            return Err(element.error(Problem::Conflict(why)));
        }
        Ok(())
    }

    fn add_light(&mut self, element: &Element) -> Result<()> {
        let limit = Shading::MAX_LIGHTS;
        if self.lights.len() + self.appearance.trace.lights.len() == limit {
            return Err(element.error(Problem::TooManyLights { limit }));
        }
        if element.get("at").is_some() {
            return self.add_placed_light(element);
        }
        if let Some(edge) = ["u", "v"].into_iter().find(|edge| element.get(edge).is_some()) {
            let why = "an area light has a place: give `at` too";
            return Err(element.error_of(edge, Problem::Conflict(why)));
        }
        self.lights.push(Light {
            towards: element.require("towards")?.direction()?,
            intensity: element.get("intensity").map_or(Ok(1.0), |v| v.within(0.0, 10.0))? as f32,
        });
        Ok(())
    }

    fn add_placed_light(&mut self, element: &Element) -> Result<()> {
        if element.get("towards").is_some() {
            let why = "a light is `at` a place or `towards` a direction, one of them";
            return Err(element.error_of("towards", Problem::Conflict(why)));
        }
        self.appearance.trace.lights.push(trace::light(element)?);
        Ok(())
    }

    fn material(&mut self, element: &Element) -> Result<()> {
        let default = Material::default();
        let factor = |key, default: f32| {
            element
                .get(key)
                .map_or(Ok(default), |v| v.within(0.0, 10.0).map(|n| n as f32))
        };
        self.material = Some(Material {
            ambient: factor("ambient", default.ambient)?,
            diffuse: factor("diffuse", default.diffuse)?,
            specular: factor("specular", default.specular)?,
            shininess_log2: element
                .get("shininess")
                .map_or(Ok(default.shininess_log2), shininess_log2)?,
        });
        self.soft_gradient = element.get("soft-gradient").map(|v| v.positive()).transpose()?;
        Ok(())
    }

    fn render(&mut self, element: &Element) -> Result<()> {
        self.mode = element.get("mode").map(|v| v.one_of(Mode::NAMES)).transpose()?;
        self.shaded = element.get("shading").map(|v| v.boolean()).transpose()?;
        if let Some(samples) = element.get("samples-per-voxel") {
            self.appearance.settings.samples_per_voxel = samples.within(1.0 / 64.0, 64.0)?;
        }
        self.appearance.frame_size = element.get("size").map(frame_size).transpose()?;
        Ok(())
    }

    fn finish(mut self) -> Appearance {
        let look = self.appearance.transfer.as_ref().and_then(TransferSpec::look);
        let default = Settings::default();
        self.appearance.settings.mode = self.mode.or(look.map(|look| look.mode)).unwrap_or(default.mode);
        let of_look = look.map_or(Some(Material::default()), |look| look.material);
        let shaded = self.shaded.unwrap_or(self.material.is_some() || of_look.is_some());
        let standard = Shading::default();
        self.appearance.trace.far_lights = !self.lights.is_empty() || self.appearance.trace.lights.is_empty();
        self.appearance.settings.shading = shaded.then(|| Shading {
            lights: if self.lights.is_empty() {
                standard.lights
            } else {
                self.lights
            },
            material: self.material.or(of_look).unwrap_or_default(),
            soft_gradient: self.soft_gradient.unwrap_or(standard.soft_gradient),
        });
        self.appearance
    }
}

/// A specular exponent must be a power of two up to 1024.
fn shininess_log2(value: Value) -> Result<u32> {
    let exponent = value.whole(1, 1024)?;
    if exponent.is_power_of_two() {
        Ok(exponent.ilog2())
    } else {
        Err(value.bad("a power of two in 1..1024"))
    }
}

fn frame_size(value: Value) -> Result<[u32; 2]> {
    parse_size(value.string()?).ok_or_else(|| value.bad("a size like \"1024x768\", each side in 1..16384"))
}

/// `WIDTHxHEIGHT` in pixels, each in 1..16384.
pub fn parse_size(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    let side = |s: &str| s.trim().parse().ok().filter(|n| (1..=16384).contains(n));
    Some([side(width)?, side(height)?])
}

fn background(value: Value) -> Result<[f32; 4]> {
    if value.string()? == "transparent" {
        return Ok([0.0; 4]);
    }
    let [r, g, b] = value
        .color()
        .map_err(|_| value.bad("\"transparent\" or a colour like \"#101820\""))?;
    Ok([r, g, b, 1.0])
}

fn view(element: &Element) -> Result<View> {
    let degrees = |key| element.get(key).map_or(Ok(0.0), |v| v.within(-3600.0, 3600.0));
    Ok(View {
        azimuth_deg: degrees("azimuth")?,
        elevation_deg: degrees("elevation")?,
        roll_deg: degrees("roll")?,
        zoom: element.get("zoom").map_or(Ok(1.0), |v| v.within(1e-3, 1e4))?,
        focus: element.get("focus").map(|v| v.vector()).transpose()?,
        projection: projection(element)?,
    })
}

fn projection(element: &Element) -> Result<Projection> {
    let kinds = [("orthographic", false), ("perspective", true)];
    let perspective = element.get("projection").map_or(Ok(false), |v| v.one_of(&kinds))?;
    match element.get("fov") {
        Some(_) if !perspective => {
            Err(element.error_of("fov", Problem::Conflict("`fov` goes with projection=\"perspective\"")))
        }
        _ if !perspective => Ok(Projection::Orthographic),
        Some(fov) => Ok(Projection::Perspective {
            fov_y_deg: fov.within(1.0, 170.0)?,
        }),
        None => Ok(Projection::Perspective { fov_y_deg: 30.0 }),
    }
}

/// The transfer function that a `transfer` or `classify` node states; the path of its file starts in `base_dir`.
pub(super) fn transfer(element: &Element, base_dir: &Path) -> Result<TransferSpec> {
    let unit_mm = element.get("unit-mm").map(|v| v.positive()).transpose()?;
    let points = control_points(element)?;
    let window = display_window(element)?;
    let choice = match (element.get("preset"), element.get("file"), points.is_empty()) {
        (Some(name), None, true) => TransferChoice::Preset(preset(name)?),
        (None, Some(file), true) => TransferChoice::File(property(file, base_dir)?),
        (None, None, true) => TransferChoice::Automatic,
        (None, None, false) => {
            let function = TransferFunction::new(points, unit_mm.unwrap_or(1.0));
            TransferChoice::Points(function.map_err(|e| element.error(Problem::Transfer(e)))?)
        }
        (preset, _, _) => {
            let problem =
                Problem::Conflict("a transfer function has a preset, a file or points of its own, one of them");
            let key = if preset.is_some() { "preset" } else { "file" };
            return Err(element.error_of(key, problem));
        }
    };
    if window.is_some() && matches!(choice, TransferChoice::Points(_) | TransferChoice::File(_)) {
        let problem = Problem::Conflict("`window` and `level` fit a preset; points and files state their values");
        return Err(element.error_of("window", problem));
    }
    Ok(TransferSpec {
        choice,
        window,
        unit_mm,
    })
}

fn control_points(element: &Element) -> Result<Vec<ControlPoint>> {
    let read = |point: Element| {
        Ok(ControlPoint {
            value: point.argument(0).single()?,
            color: point.require("color")?.color()?,
            opacity: point.require("opacity")?.within(0.0, 1.0)? as f32,
        })
    };
    let mut points = Vec::new();
    for child in element.children() {
        let child = child?;
        if child.name() == "point" {
            points.push(read(child)?);
        }
    }
    Ok(points)
}

/// `window` and `level`: how wide the range of displayed values is, and its middle.
fn display_window(element: &Element) -> Result<Option<Interval>> {
    match (element.get("window"), element.get("level")) {
        (None, None) => Ok(None),
        (Some(width), Some(level)) => {
            let (width, level) = (width.positive()? as f32, level.single()?);
            Ok(Some(Interval::new(level - 0.5 * width, level + 0.5 * width)))
        }
        _ => Err(element.error(Problem::Conflict("`window` and `level` go together"))),
    }
}

fn property(file: Value, base_dir: &Path) -> Result<volume_property::VolumeProperty> {
    let reading = volume_property::read(&base_dir.join(file.string()?));
    let reading = reading.map_err(|e| file.error(Problem::TransferFile(e.to_string())))?;
    Ok(reading.property)
}

fn preset(value: Value) -> Result<&'static presets::Preset> {
    let found = value.string()?;
    presets::named(found).ok_or_else(|| {
        let names: Vec<_> = presets::all().iter().map(|preset| preset.name()).collect();
        value.error(Problem::UnknownPreset {
            found: found.into(),
            nearest: nearest(found, &names),
        })
    })
}
