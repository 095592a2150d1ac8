//! Which frames of which files belong together.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use super::image::{Frame, Image};

/// A frame of a file.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    pub image: Arc<Image>,
    frame: usize,
}

impl Slice {
    pub(super) fn frame(&self) -> &Frame {
        &self.image.frames[self.frame]
    }

    pub(super) fn path(&self) -> &Path {
        &self.image.path
    }

    /// Its file's name, and which of several frames it is, for messages.
    pub(super) fn name(&self) -> String {
        let file = self.path().file_name().unwrap_or_default().to_string_lossy();
        match self.image.frames.len() {
            1 => file.into_owned(),
            _ => format!("{file}, frame {}", self.frame),
        }
    }

    /// Whether it can be of one grid with `other`. A thousandth of a radian or of a pixel's size is rounding: over 500 pixels it
    /// comes to half of one.
    fn fits(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|s| (&s.image.layout, s.frame()));
        let close = |x: f64, y: f64| (x - y).abs() <= 1e-3 * y;
        a.0.rows == b.0.rows
            && a.0.columns == b.0.columns
            && a.0.components() == b.0.components()
            && a.1.position.is_some() == b.1.position.is_some()
            && (0..2).all(|i| a.1.axes[i].abs_diff_eq(b.1.axes[i], 1e-3))
            && (0..2).all(|i| close(a.1.spacing[i], b.1.spacing[i]))
    }
}

/// Slices of one series that can be of one grid.
#[derive(Debug)]
pub(super) struct Series {
    /// The series' UID, with a number where it holds images of several kinds.
    pub name: String,
    /// What the scanner called it.
    pub description: String,
    /// Never none.
    pub slices: Vec<Slice>,
    /// What should be known of them.
    pub notes: Vec<String>,
}

impl Series {
    /// Whether `wanted` means it: the end of its name, or its description in any case.
    pub(super) fn is_called(&self, wanted: &str) -> bool {
        let uid = self.name.split('#').next().unwrap_or_default();
        self.name.ends_with(wanted) || uid.ends_with(wanted) || self.description.to_lowercase() == wanted.to_lowercase()
    }

    /// Its name and description, for messages.
    pub(super) fn title(&self) -> String {
        match self.description.as_str() {
            "" => format!("`{}`", self.name),
            description => format!("`{}` ({description})", self.name),
        }
    }

    /// The series of `images`, in the order of their first files.
    pub(super) fn of(images: Vec<Image>) -> Vec<Self> {
        let mut by_uid: Vec<(String, Vec<Arc<Image>>)> = Vec::new();
        for image in images {
            let image = Arc::new(image);
            match by_uid.iter_mut().find(|(uid, _)| *uid == image.series) {
                Some((_, images)) => images.push(image),
                None => by_uid.push((image.series.clone(), vec![image])),
            }
        }
        by_uid
            .into_iter()
            .flat_map(|(uid, images)| Self::split(&uid, images))
            .collect()
    }

    /// The images of one series as groups that fit.
    fn split(uid: &str, images: Vec<Arc<Image>>) -> Vec<Self> {
        let all = images.len();
        let mut seen = HashSet::new();
        // The same image twice, as folders put together have it, is one. What was made of it has a number of its own.
        let first = |image: &Arc<Image>| image.instance.0.is_empty() || seen.insert(image.instance.clone());
        let images: Vec<_> = images.into_iter().filter(first).collect();
        let copies = all - images.len();
        let mut groups: Vec<Vec<Slice>> = Vec::new();
        for image in images {
            for frame in 0..image.frames.len() {
                let slice = Slice {
                    image: image.clone(),
                    frame,
                };
                match groups.iter_mut().find(|group| slice.fits(&group[0])) {
                    Some(group) => group.push(slice),
                    None => groups.push(vec![slice]),
                }
            }
        }
        let several = groups.len() > 1;
        let series = |(i, slices): (usize, Vec<Slice>)| Self {
            name: if several { format!("{uid}#{i}") } else { uid.to_owned() },
            description: slices[0].image.description.clone(),
            notes: notes(&slices, copies),
            slices,
        };
        groups.into_iter().enumerate().map(series).collect()
    }
}

fn notes(slices: &[Slice], copies: usize) -> Vec<String> {
    let mut notes = slices[0].image.notes.clone();
    if copies > 0 {
        notes.push(format!("images that are there twice are taken once; copies: {copies}"));
    }
    notes
}
