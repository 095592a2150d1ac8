//! What a mesh can be refused for.

use glam::DVec3;
use thiserror::Error;

/// Why a mesh bounds no solid. Places are in the mesh's own frame, millimetres.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate that is NaN, infinite, or so large that squares of areas are.
    #[error("vertex {vertex} has a coordinate that is not a number of at most {limit:e}")]
    NotFinite {
        /// Which vertex, from 0 on.
        vertex: usize,
        /// The largest coordinate.
        limit: f64,
    },
    /// A corner that is no vertex.
    #[error("triangle {triangle} has vertex {vertex} of {vertices}")]
    Index {
        /// Which triangle, from 0 on.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// No triangle with three different corners.
    #[error("the mesh has no triangles")]
    Empty,
    /// More triangles than are counted here.
    #[error("the mesh has {found} triangles, more than {limit}")]
    TooMany {
        /// How many there are.
        found: usize,
        /// The most.
        limit: usize,
    },
    /// Edges at which the surface ends.
    #[error("the mesh is not watertight: it is open at {edges} edge(s), one of them at {}", place(*at))]
    Open {
        /// How many.
        edges: usize,
        /// The middle of the first.
        at: DVec3,
    },
    /// Edges whose triangles face different sides.
    #[error("neighbouring triangles face different sides at {edges} edge(s), one of them at {}", place(*at))]
    Orientation {
        /// How many.
        edges: usize,
        /// The middle of the first.
        at: DVec3,
    },
    /// A triangle whose corners lie on a line.
    #[error("the triangle at {} has no area", place(*at))]
    NoArea {
        /// Its middle.
        at: DVec3,
    },
    /// Nothing within it.
    #[error("the mesh encloses no volume")]
    NoVolume,
    /// Triangles that pass through each other.
    #[error("the mesh crosses itself at {}", place(*at))]
    Crosses {
        /// The middle of what the boxes of two triangles share.
        at: DVec3,
    },
    /// A piece that is turned the wrong way for where it lies.
    #[error("a piece of the mesh is inside out, or lies within another one, at {}", place(*at))]
    Sides {
        /// The middle of one of its triangles.
        at: DVec3,
    },
}

/// A place, short.
fn place(p: DVec3) -> String {
    let short = |x: f64| {
        let text = format!("{x:.3}");
        // Small and large things are told apart by their exponents.
        if x != 0.0 && !(1e-2..1e7).contains(&x.abs()) {
            format!("{x:.3e}")
        } else {
            text
        }
    };
    format!("({}, {}, {})", short(p.x), short(p.y), short(p.z))
}
