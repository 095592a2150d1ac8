//! 3D Slicer's `.vp.json`.

use serde::Deserialize;
use serde_json::{Value, json};

use super::{GRADIENT_OPACITY, Node, Parts, Reading, VolumeProperty, Wrong, changes, check, check_count, material};
use crate::projection::ControlPoint;

const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#";

/// What every schema of volume properties has in its name.
const SCHEMA_NAME: &str = "volume-property-schema-v";

#[derive(Deserialize)]
struct File {
    #[serde(rename = "@schema", default)]
    schema: String,
    #[serde(rename = "volumeProperties", default)]
    properties: Vec<Property>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Property {
    #[serde(default)]
    iso_surface_values: Vec<f64>,
    #[serde(default)]
    components: Vec<Component>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Component {
    #[serde(default)]
    shade: bool,
    #[serde(default)]
    lighting: Lighting,
    #[serde(default)]
    disable_gradient_opacity: bool,
    #[serde(default = "one")]
    scalar_opacity_unit_distance: f64,
    rgb_transfer_function: Option<Function<ColorPoint>>,
    gray_transfer_function: Option<Function<Point>>,
    scalar_opacity: Option<Function<Point>>,
    gradient_opacity: Option<Function<Point>>,
}

/// Where nothing is said, as VTK has it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Lighting {
    ambient: f64,
    diffuse: f64,
    specular: f64,
    specular_power: f64,
}

impl Default for Lighting {
    fn default() -> Self {
        Self {
            ambient: 0.1,
            diffuse: 0.7,
            specular: 0.2,
            specular_power: 10.0,
        }
    }
}

#[derive(Deserialize)]
struct Function<P> {
    points: Vec<P>,
}

#[derive(Deserialize)]
struct Point {
    x: f64,
    y: f64,
    #[serde(default = "half")]
    midpoint: f64,
    #[serde(default)]
    sharpness: f64,
}

#[derive(Deserialize)]
struct ColorPoint {
    x: f64,
    color: [f64; 3],
    #[serde(default = "half")]
    midpoint: f64,
    #[serde(default)]
    sharpness: f64,
}

fn one() -> f64 {
    1.0
}

fn half() -> f64 {
    0.5
}

impl Point {
    fn node<const N: usize>(&self) -> Node<N> {
        Node {
            x: self.x,
            y: [self.y; N],
            midpoint: self.midpoint,
            sharpness: self.sharpness,
        }
    }
}

impl ColorPoint {
    fn node(&self) -> Node<3> {
        Node {
            x: self.x,
            y: self.color,
            midpoint: self.midpoint,
            sharpness: self.sharpness,
        }
    }
}

/// The nodes of a function called `name`, each checked.
fn nodes<P, const N: usize>(
    name: &str,
    function: &Function<P>,
    node: impl Fn(&P) -> Node<N>,
) -> Result<Vec<Node<N>>, Wrong> {
    check_count(name, function.points.len()).map_err(Wrong::whole)?;
    let checked = |(i, point): (usize, &P)| {
        let node = node(point);
        check(name, i + 1, &node).map(|()| node).map_err(Wrong::whole)
    };
    function.points.iter().enumerate().map(checked).collect()
}

impl Component {
    fn color(&self) -> Result<Vec<Node<3>>, Wrong> {
        match (&self.rgb_transfer_function, &self.gray_transfer_function) {
            (Some(rgb), _) => nodes("rgbTransferFunction", rgb, ColorPoint::node),
            (None, Some(grey)) => nodes("grayTransferFunction", grey, Point::node),
            (None, None) => Err(Wrong::whole(
                "the first component has neither rgbTransferFunction nor grayTransferFunction",
            )),
        }
    }

    fn opacity(&self) -> Result<Vec<Node<1>>, Wrong> {
        let missing = || Wrong::whole("the first component has no scalarOpacity");
        nodes(
            "scalarOpacity",
            self.scalar_opacity.as_ref().ok_or_else(missing)?,
            Point::node,
        )
    }

