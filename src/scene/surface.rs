//! A scene's `surface` nodes: surfaces of constant value in its picture (LC87).

use super::element::Element;
use super::error::SceneError;
use crate::surface::{MeshColor, MeshLook, MeshShading, Topology};

/// A surface of constant value, and how it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSpec {
    /// The value whose surface it is, finite.
    pub iso: f64,
    /// How it runs where corners of a cell leave it open.
    pub topology: Topology,
    /// Colour and shading.
    pub look: MeshLook,
}

/// The names of shadings.
const SHADINGS: &[(&str, MeshShading)] = &[("phong", MeshShading::Phong), ("gouraud", MeshShading::Gouraud)];

/// The names of topologies.
const TOPOLOGIES: &[(&str, Topology)] = &[("vtk", Topology::Vtk), ("trilinear", Topology::Trilinear)];

impl SurfaceSpec {
    /// The surface of the value `iso` (finite), as it looks where nobody says how.
    pub fn at(iso: f64) -> Self {
        Self {
            iso,
            topology: Topology::default(),
            look: MeshLook::default(),
        }
    }

    /// The surface of a `surface` node.
    pub(super) fn read(element: &Element) -> Result<Self, SceneError> {
        let Self {
            iso,
            mut topology,
            mut look,
        } = Self::at(element.require("iso")?.number()?);
        if let Some(color) = element.get("color") {
            look.color = MeshColor::Uniform(color.color()?);
        }
        if let Some(shading) = element.get("shading") {
            look.shading = shading.one_of(SHADINGS)?;
        }
        if let Some(name) = element.get("topology") {
            topology = name.one_of(TOPOLOGIES)?;
        }
        Ok(Self { iso, topology, look })
    }
}
