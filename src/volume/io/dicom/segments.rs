//! Tables of a palette's colours in segments (PS3.3, C.7.9.2).
//!
//! *Practice.* A segment has at least one entry, so that a table ends after as many segments as it has entries, whatever its words say.

/// What a segment is, by its first word.
const DISCRETE: u16 = 0;
const LINEAR: u16 = 1;
const INDIRECT: u16 = 2;

/// The `count` entries of the table that `words` are the segments of; `None` where they are no such table.
pub(super) fn expanded(words: &[u16], count: usize) -> Option<Vec<i64>> {
    let mut table = Table {
        entries: Vec::new(),
        count,
    };
    let mut rest = words;
    while table.entries.len() < count {
        rest = match *rest {
            [INDIRECT, segments, low, high, ref after @ ..] => {
                let bytes = usize::from(high) << 16 | usize::from(low);
                let mut copied = words.get(bytes / 2..)?;
                for _ in 0..segments.max(1) {
                    if table.entries.len() < count {
                        copied = table.add(copied)?;
                    }
                }
                after
            }
            _ => table.add(rest)?,
        };
    }
    Some(table.entries)
}

struct Table {
    entries: Vec<i64>,
    /// How many it takes.
    count: usize,
}

impl Table {
    /// Adds the segment at the start of `words`, which is not indirect; the words behind it.
    fn add<'a>(&mut self, words: &'a [u16]) -> Option<&'a [u16]> {
        let [kind, length, ref rest @ ..] = *words else {
            return None;
        };
        let length = usize::from(length);
        if length == 0 {
            return None;
        }
        let room = self.count - self.entries.len();
        match kind {
            DISCRETE => {
                let (values, rest) = rest.split_at_checked(length)?;
                self.entries.extend(values.iter().take(room).map(|v| i64::from(*v)));
                Some(rest)
            }
            LINEAR => {
                let (end, rest) = rest.split_first()?;
                let (start, end) = (*self.entries.last()? as f64, f64::from(*end));
                let step = (end - start) / length as f64;
                let entry = |i: usize| (start + step * i as f64).round_ties_even() as i64;
                self.entries.extend((1..=length.min(room)).map(entry));
                Some(rest)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_of_each_kind() {
        let words = [DISCRETE, 2, 5, 10, LINEAR, 5, 60, INDIRECT, 2, 0, 0, DISCRETE, 1, 7];
        let expected = [5, 10, 20, 30, 40, 50, 60, 5, 10, 20, 30, 40, 50, 60, 7];
        assert_eq!(expanded(&words, 15).unwrap(), expected);
        // A table takes no more than its entries.
        assert_eq!(expanded(&words, 4).unwrap(), expected[..4]);
        assert_eq!(expanded(&words, 9).unwrap(), expected[..9]);
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let none = [
            &[DISCRETE, 2, 5, 10][..],
            &[DISCRETE, 0],
            &[DISCRETE, 3, 1],
            &[LINEAR, 3, 1],
            &[DISCRETE, 1, 1, LINEAR],
            &[DISCRETE, 1, 1, INDIRECT, 1, 100, 0],
            &[DISCRETE, 1, 1, INDIRECT, 9, 6, 0],
            &[3, 1, 1],
        ];
        for words in none {
            assert_eq!(expanded(words, 8), None, "{words:?}");
        }
    }
}
