//! Rules of the house, checked on its text: layers, SAFETY notes, lengths, and words that stay out.
//!
//! Each rule is a function from text to findings, with a test that shows it can find something.

mod layers;
mod limits;
mod manners;
mod source;

use source::{Finding, SourceFile};

/// Fails with every finding that `rule` has in the files whose path `applies`.
fn require(applies: fn(&str) -> bool, rule: impl Fn(&SourceFile) -> Vec<Finding>) {
    let files: Vec<_> = source::tracked_files()
        .into_iter()
        .filter(|file| applies(&file.path))
        .collect();
    assert!(!files.is_empty(), "the rule applies to no file");
    let findings: Vec<_> = files.iter().flat_map(rule).map(|f| f.to_string()).collect();
    assert!(findings.is_empty(), "\n{}", findings.join("\n"));
}

fn is_rust(path: &str) -> bool {
    path.ends_with(".rs")
}

fn is_library(path: &str) -> bool {
    is_rust(path) && path.starts_with("src/")
}

fn is_code(path: &str) -> bool {
    let suffixes = [".rs", ".py", ".glsl", ".vert", ".frag", ".comp"];
    let scripts = ["tools/setup", "tools/demo", ".ci/run", "Makefile"];
    suffixes.iter().any(|s| path.ends_with(s)) || scripts.contains(&path)
}

fn is_anything(_: &str) -> bool {
    true
}

#[test]
fn modules_import_only_earlier_ones() {
    require(is_library, layers::forbidden_imports);
}

#[test]
fn every_unsafe_has_its_note() {
    require(is_rust, manners::unsafe_without_note);
}

#[test]
fn unsafe_stays_in_gpu() {
    require(is_rust, manners::unsafe_outside_gpu);
}

#[test]
fn nothing_is_left_half_done() {
    require(is_rust, manners::unfinished_business);
}

#[test]
fn no_file_knows_a_machine() {
    require(is_anything, manners::machine_paths);
}

#[test]
fn files_are_short() {
    require(is_code, limits::long_file);
}

#[test]
fn functions_are_short() {
    require(is_rust, limits::long_functions);
}

#[test]
fn the_architecture_page_names_every_module() {
    let page = source::read("docs/ARCHITECTURE.md");
    let paths: Vec<_> = source::tracked_files().into_iter().map(|f| f.path).collect();
    let modules = layers::modules(paths.iter().map(String::as_str));
    assert!(modules.len() > 5, "the modules were not found");
    let unnamed = layers::unnamed_modules(&page, &modules);
    assert!(unnamed.is_empty(), "docs/ARCHITECTURE.md does not name {unnamed:?}");
}
