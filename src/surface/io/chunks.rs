//! Little-endian numbers and records, in large pieces.

use std::io::{self, Write};
use std::ops::Range;

use bytemuck::Pod;
use rayon::prelude::*;

/// How many elements a thread turns into bytes at a time: some hundred kilobytes.
const CHUNK: usize = 1 << 14;

/// Writes what `append` makes of each of `elements`, in their order, the bytes made on all threads.
pub fn write_each<A>(out: &mut impl Write, elements: Range<usize>, append: A) -> io::Result<()>
where
    A: Fn(&mut Vec<u8>, usize) + Sync,
{
    let mut buffers = vec![Vec::new(); rayon::current_num_threads()];
    for first in elements.clone().step_by(CHUNK * buffers.len()) {
        buffers.par_iter_mut().enumerate().for_each(|(n, buffer)| {
            let start = first + n * CHUNK;
            buffer.clear();
            (start..elements.end.min(start + CHUNK)).for_each(|element| append(buffer, element));
        });
        buffers.iter().try_for_each(|buffer| out.write_all(buffer))?;
    }
    Ok(())
}

/// Writes numbers of four bytes each, which `values` consist of.
pub fn write_words<T: Pod>(out: &mut impl Write, values: &[T]) -> io::Result<()> {
    if cfg!(target_endian = "little") {
        return out.write_all(bytemuck::cast_slice(values));
    }
    let words: &[u32] = bytemuck::cast_slice(values);
    write_each(out, 0..words.len(), |bytes, n| bytes.extend(words[n].to_le_bytes()))
}

/// Appends three numbers.
pub fn append_vector(bytes: &mut Vec<u8>, vector: [f32; 3]) {
    bytes.extend_from_slice(vector.map(f32::to_le_bytes).as_flattened());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_keep_their_order() {
        let count = 5 * CHUNK + 3;
        let mut bytes = Vec::new();
        write_each(&mut bytes, 7..count, |b, n| b.extend((n as u32).to_le_bytes())).expect("written");
        let expected: Vec<u8> = (7..count as u32).flat_map(u32::to_le_bytes).collect();
        assert!(bytes == expected);
    }

    #[test]
    fn nothing_is_nothing() {
        let mut bytes = Vec::new();
        write_each(&mut bytes, 3..3, |b, _| b.push(1)).expect("written");
        assert!(bytes.is_empty());
    }
}
