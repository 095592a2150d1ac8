//! SAFETY notes, leftovers, and paths that only one machine has.

use crate::source::{Finding, SourceFile, code_only, words};

/// How many lines of the same statement may stand between an `unsafe` and its note.
const STATEMENT_LINES: usize = 3;

fn unsafe_lines(file: &SourceFile) -> Vec<usize> {
    let code = code_only(&file.text);
    words(&code)
        .filter(|(_, _, word)| *word == "unsafe")
        .map(|(line, _, _)| line)
        .collect()
}

/// `unsafe` without a `SAFETY:` note, or a `# Safety` section, in the comment above it.
pub fn unsafe_without_note(file: &SourceFile) -> Vec<Finding> {
    let lines: Vec<_> = file.text.lines().collect();
    unsafe_lines(file)
        .into_iter()
        .filter(|&line| !has_note(&lines[..line]))
        .map(|line| file.finding(line, "`unsafe` without a SAFETY note above it"))
        .collect()
}

/// Whether the comment that ends at most a statement's lines above the last of `lines` is a note.
fn has_note(lines: &[&str]) -> bool {
    let is_comment = |line: &&&str| line.trim_start().starts_with("//");
    let before = lines[..lines.len() - 1].iter().rev();
    let statement = before.clone().take_while(|line| !is_comment(line)).count();
    statement <= STATEMENT_LINES
        && before
            .skip(statement)
            .take_while(is_comment)
            .any(|line| line.contains("SAFETY:") || line.contains("# Safety"))
}

/// Where `unsafe` may be: in what talks to the device, and in operations of the processor that a law holds against safe ones.
const UNSAFE: [&str; 2] = ["src/gpu/", "src/projection/raycast/simd/avx512"];

/// `unsafe` anywhere but where it may be.
pub fn unsafe_outside_gpu(file: &SourceFile) -> Vec<Finding> {
    if UNSAFE.iter().any(|place| file.path.starts_with(place)) {
        return Vec::new();
    }
    unsafe_lines(file)
        .into_iter()
        .map(|line| file.finding(line, "`unsafe` outside src/gpu and the operations of vectors"))
        .collect()
}

/// Ignored tests, forgotten stubs and prints, silenced warnings.
pub fn unfinished_business(file: &SourceFile) -> Vec<Finding> {
    let forbidden = ["#[ignore", "todo!", "unimplemented!", "dbg!", "#[allow", "#![allow"];
    let code = code_only(&file.text);
    let found = |line: &str| forbidden.iter().find(|word| line.contains(**word)).copied();
    code.lines()
        .enumerate()
        .filter_map(|(index, line)| Some(file.finding(index + 1, found(line)?)))
        .collect()
}

/// Folders of somebody's machine, and hosts that only it knows.
pub fn machine_paths(file: &SourceFile) -> Vec<Finding> {
    // Put together here, or this file would be its own finding.
    let folders = ["home", "root", "work", "farm", "tmp", "Users"].map(|name| format!("/{name}/"));
    let hosts = [concat!("local", "host"), concat!("127.0", ".0.1")];
    let names_one = |line: &str| {
        folders.iter().any(|folder| mentions_root_folder(line, folder)) || hosts.iter().any(|host| line.contains(*host))
    };
    file.text
        .lines()
        .enumerate()
        .filter(|(_, line)| names_one(line))
        .map(|(index, _)| file.finding(index + 1, "a path or host of one machine"))
        .collect()
}

/// Whether `line` holds `folder` as the start of an absolute path, not as a part of a longer one.
fn mentions_root_folder(line: &str, folder: &str) -> bool {
    line.match_indices(folder).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        before.is_none_or(|c| !c.is_alphanumeric() && !"_-.}/)".contains(c))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(rule: fn(&SourceFile) -> Vec<Finding>, text: &str) -> Vec<usize> {
        let file = SourceFile::new("src/gpu/a.rs", text);
        rule(&file).iter().map(|f| f.line).collect()
    }

    #[test]
    fn a_missing_note_is_found() {
        let rule = unsafe_without_note;
        assert_eq!(lines(rule, "fn f() {\n    unsafe { g() }\n}"), [2]);
        assert_eq!(lines(rule, "// A comment.\nunsafe { g() }"), [2]);
        assert_eq!(lines(rule, "// SAFETY: ok.\na;\nb;\nc;\nd;\nunsafe { g() }"), [6]);
        assert_eq!(
            lines(rule, "// SAFETY: ok,\n// as it is long.\nlet x =\n    unsafe { g() };"),
            []
        );
        assert_eq!(lines(rule, "/// # Safety\n/// Never.\npub unsafe fn g() {}"), []);
        assert_eq!(lines(rule, "// unsafe\nlet s = \"unsafe\";"), []);
    }

    #[test]
    fn unsafe_elsewhere_is_found() {
        let text = "// SAFETY: ok.\nunsafe { g() }";
        assert_eq!(lines(unsafe_outside_gpu, text), []);
        let elsewhere = SourceFile::new("src/render/a.rs", text);
        assert_eq!(unsafe_outside_gpu(&elsewhere).len(), 1);
    }

    #[test]
    fn leftovers_are_found() {
        let text = "#[ignore = \"slow\"]\nfn f() {\n    todo!();\n    dbg!(1);\n}\n// todo!\n#[allow(dead_code)]";
        assert_eq!(lines(unfinished_business, text), [1, 3, 4, 7]);
    }

    #[test]
    fn machine_paths_are_found() {
        let text = format!(
            "see /{0}/x\nassets/{0}/x\n\"/{0}/y\"\nhttp://local{1}:8",
            "home", "host"
        );
        assert_eq!(lines(machine_paths, &text), [1, 3, 4]);
    }
}
