//! Bounds on a scene's text, held before the KDL parser sees it.
//!
//! *Practice.* The parser calls itself for each level of children and for each nested comment, and tries a commented-out
//! node in several ways, so depth costs stack and time. One pass over the bytes, which knows strings and comments, finds
//! depth and unbalanced braces with their exact place.

use super::error::Problem;

/// The deepest nesting of nodes, over all included files together.
pub const MAX_DEPTH: usize = 256;

/// The longest text, over all included files together, bytes.
pub const MAX_BYTES: usize = 64 << 20;

/// The deepest nesting of block comments.
const MAX_COMMENT_DEPTH: usize = 32;

/// A problem and the byte that has it.
pub(super) type Found = (usize, Problem);

/// Checks the length, the nesting and the balance of `text`.
pub(super) fn check(text: &str) -> Result<(), Found> {
    if text.len() > MAX_BYTES {
        return Err((0, Problem::TooLong { limit: MAX_BYTES }));
    }
    let mut scan = Scan {
        bytes: text.as_bytes(),
        at: 0,
        open: Vec::new(),
    };
    while scan.at < scan.bytes.len() {
        scan.token()?;
    }
    match scan.open.last() {
        Some(&at) => Err((at, syntax("this `{` is never closed", "add the missing `}`"))),
        None => Ok(()),
    }
}

/// Where the node ends whose last entry ends at `from`, its children included: before what terminates it, and before comments
/// there. The text is known to be KDL.
pub(super) fn end_of_node(text: &str, from: usize) -> usize {
    let mut scan = Scan {
        bytes: text.as_bytes(),
        at: from,
        open: Vec::new(),
    };
    let mut end = from;
    while scan.at < scan.bytes.len() && !(scan.open.is_empty() && terminates(&scan.bytes[scan.at..])) {
        let rest = &scan.bytes[scan.at..];
        let silent = rest.starts_with(b"/*") || rest[0].is_ascii_whitespace();
        let went_on = match rest[0] {
            b'\\' if scan.open.is_empty() => {
                scan.at += rest
                    .iter()
                    .position(|&b| b == b'\n')
                    .map_or(rest.len(), |newline| newline + 1);
                continue;
            }
            _ => scan.token(),
        };
        if went_on.is_err() {
            break;
        }
        if !silent {
            end = scan.at;
        }
    }
    end
}

/// Whether a node ends here: at a line's end, a semicolon, the end of its parent or a comment up to the line's end.
fn terminates(rest: &[u8]) -> bool {
    const ENDS: [&str; 10] = [
        "\n", "\r", ";", "}", "//", "\u{b}", "\u{c}", "\u{85}", "\u{2028}", "\u{2029}",
    ];
    ENDS.iter().any(|end| rest.starts_with(end.as_bytes()))
}

struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where each open brace is.
    open: Vec<usize>,
}

impl Scan<'_> {
    /// Goes past one token that matters, or one byte.
    fn token(&mut self) -> Result<(), Found> {
        let rest = &self.bytes[self.at..];
        match rest {
            [b'{', ..] => self.open_brace(),
            [b'}', ..] => self.close_brace(),
            [b'/', b'/', ..] => {
                self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                Ok(())
            }
            [b'/', b'*', ..] => self.block_comment(),
            [b'"', ..] => self.string(0),
            [b'#', ..] => {
                let hashes = rest.iter().take_while(|&&b| b == b'#').count();
                self.at += hashes;
                match self.bytes.get(self.at) {
                    Some(b'"') => self.string(hashes),
                    _ => Ok(()),
                }
            }
            _ => {
                self.at += 1;
                Ok(())
            }
        }
    }

    fn open_brace(&mut self) -> Result<(), Found> {
        if self.open.len() == MAX_DEPTH {
            return Err((self.at, Problem::TooDeep { limit: MAX_DEPTH }));
        }
        self.open.push(self.at);
        self.at += 1;
        Ok(())
    }

    fn close_brace(&mut self) -> Result<(), Found> {
        let problem = syntax("this `}` closes nothing", "remove it, or add the missing `{`");
        self.open.pop().ok_or((self.at, problem))?;
        self.at += 1;
        Ok(())
    }

    fn block_comment(&mut self) -> Result<(), Found> {
        let start = self.at;
        let mut depth = 0;
        loop {
            match &self.bytes[self.at..] {
                [] => {
                    return Err((start, syntax("this comment never ends", "add the missing `*/`")));
                }
                [b'/', b'*', ..] if depth == MAX_COMMENT_DEPTH => {
                    return Err((start, syntax("comments nest too deeply", "use `//` comments")));
                }
                [b'/', b'*', ..] => {
                    depth += 1;
                    self.at += 2;
                }
                [b'*', b'/', ..] => {
                    depth -= 1;
                    self.at += 2;
                    if depth == 0 {
                        return Ok(());
                    }
                }
                _ => self.at += 1,
            }
        }
    }

    /// Goes past a string whose opening quote is at `at`; a raw one has `hashes` above 0 and no escapes.
    fn string(&mut self, hashes: usize) -> Result<(), Found> {
        let start = self.at;
        let triple = self.bytes[start..].starts_with(b"\"\"\"");
        let quotes = if triple { 3 } else { 1 };
        let mut end = vec![b'"'; quotes];
        end.resize(quotes + hashes, b'#');
        self.at += quotes;
        while !self.bytes[self.at..].starts_with(&end) {
            let escaped = hashes == 0 && self.bytes.get(self.at) == Some(&b'\\');
            self.at += if escaped { 2 } else { 1 };
            let ends = self.at >= self.bytes.len();
            if ends || (!triple && self.bytes[self.at] == b'\n') {
                return Err((start, syntax("this string never ends", "add the missing `\"`")));
            }
        }
        self.at += end.len();
        Ok(())
    }
}

fn syntax(message: &str, help: &str) -> Problem {
    Problem::Syntax {
        message: message.into(),
        help: Some(help.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &str) -> usize {
        check(text).expect_err(text).0
    }

    #[test]
    fn depth_is_counted_outside_strings_and_comments_only() {
        let deep = "a {\n".repeat(MAX_DEPTH) + &"}\n".repeat(MAX_DEPTH);
        assert_eq!(check(&deep), Ok(()));
        let limit = Problem::TooDeep { limit: MAX_DEPTH };
        assert_eq!(check(&"a {\n".repeat(30_000)), Err((4 * MAX_DEPTH + 2, limit)));
        let braces = "{".repeat(1000);
        for quiet in [
            format!("// {braces}\na"),
            format!("/* /* {braces} */ }} */ a"),
            format!("a \"{braces} \\\" {braces}\""),
            format!("a #\"{braces} \" {braces}\"# #true"),
            format!("a \"\"\"\n{braces} \" \n\"\"\""),
        ] {
            assert_eq!(check(&quiet), Ok(()), "{quiet}");
        }
    }

    #[test]
    fn what_is_not_balanced_is_found_where_it_begins() {
        assert_eq!(place("a {\n b {\n }\n"), 2);
        assert_eq!(place("a {\n}\n}"), 6);
        assert_eq!(place("a /* /* */"), 2);
        assert_eq!(place("a \"b\nc\""), 2);
        assert_eq!(place("a \"b\\"), 2);
        assert_eq!(place("a ##\"b\"#"), 4);
        assert_eq!(place(&"/* ".repeat(1000)), 0);
    }
}
