//! What a device can do at best: 256 full-screen quads of 512 × 512 pixels through one 3D texture of 256³ texels, one stage
//! of the work after another. `cargo bench --bench device [-- PART OF A NAME]`.
//!
//! The rates are the ceiling that drawing a volume is measured against, and the reason for the formats it uses.

mod quads;

use quads::{Case, SAMPLES, Scene, Times, case};
use vcsg::gpu::{Blend, Device, DeviceSelector, Format, GpuError, Instance, Requirements, Validation};

const ROUNDS: usize = 5;

const VALUE: u32 = 0;
const TABLE: u32 = 1;
const SKIP: u32 = 2;
const SHADE: u32 = 3;
const CORRECT: u32 = 4;

fn main() -> Result<(), GpuError> {
    let instance = Instance::new(Validation::Off)?;
    let device = Device::open(&instance, &DeviceSelector::Default, &Requirements::default())?;
    let info = device.info();
    println!(
        "{}, {} {}: {SAMPLES} samples, {ROUNDS} rounds",
        info.name, info.driver, info.driver_version
    );
    println!(
        "{:<58} {:>8} {:>10} {:>8} {:>9} {:>12}",
        "", "min ms", "median ms", "Msam/s", "CPU ms", "Msam/s @2CPU"
    );
    let part = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with("--"))
        .unwrap_or_default();
    let scene = Scene::new(&device);
    for case in cases().into_iter().filter(|case| case.name.contains(&part)) {
        let Times {
            least,
            median,
            processor,
        } = time(&scene, &case)?;
        let rate = |milliseconds: f64| f64::from(SAMPLES) / milliseconds / 1e3;
        let (wall, quiet) = (rate(least), rate(processor / 2.0));
        println!(
            "{:<58} {least:8.1} {median:10.1} {wall:8.1} {processor:9.1} {quiet:12.1}",
            case.name
        );
    }
    Ok(())
}

fn time(scene: &Scene, case: &Case) -> Result<Times, GpuError> {
    let mut rounds = scene.rounds(case)?;
    for _ in 0..ROUNDS {
        rounds.round()?;
    }
    Ok(rounds.times())
}

fn cases() -> Vec<Case> {
    let mut cases = vec![
        case("f: blend alone", |case| case.constants = vec![(VALUE, 0)]),
        case("f: blend alone, RGBA16F target", |case| {
            (case.constants, case.target) = (vec![(VALUE, 0)], Format::R16G16B16A16_SFLOAT);
        }),
        case("f: blend alone, RGBA8 target", |case| {
            (case.constants, case.target) = (vec![(VALUE, 0)], Format::R8G8B8A8_UNORM);
        }),
        case("f: write without blend", |case| {
            (case.constants, case.blend) = (vec![(VALUE, 0)], None)
        }),
        case("f: max instead of over", |case| {
            (case.constants, case.blend) = (vec![(VALUE, 0)], Some(Blend::Max))
        }),
    ];
    cases
        .extend(VALUE_FORMATS.map(|values| case(&format!("a: fetch + over, {values:?}"), |case| case.values = values)));
    cases.extend(value_and_table());
    cases.extend(targets());
    cases.extend(skipping());
    cases.extend(shading());
    cases
}

const VALUE_FORMATS: [Format; 9] = [
    Format::R8_UNORM,
    Format::R16_UNORM,
    Format::R16_SFLOAT,
    Format::R32_SFLOAT,
    Format::R8G8_UNORM,
    Format::R16G16_UNORM,
    Format::R8G8B8A8_UNORM,
    Format::R16G16B16A16_UNORM,
    Format::R16G16B16A16_SFLOAT,
];

