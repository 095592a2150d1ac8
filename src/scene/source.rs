//! A scene file's text, and where in it a byte lies.

use std::sync::Arc;

use miette::NamedSource;

/// The text of a scene file with its name; cheap to clone.
#[derive(Clone, Debug)]
pub struct Source {
    named: Arc<NamedSource<String>>,
}

impl Source {
    /// The text of the file called `name`.
    pub fn new(name: impl AsRef<str>, text: impl Into<String>) -> Self {
        Self {
            named: Arc::new(NamedSource::new(name, text.into())),
        }
    }

    /// The file's name as it was given.
    pub fn name(&self) -> &str {
        self.named.name()
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        self.named.inner()
    }

    /// Line and column of the byte at `offset`, both from 1; the column counts characters.
    pub fn place(&self, offset: usize) -> (usize, usize) {
        let before = self.text().get(..offset).unwrap_or(self.text());
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = 1 + before.bytes().filter(|&b| b == b'\n').count();
        let on_line = before[line_start..].trim_start_matches('\u{feff}');
        (line, 1 + on_line.chars().count())
    }

    /// Whether the line round byte `offset` is short enough to be shown: a machine-made file may have it all in one line.
    pub(super) fn is_quotable(&self, offset: usize) -> bool {
        const LONGEST: usize = 500;
        let text = self.named.inner().as_bytes();
        let (before, after) = text.split_at(offset.min(text.len()));
        let begin = before.iter().rev().position(|&b| b == b'\n').unwrap_or(before.len());
        let end = after.iter().position(|&b| b == b'\n').unwrap_or(after.len());
        begin + end <= LONGEST
    }

    /// What a diagnostic quotes from.
    pub(super) fn quoted(&self) -> &NamedSource<String> {
        &self.named
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_a_page_is_not_quoted() {
        let source = Source::new("a.kdl", format!("short\n{}\n", "x".repeat(501)));
        assert!(source.is_quotable(2) && source.is_quotable(5));
        assert!(!source.is_quotable(6) && !source.is_quotable(200));
    }

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let source = Source::new("a.kdl", "\u{feff}ab\nαβγ\n");
        assert_eq!(source.place(3), (1, 1));
        assert_eq!(source.place(6), (2, 1));
        assert_eq!(source.place(8), (2, 2));
        assert_eq!(source.place(999), (3, 1));
    }
}
