//! What a scene says of ray tracing: its `optics`, more `object`s than its own, lights with a place, and `trace`.

use std::path::Path;

use kdl::KdlDocument;

use super::appearance;
use super::element::Element;
use super::error::{Problem, SceneError};
use super::grammar;
use super::loader::VolumeLoader;
use super::options::TargetOptions;
use super::source::Source;
use super::transfer::TransferSpec;
use super::tree::TreeBuilder;
use crate::model::{Kind, Model};
use crate::projection::trace;
use crate::projection::trace::{Bounds, Optics, Sampling};

type Result<T> = std::result::Result<T, SceneError>;

/// How a scene wants to be traced.
#[derive(Clone, Debug, Default)]
pub struct TraceSpec {
    /// The optics of the scene's own model; a medium when `None`.
    pub optics: Option<Optics>,
    /// What there is beside it.
    pub objects: Vec<ObjectSpec>,
    /// Lights that have a place in the world.
    pub lights: Vec<trace::Source>,
    /// Whether lights that have a direction alone shine too.
    pub far_lights: bool,
    /// Samples and how far rays are followed.
    pub sampling: Sampling,
}

/// An `object` node: a volume beside the scene's own, on a lattice of its own.
#[derive(Clone, Debug)]
pub struct ObjectSpec {
    /// Its tree, in world millimetres.
    pub model: Model,
    /// How its target is built.
    pub target: TargetOptions,
    /// Its transfer function; the scene's when `None`.
    pub transfer: Option<TransferSpec>,
    /// Its optics; a medium when `None`.
    pub optics: Option<Optics>,
}

impl TraceSpec {
    /// Whether no other renderer than the tracer shows what the scene says.
    pub fn is_needed(&self) -> bool {
        self.optics.is_some() || !self.objects.is_empty() || !self.lights.is_empty()
    }
}

/// The optics of an `optics` node.
pub(super) fn optics(element: &Element) -> Result<Optics> {
    let number = |key, default: f64| element.get(key).map_or(Ok(default), |v| v.number());
    let reflect = number("reflect", 0.0)?;
    let transmit = number("transmit", 0.0)?;
    let bad = |error| element.error(Problem::Optics(error));
    let optics = Optics::new(reflect, transmit, number("index", 1.0)?).map_err(bad)?;
    match element.get("tint") {
        Some(tint) => optics
            .tinted(tint.color()?.map(f64::from), number("tint-mm", 1.0)?)
            .map_err(bad),
        None if element.get("tint-mm").is_some() => {
            Err(element.error_of("tint-mm", Problem::Conflict("`tint-mm` goes with a `tint`")))
        }
        None => Ok(optics),
    }
}

/// The light of a `light` node that has a place.
pub(super) fn light(element: &Element) -> Result<trace::Source> {
    let at = element.require("at")?.vector()?;
    let intensity = element.get("intensity").map_or(Ok(1.0), |v| v.within(0.0, 10.0))?;
    let edge = |key| element.get(key).map(|v| v.vector()).transpose();
    let light = match (edge("u")?, edge("v")?) {
        (None, None) => trace::Source::point(at, intensity),
        (Some(u), Some(v)) => trace::Source::area(at, u, v, intensity),
        _ => {
            let why = "`u` and `v`, the edges of an area light, go together";
            return Err(element.error(Problem::Conflict(why)));
        }
    };
    light.map_err(|error| element.error(Problem::Light(error)))
}

/// The sampling of a `trace` node.
pub(super) fn sampling(element: &Element) -> Result<Sampling> {
    let default = Sampling::default();
    let whole = |key, most, default: u32| element.get(key).map_or(Ok(default), |v| v.whole(1, most));
    Ok(Sampling {
        samples: whole("samples", Sampling::MAX_SAMPLES, default.samples)?,
        seed: element.get("seed").map_or(Ok(0), |v| v.whole(0, u32::MAX))?.into(),
        bounds: Bounds {
            depth: element
                .get("depth")
                .map_or(Ok(default.bounds.depth), |v| v.whole(0, Bounds::MAX_DEPTH))?,
            light_parts: whole("light-parts", Bounds::MAX_LIGHT_PARTS, default.bounds.light_parts)?,
            ..default.bounds
        },
    })
}

/// The objects of a document, whose paths start in `base_dir`; `root` is the file that it is.
pub(super) fn objects(
    document: &KdlDocument,
    source: &Source,
    base_dir: &Path,
    root: Option<&Path>,
    loader: &mut dyn VolumeLoader,
) -> Result<Vec<ObjectSpec>> {
    let nodes = document.nodes().iter().filter(|node| node.name().value() == "object");
    nodes
        .map(|node| {
            let element = Element::new(node, &[grammar::TOP], source)?;
            object(&element, TreeBuilder::new(loader, root), base_dir)
        })
        .collect()
}

fn object(element: &Element, tree: TreeBuilder, base_dir: &Path) -> Result<ObjectSpec> {
    let [transfer, optics_node] = [single(element, "transfer")?, single(element, "optics")?];
    let model = tree.build(*element, base_dir)?;
    if let Some(transfer) = transfer.filter(|_| model.kind_of_root() == Some(Kind::Color)) {
        let why =
            "the object's samples are colours, by its `classify` nodes: `transfer` has no values to make colours of";
        return Err(transfer.error(Problem::Conflict(why)));
    }
    Ok(ObjectSpec {
        model,
        target: TargetOptions::read(element)?,
        transfer: transfer.map(|node| appearance::transfer(&node, base_dir)).transpose()?,
        optics: optics_node.map(|node| optics(&node)).transpose()?,
    })
}

/// The child of this name, which is there at most once.
fn single<'a>(element: &Element<'a>, name: &str) -> Result<Option<Element<'a>>> {
    let mut found = None;
    for child in element.children() {
        let child = child?;
        if child.name() == name {
            if found.is_some() {
                return Err(child.error(Problem::Twice { name: name.into() }));
            }
            found = Some(child);
        }
    }
    Ok(found)
}