fn value_and_table() -> Vec<Case> {
    let float = Format::R32G32B32A32_SFLOAT;
    let tables = [
        ("linear RGBA8, 256 entries", 1, Format::R8G8B8A8_UNORM, 256),
        ("linear RGBA16F, 256 entries", 1, Format::R16G16B16A16_SFLOAT, 256),
        ("linear RGBA32F, 256 entries", 1, float, 256),
        ("linear RGBA32F, 1024 entries", 1, float, 1024),
        ("texelFetch, 1024 RGBA32F", 2, float, 1024),
        ("2 texelFetch + mix, 1024 RGBA32F", 3, float, 1024),
        ("uniform array, 1024 vec4", 4, float, 1024),
        ("storage array, 1024 vec4", 5, float, 1024),
        ("2 uniform reads + mix", 6, float, 1024),
        ("2 storage reads + mix", 7, float, 1024),
        ("arithmetic ramp, no table", 8, float, 1024),
    ];
    let with = |values: Format, short: &'static str| {
        tables.map(|(name, kind, table, width)| {
            case(&format!("b: {short} fetch + {name} + over"), |case| {
                (case.values, case.table, case.table_width) = (values, table, width);
                case.constants = vec![(TABLE, kind)];
            })
        })
    };
    let few = with(Format::R16_UNORM, "R16").into_iter().step_by(3);
    with(Format::R8_UNORM, "R8").into_iter().chain(few).collect()
}

fn targets() -> Vec<Case> {
    [
        Format::R8G8B8A8_UNORM,
        Format::R16G16B16A16_SFLOAT,
        Format::R32G32B32A32_SFLOAT,
    ]
    .map(|target| {
        case(&format!("c: R8 fetch + storage array + over into {target:?}"), |case| {
            (case.target, case.constants) = (target, vec![(TABLE, 5)]);
        })
    })
    .into()
}

fn skipping() -> Vec<Case> {
    [1.0, 0.3]
        .into_iter()
        .flat_map(|visible| {
            [
                ("blend all", 0),
                ("discard if alpha <= 0", 1),
                ("return if alpha <= 0", 2),
            ]
            .map(|(name, skip)| {
                case(
                    &format!("d: R8 + storage array, {:.0} % visible, {name}", visible * 100.0),
                    |case| {
                        (case.visible, case.constants) = (visible, vec![(TABLE, 5), (SKIP, skip)]);
                    },
                )
            })
        })
        .chain([1.0, 0.3].map(|visible| {
            case(
                &format!("d: R8 + storage array, {:.0} % visible, pow, return", visible * 100.0),
                |case| {
                    (case.visible, case.constants) = (visible, vec![(TABLE, 5), (SKIP, 2), (CORRECT, 1)]);
                },
            )
        }))
        .collect()
}

fn shading() -> Vec<Case> {
    let kinds = [
        ("RGBA8 normal fetch", 1, Format::R8_UNORM),
        ("6 taps", 2, Format::R8_UNORM),
        ("3 taps", 3, Format::R8_UNORM),
        ("normal and value in one RGBA8", 4, Format::R8G8B8A8_UNORM),
        ("normal and value in one RGBA16", 4, Format::R16G16B16A16_UNORM),
        ("normal and value in one RGBA16F", 4, Format::R16G16B16A16_SFLOAT),
        ("6 taps, R16", 2, Format::R16_UNORM),
        ("RGBA8 normal fetch, R16", 1, Format::R16_UNORM),
    ];
    let shaded = |name: &str, shade: u32, values: Format, visible: f32, skip: u32| {
        let branch = ["no branch", "discard", "return"][skip as usize];
        let percent = visible * 100.0;
        case(
            &format!("e: shaded, {name}, {percent:.0} % visible, {branch}"),
            |case| {
                (case.values, case.visible) = (values, visible);
                case.constants = vec![(TABLE, 5), (SKIP, skip), (SHADE, shade)];
            },
        )
    };
    let (name, shade, values) = kinds[0];
    let branches = [(1.0, 0), (1.0, 1), (0.3, 0), (0.3, 1)];
    let branches = branches.map(|(visible, skip)| shaded(name, shade, values, visible, skip));
    let kinds = kinds
        .into_iter()
        .flat_map(|(name, shade, values)| [1.0, 0.3].map(|visible| shaded(name, shade, values, visible, 2)));
    kinds.chain(branches).collect()
}
