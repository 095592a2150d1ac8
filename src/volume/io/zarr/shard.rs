//! The chunks in a shard: a file of several chunks, of which an index tells where they are.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::array::{Array, Coding};
use super::chunks::{Chunk, Selection, place, read};
use super::codec::{Chain, Codec, damaged};
use crate::volume::grid::Region;
use crate::volume::io::error::{Problem, ReadError};
use crate::volume::io::stored::ByteOrder;

/// Bytes of an index's entry: offset and length.
const ENTRY: usize = 16;

/// The chunks in the shard of `region`, which is in `file`.
pub(super) fn chunks(
    array: &Array,
    selection: &Selection,
    region: &Region,
    file: &Arc<PathBuf>,
) -> Result<Vec<Chunk>, ReadError> {
    let Coding::Sharded {
        chunk,
        index,
        index_is_first,
        ..
    } = &array.coding
    else {
        return Ok(Vec::new());
    };
    let counts: Vec<usize> = array.chunk.iter().zip(chunk).map(|(shard, n)| shard / n).collect();
    let entries = counts.iter().try_fold(ENTRY, |all, n| all.checked_mul(*n));
    let entries = entries.ok_or_else(|| damaged("its index is too long"));
    let entries = entries.and_then(|bytes| read_index(file, index, bytes, *index_is_first));
    let entries = entries.map_err(|e| ReadError::new(file, Problem::Compressed(e)))?;

    let along = |axis: usize| selection.index[axis] / chunk[axis] % counts[axis];
    let (grid, size) = (selection.of(&counts), selection.of(chunk));
    let mut found = Vec::new();
    for place in (0..grid.iter().product()).map(|n| place(n, grid)) {
        let first: [usize; 3] = std::array::from_fn(|a| place[a] * size[a]);
        if (0..3).any(|a| first[a] >= region.size[a]) {
            continue;
        }
        let indices = selection.indices(place, along);
        let entry = indices.iter().zip(&counts).fold(0, |entry, (i, n)| entry * n + i);
        let region = Region {
            first: std::array::from_fn(|a| region.first[a] + first[a]),
            size: std::array::from_fn(|a| size[a].min(region.size[a] - first[a])),
        };
        let [start, length] = entries[entry];
        found.push(match start == u64::MAX && length == u64::MAX {
            true => Chunk::Absent(region),
            false => Chunk::There {
                region,
                file: Arc::clone(file),
                bytes: Some(start..start.saturating_add(length)),
            },
        });
    }
    Ok(found)
}

/// The entries of an index of so many `bytes`.
fn read_index(file: &Path, chain: &Chain, bytes: usize, is_first: bool) -> io::Result<Vec<[u64; 2]>> {
    let sums = chain.codecs.iter().filter(|codec| **codec == Codec::Crc32c).count();
    let stored = (bytes + sums * size_of::<u32>()) as u64;
    let length = file.metadata()?.len();
    let start = match is_first {
        true => 0,
        false => length
            .checked_sub(stored)
            .ok_or_else(|| damaged("its index is missing"))?,
    };
    let index = chain.decode(read(file, Some(start..start + stored), usize::MAX)?, bytes)?;
    let number = |bytes: [u8; 8]| match chain.order {
        ByteOrder::Little => u64::from_le_bytes(bytes),
        ByteOrder::Big => u64::from_be_bytes(bytes),
    };
    let (entries, _) = index.as_chunks::<ENTRY>();
    let entry = |entry: &[u8; ENTRY]| {
        let (numbers, _) = entry.as_chunks::<8>();
        [number(numbers[0]), number(numbers[1])]
    };
    Ok(entries.iter().map(entry).collect())
}
