//! Who may import whom (docs/ARCHITECTURE.md).

use std::collections::BTreeSet;

use crate::source::{Finding, SourceFile, code_only};

/// The flow: each may import the ones before it.
const FLOW: [&str; 7] = ["math", "volume", "voxelize", "model", "target", "projection", "surface"];

/// Modules that import nothing of the crate, and that the flow and all above it may import.
const LEAVES: [&str; 3] = ["array", "interface", "output"];

/// Modules that nobody imports but lib, main and `cli`.
const TOPS: [&str; 3] = ["conformance", "viewer", "cli"];

/// What `module` may import; `None` for a module that has no place yet.
fn allowed(module: &str) -> Option<Vec<&'static str>> {
    let earlier = |position: usize| [&FLOW[..position], &LEAVES].concat();
    if module == "projection" {
        // A projector's result is a frame.
        return Some([earlier(5), vec!["image"]].concat());
    }
    if module == "surface" {
        // So is a picture of meshes.
        return Some([earlier(6), vec!["image"]].concat());
    }
    if let Some(position) = FLOW.iter().position(|m| *m == module) {
        return Some(earlier(position));
    }
    let all = FLOW.len();
    Some(match module {
        "array" | "interface" | "output" => vec![],
        "gpu" => vec!["interface"],
        "image" => vec!["math", "output"],
        "scene" => earlier(all),
        "render" => [earlier(all), vec!["gpu", "image", "shaders"]].concat(),
        "conformance" | "viewer" => below_tops(),
        "cli" => [below_tops(), vec!["conformance", "viewer"]].concat(),
        "lib" | "main" => [below_tops(), TOPS.to_vec()].concat(),
        _ => return None,
    })
}

fn below_tops() -> Vec<&'static str> {
    [&FLOW[..], &LEAVES, &["gpu", "image", "scene", "render"]].concat()
}

/// Imports that the layers forbid, and modules without a layer.
pub fn forbidden_imports(file: &SourceFile) -> Vec<Finding> {
    let module = top_module(&file.path);
    let Some(allowed) = allowed(module) else {
        return vec![file.finding(1, format!("module `{module}` has no layer: give it one"))];
    };
    imports(file)
        .into_iter()
        .filter(|(_, to)| to != module && !allowed.contains(&to.as_str()))
        .map(|(line, to)| file.finding(line, format!("`{module}` must not import `{to}`")))
        .collect()
}

/// `volume` for src/volume/io/nrrd.rs, `output` for src/output.rs.
fn top_module(path: &str) -> &str {
    let inside = path.strip_prefix("src/").unwrap_or(path);
    let first = inside.split('/').next().unwrap_or(inside);
    first.strip_suffix(".rs").unwrap_or(first)
}

/// The top-level modules that a file's paths name, with their lines: `crate::a`, `crate::{a::b, c}`, and `super::super::a`
/// where that climbs to the crate's root.
fn imports(file: &SourceFile) -> Vec<(usize, String)> {
    let code = code_only(&file.text);
    let climbs = format!("{}::", vec!["super"; depth(&file.path)].join("::"));
    let mut found = Vec::new();
    for root in ["crate::", climbs.as_str()] {
        for (at, _) in code.match_indices(root) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
                continue;
            }
            let line = code[..at].matches('\n').count() + 1;
            let heads = heads(&code[at + root.len()..]);
            found.extend(heads.into_iter().filter(|h| is_module(h)).map(|h| (line, h)));
        }
    }
    found
}

/// How many `super`s lead from a file's module to the root.
fn depth(path: &str) -> usize {
    let inside = path.strip_prefix("src/").unwrap_or(path);
    let parts = inside.split('/').count();
    if inside.ends_with("/mod.rs") { parts - 1 } else { parts }
}

/// Modules are lower case; what the crate's root re-exports is not.
fn is_module(head: &str) -> bool {
    head != "self" && head.starts_with(|c: char| c.is_ascii_lowercase())
}

/// The first names of what follows `crate::`: one, or those of a `{…}` list.
fn heads(rest: &str) -> Vec<String> {
    let name = |text: &str| -> String {
        let is_word = |c: &char| c.is_alphanumeric() || *c == '_';
        text.trim_start().chars().take_while(is_word).collect()
    };
    match rest.trim_start().strip_prefix('{') {
        None => vec![name(rest)],
        Some(list) => top_level_items(list).into_iter().map(name).collect(),
    }
}

