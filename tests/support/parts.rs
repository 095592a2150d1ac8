//! Random parts of a model: volumes, primitives, maps, planes and placements.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use proptest::prelude::*;
use vcsg::math::{Aabb, Interval, Plane};
use vcsg::model::{
    Admitted, BooleanOp, ControlPoint, Family, Lut, MaskLeaf, Operator, TransferFunction, ValueMap, ValueRule,
    VolumeLeaf,
};
use vcsg::volume::{Bricks, Grid, Voxels};
use vcsg::voxelize::{Polyhedron, Primitive, Profile, Relief, RoundedBox, Solid, Thread, Waves};

/// What fills a random volume.
#[derive(Clone, Copy, Debug)]
pub enum Texture {
    /// One value.
    Constant,
    /// A value for each slab of four voxels along x.
    Slabs,
    /// A value for each voxel.
    Noise,
    /// As [`Self::Noise`], but for some missing voxels (in `f32`).
    Holes,
}

/// The type of a random volume's voxels.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    U8,
    I16,
    F32,
}

/// A random volume.
#[derive(Clone, Debug)]
pub struct Scan {
    pub dims: [usize; 3],
    pub kind: Kind,
    pub texture: Texture,
    pub seed: u64,
    pub world_from_index: DAffine3,
    pub window: Interval,
}

impl Scan {
    /// The scan as a leaf.
    pub fn leaf(&self) -> VolumeLeaf {
        let values = self.values();
        let voxels = match self.kind {
            Kind::U8 => Voxels::U8(values.map(|v| v as u8).collect()),
            Kind::I16 => Voxels::I16(values.map(|v| v as i16 - 100).collect()),
            Kind::F32 => Voxels::F32(values.map(|v| v - 100.0).collect()),
        };
        let grid = Grid::new(self.dims, self.world_from_index, voxels).expect("a valid grid");
        VolumeLeaf {
            bricks: Arc::new(Bricks::new(&grid)),
            window: self.window,
        }
    }

    /// Where some of the scan's values are, as a leaf.
    pub fn mask(&self, admitted: Admitted) -> MaskLeaf {
        MaskLeaf {
            bricks: self.leaf().bricks,
            admitted,
            value: 55.0,
        }
    }

    /// Values in `[0, 256)`.
    fn values(&self) -> impl Iterator<Item = f32> {
        let Self { dims, texture, .. } = *self;
        let noise = move |n: usize| hashed(self.seed, n as u64) as f32 / 256.0;
        (0..dims.iter().product()).map(move |n| match texture {
            Texture::Constant => noise(0),
            Texture::Slabs => noise(n % dims[0] / 4),
            Texture::Noise => noise(n),
            Texture::Holes if n % 37 == 5 => f32::NAN,
            Texture::Holes => noise(n),
        })
    }
}

/// 16 random bits (the finaliser of SplitMix64; Steele, Lea and Flood 2014).
fn hashed(seed: u64, n: u64) -> u16 {
    let mut x = seed.wrapping_add(n.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ x >> 31) & 0xffff) as u16
}

/// Volumes placed by `placement`.
pub fn scan(placement: BoxedStrategy<DAffine3>) -> impl Strategy<Value = Scan> {
    let kind = prop_oneof![Just(Kind::U8), Just(Kind::I16), Just(Kind::F32)];
    let texture = prop_oneof![
        Just(Texture::Constant),
        Just(Texture::Slabs),
        Just(Texture::Noise),
        Just(Texture::Holes)
    ];
    let dims = prop::array::uniform3(1usize..24);
    (dims, kind, texture, any::<u64>(), placement, window()).prop_map(
        |(dims, kind, texture, seed, world_from_index, window)| Scan {
            dims,
            kind,
            texture,
            seed,
            world_from_index,
            window,
        },
    )
}

/// Masks of a value window, or of all but 0.
pub fn admitted() -> impl Strategy<Value = Admitted> {
    prop_oneof![1 => Just(Admitted::NotZero), 3 => window().prop_map(Admitted::Within)]
}

fn window() -> impl Strategy<Value = Interval> {
    prop_oneof![
        2 => Just(Interval::ALL),
        1 => (-100.0f32..200.0).prop_map(|lo| Interval::new(lo, f32::INFINITY)),
        1 => (-100.0f32..200.0, 0.0f32..150.0).prop_map(|(lo, width)| Interval::new(lo, lo + width)),
    ]
}

/// Points within some 12 mm of the origin, often on a half-integer.
pub fn point() -> impl Strategy<Value = DVec3> {
    let coordinate = || prop_oneof![-12.0f64..12.0, (-24i32..24).prop_map(|n| f64::from(n) / 2.0)];
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from)
}

/// Unit vectors, often along an axis.
pub fn direction() -> impl Strategy<Value = DVec3> {
    let free = prop::array::uniform3(-1.0f64..1.0).prop_map(|v| DVec3::from(v).try_normalize().unwrap_or(DVec3::X));
    let axis =
        (0usize..3, any::<bool>()).prop_map(|(axis, positive)| DVec3::AXES[axis] * if positive { 1.0 } else { -1.0 });
    prop_oneof![2 => free, 1 => axis]
}