    fn has_gradient_opacity(&self) -> bool {
        let nodes = |f: &Function<Point>| f.points.iter().map(Point::node).collect::<Vec<_>>();
        !self.disable_gradient_opacity && self.gradient_opacity.as_ref().is_some_and(|f| changes(&nodes(f)))
    }
}

/// The first component of a file's first volume property.
pub(super) fn read(text: &str) -> Result<Reading, Wrong> {
    let file: File = serde_json::from_str(text).map_err(|e| Wrong::at(e.line(), e.to_string()))?;
    if !file.schema.to_ascii_lowercase().contains(SCHEMA_NAME) {
        return Err(Wrong::whole(
            "no volume property: its \"@schema\" does not name 3D Slicer's schema of them",
        ));
    }
    let first = file.properties.first();
    let first = first.ok_or_else(|| Wrong::whole("\"volumeProperties\" is empty"))?;
    let component = first.components.first();
    let component = component.ok_or_else(|| Wrong::whole("the first volume property has no components"))?;
    let mut left_out = Vec::new();
    if component.has_gradient_opacity() {
        left_out.push(GRADIENT_OPACITY);
    }
    if !first.iso_surface_values.is_empty() {
        left_out.push("surfaces of values (isoSurfaceValues)");
    }
    let light = &component.lighting;
    let numbers = [light.ambient, light.diffuse, light.specular, light.specular_power];
    let material = component.shade.then(|| material(numbers)).transpose();
    Parts {
        color: component.color()?,
        opacity: component.opacity()?,
        unit_mm: component.scalar_opacity_unit_distance,
        material: material.map_err(Wrong::whole)?,
        left_out,
    }
    .reading()
}

/// The text of a file with one property of one component.
pub(super) fn written(property: &VolumeProperty) -> String {
    let points = property.function.points();
    let values = rising(points);
    let window = property.function.window();
    let file = json!({
        "@schema": SCHEMA,
        "volumeProperties": [{
            "effectiveRange": [f64::from(window.lo), f64::from(window.hi)],
            "isoSurfaceValues": [],
            "independentComponents": true,
            "interpolationType": "linear",
            "useClippedVoxelIntensity": false,
            "clippedVoxelIntensity": 0.0,
            "scatteringAnisotropy": 0.0,
            "components": [{
                "componentWeight": 1.0,
                "shade": property.material.is_some(),
                "lighting": lighting(property),
                "disableGradientOpacity": true,
                "scalarOpacityUnitDistance": property.function.unit_mm(),
                "rgbTransferFunction": colors(&values, points),
                "scalarOpacity": opacities(&values, points),
                "gradientOpacity": {
                    "type": "piecewiseLinearFunction",
                    "points": [node(0.0, "y", 1.0.into()), node(255.0, "y", 1.0.into())],
                },
            }],
        }],
    });
    format!("{file:#}\n")
}

fn lighting(property: &VolumeProperty) -> Value {
    let material = property.material.unwrap_or_default();
    let [ambient, diffuse, specular] = [material.ambient, material.diffuse, material.specular].map(f64::from);
    json!({
        "ambient": ambient,
        "diffuse": diffuse,
        "specular": specular,
        "specularPower": f64::from(1u32 << material.shininess_log2.min(10)),
    })
}

fn colors(values: &[f64], points: &[ControlPoint]) -> Value {
    let color = |p: &ControlPoint| json!(p.color.map(f64::from));
    let points = values.iter().zip(points).map(|(x, p)| node(*x, "color", color(p)));
    json!({ "type": "colorTransferFunction", "points": points.collect::<Vec<_>>() })
}

fn opacities(values: &[f64], points: &[ControlPoint]) -> Value {
    let points = values
        .iter()
        .zip(points)
        .map(|(x, p)| node(*x, "y", f64::from(p.opacity).into()));
    json!({ "type": "piecewiseLinearFunction", "points": points.collect::<Vec<_>>() })
}

fn node(x: f64, name: &str, value: Value) -> Value {
    json!({ "x": x, name: value, "midpoint": 0.5, "sharpness": 0.0 })
}

/// The points' values, those of steps parted by the least that a double can be: of several nodes in one place VTK would keep the last.
fn rising(points: &[ControlPoint]) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::with_capacity(points.len());
    for point in points {
        let value = f64::from(point.value);
        values.push(match values.last() {
            Some(&last) if value <= last => last.next_up(),
            _ => value,
        });
    }
    values
}
