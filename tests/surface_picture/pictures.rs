//! Both pictures of a surface, as depths.

use std::sync::Arc;

use glam::DVec3;
use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
use vcsg::image::Rgba;
use vcsg::math::Interval;
use vcsg::model::{Model, Node, VolumeLeaf};
use vcsg::projection::{Camera, ControlPoint, DepthCue, FrameSpec, Settings, TransferFunction, View};
use vcsg::render::{DeviceMesh, PagedTarget, ShownMesh, SliceRenderer};
use vcsg::surface::{Mesh, MeshLook, SurfaceView};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::{Bricks, Grid, Voxels};

use crate::oracle::Place;

/// A volume on its own lattice, and the value whose surface is looked at.
pub struct Subject {
    pub grid: Grid,
    pub place: Place,
    pub iso: f64,
    target: Target,
}

impl Subject {
    pub fn new(dims: [usize; 3], place: Place, voxels: Voxels, iso: f64) -> Self {
        let grid = Grid::new(dims, place.world_from_index(), voxels).expect("a grid");
        let mut model = Model::default();
        model.push(Node::Volume(VolumeLeaf {
            bricks: Arc::new(Bricks::new(&grid)),
            window: Interval::ALL,
        }));
        let target = Target::build(&model, None, &Subdivision::default()).expect("a target");
        assert_eq!(target.lattice.dims, dims, "samples are voxels");
        Self {
            grid,
            place,
            iso,
            target,
        }
    }

    /// The least distance between voxels.
    pub fn voxel_mm(&self) -> f64 {
        self.place.spacing.min_element()
    }
}

/// Side of the pictures, pixels.
pub const SIZE_PX: u32 = 128;

/// A pixel is 0.58 voxels of a cube of 64.
const ZOOM: f64 = 1.5;

/// The depth that each pixel sees, millimetres, top row first; infinite where it sees nothing.
pub type Depths = Vec<f32>;

/// A device with a volume and a mesh on it.
pub struct Studio {
    renderer: SliceRenderer,
    paged: PagedTarget,
    mesh: DeviceMesh,
}

impl Studio {
    pub fn new(subject: &Subject, mesh: &Mesh) -> Self {
        let make_setup = |error: &dyn std::fmt::Display| -> ! { panic!("{error}: run `make setup`") };
        let instance = Instance::new(Validation::On).unwrap_or_else(|error| make_setup(&error));
        let lavapipe = DeviceSelector::Name("llvmpipe".into());
        let device =
            Device::open(&instance, &lavapipe, &SliceRenderer::REQUIREMENTS).unwrap_or_else(|error| make_setup(&error));
        Self {
            renderer: SliceRenderer::new(&device).expect("a renderer"),
            paged: PagedTarget::new(&device, &subject.target, None, &mut |_| {}).expect("a target on the device"),
            mesh: DeviceMesh::new(&device, mesh).expect("a mesh on the device"),
        }
    }

    /// What is seen from `direction` of slices and of the mesh.
    pub fn pictures(&mut self, subject: &Subject, direction: DVec3) -> (Depths, Depths) {
        let view = View {
            azimuth_deg: direction.x.atan2(-direction.y).to_degrees(),
            elevation_deg: direction.z.atan2(direction.x.hypot(direction.y)).to_degrees(),
            zoom: ZOOM,
            ..View::default()
        };
        let camera = view.camera(&subject.target.lattice.world_bounds(), [SIZE_PX; 2]);
        let seen = (self.slices(subject, &camera), self.meshed(&camera));
        let messages = self.renderer.device().instance().take_messages();
        assert_eq!(messages, Vec::<String>::new(), "of the validation layer");
        seen
    }

    /// Flat white that the depth cue darkens from 1 at the near end to 0 at the far end tells the depth.
    fn slices(&mut self, subject: &Subject, camera: &Camera) -> Depths {
        let settings = Settings {
            shading: None,
            depth_cue: DepthCue { strength: 1.0 },
            samples_per_voxel: 4.0,
            ..Settings::default()
        };
        let transfer = step(subject.iso as f32);
        let spec = FrameSpec {
            target: &subject.target,
            transfer: &transfer,
            camera,
            settings: &settings,
        };
        let [near, far] = SurfaceView::beside(&spec).cue_mm;
        let depth = |[light, .., alpha]: &Rgba| match alpha {
            0.0 => f32::INFINITY,
            _ => (near + f64::from(1.0 - light / alpha) * (far - near)) as f32,
        };
        let (frame, _) = self.renderer.draw(&spec, &self.paged, &[]).expect("a frame");
        frame.pixels().iter().map(depth).collect()
    }

    fn meshed(&mut self, camera: &Camera) -> Depths {
        let shown = ShownMesh {
            mesh: &self.mesh,
            look: MeshLook::default(),
        };
        self.renderer.mesh_depths(camera, &[shown]).expect("depths")
    }
}

/// Opaque white from `iso` on, and nothing below.
fn step(iso: f32) -> TransferFunction {
    let point = |opacity| ControlPoint {
        value: iso,
        color: [1.0; 3],
        opacity,
    };
    TransferFunction::new(vec![point(0.0), point(1.0)], 1.0).expect("a step")
}
