//! The device under test, shared by all tests of a process.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use vcsg::conformance::{Drawing, FrameBounds, Precision, Storage};
use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
use vcsg::image::{Frame, compare};
use vcsg::projection::{FrameSpec, SlicePlan};
use vcsg::render::{PagedTarget, SliceRenderer, plan, soft_normals};

/// Names the variable with a part of the device's name.
pub const NAME: &str = "VCSG_TEST_DEVICE";

/// Names the variable that is `single` where the device must compute in single precision throughout.
pub const PRECISION: &str = "VCSG_TEST_PRECISION";

/// Runs `test` with the renderer, alone, and fails if the validation layer has said anything.
pub fn on_device(test: impl FnOnce(&mut Bench)) {
    static BENCH: OnceLock<Mutex<Bench>> = OnceLock::new();
    let bench = BENCH.get_or_init(|| Mutex::new(Bench::open()));
    let mut bench: MutexGuard<Bench> = bench.lock().unwrap_or_else(PoisonError::into_inner);
    test(&mut bench);
    let messages = bench.device().instance().take_messages();
    assert_eq!(messages, Vec::<String>::new(), "of the validation layer");
}

/// A renderer on the device under test, and what the device promises.
pub struct Bench {
    pub renderer: SliceRenderer,
    pub precision: Precision,
}

/// A frame's target on the device, and what is drawn of it.
pub struct Prepared {
    pub paged: PagedTarget,
    pub plan: SlicePlan,
}

impl Bench {
    fn open() -> Self {
        let instance = Instance::new(Validation::On).unwrap_or_else(|error| panic!("{error}: run `make setup`"));
        let selector = std::env::var(NAME).map_or(DeviceSelector::Default, DeviceSelector::Name);
        let device = Device::open(&instance, &selector, &SliceRenderer::REQUIREMENTS)
            .unwrap_or_else(|error| panic!("{error}: run `make setup`"));
        let limits = &device.info().limits;
        let precision = match std::env::var(PRECISION) {
            Ok(word) if word == "single" => Precision::single(limits),
            _ => Precision::least(limits),
        };
        println!("{}: {precision:?}", device.info().name);
        Self {
            renderer: SliceRenderer::new(&device).expect("a renderer"),
            precision,
        }
    }

    fn device(&self) -> &Arc<Device> {
        self.renderer.device()
    }

    pub fn prepare(&self, spec: &FrameSpec) -> Prepared {
        let normals = soft_normals(spec);
        let paged = PagedTarget::new(self.device(), spec.target, normals.as_ref(), &mut |_| {})
            .expect("a target on the device");
        Prepared {
            plan: plan(spec, &paged),
            paged,
        }
    }

    pub fn draw(&mut self, spec: &FrameSpec, prepared: &Prepared) -> Frame {
        let drawn = self.renderer.draw_plan(spec, &prepared.paged, &prepared.plan, &[]);
        drawn.expect("a frame").0
    }

    pub fn bounds(&self, spec: &FrameSpec, prepared: &Prepared) -> FrameBounds {
        let storage = Storage::of(&prepared.paged, spec.target.value_range);
        FrameBounds::new(spec, &Drawing::new(&prepared.plan, storage, self.precision))
    }

    /// Requires `frame` to be within `bounds`; if it is not, leaves a picture and tells `what` it was.
    pub fn require_within(&self, what: &str, frame: &Frame, bounds: &FrameBounds) {
        let name = format!("{}-{what}.png", self.device().info().name);
        let file: String = name
            .chars()
            .map(|c| if c.is_alphanumeric() || c == '.' { c } else { '-' })
            .collect();
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("agreement");
        std::fs::create_dir_all(&folder).expect("a folder for pictures");
        if let Err(error) = compare::require_within(frame, &bounds.low, &bounds.high, &folder.join(file)) {
            let pixels = bounds.pixels_outside(frame);
            panic!("{what}: {error}; {pixels} pixels are out of bounds");
        }
    }
}
