//! Which voxels are inside, and which the surface goes through, one bit each (LC87 §4, step 3).
//!
//! *Theory.* A voxel is inside where its value is not below the isovalue.
//! *Changes from the paper.* The bits of a whole row are found at once. All that follows works on words of 64 of them: where
//! an edge is crossed its two ends differ, so crossings are an exclusive or of rows, and counting set bits numbers them.
//! *Practice.* The isovalue is turned into the smallest value of the voxels' own type that is inside, so that voxels are
//! compared as they are.

use std::ops::Range;

use rayon::prelude::*;

use super::cells::SetBits;
use super::slices::Slices;
use crate::volume::Voxel;

/// The bits of a lattice of voxels: bit `i % 64` of word `i / 64` for voxel `i` of a row; bits beyond a row's end are 0.
pub(super) struct InsideRows {
    inside: Vec<u64>,
    /// Voxels of the isovalue itself with a neighbour outside: the vertices on all their crossed edges are one. Empty where
    /// no voxel can have it.
    on: Vec<u64>,
    /// The slices that are held.
    pub slices: Range<usize>,
    /// Voxels along each axis of the whole lattice.
    pub dims: [usize; 3],
}

/// What becomes of vertices that lie on one voxel because it has the isovalue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ties {
    /// They are one from the start, in slices whose neighbours are held.
    OneVertex,
    /// They are several.
    Apart,
}

impl InsideRows {
    /// The bits of `held` slices for the surface at `iso`; `None` where the voxels' type ends below it.
    pub fn of<T: Voxel>(slices: Slices<'_, T>, held: Range<usize>, iso: f64, ties: Ties) -> Option<Self> {
        let smallest_inside = T::not_below(iso)?;
        let mut rows = Self::outside(slices.dims, held);
        if ties == Ties::OneVertex && smallest_inside.to_f64() == iso {
            rows.classify_and_find(slices, smallest_inside);
        } else {
            rows.classify(slices, smallest_inside);
        }
        Some(rows)
    }

    /// The bits of `held` slices of a lattice no voxel of which is inside.
    pub fn outside(dims: [usize; 3], held: Range<usize>) -> Self {
        Self {
            inside: vec![0; dims[0].div_ceil(64) * dims[1] * held.len()],
            on: Vec::new(),
            slices: held,
            dims,
        }
    }

    fn words_a_row(&self) -> usize {
        self.dims[0].div_ceil(64)
    }

    fn classify<T: Voxel>(&mut self, slices: Slices<'_, T>, smallest_inside: T) {
        let words_a_slice = self.words_a_row() * self.dims[1];
        let tasks = self.inside.par_chunks_mut(words_a_slice).zip(self.slices.clone());
        tasks.for_each(|(inside, k)| classify(slices.slice(k), slices.dims[0], smallest_inside, inside));
    }

    /// Classifies, and finds the voxels of the isovalue in all slices whose neighbours are held.
    fn classify_and_find<T: Voxel>(&mut self, slices: Slices<'_, T>, iso: T) {
        let words_a_slice = self.words_a_row() * self.dims[1];
        let mut on = vec![0; self.inside.len()];
        self.inside
            .par_chunks_mut(words_a_slice)
            .zip(on.par_chunks_mut(words_a_slice))
            .zip(self.slices.clone())
            .for_each(|((inside, on), k)| classify_and_find(slices.slice(k), slices.dims[0], iso, inside, on));
        let tasks = on.par_chunks_mut(words_a_slice).zip(self.slices.clone());
        tasks.for_each(|(on, k)| self.keep_on_surface(slices, k, on));
        self.on = on;
    }

    /// Clears the voxels of slice `k` all of whose neighbours are inside, and those with a neighbour that is not finite: the
    /// vertex on an edge to it is elsewhere.
    fn keep_on_surface<T: Voxel>(&self, slices: Slices<'_, T>, k: usize, on: &mut [u64]) {
        let [_, ny, nz] = self.dims;
        let (below, above) = (k.saturating_sub(1), (k + 1).min(nz - 1));
        if !(self.slices.contains(&below) && self.slices.contains(&above)) {
            on.fill(0);
            return;
        }
        for (j, row) in on.chunks_exact_mut(self.words_a_row()).enumerate() {
            if row.iter().all(|word| *word == 0) {
                continue;
            }
            // Beyond the lattice the row's own voxels go on, which are inside.
            let here = self.row(j, k);
            let rows = [
                self.row(j.saturating_sub(1), k),
                self.row((j + 1).min(ny - 1), k),
                self.row(j, below),
                self.row(j, above),
            ];
            for (w, word) in row.iter_mut().enumerate() {
                let before = here[w] << 1 | if w > 0 { here[w - 1] >> 63 } else { 1 };
                let after = here[w] >> 1 | here.get(w + 1).map_or(1 << 63, |next| next << 63);
                let last = self.dims[0] - 1;
                let after = if last / 64 == w {
                    after | 1 << (last % 64)
                } else {
                    after
                };
                let inside = rows.iter().fold(before & after, |inside, row| inside & row[w]);
                *word &= !inside;
                for i in SetBits(*word) {
                    if !slices.has_finite_neighbours([w * 64 + i as usize, j, k]) {
                        *word &= !(1 << i);
                    }
                }
            }
        }
    }

