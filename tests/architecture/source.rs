//! The files of the repository, and their text without comments and strings.

use std::fmt;
use std::fs;
use std::path::Path;

/// Folders that no rule looks into: what is built, and what git keeps.
const SKIPPED: [&str; 3] = ["target", ".git", "__pycache__"];

/// A text file, its path relative to the repository and with `/`.
pub struct SourceFile {
    pub path: String,
    pub text: String,
}

/// What a rule found, and where.
#[derive(Debug, PartialEq)]
pub struct Finding {
    pub path: String,
    /// From 1.
    pub line: usize,
    pub what: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path, self.line, self.what)
    }
}

impl SourceFile {
    pub fn new(path: &str, text: &str) -> Self {
        Self {
            path: path.to_owned(),
            text: text.to_owned(),
        }
    }

    pub fn finding(&self, line: usize, what: impl Into<String>) -> Finding {
        Finding {
            path: self.path.clone(),
            line,
            what: what.into(),
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The text of one file.
pub fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Every text file outside the skipped folders.
pub fn tracked_files() -> Vec<SourceFile> {
    let mut files = Vec::new();
    collect(root(), &mut files);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    files
}

fn collect(folder: &Path, files: &mut Vec<SourceFile>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if SKIPPED.contains(&name.as_ref()) {
            continue;
        }
        if path.is_dir() {
            collect(&path, files);
        } else if let Ok(text) = fs::read_to_string(&path) {
            let relative = path.strip_prefix(root()).expect("inside the repository");
            files.push(SourceFile::new(&relative.to_string_lossy(), &text));
        }
    }
}

/// Rust code with what is in comments, strings and characters replaced by spaces; every line stays where it is.
pub fn code_only(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = blank_length(rest, code.chars().next_back());
        let length = if skipped == 0 { first.len_utf8() } else { skipped };
        let (piece, tail) = rest.split_at(length);
        if skipped == 0 {
            code.push_str(piece);
        } else {
            code.extend(piece.chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        }
        rest = tail;
    }
    code
}

/// How many bytes of a comment, string or character begin here; 0 where code does.
fn blank_length(rest: &str, before: Option<char>) -> usize {
    if rest.starts_with("//") {
        return rest.find('\n').unwrap_or(rest.len());
    }
    if rest.starts_with("/*") {
        return block_comment_length(rest);
    }
    if rest.starts_with('"') {
        return quoted_length(rest, '"');
    }
    let in_word = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
    if !in_word && let Some(length) = raw_string_length(rest) {
        return length;
    }
    if rest.starts_with('\'') {
        return character_length(rest);
    }
    0
}

fn block_comment_length(rest: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        let here = &rest.as_bytes()[at..];
        match here {
            [b'/', b'*', ..] => depth += 1,
            [b'*', b'/', ..] => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    rest.len()
}

fn quoted_length(rest: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// `r"…"`, `r#"…"#`, `br"…"`.
fn raw_string_length(rest: &str) -> Option<usize> {
    let after = rest.strip_prefix('b').unwrap_or(rest).strip_prefix('r')?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    let body = after[hashes..].strip_prefix('"')?;
    let close = format!("\"{}", "#".repeat(hashes));
    let end = body.find(&close).map_or(body.len(), |at| at + close.len());
    Some(rest.len() - body.len() + end)
}

/// A character, not a lifetime: what is quoted is one character or an escape.
fn character_length(rest: &str) -> usize {
    let mut inner = rest.chars().skip(1);
    let (first, second) = (inner.next(), inner.next());
    if first == Some('\\') || second == Some('\'') {
        quoted_length(rest, '\'')
    } else {
        0
    }
}

/// The words of some code, each with its line from 1 and the byte that it starts at.
pub fn words(code: &str) -> impl Iterator<Item = (usize, usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.lines().enumerate().flat_map(move |(index, line)| {
        let start = line.as_ptr() as usize - code.as_ptr() as usize;
        line.split(move |c| !is_word(c))
            .filter(|word| !word.is_empty())
            .map(move |word| {
                let at = word.as_ptr() as usize - line.as_ptr() as usize;
                (index + 1, start + at, word)
            })
    })
}

#[test]
fn comments_strings_and_characters_are_blanked() {
    let text = "a // b\n/* c /* d */ e */ f \"g \\\" h\" 'i' '\\'' r#\"j \" k\"# l<'m>() b\"n\" br\"o\" bar\"p\"";
    let words: Vec<_> = code_only(text)
        .split(|c: char| !c.is_alphanumeric())
        .filter(|w| !w.is_empty())
        .map(str::to_owned)
        .collect();
    assert_eq!(words, ["a", "f", "l", "m", "b", "bar"]);
    assert_eq!(code_only(text).lines().count(), 2);
}

#[test]
fn words_know_their_lines() {
    let found: Vec<_> = words("fn a(\n  b_1: C)").collect();
    let expected = [(1, 0, "fn"), (1, 3, "a"), (2, 8, "b_1"), (2, 13, "C")];
    assert_eq!(found, expected);
}
