//! Primitive nodes: geometry, how it is placed, and how soft its surface is.

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use super::element::{Element, Value};
use super::error::{Problem, SceneError};
use super::leaves::plane;
use crate::math::Aabb;
use crate::voxelize::{Polyhedron, Primitive, Profile, Relief, RoundedBox, Solid, Thread, Waves};

type Result<T> = std::result::Result<T, SceneError>;

/// A primitive, and where its own frame is.
pub(super) struct PlacedPrimitive {
    pub primitive: Primitive,
    pub parent_from_local: DAffine3,
}

/// A solid, and where its own frame is.
type PlacedSolid = (Solid, DAffine3);

/// What a primitive node holds, or `None` for another kind of node.
///
/// # Errors
/// If a value is missing or wrong.
pub(super) fn primitive(element: &Element) -> Result<Option<PlacedPrimitive>> {
    let Some((solid, parent_from_local)) = solid(element)? else {
        return Ok(None);
    };
    let mut primitive = filtered(element, solid)?;
    if element.allows("shell")
        && let Some(shell) = element.get("shell")
    {
        let no_inset = |_| {
            shell.error(Problem::Conflict(
                "this cannot be a shell: subtract a smaller one instead",
            ))
        };
        primitive = primitive.shell(shell.positive()?).map_err(no_inset)?;
    }
    Ok(Some(PlacedPrimitive {
        primitive,
        parent_from_local,
    }))
}

/// A solid with the node's `value` and `filter`.
pub(super) fn filtered(element: &Element, solid: Solid) -> Result<Primitive> {
    let soft = Primitive::soft(solid, value(element)?);
    let filter_voxels = filter_voxels(element)?.unwrap_or(soft.filter_voxels);
    Ok(Primitive { filter_voxels, ..soft })
}

/// The radius of the filter, voxels, if it is said.
pub(super) fn filter_voxels(element: &Element) -> Result<Option<f64>> {
    let filter = element.get("filter");
    filter.map(|v| v.within(0.0, Primitive::MAX_FILTER_VOXELS)).transpose()
}

/// A primitive's `value`, 1 unless said.
pub(super) fn value(element: &Element) -> Result<f32> {
    element.get("value").map_or(Ok(1.0), |v| v.single())
}

fn solid(element: &Element) -> Result<Option<PlacedSolid>> {
    Ok(Some(match element.name() {
        "sphere" => {
            let (center, radius) = (center(element)?, length(element, "radius")?);
            (Solid::Sphere { center, radius }, DAffine3::IDENTITY)
        }
        "ellipsoid" => ellipsoid(element)?,
        "box" => cuboid(element)?,
        "half-space" => (Solid::HalfSpace(plane(element)?), DAffine3::IDENTITY),
        "cylinder" | "cone" | "capsule" | "prism" => along_axis(element)?,
        "torus" => {
            let profile = Profile::torus(length(element, "radius")?, tube(element)?);
            (Solid::revolved(profile), upright(element)?)
        }
        "thread" | "helix" => screwed(element)?,
        "polyhedron" => (polyhedron(element)?, DAffine3::IDENTITY),
        "waves" => (Solid::Relief(Relief::Waves(waves(element)?)), upright(element)?),
        _ => return Ok(None),
    }))
}

fn center(element: &Element) -> Result<DVec3> {
    element.get("center").map_or(Ok(DVec3::ZERO), |v| v.vector())
}

fn length(element: &Element, key: &'static str) -> Result<f64> {
    element.require(key)?.positive()
}

fn positive_or(element: &Element, key: &'static str, default: f64) -> Result<f64> {
    element.get(key).map_or(Ok(default), |v| v.positive())
}

fn ellipsoid(element: &Element) -> Result<PlacedSolid> {
    let radii = element.require("radii")?;
    let scale = positive_vector(radii)?;
    let ball = Solid::Sphere {
        center: DVec3::ZERO,
        radius: 1.0,
    };
    let placed = DAffine3::from_translation(center(element)?) * DAffine3::from_scale(scale);
    Ok((ball, placed))
}

fn positive_vector(value: Value) -> Result<DVec3> {
    let vector = value.vector()?;
    if vector.cmpgt(DVec3::ZERO).all() {
        Ok(vector)
    } else {
        Err(value.bad("above 0 on each axis"))
    }
}

fn cuboid(element: &Element) -> Result<PlacedSolid> {
    let (min, max) = (element.require("min")?, element.require("max")?);
    let bounds = Aabb::new(min.vector()?, max.vector()?);
    if !bounds.min.cmplt(bounds.max).all() {
        return Err(max.bad("above `min` on each axis"));
    }
    let Some(round) = element.get("round") else {
        return Ok((Solid::Box(bounds), DAffine3::IDENTITY));
    };
    let (half, radius) = (0.5 * bounds.size(), round.positive()?);
    if radius > half.min_element() {
        return Err(round.bad("at most half of the box's least extent"));
    }
    let rounded = Relief::RoundedBox(RoundedBox { half, radius });
    Ok((Solid::Relief(rounded), DAffine3::from_translation(bounds.center())))
}

