//! Reading volume files against SimpleITK, which is ITK's reader: the same files, which the system holds in memory. Of DICOM both decode
//! on all threads: ours slice by slice, theirs (OpenJPEG) blocks within a slice.

use std::path::Path;

use glam::DAffine3;
use serde::{Deserialize, Serialize};
use vcsg::volume::io::{self, Encoding, ReadOptions};
use vcsg::volume::{Grid, Voxels};

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::runs::{Ratios, Summary, timed};
use crate::vtk::{Peer, write_with};

/// How many times as fast as SimpleITK ours must be, into a grid.
const BAR: f64 = 1.0;

/// Where the files go.
const FOLDER: &str = "target/bench/reading";

/// An MR head of 8 bits at half a millimetre.
const HEAD: &str = "target/deps/data/ch2better.nii.gz";

/// Voxels along an edge of the other volume.
const SIDE: usize = 256;

/// What the script says of its file.
#[derive(Deserialize)]
struct PeerFile {
    voxels: usize,
}

/// One file, read.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    mebibytes: f64,
    into_grid: Summary,
    into_bricks: Summary,
    theirs: Summary,
    grid_faster: Ratios,
    bricks_faster: Ratios,
    /// The bar, of the grid.
    pub bar: Bar,
}

/// Reads each file in turns with SimpleITK; each comparison is printed when it is done.
pub fn compare(repetitions: usize) -> Outcome<Vec<Comparison>> {
    std::fs::create_dir_all(FOLDER)?;
    println!("\nReading a file, seconds, and how many times as fast as SimpleITK.ReadImage");
    println!(
        "{:<23} {:>6} | {:>8} {:>8} | {:>8} | grid: {:>6} {:>6} {:>6}  {:<14} | bricks: {:>6}",
        "", "MiB", "grid", "bricks", "ITK", "median", "min", "CPU", "bar", "median"
    );
    let head = io::read(Path::new(HEAD))?.grid;
    let noise = noise()?;
    let mut done = Vec::new();
    for (volume, grid) in [("head u8", &head), ("noise i16", &noise)] {
        for (format, name, encoding) in [
            ("NRRD gzip", "a.nrrd", Encoding::Gzip),
            ("NIfTI gzip", "b.nii.gz", Encoding::Gzip),
            ("NRRD raw", "c.nrrd", Encoding::Raw),
            ("NIfTI raw", "d.nii", Encoding::Raw),
        ] {
            let path = Path::new(FOLDER).join(name);
            io::write(&path, grid, encoding)?;
            let comparison = compare_one(format!("{volume}, {format}"), &path, repetitions)?;
            comparison.print();
            done.push(comparison);
        }
    }
    let series = Path::new(FOLDER).join("jpeg-2000");
    write_with("tools/peers/dicom_series.py", &series)?;
    let comparison = compare_one("CT i16, DICOM JPEG 2000".to_owned(), &series, repetitions)?;
    comparison.print();
    done.push(comparison);
    Ok(done)
}

/// Smooth hills under noise of six bits, as a scanner's: it does not compress well.
fn noise() -> Outcome<Grid> {
    let mut state = 1_u32;
    let voxels = (0..SIDE * SIDE * SIDE).map(|n| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let at = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)].map(|i| i as f32 / 20.0);
        (500.0 * at[0].sin() * at[1].cos() * at[2].sin()) as i16 + (state >> 26) as i16
    });
    Ok(Grid::new([SIDE; 3], DAffine3::IDENTITY, Voxels::I16(voxels.collect()))?)
}

fn compare_one(what: String, path: &Path, repetitions: usize) -> Outcome<Comparison> {
    let named = path.to_str().ok_or("a path of readable characters")?;
    let (mut peer, file): (Peer, PeerFile) = Peer::start("tools/peers/itk_read.py", &["--path", named])?;
    let open = || io::open(path, &ReadOptions::default());
    assert_eq!(open()?.grid()?.voxels().len(), file.voxels, "{what}");
    open()?.bricks()?;
    let (mut grids, mut bricks, mut theirs) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..repetitions {
        let (grid, run) = timed(|| open()?.grid());
        grid?;
        grids.push(run);
        theirs.push(peer.run()?);
        let (brick, run) = timed(|| open()?.bricks());
        brick?;
        bricks.push(run);
    }
    let (into_grid, into_bricks, theirs) = (Summary::of(grids), Summary::of(bricks), Summary::of(theirs));
    let grid_faster = Ratios::of(&into_grid, &theirs);
    Ok(Comparison {
        bar: Bar {
            what: format!("times as fast as SimpleITK: {what}"),
            value: grid_faster.median,
            limit: Limit::AtLeast(BAR),
        },
        bricks_faster: Ratios::of(&into_bricks, &theirs),
        mebibytes: bytes(path)? as f64 / f64::from(1 << 20),
        what,
        into_grid,
        into_bricks,
        theirs,
        grid_faster,
    })
}

/// Bytes of a file, or of the files in a folder.
fn bytes(path: &Path) -> Outcome<u64> {
    if !path.is_dir() {
        return Ok(path.metadata()?.len());
    }
    let files = std::fs::read_dir(path)?.map(|file| Ok(file?.metadata()?.len()));
    files.sum::<std::io::Result<u64>>().map_err(Into::into)
}

impl Comparison {
    fn print(&self) {
        let (grid, bricks) = (&self.grid_faster, &self.bricks_faster);
        println!(
            "{:<23} {:6.1} | {:8.4} {:8.4} | {:8.4} | grid: {:6.2} {:6.2} {:6.2}  {:<14} | bricks: {:6.2}",
            self.what,
            self.mebibytes,
            self.into_grid.median_s,
            self.into_bricks.median_s,
            self.theirs.median_s,
            grid.median,
            grid.min,
            grid.cpu,
            self.bar.to_string(),
            bricks.median,
        );
    }
}
