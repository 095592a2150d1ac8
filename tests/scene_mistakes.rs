//! What each mistake in a scene is answered with, and where.

use std::path::Path;

use vcsg::scene::{NoVolumes, Scene, SceneError};

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("test.kdl", text, Path::new("."), &mut NoVolumes)
}

/// A line, the column that is at fault, and a part of the message.
type Mistake = (&'static str, usize, &'static str);

/// Lines indented by four in a `scene`.
const IN_SCENE: &[Mistake] = &[
    ("shpere radius=1", 5, "unknown node `shpere`"),
    ("sphere raduis=1", 12, "`sphere` has no property `raduis`"),
    ("sphere radius=1 radius=2", 21, "`radius` is given twice"),
    ("sphere", 5, "`sphere` needs the property `radius`"),
    ("sphere radius=-1", 12, "`radius` is -1; it must be above 0"),
    ("sphere radius=#nan", 12, "`radius` is #nan; it must be a finite number"),
    ("sphere radius=#inf", 12, "`radius` is #inf; it must be a finite number"),
    (
        "sphere radius=1e999",
        12,
        "`radius` is #inf; it must be a finite number",
    ),
    ("sphere radius=1 value=1e39", 21, "it must be at most 3.4e38 in size"),
    ("sphere radius=\"1\"", 12, "it must be a finite number"),
    (
        "sphere radius=1 center=\"0 nan 0\"",
        21,
        "it must be a string of 3 finite numbers",
    ),
    (
        "sphere radius=1 center=\"0 0\"",
        21,
        "it must be a string of 3 finite numbers",
    ),
    ("sphere radius=1 { box }", 5, "`sphere` has no children"),
    (
        "box min=\"0 0 0\" max=\"1 1 0\"",
        21,
        "it must be above `min` on each axis",
    ),
    (
        "half-space normal=\"0 0 0\"",
        16,
        "it must be a direction, not of length 0",
    ),
    (
        "cylinder radius=0 from=\"0 0 0\" to=\"0 0 1\"",
        14,
        "`radius` is 0; it must be above 0",
    ),
    (
        "cylinder radius=1 from=\"0 0 1\" to=\"0 0 1\"",
        36,
        "it must be another point than `from`",
    ),
    (
        "cone radius=1 top-radius=-1 from=\"0 0 0\" to=\"0 0 1\"",
        19,
        "`top-radius` is -1",
    ),
    ("torus radius=3 tube=3", 20, "it must be below `radius`"),
    ("ellipsoid radii=\"1 0 1\"", 15, "it must be above 0 on each axis"),
    (
        "box min=\"0 0 0\" max=\"4 4 4\" round=3",
        33,
        "at most half of the box's least extent",
    ),
    (
        "prism sides=2 radius=1 from=\"0 0 0\" to=\"0 0 1\"",
        11,
        "it must be a whole number in 3..64",
    ),
    (
        "thread radius=2 depth=2 pitch=1 turns=3",
        21,
        "it must be below `radius`",
    ),
    ("helix radius=9 tube=2 pitch=0 turns=3", 27, "`pitch` is 0"),
    (
        "polyhedron { corner \"0 0 0\"; corner \"1 0 0\"; corner \"0 1 0\"; corner \"1 1 0\" }",
        5,
        "do not all lie in one plane",
    ),
    (
        "waves size=\"9 9\" depth=2 amplitude=2",
        22,
        "it must be above `amplitude`",
    ),
    ("sphere radius=1 filter=-1", 21, "it must be in 0..64"),
    ("sphere radius=1 filter=#nan", 21, "it must be a finite number"),
    ("sphere radius=1 shell=0", 21, "`shell` is 0; it must be above 0"),
    (
        "helix radius=9 tube=2 pitch=5 turns=3 shell=1",
        43,
        "`helix` has no property `shell`",
    ),
    (
        "repeat count=0 { sphere radius=1 }",
        12,
        "it must be a whole number in 1..100000",
    ),
    ("union", 5, "`union` needs at least one child, and has 0"),
    (
        "subtract { sphere radius=1 }",
        5,
        "`subtract` needs at least two children, and has 1",
    ),
    (
        "union rule=\"frist\" { sphere radius=1 }",
        11,
        "it must be one of first, second",
    ),
    ("union rule=\"blend 2\" { sphere radius=1 }", 11, "with a share in 0..1"),
    (
        "union rule=\"max\" { lut first=\"0..1\" second=\"0..1\" { row \"1\" } }",
        11,
        "a `lut` is the rule itself",
    ),
    (
        "union { lut first=\"0..1\" second=\"0..1\" { row \"1 2\"; row \"1\" } }",
        61,
        "as long as the row above it",
    ),
    (
        "union { lut first=\"0..1\" second=\"0..1\" { row \"1 x\" } }",
        50,
        "a string of finite numbers",
    ),
    (
        "union { lut first=\"0..1\" second=\"0..1\" }",
        13,
        "or at least one `row`",
    ),
    (
        "union { lut first=\"1..1\" second=\"0..1\" { row \"1\" } }",
        13,
        "must rise",
    ),
    (
        "union { lut first=\"0..1\" { row \"1\" } }",
        13,
        "needs the property `second`",
    ),
    (
        "union { lut first=\"0..1\" second=\"0..1\" values=\"0..1\" { row \"1\" } }",
        44,
        "`values` says what black and white",
    ),
    (
        "union { lut first=\"0..1\" second=\"0..1\" image=\"no.png\" values=\"0..1\" }",
        44,
        "cannot read the table ./no.png",
    ),
    (
        "union { lut first=\"0..1\" second=\"0..1\" { row \"1\" }; lut first=\"0..1\" second=\"0..1\" { row \"1\" } }",
        57,
        "`lut` is given twice",
    ),
    (
        "translate { sphere radius=1 }",
        5,
        "`translate` takes 1 argument(s), and 0 are given",
    ),
    (
        "translate 1 2 3 { sphere radius=1 }",
        17,
        "`translate` takes 1 argument(s), and 3 are given",
    ),
    ("scale 0 { sphere radius=1 }", 5, "`scale` squeezes space flat"),
    (
        "matrix \"1 0 0 0 1 0 0 0 0 0 1 0\" { sphere radius=1 }",
        5,
        "`matrix` squeezes space flat",
    ),
    ("shear xy=1 yx=1 { sphere radius=1 }", 5, "`shear` squeezes space flat"),
    (
        "map cubic { sphere radius=1 }",
        9,
        "it must be one of linear, quadratic, table",
    ),
    (
        "map linear a=1 { sphere radius=1 }",
        16,
        "`scale` and `offset` are of a linear map",
    ),
    (
        "map table { at 1 0; at 1 1; sphere radius=1 }",
        28,
        "it must be above the point before it",
    ),
    (
        "map table { sphere radius=1 }",
        5,
        "at least one point `at INPUT OUTPUT`",
    ),
    ("use \"a\"", 9, "nothing named `a` is defined above this line"),
    ("define a { use a }", 20, "nothing named `a` is defined above this line"),
    ("include \"missing.kdl\"", 13, "cannot read"),
    ("volume \"head.nii.gz\"", 12, "cannot load the volume"),
    (
        "volume \"a.raw\" dims=\"1 2\" type=\"u8\"",
        20,
        "it must be a string of 3 finite numbers",
    ),
    (
        "volume \"a.raw\" dims=\"1 2 0\" type=\"u8\"",
        20,
        "three whole numbers above 0",
    ),
    (
        "volume \"a.raw\" dims=\"1 2 3\"",
        5,
        "`volume` needs the property `type`",
    ),
    ("volume \"a.raw\" type=\"u8\"", 20, "go with `dims`"),
    ("volume \"a.nrrd\" inside=\"80\"", 21, "a window like"),
    ("volume \"a.nrrd\" inside=\"9..1\"", 21, "a window like"),
    ("volume \"a.nrrd\" label=3", 21, "which part of a `mask`"),
    ("mask \"a.nrrd\" label=#true", 19, "a number, or a window"),
    ("mask \"a.nrrd\" inside=\"1..\"", 19, "`mask` has no property `inside`"),
    ("mask \"a.nrrd\" label=1", 10, "cannot load the volume"),
    ("point 0 opacity=0 color=\"#000000\"", 5, "unknown node `point`"),
    ("sphere radius=", 19, "Expected property value"),
    ("sphere radius=1 =", 21, "`=` does not belong here"),
    ("sphere radius=1,value=2", 20, "Expected property value"),
    ("sphere radius=1a", 20, ""),
    ("sphere (radius)=1", 12, "`(` does not belong here"),
];

