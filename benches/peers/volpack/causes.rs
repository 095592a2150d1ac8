//! What makes our picture differ from VolPack's, cause by cause, on the slow [`Model`] of both.

use serde::Serialize;
use vcsg::image::Frame;
use vcsg::projection::{FrameSpec, Reference, Projector};

use super::model::{CAUSES, Cause, Model};
use crate::Outcome;
use crate::frames::PICTURES;
use crate::picture::{self, Difference};

/// The two pictures, and what ours was made of.
pub struct Pictures<'a> {
    pub values: &'a [u8],
    pub spec: &'a FrameSpec<'a>,
    pub ours: &'a Frame,
    pub theirs: &'a Frame,
}

/// One cause.
#[derive(Serialize)]
pub struct Row {
    what: String,
    /// From VolPack's picture, with this and all causes before it done in VolPack's way.
    so_far: Difference,
    /// From the picture without this cause.
    step: Difference,
    /// From VolPack's picture, with this cause alone done in our way.
    all_but: Difference,
}

impl Pictures<'_> {
    pub fn rows(&self) -> Outcome<Vec<Row>> {
        let mut before = self.model(&[])?;
        let d = self.compare(self.ours, &before, "model-ours")?;
        println!("model from ours {:.2} {} {}", d.mean, d.percentile_99, d.max);
        let r = Reference.project(self.spec)?;
        let d = self.compare(&r, &before, "model-reference")?;
        println!("model from reference {:.2} {} {}", d.mean, d.percentile_99, d.max);
        let d = self.compare(&before, self.theirs, "model-theirs")?;
        println!("model from theirs {:.2} {} {}", d.mean, d.percentile_99, d.max);
        let mut rows = Vec::new();
        for (n, cause) in CAUSES.into_iter().enumerate() {
            let but: Vec<Cause> = CAUSES.into_iter().filter(|&c| c != cause).collect();
            let so_far = self.model(&CAUSES[..=n])?;
            let name = format!("{n}-{cause:?}");
            let row = Row {
                what: format!("{cause:?}"),
                so_far: self.compare(&so_far, self.theirs, &format!("{name}-so-far"))?,
                step: self.compare(&so_far, &before, &format!("{name}-step"))?,
                all_but: self.compare(&self.model(&but)?, self.theirs, &format!("{name}-all-but"))?,
            };
            before = so_far;
            let f = |d: &Difference| format!("{:.2}, {}, {}", d.mean, d.percentile_99, d.max);
            println!("{:<20} | {:>16} | {:>16} | {:>16}", row.what, f(&row.so_far), f(&row.step), f(&row.all_but));
            rows.push(row);
        }
        Ok(rows)
    }

    fn model(&self, theirs: &[Cause]) -> Outcome<Frame> {
        Model::new(self.values, self.spec, theirs)?.draw()
    }

    fn compare(&self, picture: &Frame, with: &Frame, name: &str) -> Outcome<Difference> {
        picture::compare(picture, with, &format!("{PICTURES}/causes-{name}.png"))
    }
}
