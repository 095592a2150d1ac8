//! The known name nearest to a misspelt one.

/// The name in `known` that is nearest to `found` by edit distance, if it is near enough to be meant.
pub(super) fn nearest(found: &str, known: &[&'static str]) -> Option<&'static str> {
    let allowed = (found.chars().count() / 3).clamp(1, 4);
    known
        .iter()
        .map(|&name| (edit_distance(found, name), name))
        .filter(|&(distance, _)| distance <= allowed)
        .min()
        .map(|(_, name)| name)
}

/// How many characters must be inserted, removed, replaced or swapped with a neighbour to make `a` into `b`
/// (optimal string alignment). Long names are cut: beyond 64 characters nothing is near anything known.
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_find_their_name_and_strangers_find_none() {
        let known = ["sphere", "box", "half-space", "scale"];
        assert_eq!(nearest("shpere", &known), Some("sphere"));
        assert_eq!(nearest("halfspace", &known), Some("half-space"));
        assert_eq!(nearest("bx", &known), Some("box"));
        assert_eq!(nearest("teapot", &known), None);
        assert_eq!(nearest(&"s".repeat(100_000), &known), None);
    }
}
