//! Files of nibabel's tests, the MNI152 head and Colin27 against SimpleITK; where it differs from nibabel's rules, nibabel's hold.

use std::path::{Path, PathBuf};

use vcsg::volume::io::{self, ReadOptions, VolumeInfo};

use crate::readers;

const DATA: &str = "target/deps/data";

/// Files that SimpleITK reads, and how many volumes in time each has.
const FILES: [(&str, usize); 8] = [
    ("ch2.nii.gz", 1),
    ("mni152.nii.gz", 1),
    ("nibabel/anatomical.nii", 1),
    ("nibabel/example4d.nii.gz", 2),
    ("nibabel/functional.nii", 20),
    ("nibabel/reoriented_anat_moved.nii", 1),
    ("nibabel/resampled_anat_moved.nii", 1),
    ("nibabel/standard.nii.gz", 1),
];

fn path(name: &str) -> PathBuf {
    let path = Path::new(DATA).join(name);
    assert!(path.exists(), "{} is missing: run make setup", path.display());
    path
}

fn info(path: &Path, frame: usize) -> VolumeInfo {
    let options = ReadOptions {
        frame: Some(frame),
        ..ReadOptions::default()
    };
    io::open(path, &options).unwrap().info().unwrap()
}

#[test]
fn simpleitk_reads_the_same() {
    let requests: Vec<_> = FILES.iter().map(|(name, _)| ("itk", path(name))).collect();
    for (read, (name, frames)) in readers::read(&requests).iter().zip(FILES) {
        let frame = |frame| info(&path(name), frame);
        let ours = frame(0);
        assert_eq!((&read.size[..3], ours.frames), (&ours.dims[..], frames), "{name}");
        assert_eq!(read.components, ours.components, "{name}");
        // SimpleITK has the place in `f32`, and orthogonal.
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * b.abs().max(1.0);
        let dimensions = read.size.len();
        for axis in 0..3 {
            assert!(
                near(read.spacing[axis], ours.spacing[axis]),
                "{name}: {read:?} {ours:?}"
            );
            assert!(near(read.origin[axis], ours.origin[axis]), "{name}: {read:?} {ours:?}");
            for row in 0..3 {
                let (theirs, ours) = (read.direction[dimensions * row + axis], ours.direction[3 * row + axis]);
                assert!((theirs - ours).abs() < 1e-5, "{name}: {read:?}");
            }
        }
        let all: Vec<_> = (0..frames).map(frame).collect();
        // What is not finite SimpleITK reads as 0.
        let zero = if all.iter().any(|info| info.non_finite > 0) {
            0.0
        } else {
            f64::NAN
        };
        let least = all.iter().map(|info| info.min).fold(zero, f64::min);
        let most = all.iter().map(|info| info.max).fold(zero, f64::max);
        let voxels = ours.dims.iter().product::<usize>();
        let sum = |info: &VolumeInfo| info.mean * (voxels - info.non_finite) as f64;
        let mean = all.iter().map(sum).sum::<f64>() / (voxels * frames) as f64;
        // Both have `f32` after slope and intercept, each by its own order of roundings.
        let same = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::from(f32::EPSILON) * b.abs().max(1.0);
        assert!(
            same(read.min, least) && same(read.max, most) && same(read.mean, mean),
            "{name}: {read:?}"
        );
    }
}

#[test]
fn nifti_2_that_simpleitk_does_not_read_is_read() {
    let info = info(&path("nibabel/example_nifti2.nii.gz"), 0);
    assert_eq!(info.format, "NIfTI-2");
    assert_eq!(info.dims, [32, 20, 12]);
    assert_eq!(info.frames, 2);
    assert!(info.non_finite == 0 && info.min < info.max);
}
