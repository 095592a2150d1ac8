//! Files of others, as VTK reads them.

use std::path::Path;

use vcsg::volume::io::{self, ReadOptions};

use crate::f64s;
use crate::oracle::Oracle;

#[test]
fn files_of_others_are_read_as_vtk_reads_them() {
    let mut oracle = Oracle::start();
    for (name, of) in [
        ("channels.vti", "cells"),
        ("frog_tissues.vti", "points"),
        ("uniform.vtk", "points"),
    ] {
        let path = Path::new("target/deps/data").join(name);
        assert!(path.exists(), "{} is missing: run make setup", path.display());
        let (seen, values) = oracle.read(&path, of);
        let array = seen.answer["array"].as_str().map(str::to_owned);
        let options = ReadOptions {
            array,
            ..ReadOptions::default()
        };
        let grid = io::read_with(&path, &options).unwrap().grid;
        assert_eq!(f64s(grid.voxels()), values, "{name}");
        let place = grid.world_from_index();
        assert_eq!(place.translation.to_array(), seen.first, "{name}");
        let spacing: [f64; 3] = serde_json::from_value(seen.answer["spacing"].clone()).unwrap();
        assert_eq!([place.x_axis.x, place.y_axis.y, place.z_axis.z], spacing, "{name}");
    }
}