    /// The inside bits of row `j` of slice `k`.
    #[inline(always)]
    pub fn row(&self, j: usize, k: usize) -> &[u64] {
        let words = self.words_a_row();
        &self.inside[words * (j + self.dims[1] * (k - self.slices.start))..][..words]
    }

    /// The bits of the voxels of row `j` of slice `k` that the surface goes through; none at all where there are none.
    #[inline(always)]
    pub fn on(&self, j: usize, k: usize) -> &[u64] {
        if self.on.is_empty() {
            return &[];
        }
        let words = self.words_a_row();
        &self.on[words * (j + self.dims[1] * (k - self.slices.start))..][..words]
    }
}

/// Fills `inside` with the bits of the rows of `width` voxels that `voxels` holds.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn classify<T: Voxel>(voxels: &[T], width: usize, smallest_inside: T, inside: &mut [u64]) {
    let rows = voxels
        .chunks_exact(width)
        .zip(inside.chunks_exact_mut(width.div_ceil(64)));
    for (row, inside) in rows {
        let (whole, rest) = row.as_chunks::<64>();
        for (chunk, word) in whole.iter().zip(inside.iter_mut()) {
            *word = not_below(chunk, smallest_inside);
        }
        if let Some(last) = inside.get_mut(whole.len()) {
            *last = not_below(rest, smallest_inside);
        }
    }
}

/// [`classify`], and the bits of the voxels that are `iso`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn classify_and_find<T: Voxel>(voxels: &[T], width: usize, iso: T, inside: &mut [u64], on: &mut [u64]) {
    let words = width.div_ceil(64);
    let words = inside.chunks_exact_mut(words).zip(on.chunks_exact_mut(words));
    for (row, (inside, on)) in voxels.chunks_exact(width).zip(words) {
        let (whole, rest) = row.as_chunks::<64>();
        for (n, chunk) in whole.iter().enumerate() {
            inside[n] = not_below(chunk, iso);
            on[n] = equal(chunk, iso);
        }
        if let Some(last) = inside.get_mut(whole.len()) {
            *last = not_below(rest, iso);
            on[whole.len()] = equal(rest, iso);
        }
    }
}

// Of at most 64 voxels each. For 64 of them compilers turn these into wide comparisons.

#[inline(always)]
fn not_below<T: Voxel>(voxels: &[T], smallest_inside: T) -> u64 {
    let mut word = 0;
    for (n, v) in voxels.iter().enumerate() {
        word |= u64::from(*v >= smallest_inside) << n;
    }
    word
}

#[inline(always)]
fn equal<T: Voxel>(voxels: &[T], iso: T) -> u64 {
    let mut word = 0;
    for (n, v) in voxels.iter().enumerate() {
        word |= u64::from(*v == iso) << n;
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_comparisons() {
        for width in [1, 7, 63, 64, 65, 130] {
            let voxels: Vec<f32> = (0..3 * width).map(|n| ((n * 37 + n * n) % 11) as f32).collect();
            let slices = Slices {
                voxels: &voxels,
                first_slice: 0,
                dims: [width, 3, 1],
            };
            let rows = InsideRows::of(slices, 0..1, 5.0, Ties::OneVertex).expect("bits");
            for (n, row) in voxels.chunks(width).enumerate() {
                let bit = |i: usize| rows.row(n, 0).get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1);
                for i in 0..width.div_ceil(64) * 64 {
                    assert_eq!(
                        bit(i),
                        row.get(i).is_some_and(|v| *v >= 5.0),
                        "width {width}, row {n}, voxel {i}"
                    );
                }
            }
        }
    }

    #[test]
    fn not_a_number_is_outside() {
        let mut words = [[0], [0]];
        let [inside, on] = &mut words;
        classify_and_find(&[f64::NAN, 1.0, f64::INFINITY], 3, 1.0, inside, on);
        assert_eq!(words, [[0b110], [0b010]]);
    }
}
