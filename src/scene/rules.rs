//! How a set operation combines values and coverages: `rule`, `family`, and tables of two values.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use super::element::Element;
use super::error::{Problem, SceneError};
use super::leaves;
use crate::math::Interval;
use crate::model::{Family, Lut, ValueRule};

type Result<T> = std::result::Result<T, SceneError>;

const RULES: &[(&str, ValueRule)] = &[
    ("first", ValueRule::First),
    ("second", ValueRule::Second),
    ("max", ValueRule::Max),
    ("min", ValueRule::Min),
    ("sum", ValueRule::Sum),
    ("difference", ValueRule::Difference),
    ("product", ValueRule::Product),
    ("average", ValueRule::Average),
    ("algebraic-sum", ValueRule::AlgebraicSum),
    ("absolute-difference", ValueRule::AbsoluteDifference),
    ("quotient", ValueRule::Quotient),
    ("over", ValueRule::Over),
    ("plus", ValueRule::Plus),
    ("in", ValueRule::In),
    ("out", ValueRule::Out),
    ("atop", ValueRule::Atop),
    ("xor", ValueRule::Xor),
];

/// The longest edge of a picture that is a table.
const LONGEST: u32 = 4096;

/// Property `family`.
pub(super) fn family(element: &Element) -> Result<Family> {
    let families = [("minmax", Family::MinMax), ("product", Family::Product)];
    element
        .get("family")
        .map_or(Ok(Family::default()), |v| v.one_of(&families))
}

/// Property `rule`, a name or `"blend T"` with T in [0, 1], or the child `lut`, whose picture lies in `base_dir` unless its path is
/// absolute.
pub(super) fn value_rule(element: &Element, base_dir: &Path) -> Result<Option<ValueRule>> {
    let table = table_of(element, base_dir)?;
    let Some(value) = element.get("rule") else {
        return Ok(table);
    };
    if table.is_some() {
        let problem = Problem::Conflict("a `lut` is the rule itself: leave out either of them");
        return Err(value.error(problem));
    }
    let Some(share) = value.string()?.strip_prefix("blend") else {
        return value.one_of(RULES).map(Some);
    };
    match share.trim().parse() {
        Ok(t) if (0.0..=1.0).contains(&t) => Ok(Some(ValueRule::Blend(t))),
        _ => Err(value.bad("like \"blend 0.5\", with a share in 0..1")),
    }
}

/// The table among the children of `element`, if there is one.
fn table_of(element: &Element, base_dir: &Path) -> Result<Option<ValueRule>> {
    let mut table = None;
    for child in element.children() {
        // A child that is wrong is told by who reads the tree, in its order.
        let Ok(child) = child else { continue };
        if child.name() != "lut" {
            continue;
        }
        if table.is_some() {
            return Err(child.error(Problem::Twice { name: "lut".into() }));
        }
        table = Some(ValueRule::Table(Arc::new(lut(&child, base_dir)?)));
    }
    Ok(table)
}

fn lut(element: &Element, base_dir: &Path) -> Result<Lut> {
    let first = leaves::parse_window(element.require("first")?)?;
    let second = leaves::parse_window(element.require("second")?)?;
    let (width, values) = match element.get("image") {
        Some(_) => picture(element, base_dir)?,
        None => rows(element)?,
    };
    Lut::new(first, second, width, values).map_err(|e| element.error(Problem::Table(e)))
}

/// The entries that `row` children state, and how many stand in a row.
fn rows(element: &Element) -> Result<(usize, Vec<f32>)> {
    if element.get("values").is_some() {
        let problem = Problem::Conflict("`values` says what black and white of an `image` stand for");
        return Err(element.error_of("values", problem));
    }
    let (mut width, mut values) = (None, Vec::new());
    for row in element.children() {
        let argument = row?.argument(0);
        let row = argument.row()?;
        if *width.get_or_insert(row.len()) != row.len() {
            return Err(argument.bad("as long as the row above it"));
        }
        values.extend(row);
    }
    match width {
        Some(width) => Ok((width, values)),
        None => {
            let (node, wanted) = (element.name(), "an `image`, or at least one `row`");
            Err(element.error(Problem::TooFewChildren { node, wanted, found: 0 }))
        }
    }
}

/// The entries that a grey picture shows, from black to white as `values` says, and how many stand in a row.
fn picture(element: &Element, base_dir: &Path) -> Result<(usize, Vec<f32>)> {
    if element.children().next().is_some() {
        return Err(element.error_of("image", Problem::Conflict("a table is an `image` or `row`s, not both")));
    }
    let Interval { lo, hi } = leaves::parse_window(element.require("values")?)?;
    let image = element.require("image")?;
    let path = base_dir.join(image.string()?);
    let fails = |why: String| image.error(Problem::Picture(format!("{}: {why}", path.display())));
    let file = File::open(&path).map_err(|e| fails(e.to_string()))?;
    let (width, greys) = grey_picture(BufReader::new(file)).map_err(fails)?;
    let value = |grey: f32| (1.0 - grey) * lo + grey * hi;
    Ok((width, greys.into_iter().map(value).collect()))
}

/// Columns of a grey PNG, and its pixels as fractions of white, row after row.
fn grey_picture(file: impl std::io::BufRead + std::io::Seek) -> std::result::Result<(usize, Vec<f32>), String> {
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(png::Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(|e| e.to_string())?;
    let (width, height) = (header.width, header.height);
    if width > LONGEST || height > LONGEST {
        return Err(format!(
            "{width} x {height} pixels; no edge may be longer than {LONGEST}"
        ));
    }
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let bytes_needed = reader.output_buffer_size().ok_or("it is too large")?;
    let mut bytes = vec![0; bytes_needed];
    let frame = reader.next_frame(&mut bytes).map_err(|e| e.to_string())?;
    bytes.truncate(frame.buffer_size());
    let greys = match (frame.color_type, frame.bit_depth) {
        (png::ColorType::Grayscale, png::BitDepth::Sixteen) => {
            let pixels = bytes.chunks_exact(2);
            pixels
                .map(|p| f32::from(u16::from_be_bytes([p[0], p[1]])) / 65535.0)
                .collect()
        }
        (png::ColorType::Grayscale, _) => bytes.iter().map(|&p| f32::from(p) / 255.0).collect(),
        _ => return Err("it must be a grey PNG without transparency".into()),
    };
    Ok((width as usize, greys))
}
