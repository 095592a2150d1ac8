//! The header of a MetaImage: lines of `Key = value`, or `Key: value`, of which `ElementDataFile` is the last.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::error::ReadError;
use super::lines::Lines;

/// A header's fields.
pub(super) struct Header {
    path: PathBuf,
    fields: BTreeMap<String, Field>,
    /// What `ElementDataFile` says.
    pub data: String,
    /// The lines after `ElementDataFile = LIST`, which name files.
    pub list: Vec<String>,
    /// Where in the file it ends.
    pub end: u64,
}

struct Field {
    line: usize,
    value: String,
}

impl Header {
    /// Reads the header of the file at `path`.
    pub(super) fn read(path: &Path, reader: impl BufRead) -> Result<Self, ReadError> {
        let mut lines = Lines::new(path, reader);
        let mut header = Self {
            path: path.to_owned(),
            fields: BTreeMap::new(),
            data: String::new(),
            list: Vec::new(),
            end: 0,
        };
        while let Some(line) = lines.next()? {
            header.add(&line, lines.number)?;
            if !header.data.is_empty() {
                header.end = lines.bytes;
                header.read_list(&mut lines)?;
                return Ok(header);
            }
        }
        Err(ReadError::header(
            path,
            "the header has no `ElementDataFile`, which ends it",
        ))
    }

    fn add(&mut self, line: &str, number: usize) -> Result<(), ReadError> {
        if line.is_empty() || line.starts_with('#') {
            return Ok(());
        }
        let Some((key, value)) = line.split_once(['=', ':']) else {
            let start: String = line.chars().take(60).collect();
            let what = format!("`{start}` is no `Key = value`");
            return Err(ReadError::header(&self.path, what).line(number));
        };
        let (key, value) = (key.trim(), value.trim().to_owned());
        if key == "ElementDataFile" {
            self.data = value;
            return Ok(());
        }
        // Where a key is given twice, the first holds.
        let field = Field { line: number, value };
        self.fields.entry(key.to_owned()).or_insert(field);
        Ok(())
    }

    fn read_list<R: BufRead>(&mut self, lines: &mut Lines<R>) -> Result<(), ReadError> {
        if self.data.starts_with("LIST") {
            while let Some(line) = lines.next()? {
                self.list
                    .extend(Some(line.trim().to_owned()).filter(|name| !name.is_empty()));
            }
        }
        Ok(())
    }

    /// The value of a key.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.fields.get(key).map(|field| field.value.as_str())
    }

    /// Whether a key says `True`.
    pub(super) fn is_true(&self, key: &str) -> bool {
        self.get(key).is_some_and(|value| value.starts_with(['t', 'T', '1']))
    }

    /// The numbers of the first of some keys that is there, which have to be `count`.
    pub(super) fn numbers<T: FromStr>(&self, keys: &[&str], count: usize) -> Result<Option<Vec<T>>, ReadError> {
        let Some((key, field)) = keys.iter().find_map(|key| Some((key, self.fields.get(*key)?))) else {
            return Ok(None);
        };
        let words = field.value.split_ascii_whitespace();
        let numbers: Option<Vec<T>> = words.map(|word| word.parse().ok()).collect();
        match numbers.filter(|numbers| numbers.len() >= count) {
            Some(mut numbers) => {
                numbers.truncate(count);
                Ok(Some(numbers))
            }
            None => {
                let what = format!("`{key}` does not say {count} numbers of its kind");
                Err(ReadError::header(&self.path, what).line(field.line))
            }
        }
    }

    /// The number of a key.
    pub(super) fn number<T: FromStr>(&self, key: &str) -> Result<Option<T>, ReadError> {
        let numbers = self.numbers(&[key], 1)?;
        Ok(numbers.and_then(|numbers| numbers.into_iter().next()))
    }

    /// The error that the value of `key` is wrong, as `what` says.
    pub(super) fn bad(&self, key: &str, what: impl Into<String>) -> ReadError {
        let error = ReadError::header(&self.path, what);
        match self.fields.get(key) {
            Some(field) => error.line(field.line),
            None => error,
        }
    }
}
