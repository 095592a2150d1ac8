//! What nodes there are, and what each may hold: the scene language as a table.

/// What the children of a node are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Children {
    /// There are none.
    None,
    /// Nodes of the tree.
    Shapes,
    /// Nodes of the tree, and the points of a table.
    ShapesAndTable,
    /// Nodes of the tree, and a table of two values.
    ShapesAndLut,
    /// Nodes of the tree, and control points.
    ShapesAndPoints,
    /// The rows of a table.
    Rows,
    /// Nodes of the tree, and landmarks.
    ShapesAndPairs,
    /// Nodes of the tree, a table of two values, and how they are seen.
    ShapesAndLook,
    /// Control points.
    Points,
    /// The corners of a solid.
    Corners,
    /// Tracks of values over time.
    Tracks,
    /// Key frames.
    Keys,
}

/// One kind of node.
#[derive(Debug)]
pub(super) struct Rule {
    pub name: &'static str,
    /// How many arguments it takes.
    pub arguments: usize,
    pub properties: &'static [&'static str],
    pub children: Children,
    /// How it is written.
    pub example: &'static str,
}

const fn rule(
    name: &'static str,
    arguments: usize,
    properties: &'static [&'static str],
    children: Children,
    example: &'static str,
) -> Rule {
    Rule {
        name,
        arguments,
        properties,
        children,
        example,
    }
}

use Children::{
    Corners, Keys, None as Leaf, Points, Rows, Shapes, ShapesAndLook, ShapesAndLut, ShapesAndPairs, ShapesAndPoints,
    ShapesAndTable, Tracks,
};

const TRANSFER: Rule = rule(
    "transfer",
    0,
    &["preset", "file", "window", "level", "unit-mm"],
    Points,
    "transfer preset=\"ct-bone\"",
);

const OPTICS: Rule = rule(
    "optics",
    0,
    &["reflect", "transmit", "index", "tint", "tint-mm"],
    Leaf,
    "optics transmit=1 index=1.5",
);

/// How an object is seen.
pub(super) const LOOK: &[Rule] = &[TRANSFER, OPTICS];

/// Nodes at the top of a file.
pub(super) const TOP: &[Rule] = &[
    rule(
        "scene",
        0,
        &[
            "spacing",
            "budget-mib",
            "coarsen",
            "boundary",
            "min-block",
            "levels",
            "rule",
            "family",
        ],
        ShapesAndLut,
        "scene { … }",
    ),
    rule(
        "object",
        0,
        &[
            "spacing",
            "budget-mib",
            "coarsen",
            "boundary",
            "min-block",
            "levels",
            "rule",
            "family",
        ],
        ShapesAndLook,
        "object { optics reflect=0.8; sphere radius=20 }",
    ),
    TRANSFER,
    OPTICS,
    rule(
        "surface",
        0,
        &["iso", "color", "shading", "topology"],
        Leaf,
        "surface iso=60 color=\"#e8c9b0\"",
    ),
    rule(
        "view",
        0,
        &["azimuth", "elevation", "roll", "zoom", "projection", "fov", "focus"],
        Leaf,
        "view azimuth=30 elevation=20",
    ),
    rule(
        "light",
        0,
        &["towards", "at", "u", "v", "intensity"],
        Leaf,
        "light towards=\"-0.5 -0.6 -1\" intensity=0.9",
    ),
    rule(
        "trace",
        0,
        &["samples", "depth", "light-parts", "seed"],
        Leaf,
        "trace samples=16",
    ),
    rule(
        "material",
        0,
        &["ambient", "diffuse", "specular", "shininess", "soft-gradient"],
        Leaf,
        "material ambient=0.2",
    ),
    rule("depth-cue", 0, &["strength"], Leaf, "depth-cue strength=0.4"),
    rule("background", 1, &[], Leaf, "background \"#101820\""),
    rule(
        "render",
        0,
        &["mode", "shading", "samples-per-voxel", "size"],
        Leaf,
        "render mode=\"mip\" size=\"1024x768\"",
    ),
    rule("animation", 0, &["frames", "fps"], Tracks, "animation frames=120 { … }"),
];

