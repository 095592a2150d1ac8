//! Volume properties: against VTK's functions of the same file, and written and read again.

#[path = "../oracle/process.rs"]
mod process;

use std::path::Path;

use process::Process;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde::Deserialize;
use serde_json::json;
use vcsg::projection::presets;
use vcsg::projection::volume_property::{self, BEND_ERROR, Reading, VolumeProperty};

const SCHEMA: &str = "https://example.org/volume-property-schema-v1.0.0.json#";

/// A node of N numbers: how far it is from the one before, its numbers, midpoint and sharpness.
type RandomNode<const N: usize> = (f64, [f64; N], f64, f64);

fn node<const N: usize>() -> impl Strategy<Value = RandomNode<N>> {
    let part = || prop_oneof![2 => 0.0..=1.0f64, 1 => Just(0.0), 1 => Just(1.0)];
    let midpoint = prop_oneof![2 => Just(0.5), 3 => 0.02..0.98f64, 1 => prop_oneof![Just(0.0), Just(1.0)]];
    let sharpness = prop_oneof![2 => Just(0.0), 4 => 0.01..0.99f64, 1 => 0.004..0.02f64, 2 => 0.991..=1.0f64];
    (60.0..800.0f64, prop::collection::vec(part(), N), midpoint, sharpness)
        .prop_map(|(step, y, midpoint, sharpness)| (step, std::array::from_fn(|i| y[i]), midpoint, sharpness))
}

fn nodes<const N: usize>() -> impl Strategy<Value = Vec<RandomNode<N>>> {
    prop::collection::vec(node(), 1..7)
}

/// The places of nodes, from −1000 on.
fn places<const N: usize>(nodes: &[RandomNode<N>]) -> Vec<f64> {
    let place = |x: &mut f64, node: &RandomNode<N>| {
        *x += node.0;
        Some(*x)
    };
    nodes.iter().scan(-1100.0, place).collect()
}

fn file_text(color: &[RandomNode<3>], opacity: &[RandomNode<1>]) -> String {
    let color_point = |(x, n): (f64, &RandomNode<3>)| json!({"x": x, "color": n.1, "midpoint": n.2, "sharpness": n.3});
    let point = |(x, n): (f64, &RandomNode<1>)| json!({"x": x, "y": n.1[0], "midpoint": n.2, "sharpness": n.3});
    let colors: Vec<_> = places(color).into_iter().zip(color).map(color_point).collect();
    let opacities: Vec<_> = places(opacity).into_iter().zip(opacity).map(point).collect();
    json!({"@schema": SCHEMA, "volumeProperties": [{"components": [{
        "shade": true,
        "scalarOpacityUnitDistance": 2.5,
        "rgbTransferFunction": {"type": "colorTransferFunction", "points": colors},
        "scalarOpacity": {"type": "piecewiseLinearFunction", "points": opacities},
    }]}]})
    .to_string()
}

/// What VTK's functions are.
#[derive(Deserialize)]
struct Truth {
    color: Vec<[f64; 3]>,
    opacity: Vec<f64>,
}

fn truth(oracle: &mut Process, file: &Path, at: &[f64]) -> Truth {
    oracle.send(&json!({"file": file, "at": at}), &[]);
    let mut answer = serde_json::Deserializer::from_reader(&mut oracle.answers);
    Truth::deserialize(&mut answer).expect("the oracle answers; see its message above")
}

/// Places are below 4096, where single precision moves a knot by at most half of this.
const PLACE: f64 = 1.0 / 4096.0;

/// Of mixing numbers up to 1 in single precision: a part of three roundings, and the mixture of three.
const ROUNDING: f64 = 8.0 * f32::EPSILON as f64;

/// Whether `ours` is as near as it should be to the values that VTK has about it.
fn near(ours: f32, theirs: [f64; 3]) -> bool {
    let (lo, hi) = (
        theirs.iter().copied().fold(f64::MAX, f64::min),
        theirs.iter().copied().fold(f64::MIN, f64::max),
    );
    let bound = BEND_ERROR + ROUNDING;
    (lo - bound..=hi + bound).contains(&f64::from(ours))
}

