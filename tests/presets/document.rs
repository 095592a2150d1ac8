//! What docs/PRESETS.md says of each preset.

use vcsg::projection::presets::{self, Kind, Preset, Scale};

/// The preset's row of the table.
fn row(preset: &Preset) -> String {
    let look = preset.look();
    let light = if look.material.is_some() { "shaded" } else { "flat" };
    let unit = preset.own_function().unit_mm();
    let unit = match preset.kind() {
        Kind::Any => format!("{unit}/200"),
        Kind::Ct | Kind::Mr => format!("{unit} mm"),
    };
    format!(
        "| `{}` | {} | {} | {} {light} | {unit} | {} |",
        preset.name(),
        preset.scale().name(),
        shown(preset),
        look.mode.name(),
        preset.description()
    )
}

/// The values that it shows.
fn shown(preset: &Preset) -> String {
    let shown = preset.shown();
    let end = |value: f32| {
        if value.is_finite() {
            value.to_string()
        } else {
            String::new()
        }
    };
    format!("{}..{}", end(shown.lo), end(shown.hi))
}

#[test]
fn the_document_has_each_preset_as_it_is() {
    let text = include_str!("../../docs/PRESETS.md");
    let rows: Vec<_> = presets::all().iter().map(row).collect();
    let missing: Vec<_> = rows.iter().filter(|row| !text.contains(*row)).cloned().collect();
    assert!(missing.is_empty(), "docs/PRESETS.md lacks:\n{}", missing.join("\n"));
    let listed = text.lines().filter(|line| line.starts_with("| `")).count();
    assert_eq!(listed, rows.len(), "rows of presets that are not there");
}

#[test]
fn numbers_lie_where_their_scale_has_them() {
    for preset in presets::all() {
        let (lo, hi) = match preset.scale() {
            Scale::Absolute if preset.kind() == Kind::Ct => (-1024.0, 3071.0),
            Scale::Absolute => (0.0, 255.0),
            // Beyond the window are the half per cent that is brightest.
            Scale::Window => (0.0, 2.0),
            Scale::Signed => (-1.0, 1.0),
            // As far above the second tissue as the first is below it, and half as far again.
            Scale::Modes => (0.0, 3.5),
        };
        let window = preset.own_function().window();
        assert!(lo <= window.lo && window.hi <= hi, "{}: {window:?}", preset.name());
    }
}
