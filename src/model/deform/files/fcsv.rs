//! 3D Slicer's older lists of points, `.fcsv`: lines of values between commas, under a header of comments that names the axes and
//! the columns.

use std::fmt::Write;

use glam::DVec3;

use super::{NamedPoint, Wrong, turned};

/// The columns of files that do not name them.
const COLUMNS: &str = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// Where a line has what.
struct Columns {
    place: [usize; 3],
    label: Option<usize>,
}

impl Columns {
    fn named(names: &str) -> Option<Self> {
        let names: Vec<&str> = names.split(',').map(str::trim).collect();
        let find = |name: &str| names.iter().position(|n| *n == name);
        Some(Self {
            place: [find("x")?, find("y")?, find("z")?],
            label: find("label"),
        })
    }
}

/// Whether the coordinates are RAS, by the header's word. The oldest files say it by number, or not at all.
fn is_ras(said: &str) -> Option<bool> {
    match said {
        "RAS" | "0" => Some(true),
        "LPS" | "1" => Some(false),
        _ => None,
    }
}

pub(super) fn read(text: &str) -> Result<Vec<NamedPoint>, Wrong> {
    let mut ras = true;
    let mut columns = Columns::named(COLUMNS).expect("x, y and z");
    let mut points = Vec::new();
    for (n, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let Some(comment) = line.trim_start().strip_prefix('#') else {
            points.push(point(n + 1, line, &columns)?);
            continue;
        };
        match comment.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
            Some(("CoordinateSystem", said)) => {
                let unknown = || Wrong::at(n + 1, format!("coordinate system {said:?}; RAS and LPS are known"));
                ras = is_ras(said).ok_or_else(unknown)?;
            }
            Some(("columns", names)) => {
                let lacks = || Wrong::at(n + 1, "the columns lack x, y or z");
                columns = Columns::named(names).ok_or_else(lacks)?;
            }
            _ => {}
        }
    }
    if ras {
        points.iter_mut().for_each(|p| p.place = turned(p.place));
    }
    Ok(points)
}

fn point(number: usize, line: &str, columns: &Columns) -> Result<NamedPoint, Wrong> {
    let values = values(line);
    let mut place = [0.0; 3];
    for (place, column) in place.iter_mut().zip(columns.place) {
        let value = values.get(column).map(|v| v.trim());
        let bad = || Wrong::at(number, format!("{:?} is not a coordinate", value.unwrap_or("")));
        *place = value.and_then(|v| v.parse().ok()).ok_or_else(bad)?;
    }
    let label = columns
        .label
        .and_then(|column| values.get(column))
        .filter(|label| !label.is_empty());
    Ok(NamedPoint {
        name: label.cloned().unwrap_or_else(|| format!("of line {number}")),
        place: DVec3::from(place),
    })
}

/// The values of a line, some of which may stand between quotes; two quotes there are one.
fn values(line: &str) -> Vec<String> {
    let mut values = vec![String::new()];
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        let last = values.last_mut().expect("at least one");
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                last.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => values.push(String::new()),
            _ => last.push(c),
        }
    }
    values
}

pub(super) fn written(points: &[NamedPoint]) -> String {
    let mut text = format!("# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = {COLUMNS}\n");
    for (n, NamedPoint { name, place }) in points.iter().enumerate() {
        let name = match name.contains(['"', ',']) {
            true => format!("\"{}\"", name.replace('"', "\"\"")),
            false => name.replace(['\n', '\r'], " "),
        };
        let _ = writeln!(text, "{n},{},{},{},0,0,0,1,1,1,0,{name},,", place.x, place.y, place.z);
    }
    text
}
