//! How long a file and a function may be.

use crate::source::{Finding, SourceFile, code_only, words};

const FILE_LINES: usize = 500;
const FUNCTION_LINES: usize = 60;

/// A file that a reader must search through.
pub fn long_file(file: &SourceFile) -> Vec<Finding> {
    let lines = file.text.lines().count();
    let finding = || file.finding(lines, format!("more than {FILE_LINES} lines"));
    (lines > FILE_LINES).then(finding).into_iter().collect()
}

/// Functions of more lines than fit on a screen, from `fn` to the closing brace.
pub fn long_functions(file: &SourceFile) -> Vec<Finding> {
    let code = code_only(&file.text);
    let too_long = |(line, at, _): (usize, usize, &str)| {
        let (name, lines) = function(&code[at..])?;
        (lines > FUNCTION_LINES).then(|| file.finding(line, format!("fn {name} has {lines} lines")))
    };
    words(&code)
        .filter(|(_, _, word)| *word == "fn")
        .filter_map(too_long)
        .collect()
}

/// The name and the number of lines of the function that `code` starts with; `None` without a name or a body.
fn function(code: &str) -> Option<(&str, usize)> {
    let after = code.strip_prefix("fn")?.trim_start();
    let name = &after[..after.find(|c: char| !c.is_alphanumeric() && c != '_')?];
    if name.is_empty() {
        return None;
    }
    let end = body_end(code)?;
    Some((name, code[..end].lines().count()))
}

/// The end of the first `{…}`, unless a `;` outside brackets comes first and there is no body.
fn body_end(code: &str) -> Option<usize> {
    let (mut braces, mut brackets) = (0_usize, 0_usize);
    for (at, c) in code.char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets = brackets.saturating_sub(1),
            ';' if braces == 0 && brackets == 0 => return None,
            '{' => braces += 1,
            '}' if braces <= 1 => return Some(at + 1),
            '}' => braces -= 1,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> SourceFile {
        SourceFile::new("src/a.rs", text)
    }

    #[test]
    fn a_long_file_is_found() {
        assert_eq!(long_file(&source(&"x\n".repeat(FILE_LINES))), []);
        assert_eq!(long_file(&source(&"x\n".repeat(FILE_LINES + 1))).len(), 1);
    }

    #[test]
    fn a_long_function_is_found() {
        let of_lines = |lines| format!("fn f(a: [u8; 2]) {{\n{}}}\n", "{ x; }\n".repeat(lines - 2));
        assert_eq!(long_functions(&source(&of_lines(FUNCTION_LINES))), []);
        let text = format!("trait T {{ fn g(); }}\n{}", of_lines(FUNCTION_LINES + 1));
        let found = long_functions(&source(&text));
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].line, found[0].what.as_str()), (2, "fn f has 61 lines"));
    }

    #[test]
    fn a_function_pointer_is_no_function() {
        assert_eq!(function("fn(u8) -> u8 { x }"), None);
    }
}
