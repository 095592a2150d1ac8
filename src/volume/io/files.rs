//! A volume's voxels in several files: a list of names, or a pattern and the numbers that go into it.

/// The most files of a pattern.
const MAX_FILES: i64 = 1 << 20;

/// The names of `pattern`, a file name with a place for a number as C's `printf` has it, for the numbers from `first` to `last` in
/// steps. `None` if it is no such pattern, or they are none or too many.
pub(super) fn numbered(pattern: &str, first: i64, last: i64, step: i64) -> Option<Vec<String>> {
    let (before, after) = pattern.split_once('%')?;
    let end = after.find(['d', 'i', 'u'])?;
    let (width, after) = (&after[..end], &after[end + 1..]);
    let zeros = width.starts_with('0');
    let width: usize = if width.is_empty() { 0 } else { width.parse().ok()? };
    let count = last.checked_sub(first)?.checked_div(step)?.checked_add(1)?;
    if !(1..=MAX_FILES).contains(&count) || width > 64 || after.contains('%') {
        return None;
    }
    let number = |n: i64| match zeros {
        true => format!("{n:0width$}"),
        false => format!("{n:width$}"),
    };
    let numbers = (0..count).map(|n| first + n * step);
    Some(numbers.map(|n| format!("{before}{}{after}", number(n))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_where_the_pattern_says() {
        assert_eq!(
            numbered("a%03d.raw", 8, 12, 2).unwrap(),
            ["a008.raw", "a010.raw", "a012.raw"]
        );
        assert_eq!(numbered("%d", 2, 1, -1).unwrap(), ["2", "1"]);
        assert_eq!(numbered("a%2d.b", 1, 1, 1).unwrap(), ["a 1.b"]);
    }

    #[test]
    fn impossible_patterns_are_none() {
        let range = (1, 3, 1);
        for pattern in [
            "a.raw",
            "a%s",
            "a%",
            "a%d%d",
            "a%-3d",
            "%99999999d",
            "%999999999999999999999d",
        ] {
            assert_eq!(numbered(pattern, range.0, range.1, range.2), None, "{pattern}");
        }
        for (first, last, step) in [
            (3, 1, 1),
            (1, 3, 0),
            (i64::MIN, i64::MAX, 1),
            (0, i64::MAX, 1),
            (i64::MIN, 0, -1),
        ] {
            assert_eq!(numbered("%d", first, last, step), None);
        }
    }
}
