//! What reading large volumes takes. One test, as the memory is the process's.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DAffine3;
use rayon::prelude::*;
use vcsg::volume::io::raw::RawLayout;
use vcsg::volume::io::{self, Budget, ByteOrder, Opened, Problem, ReadOptions};
use vcsg::volume::{Bricks, VoxelType};

/// What reading may take beside the bricks: the chunk in hand and a file's buffer, and what the allocator keeps of former ones.
const WINDOW: u64 = 16 << 20;

/// A line of the process's status, in bytes.
fn status(name: &str) -> u64 {
    let text = fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    let kilobytes: u64 = line.trim_matches(|c: char| !c.is_ascii_digit()).parse().unwrap();
    kilobytes << 10
}

/// What `work` gives, and how much memory it takes at most.
fn peak<T>(work: impl FnOnce() -> T) -> (T, u64) {
    fs::write("/proc/self/clear_refs", "5").unwrap();
    let before = status("VmHWM:");
    let done = work();
    (done, status("VmHWM:") - before)
}

fn open(path: &Path, dims: [usize; 3], voxel: VoxelType, offset: u64, budget: u64) -> Opened {
    let layout = RawLayout {
        dims,
        voxel,
        order: ByteOrder::NATIVE,
        offset,
        world_from_index: DAffine3::IDENTITY,
    };
    let options = ReadOptions {
        raw: Some(layout),
        budget: Budget::of_bytes(budget),
        ..ReadOptions::default()
    };
    io::open(path, &options).unwrap()
}

fn read(path: &Path, dims: [usize; 3], voxel: VoxelType, budget: u64) -> (Bricks, u64) {
    let opened = open(path, dims, voxel, 0, budget);
    peak(|| opened.bricks().unwrap())
}

/// A file of `length` bytes that are zeros, but for some values at some places.
fn sparse_file(path: &Path, length: u64, values: &[(u64, u8)]) {
    let mut file = File::create(path).unwrap();
    file.set_len(length).unwrap();
    for (at, value) in values {
        file.seek(SeekFrom::Start(*at)).unwrap();
        file.write_all(&[*value]).unwrap();
    }
}

/// 256 MiB in which every brick differs: the peak is below 1.3 of what is kept.
fn dense(path: &Path) {
    let mut file = File::create(path).unwrap();
    for slice in 0..512_u32 {
        let noise = (0..512 * 512).map(|n: u32| ((n ^ slice << 18).wrapping_mul(2_654_435_761) >> 16) as u16);
        file.write_all(bytemuck::cast_slice(&noise.collect::<Vec<_>>()))
            .unwrap();
    }
    let (bricks, peak) = read(path, [512; 3], VoxelType::U16, 1 << 30);
    let kept = bricks.bytes() as u64;
    eprintln!("dense: kept {kept}, peak {peak}, {:.3}", peak as f64 / kept as f64);
    assert!(kept > 256 << 20);
    assert!(peak < kept * 13 / 10 + WINDOW, "{peak} for {kept}");
}

/// 256 MiB in which one voxel differs: next to nothing.
fn constant(path: &Path) {
    sparse_file(path, 2 << 27, &[(2 * ((300 * 512 + 200) * 512 + 100), 5)]);
    let (bricks, peak) = read(path, [512; 3], VoxelType::U16, 1 << 20);
    eprintln!("constant: kept {}, peak {peak}", bricks.bytes());
    assert_eq!((bricks.voxel(100, 200, 300), bricks.voxel(101, 200, 300)), (5.0, 0.0));
    assert!(bricks.bytes() < 1 << 19, "{}", bricks.bytes());
    assert!(peak < WINDOW, "{peak}");
}

/// 64 MiB of voxels behind 4 GiB, and told how much of it has come.
fn beyond_four_gibibytes(path: &Path) {
    let dims = [1024, 1024, 64];
    let (offset, length) = (4 << 30, dims.iter().product::<usize>() as u64);
    sparse_file(
        path,
        offset + length,
        &[(offset - 1, 7), (offset, 1), (offset + length - 1, 9)],
    );
    let seen = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&seen);
    let opened = open(path, dims, VoxelType::U8, offset, 1 << 20);
    let opened = opened.watched(move |voxels| {
        counter.fetch_add(voxels, Ordering::Relaxed);
    });
    let (bricks, peak) = peak(|| opened.bricks().unwrap());
    eprintln!("beyond 4 GiB: kept {}, peak {peak}", bricks.bytes());
    assert_eq!(seen.load(Ordering::Relaxed), length);
    assert_eq!([bricks.voxel(0, 0, 0), bricks.voxel(1023, 1023, 63)], [1.0, 9.0]);
    assert_eq!(bricks.voxel(1, 0, 0), 0.0);
    assert!(peak < WINDOW, "{peak}");
}

/// A small file that declares and holds more than reading may take: refused before that is there.
fn compressed(path: &Path) {
    let header = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 512 512 512\nencoding: gzip\n\n";
    let mut file = File::create(path).unwrap();
    file.write_all(header.as_bytes()).unwrap();
    let mut stream = GzEncoder::new(file, Compression::best());
    let slice = vec![0; 512 * 512];
    (0..512).for_each(|_| stream.write_all(&slice).unwrap());
    assert!(stream.finish().unwrap().metadata().unwrap().len() < 1 << 18);
    let options = ReadOptions {
        budget: Budget::of_bytes(64 << 20),
        ..ReadOptions::default()
    };
    let (read, peak) = peak(|| io::read_with(path, &options));
    let error = read.unwrap_err();
    assert!(matches!(error.problem, Problem::Budget { .. }), "{error}");
    assert!(peak < WINDOW, "{peak}");
}

#[test]
fn reading_takes_little_more_than_what_is_kept() {
    // Threads have stacks of their own.
    (0..1000).into_par_iter().for_each(|_| {});
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.raw");
    constant(&path);
    dense(&path);
    beyond_four_gibibytes(&path);
    compressed(&folder.path().join("a.nrrd"));
}