/// Planes through some [`point`].
pub fn plane() -> impl Strategy<Value = Plane> {
    (point(), direction()).prop_map(|(p, n)| Plane::through(p, n).expect("a unit normal"))
}

/// Primitives whose coverage is 0 or 1, of the three solids that the second evaluation of a model knows.
pub fn crisp() -> impl Strategy<Value = Primitive> {
    let solid = prop_oneof![
        (point(), 1.0f64..12.0).prop_map(|(center, radius)| Solid::Sphere { center, radius }),
        (point(), point()).prop_map(|(a, b)| Solid::Box(Aabb::of_points([a, b]))),
        plane().prop_map(Solid::HalfSpace),
    ];
    (solid, -100.0f32..150.0).prop_map(|(solid, value)| Primitive::crisp(solid, value))
}

/// Volume-sampled primitives of all kinds about the origin, some of them shells.
pub fn soft() -> impl Strategy<Value = Primitive> {
    let shell = prop_oneof![2 => Just(None), 1 => (0.5f64..4.0).prop_map(Some)];
    (solid(), shell, 0.3f64..3.0, -100.0f32..150.0).prop_map(|(solid, shell, filter_voxels, value)| {
        let whole = Primitive {
            filter_voxels,
            ..Primitive::soft(solid, value)
        };
        match shell {
            Some(thickness) => whole.clone().shell(thickness).unwrap_or(whole),
            None => whole,
        }
    })
}

/// Solids of every kind.
pub fn solid() -> impl Strategy<Value = Solid> {
    let size = || 0.6f64..10.0;
    let (a, b, h) = (size(), size(), size());
    let round = prop_oneof![
        (size(), size()).prop_map(|(radius, height)| Profile::cylinder(radius, height)),
        (a, b, h).prop_map(|(bottom, top, height)| Profile::frustum(bottom, top, height)),
        (size(), size()).prop_map(|(radius, height)| Profile::frustum(radius, 0.0, height)),
        (size(), 0.1f64..0.95).prop_map(|(ring, part)| Profile::torus(ring, ring * part)),
        (size(), size()).prop_map(|(radius, length)| Profile::capsule(radius, length)),
    ];
    let waves = (size(), size(), 0.0f64..3.0, 4.0f64..20.0, 4.0f64..20.0);
    let thread = (4.0f64..9.0, 0.1f64..0.3, 2.0f64..5.0, 0.4f64..3.0);
    prop_oneof![
        2 => (point(), size()).prop_map(|(center, radius)| Solid::Sphere { center, radius }),
        2 => (point(), [size(), size(), size()])
            .prop_map(|(min, size)| Solid::Box(Aabb::new(min, min + DVec3::from(size)))),
        1 => plane().prop_map(Solid::HalfSpace),
        2 => (3usize..9, size(), size())
            .prop_map(|(sides, radius, height)| Solid::Polyhedron(Polyhedron::prism(sides, radius, height))),
        4 => round.prop_map(Solid::revolved),
        1 => ([size(), size(), size()], 0.1f64..=1.0).prop_map(|(half, part)| {
            let half = DVec3::from(half);
            let radius = part * half.min_element();
            Solid::Relief(Relief::RoundedBox(RoundedBox { half, radius }))
        }),
        1 => waves.prop_map(|(x, y, amplitude, wx, wy)| Solid::Relief(Relief::Waves(Waves {
            size: DVec2::new(x, y) * 2.0,
            depth: amplitude + 1.5,
            amplitude,
            wavelength: DVec2::new(wx, wy),
        }))),
        1 => thread.prop_map(|(ring, part, pitch, turns)| {
            let profile = Profile::torus(ring, ring * part);
            Solid::Thread(Thread::new(profile, pitch, turns).into())
        }),
    ]
}

/// Linear, quadratic and tabulated maps.
pub fn value_map() -> impl Strategy<Value = ValueMap> {
    let table = prop::collection::vec((0.5f32..80.0, -100.0f32..100.0), 0..5).prop_map(|steps| {
        let mut input = -90.0;
        let rising = steps.into_iter().map(|(step, output)| {
            input += step;
            (input, output)
        });
        ValueMap::Table(rising.collect())
    });
    prop_oneof![
        (-2.0f32..2.0, -50.0f32..50.0).prop_map(|(scale, offset)| ValueMap::Linear { scale, offset }),
        (-0.01f32..0.01, -1.0f32..1.0, -50.0f32..50.0).prop_map(|(a, b, c)| ValueMap::Quadratic { a, b, c }),
        table,
    ]
}

