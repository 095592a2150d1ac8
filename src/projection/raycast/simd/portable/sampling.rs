//! Sampling in arrays.

use super::super::{Apart, EDGE, FEW, PAIRS, PART_BITS, Places, RAYS, Sampling, Simd, normal};
use super::{Mask, Portable, Sixteen};

/// Those of two vectors. What is done with them is in functions of their own, over arrays: in place it would be more code than compilers
/// make good use of.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Short([i16; 2 * RAYS]);

impl Short {
    const ZERO: Self = Self([0; 2 * RAYS]);
}

/// From a cell's low corner to its edges along x, among few voxels.
const EDGES: [usize; 4] = [0, EDGE, EDGE * EDGE, EDGE * EDGE + EDGE];

impl Sampling for Portable {
    type Short = Short;
    type Few = [i16; FEW];

    #[inline(always)]
    fn shorts(first: Self::Int, second: Self::Int) -> Short {
        let mut all = Short::ZERO;
        for n in 0..RAYS {
            (all.0[n], all.0[RAYS + n]) = (first.0[n] as i16, second.0[n] as i16);
        }
        all
    }

    #[inline(always)]
    fn wide<const N: usize>(all: &[Short; PAIRS], n: usize) -> Self::Int {
        let of = &all[n / 2].0[n % 2 * RAYS..][..RAYS];
        let mut wide = [0; RAYS];
        for (wide, x) in wide.iter_mut().zip(of) {
            *wide = i32::from(*x as u16);
        }
        Sixteen(wide)
    }

    #[inline(always)]
    fn in_range(x: Short, [first, last]: [i16; 2]) -> [Mask; 2] {
        let mut masks = [[0; RAYS]; 2];
        for (mask, x) in masks.iter_mut().zip(x.0.as_chunks::<RAYS>().0) {
            for (mask, x) in mask.iter_mut().zip(x) {
                *mask = if first <= *x && *x <= last { -1 } else { 0 };
            }
        }
        let [first, second] = masks;
        [Sixteen(first), Sixteen(second)]
    }

    #[inline(always)]
    fn places(low: &[Short; 3], parts: [i16; 3], vectors: usize) -> Places<Self> {
        places(low, parts, vectors)
    }

    #[inline(always)]
    fn sampled(few: &Self::Few, places: &Places<Self>, vectors: usize) -> Short {
        between(&corners(few, &places.cell, vectors), &places.within, vectors)
    }

    #[inline(always)]
    fn sampled_apart(pairs: [&[Self::Int; 4]; 2], within: &[Short; 3], vectors: usize) -> Short {
        between(&ends(pairs, vectors), within, vectors)
    }

    #[inline(always)]
    fn weights<const N: usize>(within: &[[Short; PAIRS]; 3], n: usize) -> [Short; 4] {
        weights(within, n)
    }

    #[inline(always)]
    fn weighed<const N: usize>(
        few: &[Self::Few; 3],
        cells: &[Short; PAIRS],
        n: usize,
        weights: &[Short; 4],
    ) -> [Self::Float; 3] {
        weighed(few, cells, n, weights)
    }

    #[inline(always)]
    fn ask_for_all<T>(_: usize, _: [usize; 2], _: &[T]) {}

    #[inline(always)]
    fn ask_for<T>(_: usize, _: [usize; 2], _: [usize; 2], _: &[T]) {}

    #[inline(always)]
    fn any_at_least(few: &Self::Few, least: i16) -> bool {
        few.iter().fold(false, |any, number| any | (*number >= least))
    }

    #[inline(always)]
    fn few(corner: usize, strides: [usize; 2], numbers: &[i16]) -> Self::Few {
        let mut few = [0; FEW];
        for (few, row) in few.chunks_exact_mut(EDGE).zip(rows(corner, strides, numbers)) {
            few.copy_from_slice(row);
        }
        few
    }

