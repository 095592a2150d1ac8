//! What is drawn: the benchmark volumes, the models made of them, and how they are looked at.

use std::sync::Arc;

use glam::{DAffine3, DVec3, dvec3};
use serde::Deserialize;
use vcsg::math::{Aabb, Interval, Plane};
use vcsg::model::{BooleanOp, Combine, Family, Model, Node, NodeId, ValueRule, VolumeLeaf};
use vcsg::projection::{Camera, ControlPoint, Lens, Light, Material, Settings, Shading, TransferFunction, View};
use vcsg::volume::{Bricks, Grid, Voxels};
use vcsg::voxelize::{Primitive, Solid};

use crate::Outcome;

/// Voxels along each axis of the benchmark volumes; they are 1 mm apart, the first at the origin.
pub const SIDE: usize = 256;

/// Pixels along each side of a frame.
pub const FRAME_EDGE: u32 = 512;

/// Opacities of the tables hold for a voxel.
const UNIT_MM: f64 = 1.0;

/// Where a benchmark volume is.
pub fn raw_path(volume: &str) -> String {
    format!("target/bench/{volume}.raw")
}

/// Where a transfer function is.
pub fn table_path(table: &str) -> String {
    format!("tools/peers/tables/{table}.json")
}

/// A benchmark volume: `head` or `dense`.
pub fn bricks(volume: &str) -> Outcome<Arc<Bricks>> {
    let voxels = Voxels::U8(std::fs::read(raw_path(volume))?);
    let grid = Grid::new([SIDE; 3], DAffine3::IDENTITY, voxels)?;
    Ok(Arc::new(Bricks::new(&grid)))
}

fn push_volume(model: &mut Model, bricks: &Arc<Bricks>) -> NodeId {
    model.push(Node::Volume(VolumeLeaf {
        bricks: Arc::clone(bricks),
        window: Interval::ALL,
    }))
}

/// The volume alone.
pub fn bare(bricks: &Arc<Bricks>) -> Model {
    let mut model = Model::default();
    push_volume(&mut model, bricks);
    model
}

/// The box of a benchmark volume, millimetres.
pub fn bounds() -> Aabb {
    Aabb::new(DVec3::splat(-0.5), DVec3::splat(SIDE as f64 - 0.5))
}

/// The middle of a benchmark volume.
pub fn middle() -> DVec3 {
    DVec3::splat((SIDE - 1) as f64 / 2.0)
}

/// The volume cut by a plane, a sphere taken out of it.
pub fn cut_and_carved(bricks: &Arc<Bricks>) -> Outcome<Model> {
    let mut model = Model::default();
    let child = push_volume(&mut model, bricks);
    let plane = Plane::through(middle(), dvec3(1.0, -1.0, 1.0)).ok_or("a plane needs a direction")?;
    let first = model.push(Node::Cut { child, plane });
    let ball = Solid::Sphere {
        center: middle() + dvec3(-40.0, -40.0, 20.0),
        radius: 40.0,
    };
    let second = model.push(Node::Primitive(Primitive::crisp(ball, 0.0)));
    model.push(Node::Combine(Combine {
        op: BooleanOp::Subtraction,
        rule: ValueRule::First,
        family: Family::MinMax,
        first,
        second,
    }));
    Ok(model)
}

/// The volume moved.
pub fn moved(bricks: &Arc<Bricks>, parent_from_child: DAffine3) -> Model {
    let mut model = Model::default();
    let child = push_volume(&mut model, bricks);
    model.push(Node::Transform {
        child,
        parent_from_child,
    });
    model
}

/// How a model is looked at.
#[derive(Clone)]
pub struct Look {
    /// Values to colour and opacity.
    pub transfer: TransferFunction,
    /// The eye.
    pub camera: Camera,
    /// Light and sampling.
    pub settings: Settings,
}

/// A transfer function as both sides read it: points of `[value, opacity]` and of `[value, red, green, blue]`.
#[derive(Deserialize)]
struct Table {
    opacity_per_voxel: Vec<[f32; 2]>,
    colour: Vec<[f32; 4]>,
}

/// The transfer function of a table's file, with a point wherever its opacity or its colour has one.
pub fn transfer(table: &str) -> Outcome<TransferFunction> {
    let table: Table = serde_json::from_str(&std::fs::read_to_string(table_path(table))?)?;
    let opacities = table.opacity_per_voxel.iter();
    let opacity = opacities.map(|&[value, opacity]| (value, [opacity]));
    let opacity: Vec<_> = opacity.collect();
    let colours = table.colour.iter();
    let colour: Vec<_> = colours.map(|&[v, r, g, b]| (v, [r, g, b])).collect();
    let mut values: Vec<f32> = opacity.iter().map(|p| p.0).collect();
    values.extend(colour.iter().map(|p| p.0));
    values.sort_by(f32::total_cmp);
    values.dedup();
    let point = |value| ControlPoint {
        value,
        color: piecewise(&colour, value),
        opacity: piecewise(&opacity, value)[0],
    };
    let points = values.into_iter().map(point).collect();
    Ok(TransferFunction::new(points, UNIT_MM)?)
}

/// Linear between points of rising place, constant beyond them.
fn piecewise<const N: usize>(points: &[(f32, [f32; N])], at: f32) -> [f32; N] {
    let after = points.partition_point(|p| p.0 <= at);
    let (Some(b), Some(a)) = (points.get(after), points[..after].last()) else {
        let end = points.get(after).or(points.last());
        return end.map_or([0.0; N], |p| p.1);
    };
    let t = (at - a.0) / (b.0 - a.0);
    std::array::from_fn(|n| a.1[n] + t * (b.1[n] - a.1[n]))
}

/// One sample a voxel; lit by one light from the eye, with the coefficients of tools/peers/vtk_render.py, or not at all.
pub fn settings(shaded: bool) -> Settings {
    let shading = Shading {
        lights: vec![Light {
            towards: -DVec3::Z,
            intensity: 1.0,
        }],
        material: Material {
            ambient: 0.1,
            diffuse: 0.7,
            specular: 0.2,
            // VTK's highlight follows the reflected ray, ours the half-way vector, which turns half as far: cos⁸ 2a is
            // about cos³² a.
            shininess_log2: 5,
        },
        // Half a step of 8 bits: next to nothing is softened, as VTK softens nothing.
        soft_gradient: 0.002,
    };
    Settings {
        shading: shaded.then_some(shading),
        ..Settings::default()
    }
}

/// The camera that VTK's script uses when it is not told otherwise: parallel rays, and a frame that just holds `bounds`.
pub fn camera(bounds: &Aabb) -> Camera {
    let view = View {
        azimuth_deg: 30.0,
        elevation_deg: 20.0,
        ..View::default()
    };
    let camera = view.camera(bounds, [FRAME_EDGE; 2]);
    let place = |p: DVec3| camera.eye_from_world.transform_point3(p).truncate();
    let middle = place(bounds.center());
    let corners = bounds.corners().map(|c| (place(c) - middle).abs().max_element());
    let half_height_mm = corners.into_iter().fold(0.0, f64::max);
    Camera {
        lens: parallel(half_height_mm, FRAME_EDGE),
        ..camera
    }
}

/// The lens of a square frame of `edge` pixels that is twice `half_height_mm` high.
pub fn parallel(half_height_mm: f64, edge: u32) -> Lens {
    Lens::Orthographic {
        pixels_per_mm: f64::from(edge) / (2.0 * half_height_mm),
    }
}
