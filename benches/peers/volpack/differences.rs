//! How far pictures of the brain are apart, cause by cause.

use glam::DVec3;
use serde::Serialize;
use vcsg::image::Frame;
use vcsg::projection::{Camera, FrameSpec};

use super::causes::{Cause, END, FAINT};
use super::model::Model;
use crate::Outcome;
use crate::frames::PICTURES;
use crate::picture::{self, Difference};

/// The pictures, and what ours is of.
pub struct Pictures<'a> {
    /// The volume's voxels.
    pub values: &'a [u8],
    /// What is drawn.
    pub spec: &'a FrameSpec<'a>,
    /// Ours.
    pub ours: &'a Frame,
    /// VolPack's, which drops opacities up to the first, and ends rays at the second.
    pub theirs: &'a dyn Fn([f64; 2]) -> Outcome<Frame>,
}

/// Differences of many pictures.
#[derive(Serialize)]
pub struct Table {
    columns: &'static [&'static str],
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    what: String,
    differences: Vec<Difference>,
}

impl Pictures<'_> {
    /// All tables.
    pub fn tables(&self) -> Outcome<Vec<Table>> {
        let theirs = (self.theirs)([FAINT, END])?;
        Ok(vec![
            self.causes(&theirs)?,
            self.thresholds(&theirs)?,
            self.shifts(&theirs)?,
        ])
    }

    /// From our way to VolPack's, one cause after another.
    fn causes(&self, theirs: &Frame) -> Outcome<Table> {
        let mut above = self.model(&[])?;
        let mut rows = vec![Row {
            what: "our way".to_owned(),
            differences: vec![
                self.apart(&above, theirs, "our-way")?,
                self.apart(self.ours, &above, "ours")?,
            ],
        }];
        for (n, cause) in Cause::ALL.into_iter().enumerate() {
            let others: Vec<Cause> = Cause::ALL.into_iter().filter(|&other| other != cause).collect();
            let so_far = self.model(&Cause::ALL[..=n])?;
            rows.push(Row {
                what: format!("+ {}", cause.what()),
                differences: vec![
                    self.apart(&so_far, theirs, &format!("so-far-{n}"))?,
                    self.apart(&so_far, &above, &format!("above-{n}"))?,
                    self.apart(&self.model(&others)?, theirs, &format!("without-{n}"))?,
                ],
            });
            above = so_far;
        }
        let columns = &["from VolPack's", "from the row above", "all but this, from VolPack's"];
        Ok(Table { columns, rows })
    }

    /// VolPack's own pictures without its thresholds.
    fn thresholds(&self, theirs: &Frame) -> Outcome<Table> {
        let cases = [
            ("VolPack, nothing dropped", [0.0, END]),
            ("VolPack, rays to the end", [FAINT, 1.0]),
            ("VolPack, both", [0.0, 1.0]),
        ];
        let row = |(what, [faint, end]): (&str, [f64; 2])| -> Outcome<Row> {
            let other = (self.theirs)([faint, end])?;
            let what = what.to_owned();
            let name = format!("volpack-{faint}-{end}");
            let differences = vec![
                self.apart(&other, theirs, &name)?,
                self.apart(self.ours, &other, &format!("ours-{name}"))?,
            ];
            Ok(Row { what, differences })
        };
        Ok(Table {
            columns: &["from VolPack's", "from ours"],
            rows: cases.into_iter().map(row).collect::<Outcome<_>>()?,
        })
    }

    /// Whether the pictures lie over each other: our camera moved by half a pixel each way.
    fn shifts(&self, theirs: &Frame) -> Outcome<Table> {
        let row = |(x, y): (f64, f64)| -> Outcome<Row> {
            let camera = moved(self.spec.camera, x, y);
            let spec = FrameSpec {
                camera: &camera,
                ..*self.spec
            };
            let apart = |ways: &[Cause], whose: &str| -> Outcome<Difference> {
                let picture = Model::new(self.values, &spec, ways)?.draw()?;
                self.apart(&picture, theirs, &format!("{whose}-moved-{x}-{y}"))
            };
            Ok(Row {
                what: format!("moved by {x}, {y} pixels"),
                differences: vec![apart(&[], "ours")?, apart(&Cause::ALL, "theirs")?],
            })
        };
        let moves = [(-0.5, 0.0), (0.5, 0.0), (0.0, -0.5), (0.0, 0.5)];
        Ok(Table {
            columns: &["our way, from VolPack's", "VolPack's way, from VolPack's"],
            rows: moves.into_iter().map(row).collect::<Outcome<_>>()?,
        })
    }

    fn model(&self, theirs: &[Cause]) -> Outcome<Frame> {
        Model::new(self.values, self.spec, theirs)?.draw()
    }

    fn apart(&self, picture: &Frame, from: &Frame, name: &str) -> Outcome<Difference> {
        let [edge, _] = self.spec.camera.size;
        picture::compare(picture, from, &format!("{PICTURES}/brainsmall-{edge}-{name}.png"))
    }
}

/// The camera with its picture moved by so many pixels to the right and down.
fn moved(camera: &Camera, x: f64, y: f64) -> Camera {
    let mut moved = *camera;
    let pixel = camera.unproject([1.0; 2].into(), 0.0) - camera.unproject([0.0; 2].into(), 0.0);
    moved.eye_from_world.translation += pixel * DVec3::new(x, y, 0.0);
    moved
}

impl Table {
    /// Prints it.
    pub fn print(&self) {
        print!("{:<48}", "8-bit difference: mean, 99 %, most");
        self.columns.iter().for_each(|column| print!(" | {column:>30}"));
        println!();
        for row in &self.rows {
            print!("{:<48}", row.what);
            for d in &row.differences {
                let steps = format!("{:.2}, {}, {}", d.mean, d.percentile_99, d.max);
                print!(" | {steps:>30}");
            }
            println!();
        }
    }
}
