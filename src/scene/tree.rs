//! From the nodes under `scene` to a [`Model`].
//!
//! *Practice.* `define` builds a subtree once and `use` refers to it, so a scene that uses a part many times is a graph and
//! not a blown-up tree; the same holds for a file that is included more than once. Nodes that nothing uses are dropped at
//! the end.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;
use kdl::KdlDocument;

use super::deform;
use super::element::Element;
use super::error::{Problem, SceneError};
use super::file;
use super::grammar;
use super::guard::{MAX_BYTES, MAX_DEPTH};
use super::leaves;
use super::loader::{MeshRequest, VolumeLoader, VolumeRequest};
use super::maps;
use super::primitives;
use super::source::Source;
use super::transforms;
use crate::model::{BooleanOp, Combine, Family, Model, Node, NodeId, ValueRule, VolumeLeaf};
use crate::volume::Bricks;
use crate::voxelize::{Primitive, Solid, TriangleSolid};

type Result<T> = std::result::Result<T, SceneError>;

/// Builds one model from a scene file and all that it includes.
pub(super) struct TreeBuilder<'l> {
    model: Model,
    loader: &'l mut dyn VolumeLoader,
    volumes: Vec<(VolumeRequest, Arc<Bricks>)>,
    meshes: Vec<(MeshRequest, Arc<TriangleSolid>)>,
    included: HashMap<PathBuf, NodeId>,
    /// The files that are being read, the root first.
    open: Vec<PathBuf>,
    bytes: usize,
    depth: usize,
}

/// What a file's nodes see: where its paths start, and what it has defined so far.
struct Scope {
    base_dir: PathBuf,
    defined: HashMap<String, NodeId>,
}

impl Scope {
    fn new(base_dir: &Path) -> Self {
        Self {
            base_dir: base_dir.to_owned(),
            defined: HashMap::new(),
        }
    }
}

impl<'l> TreeBuilder<'l> {
    /// A builder that gets volumes from `loader`; `root` is the file that starts it, if there is one.
    pub fn new(loader: &'l mut dyn VolumeLoader, root: Option<&Path>) -> Self {
        Self {
            model: Model::default(),
            loader,
            volumes: Vec::new(),
            meshes: Vec::new(),
            included: HashMap::new(),
            open: root.and_then(|path| path.canonicalize().ok()).into_iter().collect(),
            bytes: 0,
            depth: 0,
        }
    }

    /// The model of a `scene` node, whose paths start in `base_dir`.
    pub fn build(mut self, scene: Element, base_dir: &Path) -> Result<Model> {
        self.bytes += scene.source().text().len();
        let root = self.combined(scene, &mut Scope::new(base_dir))?;
        Ok(self.model.rooted_at(root))
    }

    fn shape(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        if self.depth == MAX_DEPTH {
            return Err(element.error(Problem::TooDeep { limit: MAX_DEPTH }));
        }
        self.depth += 1;
        let id = self.shape_within_depth(element, scope);
        self.depth -= 1;
        id
    }

    fn shape_within_depth(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        match element.name() {
            "volume" => self.volume(element, scope),
            "mesh" => self.mesh(element, scope),
            "use" => reference(element, scope),
            "include" => self.include(element, scope),
            "union" | "intersect" | "subtract" | "overlay" => self.combined(element, scope),
            "map" => self.mapped(element, scope),
            "deform" => self.deformed(element, scope),
            "complement" => self.complement(element, scope),
            "repeat" => self.repeated(element, scope),
            "cut" => self.cut(element, scope),
            _ => self.primitive_or_transform(element, scope),
        }
    }

    fn primitive_or_transform(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        if let Some(placed) = primitives::primitive(&element)? {
            return Ok(self.placed(placed));
        }
        let map = transforms::parent_from_child(&element)?;
        let child = self.united(element, scope)?;
        Ok(match map {
            Some(parent_from_child) => self.model.push(Node::Transform {
                child,
                parent_from_child,
            }),
            None => child,
        })
    }

    fn placed(&mut self, placed: primitives::PlacedPrimitive) -> NodeId {
        let child = self.model.push(Node::Primitive(placed.primitive));
        let parent_from_child = placed.parent_from_local;
        if parent_from_child == DAffine3::IDENTITY {
            return child;
        }
        self.model.push(Node::Transform {
            child,
            parent_from_child,
        })
    }

    /// The children on one side of a plane; a soft cut is the product with a soft half-space.
    fn cut(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let plane = leaves::plane(&element)?;
        let filter_voxels = primitives::filter_voxels(&element)?.unwrap_or(0.0);
        let child = self.united(element, scope)?;
        if filter_voxels == 0.0 {
            return Ok(self.model.push(Node::Cut { child, plane }));
        }
        let half_space = Primitive {
            filter_voxels,
            ..Primitive::soft(Solid::HalfSpace(plane), 0.0)
        };
        let second = self.model.push(Node::Primitive(half_space));
        Ok(self.model.push(Node::Combine(Combine {
            op: BooleanOp::Intersection,
            rule: ValueRule::First,
            family: Family::Product,
            first: child,
            second,
        })))
    }