/// Lines after a `scene`.
const AT_TOP: &[Mistake] = &[
    ("scene { sphere radius=1 }", 1, "`scene` is given twice"),
    ("veiw azimuth=1", 1, "unknown node `veiw`"),
    ("view fov=20", 6, "`fov` goes with"),
    ("view zoom=0", 6, "in 0.001..10000"),
    ("transfer preset=\"ct-bnoe\"", 10, "unknown preset `ct-bnoe`"),
    (
        "transfer { point 1 opacity=2 color=\"#000000\" }",
        20,
        "`opacity` is 2; it must be in 0..1",
    ),
    ("transfer { point 1 opacity=1 color=\"red\" }", 30, "a colour like"),
    (
        "transfer preset=\"ct-bone\" window=3",
        1,
        "`window` and `level` go together",
    ),
    (
        "transfer { point 2 opacity=1 color=\"#000000\"; point 1 opacity=1 color=\"#000000\" }",
        1,
        "transfer function: point 1",
    ),
    ("surface", 1, "`surface` needs the property `iso`"),
    ("surface 60", 9, "`surface`"),
    ("surface iso=#inf", 9, "a finite number"),
    ("surface iso=\"60\"", 9, "a finite number"),
    ("surface iso=60 iso=70", 16, "`iso` is given twice"),
    ("surface iso=60 color=\"red\"", 16, "a colour like"),
    (
        "surface iso=60 shading=\"flat\"",
        16,
        "it must be one of phong, gouraud",
    ),
    (
        "surface iso=60 topology=\"mc33\"",
        16,
        "it must be one of vtk, trilinear",
    ),
    ("surface iso=60 colour=\"#ffffff\"", 16, "no property `colour`"),
    ("surface iso=60 { sphere radius=1 }", 1, "`surface`"),
    ("surfice iso=60", 1, "unknown node `surfice`"),
    ("render mode=\"fancy\"", 8, "it must be one of composite, mip"),
    ("render size=\"0x7\"", 8, "a size like"),
    ("background \"blue\"", 12, "\"transparent\" or a colour"),
    ("material shininess=3", 10, "a power of two"),
    ("render shading=true", 16, "Expected identifier string"),
];

