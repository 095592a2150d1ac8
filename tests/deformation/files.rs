//! Files of landmarks: what is written comes back, what Slicer's files mean, and what is refused where.

use std::path::PathBuf;

use glam::{DVec3, dvec3};
use proptest::prelude::*;
use tempfile::TempDir;
use vcsg::model::deform::files::{NamedPoint, paired, read_pairs, read_points, write_pairs, write_points};

use crate::random::landmarks;

fn point(name: &str, place: DVec3) -> NamedPoint {
    NamedPoint {
        name: name.into(),
        place,
    }
}

/// A file of `text` in a folder that goes away with what is returned.
fn file(name: &str, text: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a file");
    (folder, path)
}

fn points_of(name: &str, text: &str) -> Result<Vec<NamedPoint>, String> {
    let (_folder, path) = file(name, text);
    read_points(&path).map_err(|e| {
        e.to_string()
            .split_once(name)
            .map_or(String::new(), |(_, rest)| rest.to_owned())
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_comes_back(landmarks in landmarks(1..20, 1e3)) {
        let folder = tempfile::tempdir().expect("a folder");
        let table = folder.path().join("pairs.txt");
        write_pairs(&table, &landmarks).expect("a table");
        prop_assert_eq!(&read_pairs(&table).expect("the table"), &landmarks);
        let points: Vec<_> = landmarks.iter().map(|l| point(&format!("{}, \"so called\"", l.name), l.from)).collect();
        for name in ["points.fcsv", "points.mrk.json"] {
            let path = folder.path().join(name);
            write_points(&path, &points).expect("a list");
            prop_assert_eq!(&read_points(&path).expect("the list"), &points);
        }
    }
}

#[test]
fn axes_are_heeded() {
    let expected = vec![point("F-1", dvec3(-1.0, -2.0, 3.0))];
    let fcsv = |header: &str, x: f64, y: f64| {
        let columns = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";
        format!("# Markups fiducial file version = 4.10\n{header}{columns}node_1,{x},{y},3,0,0,0,1,1,1,0,F-1,,\n")
    };
    for (header, x, y) in [
        ("# CoordinateSystem = RAS\n", 1.0, 2.0),
        ("# CoordinateSystem = 0\n", 1.0, 2.0),
        ("", 1.0, 2.0),
        ("# CoordinateSystem = LPS\n", -1.0, -2.0),
        ("# CoordinateSystem = 1\n", -1.0, -2.0),
    ] {
        assert_eq!(
            points_of("a.fcsv", &fcsv(header, x, y)),
            Ok(expected.clone()),
            "{header}"
        );
    }
    let markups = |system: &str, x: f64, y: f64, z: f64| {
        format!(
            r#"{{"markups": [{{"type": "Fiducial", {system} "controlPoints": [
                {{"label": "F-1", "position": [{x}, {y}, {z}], "orientation": [-1, 0, 0, 0, -1, 0, 0, 0, 1]}},
                {{"label": "F-2", "position": [9, 9, 9], "positionStatus": "undefined"}}]}}]}}"#
        )
    };
    for (system, x, y, z) in [
        (r#""coordinateSystem": "LPS","#, -1.0, -2.0, 3.0),
        (r#""coordinateSystem": "RAS","#, 1.0, 2.0, 3.0),
        ("", -1.0, -2.0, 3.0),
        (r#""coordinateUnits": "cm","#, -0.1, -0.2, 0.3),
    ] {
        let found = points_of("a.mrk.json", &markups(system, x, y, z)).expect("a list");
        assert!(
            found.len() == 1 && found[0].place.distance(expected[0].place) < 1e-12,
            "{system}: {found:?}"
        );
    }
}

#[test]
fn what_means_nothing_is_named_with_its_line() {
    let told = |name: &str, text: &str, needle: &str| {
        let message = points_of(name, text).expect_err(needle);
        assert!(message.contains(needle), "{message:?} without {needle:?}");
    };
    told("a.fcsv", "# CoordinateSystem = IJK\n", ":1: coordinate system \"IJK\"");
    told("a.fcsv", "# columns = id,x,z\n", ":1: the columns lack");
    told("a.fcsv", "1,2,3,4\n1,2,wide,4\n", ":2: \"wide\" is not a coordinate");
    told("a.fcsv", "1,2\n", ":1: \"\" is not a coordinate");
    told("a.mrk.json", "{\n\"markups\": 3}", ":2: ");
    told("a.mrk.json", r#"{"markups": []}"#, "no markups");
    told(
        "a.mrk.json",
        r#"{"markups": [{"coordinateSystem": "SCS"}]}"#,
        "coordinate system \"SCS\"",
    );
    told(
        "a.mrk.json",
        r#"{"markups": [{"coordinateUnits": "mm2"}]}"#,
        "coordinate unit",
    );
    told(
        "a.mrk.json",
        r#"{"markups": [{"controlPoints": [{"label": "F"}]}]}"#,
        "F has no position",
    );
    told("a.csv", "", "a list of points is");
    let pairs = |text: &str| {
        let (_folder, path) = file("a.txt", text);
        read_pairs(&path).map_err(|e| e.to_string())
    };
    let message = pairs("# a comment\n1 2 3 4 5 6 # fine\nnose 1,2,3;4 5 six\n").expect_err("no number");
    assert!(message.contains("a.txt:3: \"six\" is not a number"), "{message}");
    assert!(
        pairs("1 2 3 4 5\n")
            .expect_err("too few")
            .contains("a.txt:1: a landmark is six numbers")
    );
    let named = pairs("1 2 3 4 5 6\n\nnose 1,2,3,4,5,6\n").expect("a table");
    assert_eq!(
        named.iter().map(|l| &*l.name).collect::<Vec<_>>(),
        ["of line 1", "nose"]
    );
}

#[test]
fn two_lists_are_paired_by_name_or_by_order() {
    let at = |x: f64| DVec3::X * x;
    let before = [point("a", at(1.0)), point("b", at(2.0))];
    let to =
        |after: &[NamedPoint]| -> Vec<f64> { paired(&before, after).expect("pairs").iter().map(|l| l.to.x).collect() };
    assert_eq!(to(&[point("b", at(20.0)), point("a", at(10.0))]), [10.0, 20.0]);
    assert_eq!(to(&[point("b", at(20.0)), point("c", at(10.0))]), [20.0, 10.0]);
    assert_eq!(to(&[point("a", at(20.0)), point("a", at(10.0))]), [20.0, 10.0]);
    let unpaired = paired(&before, &before[..1]).expect_err("no pairs").to_string();
    assert!(unpaired.starts_with("2 points before and 1 after"), "{unpaired}");
}
