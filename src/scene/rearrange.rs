//! Adding, removing and moving nodes in a scene's text.
//!
//! *Practice.* As with values, an edit touches the bytes of its node alone: comments and the layout of all else stay as they are.
//! A node gets a line of its own where its neighbours have one.

use std::ops::Range;

use kdl::{KdlDocument, KdlNode};

use super::edit::{bytes, end_of_entries, node_at};
use super::error::{Problem, SceneError};
use super::file;
use super::guard;
use super::source::Source;

/// The text of `source` with the node `text` as child `index` of the node at `parent`, or as the last one if it has fewer. The
/// path counts as in [`with_property`](super::with_property); an empty one means the top of the file.
///
/// # Errors
/// If the text is not KDL, or no node is at `parent`.
pub fn with_node(source: &Source, parent: &[usize], index: usize, text: &str) -> Result<Source, SceneError> {
    let document = file::parse(source)?;
    let whole = source.text();
    let siblings = siblings(&document, parent).ok_or_else(|| missing(source, parent))?;
    let (at, new) = match siblings.and_then(|siblings| siblings.nodes().get(index)) {
        Some(next) => before(whole, start_of(next), text),
        None if parent.is_empty() => at_end(whole, text),
        None => {
            let node = node_at(&document, parent).ok_or_else(|| missing(source, parent))?;
            as_last(whole, node, text)
        }
    };
    let mut edited = whole.to_owned();
    edited.insert_str(at, &new);
    Ok(Source::new(source.name(), edited))
}

/// The text of `source` without the node at `path`. Comments beside it stay.
///
/// # Errors
/// If the text is not KDL, or no node is at `path`.
pub fn without_node(source: &Source, path: &[usize]) -> Result<Source, SceneError> {
    let document = file::parse(source)?;
    let node = node_at(&document, path).ok_or_else(|| missing(source, path))?;
    let mut edited = source.text().to_owned();
    edited.replace_range(with_its_line(source.text(), range_of(source.text(), node)), "");
    Ok(Source::new(source.name(), edited))
}

/// The text of `source` with the node at `path` as child `index` of the node at `parent`; both say where things are before it is
/// moved.
///
/// # Errors
/// If the text is not KDL, no node is at either place, or the node is to be moved into itself.
pub fn with_node_moved(source: &Source, path: &[usize], parent: &[usize], index: usize) -> Result<Source, SceneError> {
    let document = file::parse(source)?;
    let node = node_at(&document, path).ok_or_else(|| missing(source, path))?;
    if parent.starts_with(path) {
        return Err(missing(source, parent));
    }
    let text = &source.text()[range_of(source.text(), node)];
    let twice = with_node(source, parent, index, text)?;
    let mut path = path.to_vec();
    let level = parent.len();
    if path.starts_with(parent) && path.get(level).is_some_and(|&at| at >= index) {
        path[level] += 1;
    }
    without_node(&twice, &path)
}

fn missing(source: &Source, path: &[usize]) -> SceneError {
    SceneError::of_file(source.name(), Problem::NoNode(path.to_vec()))
}

/// The children of the node at `parent`, if it has a block of them; `None` if there is no such node.
fn siblings<'a>(document: &'a KdlDocument, parent: &[usize]) -> Option<Option<&'a KdlDocument>> {
    if parent.is_empty() {
        return Some(Some(document));
    }
    node_at(document, parent).map(KdlNode::children)
}

/// The bytes of a node with its children, without its terminator and what is around it.
fn range_of(text: &str, node: &KdlNode) -> Range<usize> {
    start_of(node)..guard::end_of_node(text, end_of_entries(node).end)
}

fn start_of(node: &KdlNode) -> usize {
    let name = bytes(node.name().span()).start;
    node.ty()
        .map_or(name, |ty| bytes(ty.span()).start.saturating_sub(1).min(name))
}

/// What stands between the start of the line and `at`, if that is nothing but space.
fn indentation(text: &str, at: usize) -> Option<&str> {
    let line = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    let before = &text[line..at];
    before.trim_start_matches([' ', '\t']).is_empty().then_some(before)
}

fn before(text: &str, next: usize, new: &str) -> (usize, String) {
    match indentation(text, next) {
        Some(indent) => (next, format!("{new}\n{indent}")),
        None => (next, format!("{new}; ")),
    }
}

fn at_end(text: &str, new: &str) -> (usize, String) {
    let end_of_line = if text.is_empty() || text.ends_with('\n') {
        ""
    } else {
        "\n"
    };
    (text.len(), format!("{end_of_line}{new}\n"))
}

fn as_last(text: &str, parent: &KdlNode, new: &str) -> (usize, String) {
    let range = range_of(text, parent);
    let own = indentation(text, range.start).unwrap_or_default();
    let inner = format!("{own}    ");
    if parent.children().is_none() {
        return (end_of_entries(parent).end, format!(" {{\n{inner}{new}\n{own}}}"));
    }
    let brace = range.end - 1;
    if let Some(indent) = indentation(text, brace) {
        return (brace - indent.len(), format!("{inner}{new}\n"));
    }
    let inside = text[..brace].trim_end_matches([' ', '\t']).len();
    let separator = if text[..inside].ends_with(['{', ';']) { "" } else { ";" };
    let space = if text[..brace].ends_with('{') { " " } else { "" };
    (inside, format!("{separator} {new}{space}"))
}

/// A node's bytes with its semicolon, or with all of its line where nothing else is on it.
fn with_its_line(text: &str, range: Range<usize>) -> Range<usize> {
    let rest = &text[range.end..];
    let behind = rest.trim_start_matches([' ', '\t']);
    let semicolon = behind.strip_prefix(';').map(|after| rest.len() - after.len());
    let end = range.end + semicolon.unwrap_or(0);
    let blank = text[end..].trim_start_matches([' ', '\t', '\r']);
    match (indentation(text, range.start), blank.strip_prefix('\n')) {
        (Some(indent), Some(after)) => range.start - indent.len()..text.len() - after.len(),
        _ => range.start..end,
    }
}
