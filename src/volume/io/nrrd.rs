//! NRRD, with attached or detached header.
//!
//! Format: teem's "Definition of NRRD File Format" (NRRD0001 to NRRD0005).

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::error::ReadError;
use super::format::Format;
use super::nrrd_axes::Axes;
use super::nrrd_data::{byte_order, stored, stretches};
use super::nrrd_header::Header;
use super::nrrd_place::world_from_index;
use super::nrrd_write;
use super::open::{Declared, Opened, ReadOptions};
use super::payload::{Payload, chosen_frame};
use crate::volume::grid::voxel_count;

/// NRRD among the formats.
pub(super) const FORMAT: Format = Format {
    name: "NRRD",
    suffixes: &[".nrrd", ".nhdr"],
    reads: "attached and detached headers, one file or many; raw, gzip, bzip2, text and hex; components; frames",
    recognises: |probe| probe.start.starts_with(b"NRRD") || probe.is_named(&FORMAT),
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: Some(nrrd_write::WRITER),
};

/// Opens the NRRD file, or the detached header, at `path`.
fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
    let header = Header::read(path, &mut BufReader::new(file))?;
    let axes = Axes::new(path, &header)?;
    let frame = chosen_frame(path, axes.frames, options)?;
    let payload = Payload {
        stored: stored(&header)?,
        order: byte_order(path, &header)?,
        voxels: voxel_count(axes.dims).map_err(|e| ReadError::new(path, e))?,
        components: axes.components(path, frame, options)?,
        rescaling: None,
    };
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims: axes.dims,
        voxel: payload.voxel(),
        world_from_index: world_from_index(path, &header, &axes)?,
        frames: axes.frames,
        components: axes.components_count(),
        notes: notes(&header, &axes, &payload),
    };
    let (frame, frames) = axes.slowest_frames(frame);
    let stretches = stretches(path, &header, payload.bytes().saturating_mul(frames as u64))?;
    Opened::new(
        path.to_owned(),
        declared,
        payload.chunks(path, &stretches, frame, options.budget)?,
    )
}

fn notes(header: &Header, axes: &Axes, payload: &Payload) -> Vec<String> {
    let mut notes = Vec::new();
    if axes.components_count() > 1 {
        notes.extend(payload.components.note(payload.stored));
        // A magnitude is the same in every frame that is a rotation of the world's; a component is not.
        if header.get("measurementframe").is_some() {
            notes.push("the measurement frame is left out: components are as they are stored".to_owned());
        }
    }
    notes
}
