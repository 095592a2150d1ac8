//! A volume by rays, and opaque meshes in it: the picture that slices and meshes give on a device.

use super::raster;
use super::{Mesh, MeshLook, SurfaceView};
use crate::image::Frame;
use crate::projection::raycast::{self, CastTarget};
use crate::projection::{FrameSpec, ProjectError, composite};

/// Draws a target that is ready (see [`raycast::draw`]) and `meshes` in it, at which its rays end: premultiplied, without background.
///
/// A sample is taken if its plane is nearer than the mesh, and then stands for its whole slab. So of the slab that the surface
/// lies in, up to half too much or too little is seen, as with slices.
///
/// # Errors
/// As [`raycast::draw`].
pub fn cast(spec: &FrameSpec, target: &CastTarget, meshes: &[(&Mesh, MeshLook)]) -> Result<Frame, ProjectError> {
    let surfaces = raster::draw(&SurfaceView::beside(spec), meshes)?;
    let projection = raycast::draw(spec, target, Some(&surfaces.depths_mm))?;
    Ok(composite::over_surfaces(
        spec.settings.mode,
        &projection,
        &surfaces.frame,
    ))
}
