//! Marching cubes with the topology of the trilinear interpolant, cell by cell.
//!
//! *Theory.* Marching cubes (LC87) triangulates by the corners' signs alone, which leave open how the surface runs on a face whose
//! signs alternate and, in some cells, whether sheets join inside. The trilinear interpolant decides both: on a face the sign of
//! its saddle (Nielson and Hamann 1991, *The asymptotic decider*), inside a section half-way through the possible tunnel
//! (Chernyaev 1995, *Marching cubes 33*; Lewiner et al. 2003). A cell's surface is then discs, one for each closed contour on the
//! faces, or has one tube between two contours in the place of their discs (Lopes and Brodlie 2003; Nielson 2003).
//!
//! *Changes from the papers.* There is no table of the 33 cases, whose printed and programmed forms have had errors (Custodio et
//! al. 2013): contours are traced, the tunnel's test asks whether one arc of the decisive section connects two contours, and
//! discs and tube are triangulated from the contours. The hexagon inside a tunnel is that of Grosso 2016 (*Construction of
//! topologically correct and manifold isosurfaces*); which of its corners serve which contour follows from the faces that its
//! lines meet. Zero counts as infinitesimally above, in the corners' signs and in all decisions alike, so that a field with ties
//! gets the surface of the field with all values a little larger.
//!
//! *Practice.* A face's decision depends on its four values only, bit for bit the same from both sides. No triangle lies in a face
//! and no chord connects two vertices of one face, where the neighbour could have the same chord; so cells meet in a manifold
//! whatever the values, even if rounding has decided about a tunnel. Cells whose signs decide all, nearly all in smooth data, come
//! from a list made of the same parts at first use.

mod contour;
mod disc;
pub(super) mod interpolant;
mod section;
mod triangles;
mod tube;

use std::sync::LazyLock;

use crate::surface::cell::FACES;
use contour::Contours;
pub use triangles::CellTriangles;
use tube::Tube;

/// The triangles of all cells whose corners' signs leave nothing open, by [`interpolant::signs`].
static PLAIN: LazyLock<[Option<CellTriangles>; 256]> =
    LazyLock::new(|| std::array::from_fn(|signs| plain(signs as u8)));

/// Triangulates the level set of the trilinear interpolant of a cell's corner values.
///
/// `values` are the samples minus the isovalue; corner `c` is the upper one in x, y, z where its bits 0, 1, 2 are set. Edge
/// `4 * axis + u + 2 * v` runs along `axis`; `u` and `v` are 1 where it lies at the upper end of the two other axes, in increasing
/// order. A corner is inside where its value is at least zero. The vertex on an edge is where its two values interpolate to zero.
///
/// Any values give a manifold; NaN counts as outside. Its topology is the interpolant's where sixth powers of the values neither
/// overflow nor vanish (sizes from 1e-50 to 1e50 always do well), up to rounding in decisions that are closer than that.
///
/// ```
/// use vcsg::surface::trilinear::triangulate;
///
/// // One corner inside is cut off by a triangle across its three edges: 0, 4 and 8.
/// let found = triangulate(&[1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0]);
/// let &[triangle] = found.triangles() else { unreachable!() };
/// assert_eq!(triangle.iter().sum::<u8>(), 12);
/// ```
pub fn triangulate(values: &[f64; 8]) -> CellTriangles {
    PLAIN[interpolant::signs(values) as usize].unwrap_or_else(|| resolve(values))
}

/// The triangles of every cell with these signs; `None` if they leave something open.
fn plain(signs: u8) -> Option<CellTriangles> {
    let is_inside = |c: u8| signs >> c & 1 == 1;
    let values = [0, 1, 2, 3, 4, 5, 6, 7].map(|c| if is_inside(c) { 1.0 } else { -1.0 });
    let is_open = FACES.iter().any(|face| contour::alternate(face.map(is_inside)));
    let has_one_sheet = Contours::trace(&values).firsts().len() <= 1;
    (has_one_sheet && !is_open).then(|| resolve(&values))
}

/// Traces the contours and fills them with a tube and discs.
fn resolve(values: &[f64; 8]) -> CellTriangles {
    let contours = Contours::trace(values);
    let mut out = CellTriangles::EMPTY;
    let tube = Tube::find(values, &contours);
    if let Some(tube) = &tube {
        tube.triangulate(&contours, &mut out);
    }
    let in_tube = |edge: u8| {
        tube.as_ref()
            .is_some_and(|tube| tube.bounds(contours.label[edge as usize]))
    };
    for &first in contours.firsts().iter().filter(|&&first| !in_tube(first)) {
        let mut edges = [0; 12];
        let walk = contours.walk(first).zip(&mut edges).map(|(edge, place)| *place = edge);
        let length = walk.count();
        disc::triangulate(values, &edges[..length], &mut out);
    }
    out
}