/// Nodes of the tree.
pub(super) const SHAPES: &[Rule] = &[
    rule(
        "volume",
        1,
        &[
            "inside",
            "mask",
            "label",
            "frame",
            "series",
            "array",
            "component",
            "resolution",
            "resample",
            "dims",
            "type",
            "spacing",
            "endian",
            "skip",
        ],
        Leaf,
        "volume \"head.nii.gz\"",
    ),
    rule(
        "mask",
        1,
        &[
            "label",
            "value",
            "frame",
            "series",
            "array",
            "component",
            "resolution",
            "resample",
            "dims",
            "type",
            "spacing",
            "endian",
            "skip",
        ],
        Leaf,
        "mask \"labels.nrrd\" label=3",
    ),
    rule(
        "sphere",
        0,
        &["center", "radius", "value", "filter", "shell"],
        Leaf,
        "sphere radius=20 center=\"0 0 0\"",
    ),
    rule(
        "ellipsoid",
        0,
        &["center", "radii", "value", "filter", "shell"],
        Leaf,
        "ellipsoid radii=\"30 20 10\"",
    ),
    rule(
        "box",
        0,
        &["min", "max", "round", "value", "filter", "shell"],
        Leaf,
        "box min=\"-1 -1 -1\" max=\"1 1 1\"",
    ),
    rule(
        "half-space",
        0,
        &["point", "normal", "value", "filter", "shell"],
        Leaf,
        "half-space point=\"0 0 0\" normal=\"0 0 1\"",
    ),
    rule(
        "cylinder",
        0,
        &["from", "to", "radius", "value", "filter", "shell"],
        Leaf,
        "cylinder radius=6 from=\"0 0 -40\" to=\"0 0 60\"",
    ),
    rule(
        "cone",
        0,
        &["from", "to", "radius", "top-radius", "value", "filter", "shell"],
        Leaf,
        "cone radius=20 from=\"0 0 0\" to=\"0 0 40\"",
    ),
    rule(
        "capsule",
        0,
        &["from", "to", "radius", "value", "filter", "shell"],
        Leaf,
        "capsule radius=5 from=\"0 0 0\" to=\"0 0 30\"",
    ),
    rule(
        "prism",
        0,
        &["from", "to", "radius", "sides", "value", "filter", "shell"],
        Leaf,
        "prism sides=6 radius=10 from=\"0 0 0\" to=\"0 0 8\"",
    ),
    rule(
        "torus",
        0,
        &["center", "axis", "radius", "tube", "value", "filter", "shell"],
        Leaf,
        "torus radius=20 tube=5",
    ),
    rule(
        "helix",
        0,
        &["center", "axis", "radius", "tube", "pitch", "turns", "value", "filter"],
        Leaf,
        "helix radius=20 tube=2 pitch=8 turns=5",
    ),
    rule(
        "thread",
        0,
        &[
            "center", "axis", "radius", "depth", "angle", "pitch", "turns", "value", "filter",
        ],
        Leaf,
        "thread radius=10 depth=2 pitch=3 turns=8",
    ),
    rule(
        "polyhedron",
        0,
        &["value", "filter", "shell"],
        Corners,
        "polyhedron { corner \"0 0 0\"; … }",
    ),
    rule(
        "waves",
        0,
        &[
            "center",
            "axis",
            "size",
            "depth",
            "amplitude",
            "wavelength-x",
            "wavelength-y",
            "value",
            "filter",
        ],
        Leaf,
        "waves size=\"80 80\" depth=8 amplitude=3 wavelength-x=20",
    ),
    rule("mesh", 1, &["unit-mm", "value", "filter"], Leaf, "mesh \"part.stl\""),
    rule("union", 0, &["rule", "family"], ShapesAndLut, "union { … }"),
    rule("intersect", 0, &["rule", "family"], ShapesAndLut, "intersect { … }"),
    rule("subtract", 0, &["rule", "family"], ShapesAndLut, "subtract { … }"),
    rule(
        "overlay",
        0,
        &["rule", "family"],
        ShapesAndLut,
        "overlay rule=\"second\" { … }",
    ),
    rule("translate", 1, &[], Shapes, "translate \"10 0 0\" { … }"),
    rule(
        "rotate",
        0,
        &["axis", "angle", "center"],
        Shapes,
        "rotate axis=\"0 0 1\" angle=30 { … }",
    ),
    rule(
        "scale",
        1,
        &["center"],
        Shapes,
        "scale 2 { … } or scale \"1 1 2\" { … }",
    ),
    rule(
        "mirror",
        0,
        &["point", "normal"],
        Shapes,
        "mirror normal=\"1 0 0\" { … }",
    ),
    rule(
        "shear",
        0,
        &["xy", "xz", "yx", "yz", "zx", "zy", "center"],
        Shapes,
        "shear xy=0.5 { … }",
    ),
    rule("matrix", 1, &[], Shapes, "matrix \"1 0 0 0  0 1 0 0  0 0 1 0\" { … }"),
    rule(
        "deform",
        0,
        &["landmarks", "from", "to", "stiffness", "support", "error"],
        ShapesAndPairs,
        "deform landmarks=\"pairs.txt\" { … }",
    ),
    rule(
        "map",
        1,
        &["scale", "offset", "a", "b", "c"],
        ShapesAndTable,
        "map \"linear\" scale=2 { … }, map \"quadratic\" a=1 { … } or map \"table\" { at 0 0; at 100 255; … }",
    ),
    rule(
        "classify",
        0,
        &["preset", "window", "level", "unit-mm"],
        ShapesAndPoints,
        "classify preset=\"ct-bone\" { … } or classify { point 300 opacity=0.2 color=\"#f0e0d0\"; … }",
    ),
    rule(
        "cut",
        0,
        &["point", "normal", "filter"],
        Shapes,
        "cut point=\"0 0 0\" normal=\"0 1 0\" { … }",
    ),
    rule("complement", 0, &["family", "value"], Shapes, "complement { … }"),
    rule(
        "repeat",
        0,
        &["count", "by", "axis", "angle", "center", "rule", "family"],
        ShapesAndLut,
        "repeat count=12 angle=30 { … }",
    ),
    rule("define", 1, &[], Shapes, "define \"name\" { … }"),
    rule("use", 1, &[], Leaf, "use \"name\""),
    rule("include", 1, &[], Leaf, "include \"other.kdl\""),
];

