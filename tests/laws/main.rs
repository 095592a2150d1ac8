//! The laws of the model and of its target (design laws 1, 2, 5, 8 and 9), over random scenes.
//!
//! Every law is a function that returns `Err` with what it saw; beside the test that it holds there is one that it fails on a
//! deliberate mistake.

mod alike;
mod bounds;
mod edit;
#[path = "../agreement_devices/inside.rs"]
mod inside;
mod open;
mod order;
mod path;
mod picture;
mod plan;
#[path = "../agreement_devices/random.rs"]
mod random;
mod range;
mod raster;
mod raycast;
mod robust;
#[path = "../agreement_devices/scene.rs"]
mod scene;
#[path = "../agreement_devices/shapes.rs"]
mod shapes;
#[path = "../support/mod.rs"]
mod support;
mod surface;
mod touched;
mod twig;
mod values;
mod world;
