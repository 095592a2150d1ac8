//! Binary STL: for every triangle its facet normal and corners. Nothing else has a place in it.
//!
//! Format: 3D Systems, StereoLithography Interface Specification (1989).

use std::io::{self, Write};

use glam::{DVec3, Vec3};

use super::chunks::{append_vector, write_each};
use super::{Mesh, MeshWriteError, check};

/// What a file begins with: free text, padded to 80 bytes. The axes as 3D Slicer reads them.
const TEXT: &str = "vcsg, binary STL, positions in millimetres, SPACE=LPS";

/// Whether the triangles can be counted in 32 bits.
pub fn check(mesh: &Mesh) -> Result<(), MeshWriteError> {
    let limit = u64::from(u32::MAX);
    check::within(mesh.triangles.len() as u64, "triangles", limit, "STL")
}

/// Writes a whole file of at most 2³² − 1 triangles.
pub fn write(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    write!(out, "{TEXT:80}")?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    write_each(out, 0..mesh.triangles.len(), |bytes, triangle| {
        let corners = mesh.corners(triangle);
        append_vector(bytes, facet_normal(corners));
        corners.iter().for_each(|corner| append_vector(bytes, *corner));
        // No attributes.
        bytes.extend([0, 0]);
    })
}

/// The unit normal on the side from which `corners` run counterclockwise; zero for a triangle without area.
pub fn facet_normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| Vec3::from(corner).as_dvec3());
    let normal: DVec3 = (b - a).cross(c - a).normalize_or_zero();
    normal.as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_facet_faces_the_side_it_is_seen_counterclockwise_from() {
        let corners = [[1.0, 1.0, 5.0], [3.0, 1.0, 5.0], [1.0, 2.0, 5.0]];
        assert_eq!(facet_normal(corners), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_facet_without_area_has_no_normal() {
        assert_eq!(facet_normal([[1.0, 2.0, 3.0]; 3]), [0.0; 3]);
        assert_eq!(facet_normal([[f32::NAN; 3], [0.0; 3], [1.0, 0.0, 0.0]]), [0.0; 3]);
    }
}
