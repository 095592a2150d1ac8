//! A text table of landmarks: a line each, `[NAME] x y z x y z`, where from and where to, LPS millimetres. What follows `#` is a
//! comment; numbers stand apart by blanks, commas or semicolons.

use std::fmt::Write;
use std::path::Path;

use glam::DVec3;

use super::super::landmarks::Landmark;
use super::{LandmarkFileError, Wrong, text, write_text};

/// Reads a table of landmarks.
///
/// # Errors
/// If the file cannot be read, or a line is not six numbers, with a name before them or not.
pub fn read_pairs(path: &Path) -> Result<Vec<Landmark>, LandmarkFileError> {
    let text = text(path)?;
    let lines = text.lines().enumerate();
    let landmarks = lines.filter_map(|(n, line)| landmark(n + 1, line).transpose());
    landmarks.collect::<Result<_, _>>().map_err(|wrong| wrong.of(path))
}

fn landmark(number: usize, line: &str) -> Result<Option<Landmark>, Wrong> {
    let is_gap = |c: char| c.is_whitespace() || c == ',' || c == ';';
    let said = line.split('#').next().unwrap_or("");
    let words: Vec<&str> = said.split(is_gap).filter(|w| !w.is_empty()).collect();
    let (name, numbers) = match words.len() {
        0 => return Ok(None),
        6 => (format!("of line {number}"), &words[..]),
        7 => (words[0].to_owned(), &words[1..]),
        _ => {
            return Err(Wrong::at(
                number,
                "a landmark is six numbers, with a name before them or not",
            ));
        }
    };
    let mut place = [0.0; 6];
    for (place, word) in place.iter_mut().zip(numbers) {
        let bad = |_| Wrong::at(number, format!("{word:?} is not a number"));
        *place = word.parse().map_err(bad)?;
    }
    let [a, b, c, d, e, f] = place;
    Ok(Some(Landmark {
        name,
        from: DVec3::new(a, b, c),
        to: DVec3::new(d, e, f),
    }))
}

/// Writes a table of landmarks. Blanks and commas in names become underscores.
///
/// # Errors
/// If the file cannot be written.
pub fn write_pairs(path: &Path, landmarks: &[Landmark]) -> Result<(), LandmarkFileError> {
    let mut text = String::from("# name, from x y z, to x y z: LPS, millimetres\n");
    for Landmark { name, from, to } in landmarks {
        let name: String = name
            .chars()
            .map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' })
            .collect();
        let name = if name.is_empty() { "_" } else { &name };
        // Rust's shortest form of a number reads back as the same.
        let _ = writeln!(
            text,
            "{name} {} {} {} {} {} {}",
            from.x, from.y, from.z, to.x, to.y, to.z
        );
    }
    write_text(path, &text)
}
