//! DICOM: a folder's files as series, or one file.
//!
//! Format: PS3.3 (what an image's attributes mean), PS3.5 (how they are encoded), PS3.10 (files). Elements are read by `dicom-parser`,
//! pixels by the crates that `codec` names; what the attributes mean for a volume is here.
//!
//! *Practice.* Opening reads headers up to the pixels, on all threads; pixels are decoded some slices at a time when they are
//! asked for. What declares more than its bytes hold is refused when it is opened.

mod codec;
mod dataset;
mod folder;
mod fragments;
mod image;
mod jpeg12;
mod jpeg_ls;
mod layout;
mod palette;
mod segments;
mod series;
mod source;
mod stack;
mod values;

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use self::image::Image;
use self::series::Series;
use self::stack::Stack;
use super::error::ReadError;
use super::format::Format;
use super::open::{Declared, Opened, ReadOptions};
use crate::volume::grid::Voxels;
use crate::volume::voxel::VoxelType;

/// DICOM among the formats.
pub(super) const FORMAT: Format = Format {
    name: "DICOM",
    suffixes: &[".dcm", ".dicom", ".ima"],
    reads: "folders of series and single files: uncompressed, deflated, RLE, JPEG, JPEG-LS, JPEG 2000; multi-frame and enhanced",
    recognises: |probe| match probe.is_folder {
        true => folder::holds_dicom(&probe.path),
        false => !probe.has_layout && (source::is_dicom(&probe.start) || probe.is_named(&FORMAT)),
    },
    open,
    writer: None,
};

/// Opens the series in the file or folder at `path` that the options name, or all.
fn open(path: &Path, options: &ReadOptions) -> Result<Vec<Opened>, ReadError> {
    let (images, mut notes) = images(path)?;
    let mut series = Series::of(images);
    if let Some(wanted) = &options.series {
        let titles: Vec<_> = series.iter().map(Series::title).collect();
        series.retain(|series| series.is_called(wanted));
        if series.is_empty() {
            let what = format!("it holds no series `{wanted}`, but {}", titles.join(", "));
            return Err(ReadError::unsupported(path, what).hint("give the end of a series' UID, or its description"));
        }
    }
    let mut opened = Vec::new();
    let mut refused = Vec::new();
    for series in &series {
        match volume(path, series, options) {
            Ok(volume) => opened.push(volume),
            Err(e) => refused.push((series.title(), e)),
        }
    }
    // One that is left over is not taken for the one that was meant.
    if opened.len() < 2
        && let Some((title, error)) = refused.pop()
    {
        let hint = match opened.first() {
            Some(other) => format!("{}; or choose series `{}`", error.hint, other.0.name),
            None => error.hint.clone(),
        };
        return Err(if series.len() > 1 { named(error, &title) } else { error }.hint(hint));
    }
    notes.extend(
        refused
            .iter()
            .map(|(title, e)| format!("series {title} is left out: {e}")),
    );
    let add_notes = |(mut declared, chunks): (Declared, Slices)| {
        declared.notes.extend(notes.iter().cloned());
        Opened::new(path.to_owned(), declared, Box::new(chunks))
    };
    opened.into_iter().map(add_notes).collect()
}

/// `error`, which says of which series it is.
fn named(mut error: ReadError, title: &str) -> ReadError {
    let text = format!("series {title}: {}", error.problem);
    error.problem = super::error::Problem::Unsupported(text);
    error
}

/// The images of the file or folder at `path`, in the order of their paths, and what is left out.
fn images(path: &Path) -> Result<(Vec<Image>, Vec<String>), ReadError> {
    if !path.is_dir() {
        let image = Image::open(path)?;
        let image =
            image.ok_or_else(|| ReadError::unsupported(path, "it is DICOM without pixels").hint("choose an image"))?;
        return Ok((vec![image], Vec::new()));
    }
    let files = folder::files(path)?;
    let read: Vec<_> = files.par_iter().map(|file| Image::open(file)).collect();
    let (mut images, mut damaged) = (Vec::new(), Vec::new());
    for image in read {
        match image {
            Ok(Some(image)) => images.push(image),
            Ok(None) => {}
            Err(e) => damaged.push(e),
        }
    }
    match (images.is_empty(), damaged.len()) {
        (false, 0) => Ok((images, Vec::new())),
        (false, n) => Ok((
            images,
            vec![format!("{n} files are left out; the first: {}", damaged[0])],
        )),
        (true, 0) => {
            Err(ReadError::unsupported(path, "its DICOM files hold no pixels").hint("choose a folder of images"))
        }
        (true, _) => Err(damaged.swap_remove(0)),
    }
}

/// What is declared of a series, and its slices to come.
fn volume(path: &Path, series: &Series, options: &ReadOptions) -> Result<(Declared, Slices), ReadError> {
    let first = &series.slices[0];
    if let Some(mosaic) = series.slices.iter().find(|slice| slice.image.is_mosaic) {
        return Err(ReadError::unsupported(
            mosaic.path(),
            "it is a Siemens mosaic: slices side by side in one image",
        )
        .hint("convert the series with dcm2niix, and open the NIfTI file"));
    }
    let layout = &first.image.layout;
    let components = layout.components();
    if let Some(component) = options.component.filter(|&c| c >= components) {
        let what = format!("it has no component {component}: a voxel has {components}");
        return Err(ReadError::unsupported(path, what).hint("count components from 0 on"));
    }
    // Its samples, and the voxels that they become.
    let slice_bytes = (layout.pixels() * (layout.samples * size_of::<i64>() + size_of::<f64>())) as u64;
    options.budget.check(first.path(), slice_bytes)?;
    let at_once = options.budget.bytes() / 2 / slice_bytes;
    let stack = Stack::new(series, options)?;
    let resampled = stack.places.iter().any(|place| place.fract() != 0.0);
    let voxel = if resampled {
        VoxelType::F32
    } else {
        values::voxel_type(&stack.slices)
    };
    let mut notes = series.notes.clone();
    notes.extend(stack.notes.iter().cloned());
    let declared = Declared {
        format: FORMAT.name,
        name: series.name.clone(),
        dims: [layout.columns, layout.rows, stack.places.len()],
        voxel,
        world_from_index: stack.world_from_index,
        frames: stack.frames,
        components,
        notes,
    };
    let slices = Slices {
        stack: Arc::new(stack),
        voxel,
        component: options.component,
        at_once: (at_once as usize).clamp(1, 4 * rayon::current_num_threads()),
        next: 0,
        ready: VecDeque::new(),
    };
    Ok((declared, slices))
}

/// The slices of a volume, decoded on all threads some at a time, and handed over in their order.
struct Slices {
    stack: Arc<Stack>,
    voxel: VoxelType,
    component: Option<usize>,
    /// How many are decoded at a time.
    at_once: usize,
    next: usize,
    ready: VecDeque<Result<Voxels, ReadError>>,
}

impl Slices {
    fn slice(&self, i: usize) -> Result<Voxels, ReadError> {
        let place = self.stack.places[i];
        let (below, part) = (place as usize, place.fract());
        let slices = &self.stack.slices;
        match part == 0.0 {
            true => values::voxels(&slices[below], self.voxel, self.component),
            false => values::between([&slices[below], &slices[below + 1]], part, self.component),
        }
    }
}

impl Iterator for Slices {
    type Item = Result<Voxels, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ready.is_empty() {
            let end = (self.next + self.at_once).min(self.stack.places.len());
            let batch: Vec<_> = (self.next..end).into_par_iter().map(|i| self.slice(i)).collect();
            self.ready.extend(batch);
            self.next = end;
        }
        self.ready.pop_front()
    }
}
