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

    /// What a diagnostic quotes from.
    pub(super) fn quoted(&self) -> &NamedSource<String> {
        &self.named
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let source = Source::new("a.kdl", "\u{feff}ab\nαβγ\n");
        assert_eq!(source.place(3), (1, 1));
        assert_eq!(source.place(6), (2, 1));
        assert_eq!(source.place(8), (2, 2));
        assert_eq!(source.place(999), (3, 1));
    }
}