    #[inline(always)]
    fn few_normals(corner: usize, strides: [usize; 2], normals: &[u32]) -> [Self::Few; 3] {
        let mut few = [[0; FEW]; 3];
        for (n, row) in rows(corner, strides, normals).enumerate() {
            for (x, normal) in row.iter().enumerate() {
                let parts = normal::parts(*normal);
                for (few, part) in few.iter_mut().zip(parts) {
                    few[EDGE * n + x] = part;
                }
            }
        }
        few
    }

    #[inline(always)]
    fn apart_pairs(apart: &Apart<Self>, numbers: &[i16]) -> [Self::Int; 4] {
        let mut pairs = [[0i32; RAYS]; 4];
        let edges = edges(apart.strides, numbers);
        let cells = edges[0].len();
        for n in 0..RAYS {
            let at = apart.voxels.0[n] as usize;
            // Every place is in the block. But for this way out of the loop compilers may fetch by vectors, which is slower.
            if at + 1 >= cells {
                break;
            }
            for (pair, edge) in pairs.iter_mut().zip(edges) {
                pair[n] = i32::from(edge[..cells][at] as u16) | i32::from(edge[..cells][at + 1]) << 16;
            }
        }
        pairs.map(Sixteen)
    }

    /// One after another.
    #[inline(always)]
    fn apart_normals(apart: &Apart<Self>, weights: &[Short; 4], normals: &[u32], shown: Mask) -> [Self::Float; 3] {
        let edges = edges(apart.strides, normals);
        let mut all = [[0.0; 3]; RAYS];
        let mut left = Self::bits(shown);
        while left != 0 {
            let n = left.trailing_zeros() as usize % RAYS;
            let weights = [0, 1, 2, 3].map(|edge| pair(&weights[edge], n));
            all[n] = normal(&edges, apart.voxels.0[n] as usize, &weights);
            left &= left - 1;
        }
        [0, 1, 2].map(|part| Sixteen(all.map(|normal| normal[part])))
    }
}

/// See [`Simd::places`].
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn places(low: &[Short; 3], parts: [i16; 3], vectors: usize) -> Places<Portable> {
    let mut places = Places::<Portable> {
        cell: Short::ZERO,
        within: [Short::ZERO; 3],
    };
    for n in 0..RAYS * vectors.min(2) {
        let mut cell = 0;
        for axis in 0..3 {
            let at = low[axis].0[n].wrapping_add(parts[axis]) as u16;
            cell |= at >> PART_BITS << (2 * axis);
            places.within[axis].0[n] = (at << (16 - PART_BITS) >> 1) as i16;
        }
        places.cell.0[n] = cell as i16;
    }
    places
}

/// What is at both ends of each cell's edges along x, of few numbers.
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn corners(few: &[i16; FEW], cells: &Short, vectors: usize) -> [[Short; 2]; 4] {
    let mut ends = [[Short::ZERO; 2]; 4];
    for n in 0..RAYS * vectors.min(2) {
        let cell = cells.0[n] as usize;
        for (ends, by) in ends.iter_mut().zip(EDGES) {
            ends[0].0[n] = few[(cell + by) % FEW];
            ends[1].0[n] = few[(cell + by + 1) % FEW];
        }
    }
    ends
}

/// Likewise, of pairs.
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn ends(pairs: [&[Sixteen<i32>; 4]; 2], vectors: usize) -> [[Short; 2]; 4] {
    let mut ends = [[Short::ZERO; 2]; 4];
    for (first, pairs) in (0..).step_by(RAYS).zip(pairs).take(vectors) {
        for (ends, pairs) in ends.iter_mut().zip(pairs) {
            for n in 0..RAYS {
                ends[0].0[first + n] = pairs.0[n] as i16;
                ends[1].0[first + n] = (pairs.0[n] >> 16) as i16;
            }
        }
    }
    ends
}

/// What is interpolated between them: see [`Simd::sampled`].
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn between(edges: &[[Short; 2]; 4], within: &[Short; 3], vectors: usize) -> Short {
    let mut all = Short::ZERO;
    for n in 0..RAYS * vectors.min(2) {
        let [x, y, z] = [within[0].0[n], within[1].0[n], within[2].0[n]];
        let between = |a: i16, b: i16, t: i16| a.wrapping_add(product(b.wrapping_sub(a), t));
        let edge = |edge: usize| between(edges[edge][0].0[n], edges[edge][1].0[n], x);
        let (near, far) = (between(edge(0), edge(1), y), between(edge(2), edge(3), y));
        all.0[n] = between(near, far, z);
    }
    all
}

