//! The passes that draw meshes, and what they draw them into.

use std::sync::Arc;

use super::depths::DepthScale;
use super::frame::frame_data;
use super::layers::{color, depth, depths, target};
use super::mesh::{DevicePiece, ShownMesh};
use super::pipelines::MeshVariant;
use super::slices::SliceRenderer;
use super::submissions::Submissions;
use crate::gpu::{
    Binding, Bindings, Buffer, Draw, Elements, Extent, GpuError, GraphicsPipeline, Image, Load, Push, RenderPass,
    Stream,
};
use crate::interface::{MESH_DEPTH, MESH_GOURAUD, MESH_PHONG, MeshData};
use crate::projection::Lens;
use crate::surface::{MeshColor, MeshLook, MeshShading, SurfaceView};

/// What a triangle costs, in fragments of a slice, about.
const TRIANGLE_FRAGMENTS: f64 = 4.0;

/// What is shown of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Their colours.
    Color,
    /// Depths in millimetres, as red.
    Depth,
}

/// Meshes in a frame: what is nearest at each pixel.
pub struct Surfaces {
    /// Its colour, and alpha 1; 0 where there is none.
    pub image: Arc<Image>,
    /// Its depth, as [`DepthScale`] has it; 1 where there is none.
    pub depth: Arc<Image>,
}

impl Surfaces {
    /// Images for `meshes` in `view`, and in `submissions` the draws that fill them.
    pub fn new(
        renderer: &mut SliceRenderer,
        view: &SurfaceView,
        scale: &DepthScale,
        meshes: &[ShownMesh],
        shown: Shown,
        submissions: &mut Submissions,
    ) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let [width, height] = view.camera.size;
        let extent = Extent::D2(width, height);
        let surfaces = Self {
            image: color(&device, "meshes", extent)?,
            depth: depths(&device, extent)?,
        };
        submissions
            .last()
            .render(surfaces.pass(Load::Clear([0.0; 4]), Load::Clear(1.0), Vec::new()));
        let data = frame_data(view, &view.camera.eye_from_world, scale, view.settings.shading.as_ref());
        let uniform = Binding::Uniform(Buffer::with_data(&device, "frame data of meshes", &[data])?);
        let bindings = Bindings::new(&device, "meshes", &[uniform])?;
        for shown_mesh in meshes {
            let pipeline = renderer
                .pipelines
                .meshes(&device, variant(view, &shown_mesh.look, shown))?;
            for piece in &shown_mesh.mesh.pieces {
                let draw = draw(piece, &shown_mesh.look, &pipeline, &bindings);
                let cost = TRIANGLE_FRAGMENTS * f64::from(piece.triangles) + f64::from(width) * f64::from(height);
                submissions.render(surfaces.pass(Load::Keep, Load::Keep, vec![draw]), cost);
            }
        }
        Ok(surfaces)
    }

    fn pass(&self, color: Load, depths: Load<f32>, draws: Vec<Draw>) -> RenderPass {
        RenderPass {
            targets: vec![target(&self.image, color)],
            depth: Some(depth(&self.depth, depths)),
            draws,
        }
    }
}

fn variant(view: &SurfaceView, look: &MeshLook, shown: Shown) -> MeshVariant {
    let shading = view.settings.shading.as_ref();
    MeshVariant {
        shading: match (shown, look.shading) {
            (Shown::Depth, _) => MESH_DEPTH,
            (Shown::Color, MeshShading::Gouraud) => MESH_GOURAUD,
            (Shown::Color, MeshShading::Phong) => MESH_PHONG,
        },
        own_colors: look.color == MeshColor::OfVertices,
        lights: shading.map_or(0, |s| s.lights.len() as u32),
        shininess_log2: shading.map_or(0, |s| s.material.shininess_log2),
        perspective: matches!(view.camera.lens, Lens::Perspective { .. }),
    }
}

fn draw(piece: &DevicePiece, look: &MeshLook, pipeline: &Arc<GraphicsPipeline>, bindings: &Arc<Bindings>) -> Draw {
    let [r, g, b] = match look.color {
        MeshColor::Uniform(rgb) => rgb,
        MeshColor::OfVertices => [1.0; 3],
    };
    Draw {
        pipeline: Arc::clone(pipeline),
        bindings: Some(Arc::clone(bindings)),
        push: Push::of(&MeshData { rgb: [r, g, b, 1.0] }),
        stream: Some(Stream {
            buffer: Arc::clone(&piece.vertices),
            offset: 0,
        }),
        elements: Elements::Indices {
            buffer: Arc::clone(&piece.indices),
            range: 0..3 * piece.triangles,
            base_vertex: 0,
        },
        instances: 0..1,
    }
}