    /// The children deformed by landmarks.
    fn deformed(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let spline = deform::spline(&element, &scope.base_dir)?;
        let error_voxels = deform::error_voxels(&element)?;
        let child = self.united(element, scope)?;
        let bounds = self.model.bounds_of(child);
        let morph = Arc::new(deform::morph(&element, spline, &bounds)?);
        Ok(self.model.push(Node::Deform {
            child,
            morph,
            error_voxels,
        }))
    }

    /// Everything but the child.
    fn complement(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let everything = Primitive::crisp(Solid::Everything, primitives::value(&element)?);
        let first = self.model.push(Node::Primitive(everything));
        let (op, rule, family) = (BooleanOp::Subtraction, ValueRule::First, family(&element)?);
        let second = self.united(element, scope)?;
        Ok(self.model.push(Node::Combine(Combine {
            op,
            rule,
            family,
            first,
            second,
        })))
    }

    /// The child again and again, each time moved on by the same step (WK94, *sweeping*).
    fn repeated(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let step = transforms::step(&element)?;
        let count = element.require("count")?.whole(1, 100_000)?;
        let (rule, family) = (value_rule(&element, ValueRule::First)?, family(&element)?);
        let child = self.united(element, scope)?;
        let mut copies = vec![child];
        let mut parent_from_child = DAffine3::IDENTITY;
        for _ in 1..count {
            parent_from_child = step * parent_from_child;
            copies.push(self.model.push(Node::Transform {
                child,
                parent_from_child,
            }));
        }
        let folded = self.model.fold(BooleanOp::Union, rule, family, copies);
        Ok(folded.unwrap_or(child))
    }

    fn volume(&mut self, element: Element, scope: &Scope) -> Result<NodeId> {
        let window = leaves::window(&element)?;
        let request = leaves::volume_request(&element, &scope.base_dir)?;
        let fails = |reason| element.error_of_argument(0, Problem::Volume(reason));
        let bricks = self.load(&request).map_err(fails)?;
        Ok(self.model.push(Node::Volume(VolumeLeaf { bricks, window })))
    }

    fn load(&mut self, request: &VolumeRequest) -> std::result::Result<Arc<Bricks>, String> {
        if let Some((_, bricks)) = self.volumes.iter().find(|(known, _)| known == request) {
            return Ok(Arc::clone(bricks));
        }
        let bricks = self.loader.load(request)?;
        self.volumes.push((request.clone(), Arc::clone(&bricks)));
        Ok(bricks)
    }

    fn mesh(&mut self, element: Element, scope: &Scope) -> Result<NodeId> {
        let request = leaves::mesh_request(&element, &scope.base_dir)?;
        let fails = |reason| element.error_of_argument(0, Problem::Mesh(reason));
        let solid = Solid::Mesh(self.load_mesh(&request).map_err(fails)?);
        let primitive = primitives::filtered(&element, solid)?;
        Ok(self.model.push(Node::Primitive(primitive)))
    }

    fn load_mesh(&mut self, request: &MeshRequest) -> std::result::Result<Arc<TriangleSolid>, String> {
        if let Some((_, solid)) = self.meshes.iter().find(|(known, _)| known == request) {
            return Ok(Arc::clone(solid));
        }
        let solid = self.loader.load_mesh(request)?;
        self.meshes.push((request.clone(), Arc::clone(&solid)));
        Ok(solid)
    }

    /// The children of a set operation folded from the left; those of `scene` are united.
    fn combined(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let (op, least, wanted) = match element.name() {
            "intersect" => (BooleanOp::Intersection, 1, "at least one child"),
            "subtract" => (BooleanOp::Subtraction, 2, "at least two children"),
            "overlay" => (BooleanOp::SubtractionWithRule, 2, "at least two children"),
            _ => (BooleanOp::Union, 1, "at least one child"),
        };
        let rule = match op {
            BooleanOp::Subtraction => ValueRule::First,
            BooleanOp::SubtractionWithRule => value_rule(&element, ValueRule::Second)?,
            _ => value_rule(&element, ValueRule::First)?,
        };
        let family = family(&element)?;
        let operands = self.children(element, scope)?;
        let too_few = || {
            let (node, found) = (element.name(), operands.len());
            element.error(Problem::TooFewChildren { node, wanted, found })
        };
        let enough = (operands.len() >= least).then_some(&operands);
        let folded = enough.and_then(|o| self.model.fold(op, rule, family, o.iter().copied()));
        folded.ok_or_else(too_few)
    }

    fn mapped(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let mut points = Vec::new();
        for child in element.children() {
            let child = child?;
            if child.name() == "at" {
                points.push(child);
            }
        }
        let map = maps::value_map(&element, &points)?;
        let child = self.united(element, scope)?;
        Ok(self.model.push(Node::Transfer { child, map }))
    }

