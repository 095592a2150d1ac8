//! Where the frames of compressed pixels are: which items of an encapsulated element belong together.
//!
//! *Practice.* The items' headers are walked and their bytes skipped. A frame is one item in most files; where it is several,
//! the extended or the basic offset table tells which, and without a table an item that starts with a codec's first marker.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use super::source::Bytes;
use crate::volume::io::error::ReadError;

const ITEM: [u8; 4] = [0xfe, 0xff, 0x00, 0xe0];

/// The first two bytes of a JPEG or JPEG-LS stream, and of a JPEG 2000 one.
const STARTS: [[u8; 2]; 2] = [[0xff, 0xd8], [0xff, 0x4f]];

/// An item.
struct Fragment {
    /// The bytes of its value.
    bytes: Range<u64>,
    /// Whether it starts a stream.
    starts: bool,
}

/// The byte ranges of each of `frames` frames whose items start at `offset`. The first item is the basic offset table; `table`
/// are the extended one's offsets.
pub(super) fn frames(
    path: &Path,
    bytes: &Bytes,
    offset: u64,
    frames: usize,
    table: &[u64],
) -> Result<Vec<Vec<Range<u64>>>, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let walked = match bytes {
        Bytes::Inflated(all) => walk(&mut Cursor::new(all.as_slice()), offset, bytes.len()),
        Bytes::File(_) => {
            let file = File::open(path).map_err(io_error)?;
            walk(&mut BufReader::new(file), offset, bytes.len())
        }
    };
    let (basic, fragments) = walked.map_err(io_error)?;
    let table = if table.is_empty() { &basic[..] } else { table };
    grouped(&fragments, frames, table).ok_or_else(|| {
        let what = format!(
            "it declares {frames} frames, its compressed pixels are {} items",
            fragments.len()
        );
        ReadError::header(path, what)
            .byte(offset)
            .hint("the file is incomplete or its header is wrong: copy or export it again")
    })
}

/// The basic offset table and the items behind it. An item that the file cuts short is none.
fn walk(file: &mut (impl Read + Seek), start: u64, end: u64) -> io::Result<(Vec<u64>, Vec<Fragment>)> {
    let mut table = Vec::new();
    let mut fragments = Vec::new();
    let mut at = start;
    loop {
        file.seek(SeekFrom::Start(at))?;
        let mut header = [0; 10];
        let there = file.take(10).read(&mut header)?;
        let bytes = u64::from(u32::from_le_bytes([header[4], header[5], header[6], header[7]]));
        if there < 8 || header[..4] != ITEM || at + 8 + bytes > end {
            return Ok((table, fragments));
        }
        let value = at + 8..at + 8 + bytes;
        if at == start {
            file.seek(SeekFrom::Start(value.start))?;
            let mut offsets = Vec::new();
            file.take(bytes).read_to_end(&mut offsets)?;
            let offset = |b: &[u8]| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            table = offsets.chunks_exact(4).map(offset).collect();
        } else {
            let starts = bytes >= 2 && STARTS.contains(&[header[8], header[9]]);
            fragments.push(Fragment {
                bytes: value.clone(),
                starts,
            });
        }
        at = value.end;
    }
}

/// The items of each frame; `None` where nothing tells.
fn grouped(fragments: &[Fragment], frames: usize, table: &[u64]) -> Option<Vec<Vec<Range<u64>>>> {
    let first = fragments.first()?.bytes.start;
    let ranges = |run: &[Fragment]| run.iter().map(|f| f.bytes.clone()).collect::<Vec<_>>();
    if frames == 1 {
        return Some(vec![ranges(fragments)]);
    }
    if fragments.len() == frames {
        return Some(fragments.iter().map(|f| vec![f.bytes.clone()]).collect());
    }
    let by_table = table.len() == frames;
    let begins = |f: &&Fragment| match by_table {
        // Offsets count from the first item's header.
        true => table.binary_search(&(f.bytes.start - first)).is_ok(),
        false => f.starts,
    };
    let mut grouped: Vec<Vec<Range<u64>>> = Vec::new();
    for fragment in fragments {
        match begins(&fragment) {
            true => grouped.push(vec![fragment.bytes.clone()]),
            false => grouped.last_mut()?.push(fragment.bytes.clone()),
        }
    }
    (grouped.len() == frames).then_some(grouped)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Items of ten bytes one after another; of which some start a stream.
    fn items(starts: &[bool]) -> Vec<Fragment> {
        let item = |(i, &starts): (usize, &bool)| {
            let start = 100 + 18 * i as u64;
            Fragment {
                bytes: start..start + 10,
                starts,
            }
        };
        starts.iter().enumerate().map(item).collect()
    }

    /// How many items each frame has.
    fn sizes(starts: &[bool], frames: usize, table: &[u64]) -> Option<Vec<usize>> {
        let grouped = grouped(&items(starts), frames, table)?;
        Some(grouped.iter().map(Vec::len).collect())
    }

    #[test]
    fn items_belong_to_frames_by_number_table_or_marker() {
        assert_eq!(sizes(&[false; 3], 1, &[]), Some(vec![3]));
        assert_eq!(sizes(&[false; 3], 3, &[]), Some(vec![1; 3]));
        assert_eq!(sizes(&[false; 3], 2, &[0, 36]), Some(vec![2, 1]));
        assert_eq!(sizes(&[true, false, true], 2, &[]), Some(vec![2, 1]));
        // Without either nothing tells.
        assert_eq!(sizes(&[false; 3], 2, &[]), None);
        assert_eq!(sizes(&[true; 3], 2, &[]), None);
        assert_eq!(sizes(&[], 1, &[]), None);
    }
}
