//! Which chunks of an array are there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::array::Array;
use super::chunks::Selection;

/// Where the chunks that are there are in the `grid` of a volume's chunks, the last one first.
pub(super) fn present(array: &Array, selection: &Selection, grid: [usize; 3]) -> io::Result<Vec<usize>> {
    let axes = array.shape.len();
    let axis = |axis: usize| Axis::new(array, selection, grid, axis);
    let axes: Vec<Axis> = (0..axes).map(axis).collect();
    let mut there = match array.keys.are_folders {
        true => in_folders(&array.path.join(array.keys.prefix.unwrap_or_default()), &axes)?,
        false => in_names(&array.path, array.keys.prefix, &axes)?,
    };
    there.sort_unstable_by(|a, b| b.cmp(a));
    there.dedup();
    Ok(there)
}

/// An axis of the array, in units of chunks.
struct Axis {
    /// The first chunk that is wanted.
    first: usize,
    /// How many are.
    count: usize,
    /// How far neighbours are apart in the grid.
    stride: usize,
}

impl Axis {
    fn new(array: &Array, selection: &Selection, grid: [usize; 3], axis: usize) -> Self {
        match selection.spatial.iter().position(|a| *a == axis) {
            Some(at) => Self {
                first: 0,
                count: grid[at],
                stride: grid[..at].iter().product(),
            },
            None => Self {
                first: selection.index[axis] / array.chunk[axis],
                count: 1,
                stride: 0,
            },
        }
    }

    /// How much an index, as it is written in a file's name, adds to the place in the grid; `None` if it is not wanted.
    fn offset(&self, word: &str) -> Option<usize> {
        let index: usize = word.parse().ok()?;
        // Not what is written with zeros in front: it is another file.
        let is_wanted = index.to_string() == word && (self.first..self.first + self.count).contains(&index);
        is_wanted.then(|| (index - self.first) * self.stride)
    }
}

/// The names in a folder, which need not be there.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if [io::ErrorKind::NotFound, io::ErrorKind::NotADirectory].contains(&e.kind()) => return Ok(Vec::new()),
        Err(e) => return Err(e),
    };
    let names = entries.map(|entry| Ok(entry?.file_name().into_string().ok()));
    Ok(names.collect::<io::Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// The chunks whose files lie in a folder an index.
fn in_folders(root: &Path, axes: &[Axis]) -> io::Result<Vec<usize>> {
    let mut folders: Vec<(PathBuf, usize)> = vec![(root.to_owned(), 0)];
    for axis in axes {
        let mut inner = Vec::new();
        for (folder, place) in folders {
            for name in names(&folder)? {
                if let Some(offset) = axis.offset(&name) {
                    inner.push((folder.join(name), place + offset));
                }
            }
        }
        folders = inner;
    }
    Ok(folders.into_iter().map(|(_, place)| place).collect())
}

/// The chunks whose files have all indices in their names.
fn in_names(folder: &Path, prefix: Option<&str>, axes: &[Axis]) -> io::Result<Vec<usize>> {
    let place = |name: String| {
        let indices = match prefix {
            Some(prefix) => name.strip_prefix(prefix)?.strip_prefix('.')?,
            None => &name,
        };
        let words: Vec<&str> = indices.split('.').collect();
        let offsets = words.iter().zip(axes).map(|(word, axis)| axis.offset(word));
        (words.len() == axes.len()).then(|| offsets.sum::<Option<usize>>())?
    };
    Ok(names(folder)?.into_iter().filter_map(place).collect())
}