/// Solids between two points of their axis.
fn along_axis(element: &Element) -> Result<PlacedSolid> {
    let (from, to) = (element.require("from")?.vector()?, element.require("to")?);
    let end = to.vector()?;
    let axis = (end - from)
        .try_normalize()
        .ok_or_else(|| to.bad("another point than `from`"))?;
    let (height, radius) = ((end - from).length(), length(element, "radius")?);
    let solid = match element.name() {
        "cylinder" => Solid::revolved(Profile::cylinder(radius, height)),
        "capsule" => Solid::revolved(Profile::capsule(radius, height)),
        "cone" => {
            let top = element.get("top-radius").map_or(Ok(0.0), |v| v.within(0.0, f64::MAX))?;
            Solid::revolved(Profile::frustum(radius, top, height))
        }
        _ => {
            let sides = element.get("sides").map_or(Ok(6), |v| v.whole(3, 64))?;
            Solid::Polyhedron(Polyhedron::prism(sides as usize, radius, height))
        }
    };
    Ok((solid, standing(0.5 * (from + end), axis)))
}

/// The frame of a solid about z that stands at `center` along `axis`.
fn standing(center: DVec3, axis: DVec3) -> DAffine3 {
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, axis));
    DAffine3 {
        matrix3: turn,
        translation: center,
    }
}

/// The frame of a solid with a `center` and an `axis`, z unless said.
fn upright(element: &Element) -> Result<DAffine3> {
    let axis = element.get("axis").map_or(Ok(DVec3::Z), |v| v.direction())?;
    Ok(standing(center(element)?, axis))
}

/// The radius of a tube, below that of the circle it lies on.
fn tube(element: &Element) -> Result<f64> {
    let (tube, radius) = (element.require("tube")?, length(element, "radius")?);
    let value = tube.positive()?;
    if value < radius {
        Ok(value)
    } else {
        Err(tube.bad("below `radius`"))
    }
}

/// The least width of a thread's crest, as a part of its pitch (ISO 68-1 has an eighth).
const CREST: f64 = 0.125;

fn screwed(element: &Element) -> Result<PlacedSolid> {
    let pitch = length(element, "pitch")?;
    let turns = element.require("turns")?.within(1e-3, 10_000.0)?;
    let profile = if element.name() == "helix" {
        Profile::torus(length(element, "radius")?, tube(element)?)
    } else {
        thread_profile(element, pitch)?
    };
    // Its middle is where it is put.
    let middle = DAffine3::from_translation(DVec3::Z * (-0.5 * pitch * turns));
    let thread = Thread::new(profile, pitch, turns);
    Ok((Solid::Thread(thread.into()), upright(element)? * middle))
}

/// The ridge of a screw: from `radius` outside down to `depth` below it, with flanks `angle` apart, and on towards the axis so
/// that a core of that radius joins it.
fn thread_profile(element: &Element, pitch: f64) -> Result<Profile> {
    let radius = length(element, "radius")?;
    let depth = element.require("depth")?;
    let root = radius - depth.positive()?;
    if root <= 0.0 {
        return Err(depth.bad("below `radius`"));
    }
    let angle = element.get("angle").map_or(Ok(60.0), |v| v.within(1.0, 170.0))?;
    let crest = 0.5 * CREST * pitch;
    let foot = crest + (radius - root) * (0.5 * angle.to_radians()).tan();
    let corners = [
        (0.5 * root, -foot),
        (root, -foot),
        (radius, -crest),
        (radius, crest),
        (root, foot),
        (0.5 * root, foot),
    ];
    Ok(Profile::polygon(&corners.map(DVec2::from)))
}

fn polyhedron(element: &Element) -> Result<Solid> {
    let mut corners = Vec::new();
    for child in element.children() {
        corners.push(child?.argument(0).vector()?);
    }
    let problem = Problem::Conflict("a polyhedron needs 4 to 128 `corner` children that do not all lie in one plane");
    let hull = Polyhedron::hull(&corners).ok_or_else(|| element.error(problem))?;
    Ok(Solid::Polyhedron(hull))
}

fn waves(element: &Element) -> Result<Waves> {
    let size = element.require("size")?;
    let [x, y] = size.numbers()?;
    if x <= 0.0 || y <= 0.0 {
        return Err(size.bad("above 0 on both axes"));
    }
    let amplitude = element.get("amplitude").map_or(Ok(0.0), |v| v.within(0.0, f64::MAX))?;
    let depth = element.require("depth")?;
    let below = depth.positive()?;
    if below <= amplitude {
        return Err(depth.bad("above `amplitude`"));
    }
    Ok(Waves {
        size: DVec2::new(x, y),
        depth: below,
        amplitude,
        wavelength: DVec2::new(
            positive_or(element, "wavelength-x", f64::INFINITY)?,
            positive_or(element, "wavelength-y", f64::INFINITY)?,
        ),
    })
}