fn expect(text: &str, place: (usize, usize), message: &str) {
    let error = parse(text).expect_err(text);
    assert_eq!(error.place(), Some(place), "{error}\n{text}");
    assert!(error.problem().to_string().contains(message), "{error}\n{text}");
}

#[test]
fn a_mistake_in_the_tree_is_answered_with_its_place() {
    for (line, column, message) in IN_SCENE {
        expect(&format!("scene {{\n    {line}\n}}\n"), (2, *column), message);
    }
}

#[test]
fn a_mistake_at_the_top_is_answered_with_its_place() {
    for (line, column, message) in AT_TOP {
        expect(&format!("scene {{ sphere radius=1 }}\n{line}\n"), (2, *column), message);
    }
}

#[test]
fn what_is_missing_or_too_many_is_answered_with_its_place() {
    expect("view azimuth=1\n", (1, 1), "there is no `scene` node");
    expect("", (1, 1), "there is no `scene` node");
    expect(
        "scene {\n  union {\n sphere radius=1\n}\n",
        (1, 7),
        "this `{` is never closed",
    );
    let lights = "light towards=\"0 0 -1\"\n".repeat(6);
    expect(
        &format!("scene {{ sphere radius=1 }}\n{lights}"),
        (7, 1),
        "more than 5 lights",
    );
}

#[test]
fn levels_go_neither_with_surfaces_nor_with_coarsening() {
    let levels = "scene levels=4 { sphere radius=1 }\n";
    expect(&format!("{levels}surface iso=0.5\n"), (2, 1), "from one level");
    expect(&format!("surface iso=0.5\n{levels}"), (2, 1), "from one level");
    expect(
        "scene levels=4 coarsen=#true { sphere radius=1 }",
        (1, 1),
        "not coarsened",
    );
    expect("scene levels=9 { sphere radius=1 }", (1, 7), "in 1..8");
    expect("scene levels=1.5 { sphere radius=1 }", (1, 7), "whole number");
}

#[test]
fn a_misspelt_name_is_answered_with_the_right_one_and_the_line() {
    let error = parse("scene {\n    shpere radius=1\n}\n").unwrap_err();
    assert_eq!(error.to_string(), "test.kdl:2:5: unknown node `shpere`");
    let shown = format!("{:?}", miette::Report::new(error));
    for part in ["shpere radius=1", "did you mean `sphere`?", "test.kdl:2:5"] {
        assert!(shown.contains(part), "{shown}");
    }
}