/// Tables of two values.
pub fn lut() -> impl Strategy<Value = Lut> {
    let axis = || (-100.0f32..100.0, 1.0f32..150.0).prop_map(|(lo, width)| Interval::new(lo, lo + width));
    (axis(), axis(), 1usize..7, 1usize..7).prop_flat_map(|(first, second, width, height)| {
        prop::collection::vec(-100.0f32..100.0, width * height)
            .prop_map(move |values| Lut::new(first, second, width, values).expect("a sound table"))
    })
}

/// Every Boolean operation with every value rule that keeps finite values finite, in both families.
pub fn operator() -> impl Strategy<Value = Operator> {
    let op = prop::sample::select(vec![
        BooleanOp::Union,
        BooleanOp::Union,
        BooleanOp::Intersection,
        BooleanOp::Subtraction,
        BooleanOp::SubtractionWithRule,
    ]);
    let rule = prop_oneof![
        10 => prop::sample::select(vec![
            ValueRule::First,
            ValueRule::Second,
            ValueRule::Max,
            ValueRule::Min,
            ValueRule::Sum,
            ValueRule::Difference,
            ValueRule::Product,
            ValueRule::Average,
            ValueRule::AlgebraicSum,
            ValueRule::AbsoluteDifference,
        ]),
        1 => (0.0f32..=1.0).prop_map(ValueRule::Blend),
        2 => lut().prop_map(|lut| ValueRule::Table(Arc::new(lut))),
    ];
    let family = prop::sample::select(vec![Family::MinMax, Family::Product]);
    (op, rule, family).prop_map(|(op, rule, family)| Operator { op, rule, family })
}

/// Every Boolean operation with every rule of colours, in both families.
pub fn color_operator() -> impl Strategy<Value = Operator> {
    let op = prop::sample::select(vec![
        BooleanOp::Union,
        BooleanOp::Union,
        BooleanOp::Intersection,
        BooleanOp::Subtraction,
        BooleanOp::SubtractionWithRule,
    ]);
    let rule = prop::sample::select(vec![
        ValueRule::First,
        ValueRule::Second,
        ValueRule::Over,
        ValueRule::Plus,
        ValueRule::In,
        ValueRule::Out,
        ValueRule::Atop,
        ValueRule::Xor,
    ]);
    let family = prop::sample::select(vec![Family::MinMax, Family::Product]);
    (op, rule, family).prop_map(|(op, rule, family)| Operator { op, rule, family })
}

/// Transfer functions of the values that volumes and primitives have, often with transparent stretches.
pub fn transfer() -> impl Strategy<Value = TransferFunction> {
    let opacity = prop_oneof![2 => Just(0.0f32), 2 => 0.0f32..=1.0, 1 => Just(1.0f32)];
    let point = (-120.0f32..260.0, prop::array::uniform3(0.0f32..=1.0), opacity);
    let unit_mm = prop_oneof![Just(1.0), 0.3f64..5.0];
    (prop::collection::vec(point, 1..6), unit_mm).prop_map(|(mut points, unit_mm)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points = points
            .into_iter()
            .map(|(value, color, opacity)| ControlPoint { value, color, opacity });
        TransferFunction::new(points.collect(), unit_mm).expect("a valid function")
    })
}

/// Whole-voxel shifts of some 12 voxels.
pub fn shift() -> impl Strategy<Value = DAffine3> {
    prop::array::uniform3(-12i32..12).prop_map(|by| DAffine3::from_translation(DVec3::from(by.map(f64::from))))
}

/// Rigid and mirroring maps of the axes onto one another, shifts, and free maps with scale and shear.
pub fn placement() -> impl Strategy<Value = DAffine3> {
    prop_oneof![
        1 => Just(DAffine3::IDENTITY),
        1 => shift(),
        1 => (0usize..3, shift()).prop_map(|(axis, by)| by * mirror(axis)),
        1 => (0usize..3, shift()).prop_map(|(axis, by)| by * quarter_turn(axis)),
        3 => free(),
    ]
}

fn mirror(axis: usize) -> DAffine3 {
    let mut scale = DVec3::ONE;
    scale[axis] = -1.0;
    DAffine3::from_scale(scale)
}

fn quarter_turn(axis: usize) -> DAffine3 {
    DAffine3::from_axis_angle(DVec3::AXES[axis], std::f64::consts::FRAC_PI_2)
}

fn free() -> impl Strategy<Value = DAffine3> {
    let spacing = prop::array::uniform3(0.5f64..1.8);
    let shear = prop::array::uniform3(-0.4f64..0.4);
    (direction(), -3.1f64..3.1, spacing, shear, point()).prop_map(|(axis, angle, spacing, shear, translation)| {
        let sheared = DMat3::from_cols(
            DVec3::X,
            DVec3::new(shear[0], 1.0, 0.0),
            DVec3::new(shear[1], shear[2], 1.0),
        );
        let turned = DMat3::from_quat(DQuat::from_axis_angle(axis, angle));
        DAffine3 {
            matrix3: turned * sheared * DMat3::from_diagonal(spacing.into()),
            translation,
        }
    })
}
