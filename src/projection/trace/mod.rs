//! Volumetric ray tracing (WK94, *rendering volume-sampled models*): rays march through volumes, meet surfaces where the classifier says
//! that there are some, and spawn mirrored, transmitted and shadow rays there, which do the same.
//!
//! *Theory.* Sampled volumes need no intersection of rays with geometry, nor normals of geometry: a trilinear sample and a classifier
//! tell where a surface is, and central differences how it is turned. As the model is band-limited, so are silhouettes, reflections,
//! refractions and shadows.
//! *Changes from the paper.* A world has *media*, composited sample by sample as the ray caster does, and *solids*, whose surfaces are
//! met once ([`surface`]). There are refraction, tints, Fresnel's equations, any depth, three kinds of lights. What the paper does by
//! bounding boxes, octrees and cells of 8³ voxels do.
//! *Practice.* All in double precision and on all threads. Colours are display-referred, as everywhere here. Light bends at surfaces
//! for the eye's rays, and goes straight to what is lit: there are no caustics.

mod classifier;
mod frame;
mod light;
mod media;
mod object;
mod optics;
mod projector;
mod ray;
mod sampling;
mod shade;
mod shadow;
pub mod surface;
mod tracer;
mod voxels;
mod world;

pub use classifier::{Classifier, Sample, Tissue};
pub use frame::{Progressive, Sampling, draw};
pub use light::{Beam, Source, SourceError};
pub use object::{Object, Probe};
pub use optics::{Optics, OpticsError, Shares, fresnel, reflect, refract};
pub use projector::{RayTracer, check_mode};
pub use ray::Ray;
pub use sampling::Stream;
pub use tracer::{Bounds, Tracer};
pub use world::{Look, TooManyObjects, World};
