//! Changing values in a scene's text.
//!
//! *Practice.* An edit replaces the bytes of one value and touches no other, so comments and layout survive by
//! construction, whatever a printer would make of them.

use std::ops::Range;

use kdl::{KdlDocument, KdlEntry, KdlNode, KdlValue};

use super::error::{Problem, SceneError};
use super::file;
use super::source::Source;
use crate::projection::{Projection, View};

/// The text of `source` with property `key` of the node at `path` set to `value`, or taken away if that is `None`.
///
/// `path` says which node to go to at each level, counted from 0; commented-out nodes do not count. A property that is not
/// there yet is added after the last one.
///
/// # Errors
/// If the text is not KDL, or no node is at `path`.
pub fn with_property(
    source: &Source,
    path: &[usize],
    key: &str,
    value: Option<KdlValue>,
) -> Result<Source, SceneError> {
    let document = file::parse(source)?;
    let missing = || SceneError::of_file(source.name(), Problem::NoNode(path.to_vec()));
    let node = node_at(&document, path).ok_or_else(missing)?;
    let property = value.map(|value| KdlEntry::new_prop(key, value).to_string());
    let (at, new) = match (node.entry(key), property) {
        (Some(entry), Some(property)) => (bytes(entry.span()), property),
        (Some(entry), None) => (with_space_before(source.text(), bytes(entry.span())), String::new()),
        (None, Some(property)) => (end_of_entries(node), format!(" {property}")),
        (None, None) => (0..0, String::new()),
    };
    let mut text = source.text().to_owned();
    text.replace_range(at, &new);
    Ok(Source::new(source.name(), text))
}

/// The text of `source` with argument `index` of the node at `path` set to `value`.
///
/// # Errors
/// If the text is not KDL, no node is at `path`, or it has fewer arguments.
pub fn with_argument(source: &Source, path: &[usize], index: usize, value: KdlValue) -> Result<Source, SceneError> {
    let document = file::parse(source)?;
    let missing = || SceneError::of_file(source.name(), Problem::NoNode(path.to_vec()));
    let node = node_at(&document, path).ok_or_else(missing)?;
    let argument = node.entries().iter().filter(|entry| entry.name().is_none()).nth(index);
    let at = bytes(argument.ok_or_else(missing)?.span());
    let mut text = source.text().to_owned();
    text.replace_range(at, &KdlEntry::new(value).to_string());
    Ok(Source::new(source.name(), text))
}

/// The text of `source` with its `view` node made to say `view`; the node is added at the end if there is none.
///
/// # Errors
/// If the text is not KDL.
pub(super) fn with_view(source: &Source, view: &View) -> Result<Source, SceneError> {
    let document = file::parse(source)?;
    let is_view = |node: &KdlNode| node.name().value() == "view";
    let Some(place) = document.nodes().iter().position(is_view) else {
        let end_of_line = if source.text().ends_with('\n') { "" } else { "\n" };
        let text = format!("{}{end_of_line}view\n", source.text());
        return with_view(&Source::new(source.name(), text), view);
    };
    let unchanged = |key: &str, value: &Option<KdlValue>| document.nodes()[place].get(key) == value.as_ref();
    let mut edited = source.clone();
    for (key, value) in view_properties(view) {
        if !unchanged(key, &value) {
            edited = with_property(&edited, &[place], key, value)?;
        }
    }
    Ok(edited)
}

/// What a `view` node says; `None` for what goes without saying.
fn view_properties(view: &View) -> [(&'static str, Option<KdlValue>); 7] {
    let unless = |number: f64, default: f64| (number != default).then_some(KdlValue::Float(number));
    let fov_y_deg = match view.projection {
        Projection::Orthographic => None,
        Projection::Perspective { fov_y_deg } => Some(fov_y_deg),
    };
    let focus = view.focus.map(|p| KdlValue::String(format!("{} {} {}", p.x, p.y, p.z)));
    [
        ("azimuth", unless(view.azimuth_deg, 0.0)),
        ("elevation", unless(view.elevation_deg, 0.0)),
        ("roll", unless(view.roll_deg, 0.0)),
        ("zoom", unless(view.zoom, 1.0)),
        ("projection", fov_y_deg.map(|_| "perspective".into())),
        ("fov", fov_y_deg.map(KdlValue::Float)),
        ("focus", focus),
    ]
}

pub(super) fn node_at<'a>(document: &'a KdlDocument, path: &[usize]) -> Option<&'a KdlNode> {
    let (&first, rest) = path.split_first()?;
    let node = document.nodes().get(first)?;
    if rest.is_empty() {
        Some(node)
    } else {
        node_at(node.children()?, rest)
    }
}

pub(super) fn end_of_entries(node: &KdlNode) -> Range<usize> {
    let last = node.entries().last().map_or(node.name().span(), KdlEntry::span);
    let end = bytes(last).end;
    end..end
}

/// The range with one space before it, if there is one.
fn with_space_before(text: &str, range: Range<usize>) -> Range<usize> {
    let spaced = text[..range.start].ends_with(' ');
    range.start - usize::from(spaced)..range.end
}

pub(super) fn bytes(span: miette::SourceSpan) -> Range<usize> {
    span.offset()..span.offset() + span.len()
}
