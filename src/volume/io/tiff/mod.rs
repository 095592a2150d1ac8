//! TIFF: stacks of pages, with ImageJ's or OME's description or none.
//!
//! Formats: TIFF 6.0 and BigTIFF, whose pages the `tiff` crate decodes; ImageJ's description of hyperstacks; OME-XML 2016-06.
//!
//! *Practice.* Values are as they are stored: a palette's are its indices, and of white-is-zero images white is 0. Pages of reduced
//! resolution and masks are passed over. Pages are read one by one, as they are asked for.

mod imagej;
mod lzw_tiles;
mod ome;
mod page;
mod pages;
mod shown;

use std::path::Path;

use glam::{DAffine3, DVec3};

use self::pages::{Contiguous, Pages};
use super::components::Components;
use super::error::ReadError;
use super::format::Format;
use super::open::{Chunks, Declared, Opened, ReadOptions};
use super::slices::Picture;
use crate::volume::grid::Voxels;

/// TIFF among the formats.
pub(super) const FORMAT: Format = Format {
    name: "TIFF",
    suffixes: &[".tif", ".tiff", ".btf", ".tf8"],
    reads: "stacks of 8 to 64 bits, BigTIFF; deflate, LZW, PackBits, Zstandard, JPEG; ImageJ and OME: spacing, channels, times",
    recognises: |probe| !probe.is_folder && !probe.has_layout && (probe.is_named(&FORMAT) || is_tiff(&probe.start)),
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: None,
};

fn is_tiff(start: &[u8]) -> bool {
    [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"]
        .iter()
        .any(|magic| start.starts_with(*magic))
}

/// How a file's pages are a volume.
#[derive(Clone, Debug, PartialEq)]
struct Stack {
    /// Slices, channels and volumes in time.
    sizes: [usize; 3],
    /// Pages from one slice, channel and time to the next.
    strides: [usize; 3],
    /// Of each plane the page that it is on, where they do not follow each other.
    pages: Option<Vec<usize>>,
    /// Millimetres between voxels, as far as it is known.
    spacing: [Option<f64>; 3],
    notes: Vec<String>,
}

impl Stack {
    /// Pages that are slices.
    fn plain(slices: usize, spacing: [Option<f64>; 3]) -> Self {
        Self {
            sizes: [slices, 1, 1],
            strides: [1; 3],
            pages: None,
            spacing,
            notes: Vec::new(),
        }
    }

    /// How many pages it takes.
    fn planes(&self) -> usize {
        self.sizes.iter().fold(1, |n: usize, &size| n.saturating_mul(size))
    }

    /// The page of slice, channel and time `at`.
    fn page(&self, at: [usize; 3]) -> usize {
        let plane = (0..3).map(|axis| at[axis] * self.strides[axis]).sum();
        self.pages.as_ref().map_or(plane, |pages| pages[plane])
    }

    /// Where the voxels lie. A distance of slices that is not known is taken to be that of columns.
    fn world_from_index(&mut self) -> DAffine3 {
        let [x, y, z] = self.spacing;
        let xy = [x.or(y).unwrap_or(1.0), y.or(x).unwrap_or(1.0)];
        if x.or(y).is_none() {
            self.notes
                .push("the file gives no size of a pixel: it is taken to be 1 mm".to_owned());
        }
        if z.is_none() && self.sizes[0] > 1 {
            let note = format!(
                "the file gives no distance between slices: it is taken to be that of columns, {} mm",
                xy[0]
            );
            self.notes.push(note);
        }
        DAffine3::from_scale(DVec3::new(xy[0], xy[1], z.unwrap_or(xy[0])))
    }
}

fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let pages = Pages::open(path)?;
    let mut stack = stack(path, &pages)?;
    let [slices, channels, frames] = stack.sizes;
    let frame = options.frame.unwrap_or(0);
    if frame >= frames {
        let what = format!("it has no volume {frame}: it holds {frames}");
        return Err(ReadError::unsupported(path, what).hint("volumes in time are counted from 0"));
    }
    let layout = pages.layout.clone();
    let (channel, within) = match channels {
        1 => (0, options.component),
        _ => (options.component.unwrap_or(0), None),
    };
    if channels > 1 {
        // The same check as of components, and the same message.
        Components::new(path, channels, options.component)?;
        stack
            .notes
            .push(format!("channel {channel} of {channels}: choose with --component"));
    }
    let components = layout.components(path, within)?;
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims: [layout.dims[0], layout.dims[1], slices],
        voxel: components.voxel(layout.stored.voxel()),
        world_from_index: stack.world_from_index(),
        frames,
        components: if channels > 1 { channels } else { components.count() },
        notes: std::mem::take(&mut stack.notes),
    };
    let contiguous = contiguous(path, &pages, &stack)?;
    if contiguous.is_none() {
        pages.check(stack.planes())?;
    }
    // A page is in memory as a whole.
    options.budget.check(path, layout.bytes())?;
    let file = path.to_owned();
    let mut source: Box<dyn FnMut(usize) -> Result<Voxels, ReadError> + Send> = match contiguous {
        None => {
            let mut pages = pages;
            Box::new(move |page| pages.read(page))
        }
        Some(data) => {
            let numbers = layout.pixels() * components.count();
            Box::new(move |page| data.read(&file, page * numbers, numbers))
        }
    };
    let chunks: Chunks = Box::new((0..slices).map(move |slice| {
        let page = stack.page([slice, channel, frame]);
        Ok(components.one(source(page)?))
    }));
    Opened::new(path.to_owned(), declared, chunks)
}

/// How the pages are a volume: as OME or ImageJ say, else each is a slice.
fn stack(path: &Path, pages: &Pages) -> Result<Stack, ReadError> {
    let description = pages.description.as_str();
    let stack = if description.contains("<OME") {
        ome::stack(path, description, pages)?
    } else if let Some(stack) = imagej::stack(description, pages) {
        stack
    } else {
        Stack::plain(pages.count(), pages.resolution.millimetres())
    };
    Ok(stack)
}

/// Where the planes are, if there are more than pages because they follow the first without pages of their own, as in ImageJ's
/// large stacks.
fn contiguous(path: &Path, pages: &Pages, stack: &Stack) -> Result<Option<Contiguous>, ReadError> {
    if stack.planes() <= pages.count() {
        return Ok(None);
    }
    let Some(data) = pages.contiguous.filter(|_| pages.count() == 1) else {
        let what = format!(
            "its description asks for {} pages, it has {}",
            stack.planes(),
            pages.count()
        );
        return Err(ReadError::header(path, what).hint("the file is incomplete: copy or export it again"));
    };
    let count = stack
        .planes()
        .saturating_mul(pages.layout.pixels())
        .saturating_mul(pages.layout.samples);
    data.check(path, count)?;
    Ok(Some(data))
}

/// The only page of a file that is one slice of several, and millimetres between its pixels, as far as they are known.
pub(super) fn picture(path: &Path, options: &ReadOptions) -> Result<(Picture, [Option<f64>; 3]), ReadError> {
    let mut pages = Pages::open(path)?;
    pages.check(1)?;
    options.budget.check(path, pages.layout.bytes())?;
    if pages.count() != 1 {
        let what = format!("it has {} pages, where a file is one slice", pages.count());
        return Err(ReadError::unsupported(path, what).hint("open it by itself"));
    }
    let picture = Picture {
        dims: pages.layout.dims,
        components: pages.layout.components(path, options.component)?,
        numbers: pages.read(0)?,
    };
    Ok((picture, stack(path, &pages)?.spacing))
}
