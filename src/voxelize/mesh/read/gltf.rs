//! The document of a glTF file: its lists, and the numbers that its accessors mean.

use glam::DVec3;
use serde_json::Value;

use super::bytes;
use super::error::Fault;

/// A document and the binary data that goes with it.
pub(super) struct Document<'a> {
    root: &'a Value,
    binary: &'a [u8],
}

/// What an accessor means: elements in their place in the file, all of which are there.
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    pub count: usize,
}

impl Elements<'_> {
    fn get(&self, n: usize) -> Option<&[u8]> {
        let at = n * self.stride;
        (n < self.count).then(|| &self.bytes[at..at + self.size])
    }

    /// Element `n` as a vector.
    pub fn vector(&self, n: usize) -> Option<DVec3> {
        self.get(n)?.try_into().ok().map(bytes::vector)
    }

    /// Element `n` as a whole number of at most four bytes.
    pub fn index(&self, n: usize) -> Option<usize> {
        let bytes = self.get(n)?;
        let mut word = [0; 4];
        word.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(u32::from_le_bytes(word) as usize)
    }
}

// Constants of the specification.
const UNSIGNED_BYTE: usize = 5121;
const UNSIGNED_SHORT: usize = 5123;
const UNSIGNED_INT: usize = 5125;
const FLOAT: usize = 5126;

impl<'a> Document<'a> {
    pub fn new(root: &'a Value, binary: &'a [u8]) -> Result<Self, Fault> {
        let extensions = root.get("extensionsRequired").and_then(Value::as_array);
        if let Some(extension) = extensions.into_iter().flatten().next() {
            let name = bytes::shortened(&extension.to_string());
            return Err(Fault::new(format!(
                "the file requires the extension {name}, which is not read"
            )));
        }
        Ok(Self { root, binary })
    }

    /// How many `list` has.
    pub fn count(&self, list: &str) -> usize {
        self.root.get(list).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// Item `n` of `list`.
    pub fn item(&self, list: &str, n: usize) -> Result<&'a Value, Fault> {
        let item = self.root.get(list).and_then(|list| list.get(n));
        item.ok_or_else(|| Fault::new(format!("there is no item {n} of `{list}`")))
    }

    /// The nodes at the top of the scene: of the one that is named, or the first; without scenes there are none.
    pub fn scene_nodes(&self) -> Result<Vec<usize>, Fault> {
        if self.count("scenes") == 0 {
            return Ok(Vec::new());
        }
        let scene = self.number(self.root, "scene")?.unwrap_or(0);
        self.numbers(self.item("scenes", scene)?, "nodes")
    }

    /// The whole number `key`, if it is there.
    pub fn number(&self, of: &Value, key: &str) -> Result<Option<usize>, Fault> {
        of.get(key).map(|value| whole(value, key)).transpose()
    }

    /// The whole numbers of the list `key`, none if it is not there.
    pub fn numbers(&self, of: &Value, key: &str) -> Result<Vec<usize>, Fault> {
        let list = of.get(key).and_then(Value::as_array);
        list.into_iter().flatten().map(|value| whole(value, key)).collect()
    }

    /// Positions, three numbers each.
    pub fn positions(&self, accessor: usize) -> Result<Elements<'a>, Fault> {
        self.elements(accessor, "VEC3", &[(FLOAT, 12)])
    }

    /// Numbers of vertices.
    pub fn indices(&self, accessor: usize) -> Result<Elements<'a>, Fault> {
        let types = [(UNSIGNED_BYTE, 1), (UNSIGNED_SHORT, 2), (UNSIGNED_INT, 4)];
        self.elements(accessor, "SCALAR", &types)
    }

    /// The elements of an accessor, whose component type is one of `types`, given with an element's size.
    fn elements(&self, n: usize, shape: &str, types: &[(usize, usize)]) -> Result<Elements<'a>, Fault> {
        let accessor = self.item("accessors", n)?;
        let bad = |what: &str| Fault::new(format!("accessor {n} {what}"));
        if accessor.get("sparse").is_some() {
            return Err(bad("is sparse, which is not read"));
        }
        let component = self.number(accessor, "componentType")?;
        let known = types.iter().find(|(known, _)| Some(*known) == component);
        let Some((_, size)) = known.filter(|_| accessor["type"] == shape) else {
            return Err(bad(&format!("has not the type that is read here ({shape})")));
        };
        let count = self.number(accessor, "count")?.ok_or_else(|| bad("has no `count`"))?;
        let view = self
            .number(accessor, "bufferView")?
            .ok_or_else(|| bad("has no `bufferView`"))?;
        let (bytes, stride, at) = self.view(view)?;
        let (stride, offset) = (
            stride.unwrap_or(*size),
            self.number(accessor, "byteOffset")?.unwrap_or(0),
        );
        if stride < *size {
            return Err(bad("has elements that overlap"));
        }
        let end = (count as u128).saturating_sub(1) * stride as u128 + *size as u128 + offset as u128;
        if count > 0 && end > bytes.len() as u128 {
            let what = format!("ends {end} bytes into a view of {}", bytes.len());
            return Err(bad(&what).byte(at));
        }
        Ok(Elements {
            bytes: bytes.get(offset..).unwrap_or_default(),
            stride,
            size: *size,
            count,
        })
    }

    /// A view's bytes, the distance between elements, and where it begins in the binary data.
    fn view(&self, n: usize) -> Result<(&'a [u8], Option<usize>, usize), Fault> {
        let view = self.item("bufferViews", n)?;
        let buffer = self.number(view, "buffer")?.unwrap_or(0);
        if buffer != 0 || self.item("buffers", 0)?.get("uri").is_some() {
            return Err(Fault::new(format!(
                "view {n} is of data outside the file, which is not read"
            )));
        }
        let offset = self.number(view, "byteOffset")?.unwrap_or(0);
        let length = self.number(view, "byteLength")?.unwrap_or(0);
        let bytes = self.binary.get(offset..).and_then(|bytes| bytes.get(..length));
        let outside = || {
            let what = format!(
                "view {n} ends beyond the {} bytes of data that there are",
                self.binary.len()
            );
            Fault::new(what).byte(self.binary.len())
        };
        Ok((bytes.ok_or_else(outside)?, self.number(view, "byteStride")?, offset))
    }
}

fn whole(value: &Value, key: &str) -> Result<usize, Fault> {
    let number = value.as_u64().and_then(|number| usize::try_from(number).ok());
    number.ok_or_else(|| {
        let value = bytes::shortened(&value.to_string());
        Fault::new(format!("`{key}` is {value}, which is no whole number"))
    })
}
