//! ImageJ's description of a stack: lines of `key=value`.

use super::Stack;
use super::pages::Pages;
use crate::volume::io::geometry::millimetres;

/// The most channels that ImageJ shows together. What has more, and but one slice, is a stack whose writer was not told what its axes
/// are: tifffile then calls them channels.
const MOST_CHANNELS: usize = 7;

/// What `description` says of the pages; `None` where it is not ImageJ's. Channels follow each other fastest, then slices, then
/// times.
pub(super) fn stack(description: &str, pages: &Pages) -> Option<Stack> {
    if !description.starts_with("ImageJ=") {
        return None;
    }
    let value = |key: &str| {
        description
            .lines()
            .find_map(|line| line.strip_prefix(key)?.strip_prefix('='))
    };
    let number = |key: &str| value(key).and_then(|text| text.trim().parse::<usize>().ok());
    let count = |key: &str| number(key).unwrap_or(1).max(1);
    let images = number("images").unwrap_or(1).max(pages.count());
    let (channels, frames) = (count("channels"), count("frames"));
    let others = channels.saturating_mul(frames);
    let slices = number("slices").unwrap_or(images / others).max(1);
    let are_slices = channels > MOST_CHANNELS && slices == 1 && frames == 1;
    let (slices, channels) = if are_slices { (channels, 1) } else { (slices, channels) };
    let unit = value("unit").map(unescaped).unwrap_or_default();
    let mut stack = Stack::plain(slices, [None; 3]);
    stack.sizes = [slices, channels, frames];
    stack.strides = [channels, 1, channels.saturating_mul(slices)];
    if are_slices {
        let note =
            format!("ImageJ has no more than {MOST_CHANNELS} channels: the {slices} that the file says are slices");
        stack.notes.push(note);
    }
    match length(unit.trim()) {
        None => stack.spacing = pages.resolution.millimetres(),
        Some(unit) => {
            let depth = value("spacing").and_then(|text| text.trim().parse::<f64>().ok());
            let depth = depth.map(f64::abs).filter(|d| d.is_normal());
            let [x, y] = pages.resolution.pixels.map(|n| n.map(|n| unit / n));
            stack.spacing = [x, y, depth.map(|d| d * unit)];
        }
    }
    Some(stack)
}

/// Millimetres in the unit that ImageJ calls `name`; `None` where that is no length.
fn length(name: &str) -> Option<f64> {
    match name {
        "" | "pixel" | "pixels" => None,
        "inch" | "inches" | "in" | "\"" => Some(25.4),
        "mm" | "millimeter" | "millimetre" | "millimeters" => Some(1.0),
        name => match millimetres(name) {
            1.0 => None,
            unit => Some(unit),
        },
    }
}

/// `text`, with `\u00B5` and the like as the characters they stand for.
fn unescaped(text: &str) -> String {
    let mut parts = text.split("\\u");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let code = part.get(..4).and_then(|digits| u32::from_str_radix(digits, 16).ok());
        match code.and_then(char::from_u32) {
            Some(c) => {
                plain.push(c);
                plain.push_str(&part[4..]);
            }
            None => {
                plain.push_str("\\u");
                plain.push_str(part);
            }
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_lengths_or_none() {
        assert_eq!(length(&unescaped("\\u00B5m")), Some(1e-3));
        assert_eq!(length(&unescaped("\\u03BCm")), Some(1e-3));
        assert_eq!(length("micron"), Some(1e-3));
        assert_eq!(length("millimeter"), Some(1.0));
        assert_eq!(length("pixel"), None);
        assert_eq!(length("sec"), None);
        assert_eq!(unescaped("\\uXYZ"), "\\uXYZ");
        assert_eq!(unescaped("a\\u00é"), "a\\u00é");
    }
}
