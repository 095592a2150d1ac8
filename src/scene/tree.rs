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
use super::kinds;
use super::leaves;
use super::loader::{Remembered, VolumeLoader};
use super::maps;
use super::primitives;
use super::rules;
use super::source::Source;
use super::transforms;
use crate::model::{BooleanOp, Combine, Family, Kind, MaskLeaf, Model, Node, NodeId, ValueRule, VolumeLeaf};
use crate::voxelize::{Primitive, Solid};

type Result<T> = std::result::Result<T, SceneError>;

/// Builds one model from a scene file and all that it includes.
pub(super) struct TreeBuilder<'l> {
    model: Model,
    loader: Remembered<&'l mut dyn VolumeLoader>,
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

/// A child, and where it is written.
struct Operand<'e> {
    id: NodeId,
    element: Element<'e>,
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
            loader: Remembered::new(loader),
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
            "mask" => self.mask(element, scope),
            "mesh" => self.mesh(element, scope),
            "use" => reference(element, scope),
            "include" => self.include(element, scope),
            "union" | "intersect" | "subtract" | "overlay" => self.combined(element, scope),
            "map" => self.mapped(element, scope),
            "classify" => self.classified(element, scope),
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
        let (op, rule, family) = (BooleanOp::Subtraction, ValueRule::First, rules::family(&element)?);
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
        let rule = rules::value_rule(&element, &scope.base_dir)?;
        let family = rules::family(&element)?;
        let child = self.united(element, scope)?;
        let rule = kinds::rule_for(&element, BooleanOp::Union, rule, element, self.model.kind(child))?;
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
        let mask = leaves::mask_request(&element, &scope.base_dir)?;
        let fails = |reason| element.error_of_argument(0, Problem::Volume(reason));
        let bricks = self.loader.load(&request).map_err(fails)?;
        let Some(request) = mask else {
            return Ok(self.model.push(Node::Volume(VolumeLeaf { bricks, window })));
        };
        let admitted = leaves::admitted(&element)?;
        let fails = |reason| element.error_of("mask", Problem::Volume(reason));
        let mask = MaskLeaf {
            bricks: self.loader.load(&request).map_err(fails)?,
            admitted,
            value: 1.0,
        };
        let first = self.model.push(Node::Volume(VolumeLeaf { bricks, window }));
        let second = self.model.push(Node::Mask(mask));
        Ok(self.model.push(Node::Combine(Combine {
            op: BooleanOp::Intersection,
            rule: ValueRule::First,
            family: Family::MinMax,
            first,
            second,
        })))
    }

    fn mask(&mut self, element: Element, scope: &Scope) -> Result<NodeId> {
        let (admitted, value) = (leaves::admitted(&element)?, primitives::value(&element)?);
        let request = leaves::volume_request(&element, &scope.base_dir)?;
        let fails = |reason| element.error_of_argument(0, Problem::Volume(reason));
        let bricks = self.loader.load(&request).map_err(fails)?;
        Ok(self.model.push(Node::Mask(MaskLeaf {
            bricks,
            admitted,
            value,
        })))
    }

    fn mesh(&mut self, element: Element, scope: &Scope) -> Result<NodeId> {
        let request = leaves::mesh_request(&element, &scope.base_dir)?;
        let fails = |reason| element.error_of_argument(0, Problem::Mesh(reason));
        let solid = Solid::Mesh(self.loader.load_mesh(&request).map_err(fails)?);
        let primitive = primitives::filtered(&element, solid)?;
        Ok(self.model.push(Node::Primitive(primitive)))
    }

    /// The children of a set operation folded from the left; those of `scene` are united.
    fn combined(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let rule = rules::value_rule(&element, &scope.base_dir)?;
        let (op, least, wanted) = match element.name() {
            "intersect" => (BooleanOp::Intersection, 1, "at least one child"),
            "subtract" if rule.is_none() => (BooleanOp::Subtraction, 2, "at least two children"),
            "subtract" | "overlay" => (BooleanOp::SubtractionWithRule, 2, "at least two children"),
            _ => (BooleanOp::Union, 1, "at least one child"),
        };
        let family = rules::family(&element)?;
        let operands = self.children(element, scope)?;
        let too_few = || {
            let (node, found) = (element.name(), operands.len());
            element.error(Problem::TooFewChildren { node, wanted, found })
        };
        if operands.len() < least {
            return Err(too_few());
        }
        self.folded(element, (op, rule, family), &operands)?.ok_or_else(too_few)
    }

    /// Operands of one kind folded by a rule for them, which is `rule` if there is one.
    fn folded(
        &mut self,
        element: Element,
        (op, rule, family): (BooleanOp, Option<ValueRule>, Family),
        operands: &[Operand],
    ) -> Result<Option<NodeId>> {
        let Some((first, others)) = operands.split_first() else {
            return Ok(None);
        };
        let kind = self.model.kind(first.id);
        for other in others {
            kinds::require_one(first.element, kind, other.element, self.model.kind(other.id))?;
        }
        let rule = kinds::rule_for(&element, op, rule, first.element, kind)?;
        let ids = operands.iter().map(|operand| operand.id);
        Ok(self.model.fold(op, rule, family, ids))
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
        let child = self.united_values(element, scope)?;
        Ok(self.model.push(Node::Transfer { child, map }))
    }

    fn classified(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let transfer = Arc::new(kinds::transfer_function(&element)?);
        let child = self.united_values(element, scope)?;
        Ok(self.model.push(Node::Classify { child, transfer }))
    }

    /// All children as one node of values.
    fn united_values(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let children = self.children(element, scope)?;
        let colored = children.iter().find(|child| self.model.kind(child.id) == Kind::Color);
        if let Some(child) = colored {
            return Err(element.error(Problem::WantsValues {
                node: element.name(),
                child: child.element.name(),
                line: child.element.line(),
            }));
        }
        self.united_of(element, &children)
    }

    /// All children as one node.
    fn united(&mut self, element: Element, scope: &mut Scope) -> Result<NodeId> {
        let children = self.children(element, scope)?;
        self.united_of(element, &children)
    }

    fn united_of(&mut self, element: Element, children: &[Operand]) -> Result<NodeId> {
        let united = self.folded(element, (BooleanOp::Union, None, Family::default()), children)?;
        let (node, wanted) = (element.name(), "at least one child");
        united.ok_or_else(|| element.error(Problem::TooFewChildren { node, wanted, found: 0 }))
    }

    fn children<'e>(&mut self, element: Element<'e>, scope: &mut Scope) -> Result<Vec<Operand<'e>>> {
        let mut operands = Vec::new();
        for child in element.children() {
            let child = child?;
            match child.name() {
                "at" | "lut" | "point" | "pair" | "transfer" | "optics" => {}
                "define" => self.define(child, scope)?,
                _ => operands.push(Operand {
                    id: self.shape(child, scope)?,
                    element: child,
                }),
            }
        }
        Ok(operands)
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