#[test]
fn our_points_are_vtks_functions() {
    let oracle = std::cell::RefCell::new(Process::start("tests/oracle/volume_property.py"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("random.vp.json");
    let config = Config {
        cases: 60,
        failure_persistence: None,
        ..Config::default()
    };
    let cases = (
        nodes::<3>(),
        nodes::<1>(),
        prop::collection::vec(-1200.0f32..4000.0, 120),
    );
    let check = |(color, opacity, values): (Vec<RandomNode<3>>, Vec<RandomNode<1>>, Vec<f32>)| {
        std::fs::write(&file, file_text(&color, &opacity)).unwrap();
        let function = volume_property::read(&file).expect("a property").property.function;
        let nodes = [places(&color), places(&opacity)].concat();
        // At a node the function turns, and what is about it says less.
        let away = |v: &f32| nodes.iter().all(|x| (x - f64::from(*v)).abs() > PLACE);
        let values: Vec<f32> = values.into_iter().filter(away).collect();
        let about = |v: &f32| [-PLACE, 0.0, PLACE].map(|by| f64::from(*v) + by);
        let at: Vec<f64> = values.iter().flat_map(about).collect();
        let truth = truth(&mut oracle.borrow_mut(), &file, &at);
        for (i, value) in values.iter().enumerate() {
            let (color, opacity) = function.evaluate(*value);
            let three = |of: &dyn Fn(usize) -> f64| [of(3 * i), of(3 * i + 1), of(3 * i + 2)];
            let theirs = three(&|n| truth.opacity[n]);
            prop_assert!(near(opacity, theirs), "opacity at {value}: {opacity}, not {theirs:?}");
            for (c, ours) in color.into_iter().enumerate() {
                let theirs = three(&|n| truth.color[n][c]);
                prop_assert!(near(ours, theirs), "colour {c} at {value}: {}, not {theirs:?}", ours);
            }
        }
        Ok(())
    };
    let result = TestRunner::new(config).run(&cases, check);
    assert!(result.is_ok(), "{result:?}");
}

fn written_and_read(folder: &Path, property: &VolumeProperty) -> Reading {
    let file = folder.join("again.vp.json");
    volume_property::write(&file, property).expect("written");
    volume_property::read(&file).expect("read")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_read_is_written_and_read_again(color in nodes::<3>(), opacity in nodes::<1>()) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("random.vp.json");
        std::fs::write(&file, file_text(&color, &opacity)).unwrap();
        let first = volume_property::read(&file).expect("a property");
        prop_assert_eq!(written_and_read(folder.path(), &first.property), first);
    }
}

#[test]
fn every_preset_is_written_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    for preset in presets::all() {
        let property = VolumeProperty {
            function: preset.own_function().clone(),
            material: preset.look().material,
        };
        let again = written_and_read(folder.path(), &property);
        assert_eq!(again.property, property, "{}", preset.name());
        assert_eq!(again.left_out, Vec::<&str>::new());
    }
}

#[test]
fn a_written_step_is_a_step_for_vtk() {
    let folder = tempfile::tempdir().unwrap();
    let text = "1\n0\n0.9\n0.1\n0.2\n10\n8 0 0 100 0 100 1 200 1\n4 0 1 255 1\n8 0 1 0 0 200 0 0 1\n";
    let older = folder.path().join("step.vp");
    std::fs::write(&older, text).unwrap();
    let property = volume_property::read(&older).expect("a property").property;
    assert_eq!(property.material, None);
    assert_eq!([99.9, 100.1].map(|v| property.function.evaluate(v).1), [0.0, 1.0]);
    let file = folder.path().join("step.vp.json");
    volume_property::write(&file, &property).expect("written");
    let mut oracle = Process::start("tests/oracle/volume_property.py");
    let truth = truth(&mut oracle, &file, &[99.9, 100.1, 100.0]);
    assert_eq!(truth.opacity[..2], [0.0, 1.0]);
    assert_eq!(truth.color[2], [0.5, 0.0, 0.5]);
}