/// The nearest whole number to `a·b/2¹⁵`, the higher of two.
#[inline(always)]
fn product(a: i16, b: i16) -> i16 {
    ((i32::from(a) * i32::from(b) + (1 << 14)) >> 15) as i16
}

/// See [`Simd::weights`].
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn weights(within: &[[Short; PAIRS]; 3], n: usize) -> [Short; 4] {
    let mut weights = [Short::ZERO; 4];
    for ray in 0..RAYS {
        let of = |axis: usize| within[axis][n / 2].0[n % 2 * RAYS + ray];
        let [x, y, z] = [of(0), of(1), of(2)];
        let yz = product(y, z);
        let none = i16::MAX - y - (z - yz);
        for (weights, of) in weights.iter_mut().zip([none, y - yz, z - yz, yz]) {
            weights.0[2 * ray] = product(x ^ i16::MIN, of);
            weights.0[2 * ray + 1] = product(-x, of);
        }
    }
    weights
}

/// See [`Simd::weighed`].
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn weighed(few: &[[i16; FEW]; 3], cells: &[Short; PAIRS], n: usize, weights: &[Short; 4]) -> [Sixteen<f32>; 3] {
    let mut sums = [Sixteen([0.0; RAYS]); 3];
    for ray in 0..RAYS {
        let cell = cells[n / 2].0[n % 2 * RAYS + ray] as usize;
        for (sums, few) in sums.iter_mut().zip(few) {
            let mut sum = 0;
            for (weights, by) in weights.iter().zip(EDGES) {
                let [first, second] = pair(weights, ray);
                sum += i32::from(few[(cell + by) % FEW]) * i32::from(first)
                    + i32::from(few[(cell + by + 1) % FEW]) * i32::from(second);
            }
            sums.0[ray] = sum as f32;
        }
    }
    sums
}

/// The nth two numbers side by side.
#[inline(always)]
fn pair(of: &Short, n: usize) -> [i16; 2] {
    [of.0[2 * n], of.0[2 * n + 1]]
}

/// The trilinear sample of normals on the [`edges`] of cells, in that whose low corner is voxel `at`, as [`Simd::weighed`] does it.
#[inline(always)]
fn normal(edges: &[&[u32]; 4], at: usize, weights: &[[i16; 2]; 4]) -> [f32; 3] {
    let mut sums = [0i32; 3];
    for (edge, weights) in edges.iter().zip(weights) {
        // Two voxels side by side.
        let pair: Option<&[u32; 2]> = edge.get(at..).and_then(|rest| rest.first_chunk());
        for (normal, weight) in pair.copied().unwrap_or_default().into_iter().zip(weights) {
            for (sum, part) in sums.iter_mut().zip(normal::parts(normal)) {
                *sum += i32::from(part) * i32::from(*weight);
            }
        }
    }
    sums.map(|sum| sum as f32)
}

/// What is stored, from the first voxel on each of the four edges of a cell along x: an index in one is in all of them.
#[inline(always)]
fn edges<T>([row, plane]: [usize; 2], stored: &[T]) -> [&[T]; 4] {
    let cells = stored.len().saturating_sub(row + plane);
    [0, row, plane, row + plane].map(|by| stored.get(by..by + cells).unwrap_or_default())
}

/// The rows that few voxels are in, from the one at `corner` on.
#[inline(always)]
fn rows<T>(corner: usize, [y, z]: [usize; 2], stored: &[T]) -> impl Iterator<Item = &[T]> {
    let all = &stored[corner..][..(EDGE - 1) * (y + z) + EDGE];
    (0..EDGE * EDGE).map(move |n| &all[n % EDGE * y + n / EDGE * z..][..EDGE])
}
