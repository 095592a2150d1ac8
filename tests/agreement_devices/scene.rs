//! Scenes, views and transfer functions that follow from a seed.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use vcsg::math::{Aabb, Interval, Plane};
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline};
use vcsg::model::{BooleanOp, Combine, Family, Model, Node, NodeId, ValueRule, VolumeLeaf};
use vcsg::projection::{
    Camera, ControlPoint, DepthCue, FrameSpec, Light, Material, Mode, Projection, Settings, Shading, TransferFunction,
    View,
};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::{Bricks, Grid, VoxelType, Voxels};
use vcsg::voxelize::{Primitive, Solid};

use crate::random::Random;

/// What a scene is made of, as far as it is not left to the seed.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    pub seed: u64,
    pub voxels: VoxelType,
    pub content: Content,
    pub mode: Mode,
    pub lit: bool,
    pub perspective: bool,
    /// Smallest and largest block.
    pub blocks: [usize; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Content {
    /// A volume on its own lattice: all covered.
    Volume,
    /// A volume turned in the world and sampled on the world's axes.
    Turned,
    /// A volume with a cut and a ball taken away.
    Carved,
    /// A volume and a ball beside and within it.
    United,
    /// The same with colours of their own, blended by a rule that the seed chooses, and cut.
    Blended,
    /// A volume bent by landmarks at its corners.
    Deformed,
}

/// All that a frame needs.
pub struct Scene {
    pub target: Target,
    pub transfer: TransferFunction,
    pub camera: Camera,
    pub settings: Settings,
}

impl Scene {
    pub fn spec(&self) -> FrameSpec<'_> {
        FrameSpec {
            target: &self.target,
            transfer: &self.transfer,
            camera: &self.camera,
            settings: &self.settings,
        }
    }
}

/// The rules that colours are blended by.
const COLOR_RULES: [fn() -> ValueRule; 6] = [
    || ValueRule::Over,
    || ValueRule::Plus,
    || ValueRule::In,
    || ValueRule::Out,
    || ValueRule::Atop,
    || ValueRule::Xor,
];

/// Voxel values are 20 + 200·[0, 1] in every type.
const VALUES: [f64; 2] = [20.0, 220.0];

pub const FRAME_PX: [u32; 2] = [48, 40];

impl Recipe {
    /// All of it left to the seed.
    pub fn random(seed: u64) -> Self {
        use Content::{Blended, Carved, Deformed, Turned, United, Volume};
        let random = &mut Random(!seed);
        let mode = random.of(&Mode::ALL);
        Self {
            seed,
            voxels: random.of(&[VoxelType::U8, VoxelType::I16, VoxelType::F32]),
            content: random.of(&[Volume, Turned, Carved, United, Blended, Deformed]),
            mode: random.of(&[Mode::Composite, mode]),
            lit: random.below(2) == 1,
            perspective: random.below(2) == 1,
            blocks: random.of(&[[8, 8], [8, 16], [8, 64], [16, 32], [32, 32], [64, 64]]),
        }
    }

    pub fn scene(&self) -> Scene {
        let mut random = Random(self.seed);
        let model = self.model(&mut random);
        let subdivision = Subdivision {
            min_block: self.blocks[0],
            max_block: self.blocks[1],
            ..Subdivision::default()
        };
        // A lattice of its own, so that the volume is interpolated.
        let spacing_mm = (self.content == Content::Turned).then_some(1.1);
        let target = Target::build(&model, spacing_mm, &subdivision).expect("a target");
        let camera = self.view(&mut random).camera(&target.lattice.world_bounds(), FRAME_PX);
        Scene {
            transfer: transfer(&mut random, 1.0),
            camera,
            settings: self.settings(&mut random),
            target,
        }
    }

    pub fn model(&self, random: &mut Random) -> Model {
        let mut model = Model::default();
        let grid = grid(self.voxels, random);
        let volume = model.push(Node::Volume(VolumeLeaf {
            bricks: Arc::new(Bricks::new(&grid)),
            window: Interval::ALL,
        }));
        let bounds = model.bounds()[0];
        let (center, size) = (bounds.center(), bounds.size());
        let ball = Solid::Sphere {
            center: center + size * 0.3,
            radius: size.min_element() * 0.4,
        };
        let ball = Node::Primitive(Primitive::soft(ball, 150.0));
        match self.content {
            Content::Volume => {}
            Content::Turned => {
                let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.5);
                model.push(Node::Transform {
                    child: volume,
                    parent_from_child: DAffine3::from_quat(turn),
                });
            }
            Content::Carved => {
                let plane = Plane::through(center, DVec3::new(1.0, -1.0, 0.5)).expect("a plane");
                let child = model.push(Node::Cut { child: volume, plane });
                let second = model.push(ball);
                model.push(combine(BooleanOp::Subtraction, ValueRule::First, child, second));
            }
            Content::Blended => {
                let ball = model.push(ball);
                let [first, second] = [volume, ball].map(|child| {
                    let unit_mm = random.of(&[1.0, 2.5]);
                    let transfer = Arc::new(transfer(random, unit_mm));
                    model.push(Node::Classify { child, transfer })
                });
                let rule = random.of(&COLOR_RULES)();
                let child = model.push(combine(BooleanOp::Union, rule, first, second));
                let plane = Plane::through(center, DVec3::new(1.0, -1.0, 0.5)).expect("a plane");
                model.push(Node::Cut { child, plane });
            }
            Content::Deformed => {
                model.push(Node::Deform {
                    child: volume,
                    morph: Arc::new(bent(&bounds, random)),
                    error_voxels: 0.1,
                });
            }
            Content::United => {
                let second = model.push(ball);
                model.push(combine(BooleanOp::Union, ValueRule::Max, volume, second));
            }
        }
        model
    }

    fn view(&self, random: &mut Random) -> View {
        let projection = if self.perspective {
            Projection::Perspective {
                fov_y_deg: random.between(25.0, 60.0),
            }
        } else {
            Projection::Orthographic
        };
        let turned = random.below(4) > 0;
        let mut degrees = |most: f64| {
            if turned { random.between(-most, most) } else { 0.0 }
        };
        View {
            azimuth_deg: degrees(180.0),
            elevation_deg: degrees(80.0),
            roll_deg: degrees(30.0),
            zoom: random.between(0.9, 2.5),
            projection,
            ..View::default()
        }
    }

    fn settings(&self, random: &mut Random) -> Settings {
        Settings {
            // Of colours there are no values to see.
            mode: match self.content {
                Content::Blended if !self.mode.classifies() => Mode::Composite,
                _ => self.mode,
            },
            shading: self.lit.then(|| shading(random)),
            depth_cue: DepthCue {
                strength: random.of(&[0.0, 0.4]),
            },
            samples_per_voxel: random.between(0.7, 1.3),
            ..Settings::default()
        }
    }
}

