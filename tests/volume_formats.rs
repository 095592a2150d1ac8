//! The table of formats is the one that docs/FORMATS.md and `vcsg formats` show.

use std::fs;
use std::process::Command;

use vcsg::volume::io::{FORMATS, Format};

fn suffixes(suffixes: &[&str]) -> String {
    let quoted: Vec<_> = suffixes.iter().map(|suffix| format!("`{suffix}`")).collect();
    quoted.join(" ")
}

/// The row of the page's table.
fn row(format: &Format) -> String {
    let (written, writes) = match &format.writer {
        Some(writer) => (suffixes(writer.suffixes), writer.writes),
        None => ("–".to_owned(), "–"),
    };
    format!(
        "| {} | {} | {} | {written} | {writes} |",
        format.name,
        suffixes(format.suffixes),
        format.reads
    )
}

#[test]
fn the_page_has_the_table() {
    let page = fs::read_to_string("docs/FORMATS.md").expect("docs/FORMATS.md");
    let is_row = |line: &&str| line.starts_with("| ") && !line.starts_with("| format ");
    let found: Vec<_> = page
        .lines()
        .take_while(|line| !line.starts_with("## "))
        .filter(is_row)
        .collect();
    let expected = FORMATS.map(row);
    assert_eq!(
        found,
        expected,
        "the table of docs/FORMATS.md should be\n{}",
        expected.join("\n")
    );
}

#[test]
fn the_program_lists_them() {
    let output = Command::new(env!("CARGO_BIN_EXE_vcsg"))
        .arg("formats")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let json = Command::new(env!("CARGO_BIN_EXE_vcsg"))
        .args(["formats", "--json"])
        .output()
        .unwrap();
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    for (n, format) in FORMATS.iter().enumerate() {
        assert!(text.contains(format.name) && text.contains(format.reads), "{text}");
        assert_eq!(json["formats"][n]["name"], format.name);
        assert_eq!(json["formats"][n]["writes"].is_null(), format.writer.is_none());
    }
}

#[test]
fn every_writer_is_also_read() {
    for format in FORMATS {
        for suffix in format.writer.iter().flat_map(|writer| writer.suffixes) {
            assert!(format.suffixes.contains(suffix), "{}: {suffix}", format.name);
        }
    }
}
