//! The header of a NRRD file: lines of `field: value`, of `key:=value`, and comments, up to an empty line.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::DVec3;

use super::error::ReadError;
use super::lines::Lines;

/// A header's fields.
pub(super) struct Header {
    path: PathBuf,
    fields: BTreeMap<String, Field>,
    /// The lines after a field `data file: LIST`, which name files.
    pub list: Vec<String>,
    /// Where in the file it ends.
    pub end: u64,
}

/// A field's value and where it stands.
pub(super) struct Field {
    /// The line, from 1 on.
    pub line: usize,
    /// What follows the colon.
    pub value: String,
}

impl Header {
    /// Reads a header, and the empty line that ends it.
    pub(super) fn read(path: &Path, reader: &mut impl BufRead) -> Result<Self, ReadError> {
        let mut lines = Lines::new(path, reader);
        let magic = lines.next()?.unwrap_or_default();
        if !magic.starts_with("NRRD000") {
            return Err(ReadError::header(path, "it does not start with NRRD000…").line(1));
        }
        let mut header = Self {
            path: path.to_owned(),
            fields: BTreeMap::new(),
            list: Vec::new(),
            end: 0,
        };
        while let Some(line) = lines.next()?.filter(|line| !line.is_empty()) {
            match header.names_a_list() {
                true => header.list.push(line),
                false => header.add(&line, lines.number)?,
            }
        }
        header.end = lines.bytes;
        Ok(header)
    }

    /// Whether its last field is a list of files, which goes on to the header's end.
    fn names_a_list(&self) -> bool {
        self.get("datafile")
            .is_some_and(|field| field.value.starts_with("LIST"))
    }

    fn add(&mut self, line: &str, number: usize) -> Result<(), ReadError> {
        if line.starts_with('#') {
            return Ok(());
        }
        let Some((name, value)) = line.split_once(':') else {
            let what = format!("`{}` is no `field: value`", shortened(line));
            return Err(ReadError::header(&self.path, what).line(number));
        };
        if value.starts_with('=') {
            return Ok(());
        }
        let field = Field {
            line: number,
            value: value.trim().to_owned(),
        };
        match self.fields.insert(canonical(name), field) {
            Some(first) => {
                let what = format!("`{name}` is given a second time (first in line {})", first.line);
                Err(ReadError::header(&self.path, what).line(number))
            }
            None => Ok(()),
        }
    }

    /// The field of this name, in lower case and without spaces.
    pub(super) fn get(&self, name: &str) -> Option<&Field> {
        self.fields.get(name)
    }

    /// The field of this name, which has to be there.
    pub(super) fn need(&self, name: &str) -> Result<&Field, ReadError> {
        self.get(name)
            .ok_or_else(|| ReadError::header(&self.path, format!("the header has no `{name}`")))
    }

    /// The words of a field as numbers; `None` without the field.
    pub(super) fn numbers<T: FromStr>(&self, name: &str) -> Result<Option<Vec<T>>, ReadError> {
        let Some(field) = self.get(name) else {
            return Ok(None);
        };
        let words = field.value.split_ascii_whitespace();
        let numbers = words.map(|word| word.parse().map_err(|_| self.bad(field, word)));
        numbers.collect::<Result<_, _>>().map(Some)
    }

    /// The single number of a field, or `default` without the field.
    pub(super) fn number<T: FromStr>(&self, name: &str, default: T) -> Result<T, ReadError> {
        match self.get(name) {
            Some(field) => field.value.parse().map_err(|_| self.bad(field, &field.value)),
            None => Ok(default),
        }
    }

    /// The vectors of a field, missing components 0; `none` and vectors that are not finite are `None`.
    pub(super) fn vectors(&self, name: &str) -> Result<Option<Vec<Option<DVec3>>>, ReadError> {
        let Some(field) = self.get(name) else {
            return Ok(None);
        };
        let mut vectors = Vec::new();
        let mut rest = field.value.trim_start();
        while !rest.is_empty() {
            let end = rest.find(ends_vector(rest)).map_or(rest.len(), |i| i + 1);
            vectors.push(vector(&rest[..end]).map_err(|()| self.bad(field, &rest[..end]))?);
            rest = rest[end..].trim_start();
        }
        Ok(Some(vectors))
    }

    /// The words of a field, which may be in quotes.
    pub(super) fn words(&self, name: &str) -> Vec<String> {
        let value = self.get(name).map_or("", |field| &field.value);
        let words = value.split_ascii_whitespace();
        words.map(|w| w.trim_matches('"').to_owned()).collect()
    }

    /// The error that `field` says `what`, which it cannot.
    pub(super) fn bad(&self, field: &Field, what: &str) -> ReadError {
        let what = format!("`{}` is not a value of this field", shortened(what));
        ReadError::header(&self.path, what).line(field.line)
    }
}

/// A vector ends with its bracket, a word before the next space.
fn ends_vector(text: &str) -> fn(char) -> bool {
    match text.starts_with('(') {
        true => |c| c == ')',
        false => |c| c == ' ' || c == '\t',
    }
}

/// `(x,y,z)` or `none`.
fn vector(text: &str) -> Result<Option<DVec3>, ()> {
    let text = text.trim();
    if text == "none" {
        return Ok(None);
    }
    let inner = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
    let numbers: Vec<f64> = (inner.ok_or(())?.split(','))
        .map(|n| n.trim().parse().map_err(drop))
        .collect::<Result<_, _>>()?;
    let at = |axis| numbers.get(axis).copied().unwrap_or(0.0);
    let vector = DVec3::new(at(0), at(1), at(2));
    Ok(vector.is_finite().then_some(vector))
}

/// Field names are compared without case and spaces: `data file` is also written `datafile`.
fn canonical(name: &str) -> String {
    let letters = name.chars().filter(|c| !c.is_ascii_whitespace());
    letters.map(|c| c.to_ascii_lowercase()).collect()
}

/// Enough of a text to recognise it.
fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}
