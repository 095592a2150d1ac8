//! vcsg: model with volumes, see the result at once, and prove the picture is right.
//!
//! Scans and geometric primitives are combined in a **Volumetric CSG tree** ([`model`]); space is divided into **target blocks**,
//! each of which evaluates only the part of the tree that reaches it ([`target`]); and the blocks are drawn as slices of 3D
//! textures, from back to front ([`projection`] plans, [`render`] draws with [`gpu`]). docs/ARCHITECTURE.md has the map,
//! docs/CONVENTIONS.md the axes and units, docs/PAPERS.md the sources.
//!
//! # A tour
//!
//! A model is a list of nodes, children before parents. Here a ball of value 100 is united with a box of value 200, and where
//! both are the larger value wins. Lengths are millimetres, axes LPS.
//!
//! ```
//! use glam::DVec3;
//! use vcsg::math::Aabb;
//! use vcsg::model::{BooleanOp, Combine, Family, Model, Node, ValueRule};
//! use vcsg::voxelize::{Primitive, Solid};
//!
//! let mut model = Model::default();
//! let ball = Solid::Sphere { center: DVec3::ZERO, radius: 10.0 };
//! let ball = model.push(Node::Primitive(Primitive::soft(ball, 100.0)));
//! let cube = Solid::Box(Aabb::new(DVec3::ZERO, DVec3::splat(12.0)));
//! let cube = model.push(Node::Primitive(Primitive::soft(cube, 200.0)));
//! let root = model.push(Node::Combine(Combine {
//!     op: BooleanOp::Union,
//!     rule: ValueRule::Max,
//!     family: Family::MinMax,
//!     first: ball,
//!     second: cube,
//! }));
//! let bounds = model.bounds()[root.index()];
//! assert_eq!(bounds, Aabb::new(DVec3::splat(-10.0), DVec3::splat(12.0)));
//!
//! // The target samples the model every half millimetre: 44 voxels an axis and, on each side, two of soft surface and an
//! // empty one.
//! use vcsg::target::{Layout, Subdivision, Target, VoxelTarget};
//!
//! let subdivision = Subdivision { min_block: 4, ..Subdivision::default() };
//! let target = Target::build(&model, Some(0.5), &subdivision)?;
//! assert_eq!(target.lattice.dims, [50; 3]);
//!
//! // A block that one node fills has a path of one step and stores one value; one that both surfaces cross needs both.
//! let steps = |block| target.path(block).len();
//! assert!(target.blocks.iter().any(|b| b.layout == Layout::Uniform && steps(b) == 1));
//! assert!(target.blocks.iter().any(|b| b.layout == Layout::Mixed && steps(b) == 3));
//!
//! // Whatever a block leaves out, its voxels are the tree's own samples, bit for bit.
//! let voxels = VoxelTarget::new(&target);
//! for at in [[0, 0, 0], [10, 23, 23], [30, 30, 30], [43, 43, 43]] {
//!     let truth = target.sample(DVec3::from_array(at.map(|n| n as f64)));
//!     assert_eq!(voxels.sample(at), truth);
//! }
//!
//! // A picture needs colours, a camera and settings. The reference projector is slow, in double precision, and needs no device.
//! use vcsg::projection::{
//!     ControlPoint, FrameSpec, Projector, Reference, Settings, TransferFunction, View,
//! };
//!
//! let point = |value, color| ControlPoint { value, color, opacity: 0.9 };
//! let points = vec![point(100.0, [0.9, 0.8, 0.7]), point(200.0, [0.3, 0.6, 0.9])];
//! let view = View { azimuth_deg: 30.0, elevation_deg: 20.0, ..View::default() };
//! let frame = Reference.project(&FrameSpec {
//!     target: &target,
//!     transfer: &TransferFunction::new(points, 1.0)?,
//!     camera: &view.camera(&bounds, [24, 24]),
//!     settings: &Settings::default(),
//! })?;
//! let alpha = |x, y| frame.pixel(x, y).map(|rgba| rgba[3]);
//! assert_eq!(alpha(0, 0), Some(0.0));
//! assert!(alpha(12, 12) > Some(0.99));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! On a device the same frame is drawn by [`render::Slices`], which is a [`projection::Projector`] too:
//!
//! ```no_run
//! use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
//! use vcsg::render::{SliceRenderer, Slices};
//!
//! let instance = Instance::new(Validation::Off)?;
//! let device = Device::open(&instance, &DeviceSelector::Default, &SliceRenderer::REQUIREMENTS)?;
//! let slices = Slices::new(&device)?;
//! # Ok::<(), vcsg::gpu::GpuError>(())
//! ```
//!
//! [`render::SliceRenderer`] with [`render::PagedTarget`] keeps a target on the device and draws it from many views.
//! [`scene::Scene`] reads a tree and how it is seen from a scene file, [`volume::io`] reads scans, and [`fn@image::save`] writes
//! frames.

#![warn(missing_docs)]

pub mod array;
pub mod cli;
pub mod conformance;
pub mod gpu;
pub mod image;
pub mod interface;
pub mod math;
pub mod model;
pub mod output;
pub mod projection;
pub mod render;
pub mod scene;
pub mod surface;
pub mod target;
pub mod volume;
pub mod voxelize;

/// The SPIR-V of `shaders/`, a constant a shader.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