/// A point of a value table.
pub(super) const AT: &[Rule] = &[rule("at", 2, &[], Leaf, "at 100 255")];

/// A table of two values.
pub(super) const LUT: &[Rule] = &[rule(
    "lut",
    0,
    &["first", "second", "image", "values"],
    Rows,
    "lut first=\"0..255\" second=\"0..255\" { row \"0 100\"; row \"100 255\" }",
)];

/// A row of a table.
pub(super) const ROW: &[Rule] = &[rule("row", 1, &[], Leaf, "row \"0 100 255\"")];

/// A landmark of a deformation.
pub(super) const PAIR: &[Rule] = &[rule(
    "pair",
    0,
    &["from", "to", "name"],
    Leaf,
    "pair from=\"0 0 0\" to=\"5 0 0\"",
)];

/// A control point of a transfer function.
pub(super) const POINT: &[Rule] = &[rule(
    "point",
    1,
    &["opacity", "color"],
    Leaf,
    "point 300 opacity=0.2 color=\"#f0e0d0\"",
)];

/// A value of an animation.
pub(super) const TRACK: &[Rule] = &[rule(
    "track",
    1,
    &["property", "ease"],
    Keys,
    "track \"view\" property=\"azimuth\" { at 0 0; at 119 360 }",
)];

/// A corner of a polyhedron.
pub(super) const CORNER: &[Rule] = &[rule("corner", 1, &[], Leaf, "corner \"0 0 10\"")];

/// The groups of rules that hold among the children of a node.
pub(super) fn inside(children: Children) -> &'static [&'static [Rule]] {
    match children {
        Children::None => &[],
        Children::Shapes => &[SHAPES],
        Children::ShapesAndTable => &[SHAPES, AT],
        Children::ShapesAndLut => &[SHAPES, LUT],
        Children::ShapesAndPoints => &[SHAPES, POINT],
        Children::Rows => &[ROW],
        Children::ShapesAndPairs => &[SHAPES, PAIR],
        Children::ShapesAndLook => &[SHAPES, LUT, LOOK],
        Children::Points => &[POINT],
        Children::Corners => &[CORNER],
        Children::Tracks => &[TRACK],
        Children::Keys => &[AT],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_document_names_every_node_and_property() {
        let text = include_str!("../../docs/SCENE.md");
        let documented = |name: &str, ends: &[char]| ends.iter().any(|end| text.contains(&format!("`{name}{end}")));
        for rule in [TOP, LOOK, SHAPES, AT, LUT, ROW, POINT, CORNER, PAIR, TRACK]
            .into_iter()
            .flatten()
        {
            assert!(documented(rule.name, &['`', ' ']), "{}", rule.name);
            for property in rule.properties {
                assert!(documented(property, &['`', '=']), "{} of {}", property, rule.name);
            }
        }
    }
}
