//! What reading large volumes takes. One test, as the memory is the process's.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DAffine3;
use rayon::prelude::*;
use vcsg::volume::io::raw::RawLayout;
use vcsg::volume::io::{self, Budget, ByteOrder, Opened, ReadOptions};
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

fn open(path: &Path, dims: [usize; 3], voxel: VoxelType, budget: u64) -> Opened {
    let layout = RawLayout {
        dims,
        voxel,
        order: ByteOrder::NATIVE,
        offset: 0,
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
    let opened = open(path, dims, voxel, budget);
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

/// More than 4 GiB, and told how much of it has come.
fn beyond_four_gibibytes(path: &Path) {
    let dims = [2048, 1024, 2100];
    let length = dims.iter().product::<usize>() as u64;
    assert!(length > 4 << 30);
    sparse_file(path, length, &[(0, 1), (length - 1, 9), ((4 << 30) + 7, 3)]);
    let seen = Arc::new(AtomicU64::new(0));
    let counter = Arc::clone(&seen);
    let opened = open(path, dims, VoxelType::U8, 16 << 20);
    let opened = opened.watched(move |voxels| {
        counter.fetch_add(voxels, Ordering::Relaxed);
    });
    let (bricks, peak) = peak(|| opened.bricks().unwrap());
    eprintln!("beyond 4 GiB: kept {}, peak {peak}", bricks.bytes());
    assert_eq!(seen.load(Ordering::Relaxed), length);
    assert_eq!([bricks.voxel(0, 0, 0), bricks.voxel(2047, 1023, 2099)], [1.0, 9.0]);
    assert_eq!(bricks.voxel(7, 0, 2048), 3.0);
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
}
