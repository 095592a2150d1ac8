//! OME-XML: which page is which plane, and how large a voxel is.

use std::path::Path;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::Stack;
use super::pages::Pages;
use crate::volume::io::error::ReadError;
use crate::volume::io::geometry::millimetres;

/// A run of planes on pages.
#[derive(Default)]
struct Run {
    /// Slice, channel and time of the first.
    first: [usize; 3],
    /// Its page among the file's directories, and how many planes follow; `None` for all.
    page: usize,
    planes: Option<usize>,
    /// The file that has them, if that is said.
    file: Option<String>,
}

/// The first image of a file.
#[derive(Default)]
struct Pixels {
    /// Slices, channels and times.
    sizes: [usize; 3],
    /// The axes of `sizes`, the fastest first.
    order: Vec<usize>,
    spacing: [Option<f64>; 3],
    runs: Vec<Run>,
    /// How many images there are.
    images: usize,
}

/// What OME's `description` says of the pages.
pub(super) fn stack(path: &Path, description: &str, pages: &Pages) -> Result<Stack, ReadError> {
    let bad = |what: String| ReadError::header(path, format!("its OME-XML {what}"));
    let pixels = parse(description).map_err(bad)?;
    let mut stack = Stack::plain(1, pixels.spacing);
    stack.sizes = pixels.sizes;
    if pages.layout.samples > 1 {
        // Channels that are samples of a pixel are on one page.
        stack.sizes[1] = (stack.sizes[1] / pages.layout.samples).max(1);
    }
    let mut stride = 1_usize;
    for &axis in &pixels.order {
        stack.strides[axis] = stride;
        stride = stride.saturating_mul(stack.sizes[axis]);
    }
    if pixels.images > 1 {
        stack.notes.push(format!("the first of {} images", pixels.images));
    }
    stack.pages = placed(&stack, &pixels, pages).map_err(bad)?;
    Ok(stack)
}

/// The page of each plane; `None` where they follow each other.
fn placed(stack: &Stack, pixels: &Pixels, pages: &Pages) -> Result<Option<Vec<usize>>, String> {
    if stack.planes() > pages.count() {
        let what = format!(
            "asks for {} planes, the file has {} pages of them",
            stack.planes(),
            pages.count()
        );
        return Err(what);
    }
    // Files are renamed, so one name that all planes have means this file.
    let mut names: Vec<_> = pixels.runs.iter().filter_map(|run| run.file.as_deref()).collect();
    names.sort_unstable();
    names.dedup();
    if names.len() > 1 {
        return Err(format!("puts planes in {} files: join them first", names.len()));
    }
    if pixels.runs.is_empty() {
        return Ok(None);
    }
    let mut found = vec![None; stack.planes()];
    for run in &pixels.runs {
        let first: usize = (0..3)
            .map(|axis| run.first[axis].saturating_mul(stack.strides[axis]))
            .sum();
        let most = stack.planes().saturating_sub(first);
        for i in 0..run.planes.unwrap_or(most).min(most) {
            found[first + i] = pages.index(run.page.saturating_add(i));
        }
    }
    let all: Option<Vec<usize>> = found.into_iter().collect();
    all.map(Some).ok_or_else(|| "names no page for some planes".to_owned())
}

fn parse(description: &str) -> Result<Pixels, String> {
    let mut xml = Reader::from_str(description);
    let mut pixels = Pixels::default();
    loop {
        match xml.read_event().map_err(|e| format!("is no XML: {e}"))? {
            Event::Start(element) | Event::Empty(element) => match (element.local_name().as_ref(), pixels.images) {
                ("Pixels", 0) => {
                    pixels = Pixels {
                        images: 1,
                        ..sizes(&element)?
                    };
                }
                ("Pixels", _) => pixels.images += 1,
                ("TiffData", 1) => pixels.runs.push(run(&element)),
                ("UUID", 1) => {
                    if let Some(run) = pixels.runs.last_mut() {
                        run.file = get(&element, "FileName");
                    }
                }
                _ => {}
            },
            Event::Eof => break,
            _ => {}
        }
    }
    match pixels.images {
        0 => Err("has no Pixels".to_owned()),
        _ => Ok(pixels),
    }
}

fn get(element: &BytesStart, name: &str) -> Option<String> {
    let attribute = element.try_get_attribute(name).ok()??;
    attribute
        .normalized_value(XmlVersion::Implicit1_0)
        .ok()
        .map(String::from)
}

fn number(element: &BytesStart, name: &str) -> Option<usize> {
    get(element, name)?.trim().parse().ok()
}

fn sizes(element: &BytesStart) -> Result<Pixels, String> {
    let size = |name: &str| match number(element, name) {
        None | Some(0) => Err(format!("has no {name}")),
        Some(size) => Ok(size),
    };
    let order = get(element, "DimensionOrder").unwrap_or_else(|| "XYZCT".to_owned());
    let order: Vec<usize> = order.chars().filter_map(|axis| "ZCT".find(axis)).collect();
    if order.len() != 3 || (0..3).any(|axis| !order.contains(&axis)) {
        return Err("has a DimensionOrder that is none".to_owned());
    }
    let spacing = ["X", "Y", "Z"].map(|axis| {
        let size: f64 = get(element, &format!("PhysicalSize{axis}"))?.trim().parse().ok()?;
        let unit = get(element, &format!("PhysicalSize{axis}Unit")).unwrap_or_else(|| "µm".to_owned());
        let unit = match unit.as_str() {
            "pixel" | "reference frame" => return None,
            "in" => 25.4,
            "Å" => 1e-7,
            "pm" => 1e-9,
            "dm" => 100.0,
            unit => millimetres(unit),
        };
        Some(size * unit).filter(|mm| mm.is_normal() && *mm > 0.0)
    });
    Ok(Pixels {
        sizes: [size("SizeZ")?, size("SizeC")?, size("SizeT")?],
        order,
        spacing,
        ..Pixels::default()
    })
}

fn run(element: &BytesStart) -> Run {
    let number = |name| number(element, name);
    let page = number("IFD");
    Run {
        first: ["FirstZ", "FirstC", "FirstT"].map(|name| number(name).unwrap_or(0)),
        page: page.unwrap_or(0),
        planes: number("PlaneCount").or(page.map(|_| 1)),
        file: None,
    }
}
