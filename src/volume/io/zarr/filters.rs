//! The filters of Zarr 2, which elements go through before they are compressed.

use serde_json::Value;

use super::array::Element;
use super::codec::Codec;
use super::json::Document;
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::{ByteOrder, Stored};

/// The largest element that is shuffled.
const MAX_SHUFFLED: u64 = 16;

/// The filter that numcodecs describes so, of an array of elements of NumPy's type `dtype`, which is `element` in `order`.
pub(super) fn filter(
    document: &Document,
    filter: &Value,
    dtype: &Value,
    (element, order): (Element, ByteOrder),
) -> Result<Codec, ReadError> {
    let id = filter.get("id").and_then(Value::as_str).unwrap_or_default();
    let is_of_array = |key: &str| filter.get(key).is_none_or(|kind| kind == dtype);
    let known = match (id, element) {
        ("shuffle", _) => shuffle(filter),
        // Differences that are stored as what they are of.
        ("delta", Element::Scalar(stored)) if !is_float(stored) && is_of_array("dtype") && is_of_array("astype") => {
            Some(Codec::Delta(stored.bytes(), order))
        }
        _ => None,
    };
    known.ok_or_else(|| document.unsupported(format!("the filter `{id}` as it is used here")))
}

fn shuffle(filter: &Value) -> Option<Codec> {
    let size = filter.get("elementsize").map_or(Some(4), Value::as_u64)?;
    (1..=MAX_SHUFFLED)
        .contains(&size)
        .then_some(Codec::Shuffle(size as usize))
}

fn is_float(stored: Stored) -> bool {
    matches!(stored, Stored::Voxel(voxel) if voxel.is_float())
}
