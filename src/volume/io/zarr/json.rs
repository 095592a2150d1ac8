//! The JSON documents of a Zarr hierarchy.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::volume::io::error::ReadError;

/// The most bytes of a document: consolidated metadata of many arrays are some megabytes.
const MAX_BYTES: u64 = 16 << 20;

/// A document, and where it is from.
#[derive(Debug)]
pub(super) struct Document {
    path: PathBuf,
    value: Value,
}

/// A name with what belongs to it, as version 3 has it for all that can be extended.
#[derive(Debug, Deserialize)]
#[serde(from = "NameOrMore")]
pub(super) struct Named {
    pub name: String,
    pub configuration: Value,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum NameOrMore {
    Name(String),
    More {
        name: String,
        #[serde(default)]
        configuration: Value,
    },
}

impl From<NameOrMore> for Named {
    fn from(named: NameOrMore) -> Self {
        match named {
            NameOrMore::Name(name) => Self {
                name,
                configuration: Value::Null,
            },
            NameOrMore::More { name, configuration } => Self { name, configuration },
        }
    }
}

impl Document {
    /// The document at `path`; `None` where there is none.
    pub fn read(path: &Path) -> Result<Option<Self>, ReadError> {
        if !path.is_file() {
            return Ok(None);
        }
        let mut text = Vec::new();
        let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut text));
        read.map_err(|e| ReadError::io(path, e))?;
        if text.len() as u64 > MAX_BYTES {
            return Err(ReadError::header(path, "it is too long for metadata"));
        }
        let value = serde_json::from_slice(&text)
            .map_err(|e| ReadError::header(path, format!("it is not JSON: {e}")).line(e.line().max(1)))?;
        let path = path.to_owned();
        Ok(Some(Self { path, value }))
    }

    /// Whether it is of Zarr's version 3.
    pub fn is_version_3(&self) -> bool {
        self.value.get("zarr_format").and_then(Value::as_u64) == Some(3)
    }

    /// What stands under a key.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.value.get(key)
    }

    /// All of it.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// Its fields.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ReadError> {
        self.parse_value(self.value.clone())
    }

    /// The fields of a part of it.
    pub fn parse_value<T: DeserializeOwned>(&self, value: Value) -> Result<T, ReadError> {
        serde_json::from_value(value).map_err(|e| self.wrong(e.to_string()))
    }

    /// The error for something impossible in it.
    pub fn wrong(&self, what: impl Into<String>) -> ReadError {
        ReadError::header(&self.path, what)
    }

    /// The error for a variant that is not read.
    pub fn unsupported(&self, what: impl AsRef<str>) -> ReadError {
        ReadError::unsupported(&self.path, format!("not read: {}", what.as_ref()))
            .hint("store it again with the codecs bytes, gzip, zstd or blosc, as zarr-python does")
    }
}
