//! Volumetric ray tracing against closed forms (WK94): surfaces, normals, mirrors, lenses, shadows, energy; the same bits however it is
//! computed; defined results at the edges.

mod closed_forms;
mod energy;
mod glass;
mod language;
mod levels;
mod pictures;
mod program;
mod shadows;
mod world;