/// The items of a `{…}` list whose opening brace is already read.
fn top_level_items(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut items) = (0, 0, Vec::new());
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                items.push(&list[start..at]);
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                items.push(&list[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    items
}

/// The modules of the library to a depth of two: `volume`, `volume/grid`, `volume/io`.
pub fn modules<'a>(paths: impl Iterator<Item = &'a str>) -> BTreeSet<String> {
    let mut modules = BTreeSet::new();
    for path in paths {
        let Some(inside) = path.strip_prefix("src/").and_then(|p| p.strip_suffix(".rs")) else {
            continue;
        };
        let parts: Vec<_> = inside.split('/').filter(|part| *part != "mod").collect();
        if parts != ["lib"] && parts != ["main"] {
            modules.insert(parts[0].to_owned());
            modules.insert(parts[..parts.len().min(2)].join("/"));
        }
    }
    modules
}

/// Modules without a line of `page` that has their names in backticks: `a`, or both `a` and `b` for `a/b`.
pub fn unnamed_modules<'a>(page: &str, modules: &'a BTreeSet<String>) -> Vec<&'a str> {
    let named = |module: &&str| {
        page.lines()
            .any(|line| module.split('/').all(|part| line.contains(&format!("`{part}`"))))
    };
    modules.iter().map(String::as_str).filter(|m| !named(m)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forbidden(path: &str, text: &str) -> Vec<String> {
        let findings = forbidden_imports(&SourceFile::new(path, text));
        findings.into_iter().map(|f| f.what).collect()
    }

    #[test]
    fn a_later_module_is_found_however_it_is_named() {
        let expected = ["`volume` must not import `model`"];
        assert_eq!(forbidden("src/volume/a.rs", "use crate::model::Node;"), expected);
        assert_eq!(
            forbidden("src/volume/a.rs", "use crate::{math::{Aabb, x}, model};"),
            expected
        );
        assert_eq!(
            forbidden("src/volume/a.rs", "fn f() -> crate::model::Node {}"),
            expected
        );
        assert_eq!(forbidden("src/volume/a.rs", "use super::super::model::Node;"), expected);
        assert_eq!(forbidden("src/volume/mod.rs", "use super::model::Node;"), expected);
    }

    #[test]
    fn an_earlier_module_may_be_imported() {
        assert!(forbidden("src/model/a.rs", "use crate::{math::Aabb, volume};").is_empty());
        assert!(forbidden("src/model/a.rs", "use super::surface;").is_empty());
        assert!(forbidden("src/volume/a.rs", "// use crate::model;").is_empty());
        assert!(forbidden("src/volume/a.rs", "use crate::{self, Error};").is_empty());
    }

    #[test]
    fn what_stands_beside_the_flow_stays_there() {
        assert_eq!(forbidden("src/gpu/a.rs", "use crate::{interface, math};").len(), 1);
        assert_eq!(forbidden("src/image/a.rs", "use crate::projection;").len(), 1);
        assert_eq!(forbidden("src/render/a.rs", "use crate::scene;").len(), 1);
        assert_eq!(forbidden("src/projection/a.rs", "use crate::scene;").len(), 1);
    }

    #[test]
    fn nobody_imports_the_tops() {
        for top in TOPS {
            let text = format!("use crate::{top}::run;");
            assert_eq!(forbidden("src/render/a.rs", &text).len(), 1);
            assert!(forbidden("src/main.rs", &text).is_empty());
        }
        assert_eq!(forbidden("src/viewer/a.rs", "use crate::cli;").len(), 1);
    }

    #[test]
    fn a_module_without_a_layer_is_found() {
        assert_eq!(forbidden("src/misc.rs", "").len(), 1);
    }

    #[test]
    fn an_unnamed_module_is_found() {
        let paths = ["src/lib.rs", "src/a/mod.rs", "src/a/b.rs", "src/a/io/c.rs", "src/d.rs"];
        let modules = modules(paths.into_iter());
        let names: Vec<_> = modules.iter().map(String::as_str).collect();
        assert_eq!(names, ["a", "a/b", "a/io", "d"]);
        assert_eq!(unnamed_modules("| `a` | `b` |\n`io`", &modules), ["a/io", "d"]);
    }
}