    /// All children as one node.
    fn united(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let children = self.children(element, scope)?;
        let united = self
            .model
            .fold(BooleanOp::Union, ValueRule::First, Family::default(), children);
        let (node, wanted) = (element.name(), "at least one child");
        united.ok_or_else(|| element.error(Problem::TooFewChildren { node, wanted, found: 0 }))
    }

    fn children(&mut self, element: Element, scope: &mut Scope) -> Result<Vec<NodeId>> {
        let mut ids = Vec::new();
        for child in element.children() {
            let child = child?;
            match child.name() {
                "at" | "pair" => {}
                "define" => self.define(child, scope)?,
                _ => ids.push(self.shape(child, scope)?),
            }
        }
        Ok(ids)
    }

    fn define(&mut self, element: Element, scope: &mut Scope) -> Result<()> {
        let name = element.argument(0).string()?;
        if scope.defined.contains_key(name) {
            return Err(element.error_of_argument(0, Problem::Twice { name: name.into() }));
        }
        let id = self.shape(element, scope)?;
        scope.defined.insert(name.into(), id);
        Ok(())
    }

    fn include(&mut self, element: Element, scope: &Scope) -> Result<NodeId> {
        let path = scope.base_dir.join(element.argument(0).string()?);
        let fails = |problem| element.error_of_argument(0, problem);
        let canonical = path.canonicalize().map_err(|e| fails(file::unreadable(&path, &e)))?;
        if let Some(&id) = self.included.get(&canonical) {
            return Ok(id);
        }
        if let Some(first) = self.open.iter().position(|open| *open == canonical) {
            return Err(fails(cycle(&self.open[first..], &canonical)));
        }
        let text = file::read(&path).map_err(fails)?;
        self.bytes += text.len();
        if self.bytes > MAX_BYTES {
            return Err(fails(Problem::TooLong { limit: MAX_BYTES }));
        }
        self.open.push(canonical.clone());
        let id = self.included_scene(&Source::new(path.to_string_lossy(), text), &path)?;
        self.open.pop();
        self.included.insert(canonical, id);
        Ok(id)
    }

    fn included_scene(&mut self, source: &Source, path: &Path) -> Result<NodeId> {
        let document = file::parse(source)?;
        let scene = scene_element(&document, source)?;
        let base_dir = path.parent().unwrap_or(Path::new(""));
        self.combined(scene, &mut Scope::new(base_dir))
    }
}

/// The `scene` node of a document.
pub(super) fn scene_element<'a>(document: &'a KdlDocument, source: &'a Source) -> Result<Element<'a>> {
    let node = document.nodes().iter().find(|node| node.name().value() == "scene");
    let missing = || SceneError::at(source, (0..0).into(), Problem::NoScene);
    Element::new(node.ok_or_else(missing)?, &[grammar::TOP], source)
}

fn reference(element: Element, scope: &Scope) -> Result<NodeId> {
    let name = element.argument(0).string()?;
    let undefined = || element.error_of_argument(0, Problem::Undefined { name: name.into() });
    scope.defined.get(name).copied().ok_or_else(undefined)
}

fn cycle(chain: &[PathBuf], again: &Path) -> Problem {
    let name = |path: &Path| {
        path.file_name()
            .map_or_else(|| path.to_string_lossy(), |n| n.to_string_lossy())
            .into_owned()
    };
    let links: Vec<_> = chain.iter().map(|path| name(path)).chain([name(again)]).collect();
    Problem::IncludeCycle {
        path: name(again),
        chain: links.join(" → "),
    }
}

const RULES: &[(&str, ValueRule)] = &[
    ("first", ValueRule::First),
    ("second", ValueRule::Second),
    ("max", ValueRule::Max),
    ("min", ValueRule::Min),
    ("sum", ValueRule::Sum),
    ("difference", ValueRule::Difference),
    ("product", ValueRule::Product),
    ("average", ValueRule::Average),
];

/// Property `family`.
fn family(element: &Element) -> Result<Family> {
    let families = [("minmax", Family::MinMax), ("product", Family::Product)];
    element
        .get("family")
        .map_or(Ok(Family::default()), |v| v.one_of(&families))
}

/// Property `rule`: a name, or `"blend T"` with T in [0, 1].
fn value_rule(element: &Element, default: ValueRule) -> Result<ValueRule> {
    let Some(value) = element.get("rule") else {
        return Ok(default);
    };
    let Some(share) = value.string()?.strip_prefix("blend") else {
        return value.one_of(RULES);
    };
    match share.trim().parse() {
        Ok(t) if (0.0..=1.0).contains(&t) => Ok(ValueRule::Blend(t)),
        _ => Err(value.bad("like \"blend 0.5\", with a share in 0..1")),
    }
}