fn shading(random: &mut Random) -> Shading {
    let lights = (0..1 + random.below(Shading::MAX_LIGHTS)).map(|_| Light {
        towards: DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0))).normalize_or(DVec3::NEG_Z),
        intensity: random.between(0.1, 0.8) as f32,
    });
    Shading {
        lights: lights.collect(),
        material: Material {
            specular: random.between(0.0, 0.5) as f32,
            shininess_log2: random.below(7) as u32,
            ..Material::default()
        },
        soft_gradient: random.between(0.01, 0.1),
    }
}

/// Waves of lengths that make neighbours differ, but not by much.
fn grid(voxels: VoxelType, random: &mut Random) -> Grid {
    let dims: [usize; 3] = std::array::from_fn(|_| 20 + random.below(14));
    let waves: [(DVec3, f64); 3] = std::array::from_fn(|_| {
        let wave = DVec3::from_array(std::array::from_fn(|_| random.between(-0.35, 0.35)));
        (wave, random.between(0.0, std::f64::consts::TAU))
    });
    let value = |p: DVec3| {
        let sum: f64 = waves.iter().map(|(k, phase)| (k.dot(p) + phase).sin()).sum();
        VALUES[0] + (VALUES[1] - VALUES[0]) * (0.5 + sum / 6.0)
    };
    let [nx, ny, nz] = dims;
    let values: Vec<f64> = (0..nx * ny * nz)
        .map(|n| {
            let at = [n % nx, n / nx % ny, n / (nx * ny)];
            value(DVec3::from_array(at.map(|a| a as f64)))
        })
        .collect();
    let spacing = DVec3::from_array(std::array::from_fn(|_| random.between(0.8, 1.4)));
    let origin = DVec3::from_array(std::array::from_fn(|_| random.between(-100.0, 100.0)));
    Grid::new(
        dims,
        DAffine3::from_translation(origin) * DAffine3::from_scale(spacing),
        typed(voxels, &values),
    )
    .expect("a grid")
}

fn typed(voxels: VoxelType, values: &[f64]) -> Voxels {
    let values = values.iter();
    match voxels {
        VoxelType::U8 => Voxels::U8(values.map(|v| v.round() as u8).collect()),
        VoxelType::I16 => Voxels::I16(values.map(|v| v.round() as i16).collect()),
        _ => Voxels::F32(values.map(|&v| v as f32).collect()),
    }
}

/// Rising and falling opacity, with low values invisible.
fn transfer(random: &mut Random, unit_mm: f64) -> TransferFunction {
    let mut point = |value: f64, opacity: [f64; 2]| ControlPoint {
        value: value as f32,
        color: std::array::from_fn(|_| random.between(0.1, 1.0) as f32),
        opacity: random.between(opacity[0], opacity[1]) as f32,
    };
    let points = vec![
        point(60.0, [0.0, 1e-9]),
        point(100.0, [0.02, 0.2]),
        point(160.0, [0.05, 0.5]),
        point(220.0, [0.02, 0.3]),
    ];
    TransferFunction::new(points, unit_mm).expect("rising values")
}

fn combine(op: BooleanOp, rule: ValueRule, first: NodeId, second: NodeId) -> Node {
    Node::Combine(Combine {
        op,
        rule,
        family: Family::MinMax,
        first,
        second,
    })
}

/// Each corner of `bounds` goes up to a twelfth of its size along each axis.
fn bent(bounds: &Aabb, random: &mut Random) -> Morph {
    let mut by = || DVec3::from([0; 3].map(|_| random.between(-1.0, 1.0) / 12.0)) * bounds.size();
    let landmarks = bounds.corners().map(|from| Landmark {
        name: "corner".into(),
        from,
        to: from + by(),
    });
    let spline = Spline::new(&landmarks, &Smoothness::default()).expect("a spline");
    Morph::new(spline, *bounds).expect("corners that go apart fold nothing")
}
