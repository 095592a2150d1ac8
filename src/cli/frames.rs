//! Frames of an animation, to numbered files.
//!
//! *Practice.* A frame is a file of its own, written whole or not at all. So what was interrupted goes on where it stopped: frames
//! that are there are kept. And several machines can share the work, each with a shard of the frames: which frames one has drawn
//! before makes no difference to the next.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::CliError;
use super::console::{Stages, frames_progress, note, print_json};
use super::render::Render;
use super::sequence::Sequence;
use super::video;
use crate::image::save;
use crate::scene::Remembered;

/// Which frames are drawn.
#[derive(Debug, Args)]
pub(super) struct FrameArgs {
    /// Draw these frames of the scene's animation, the first and the last counted in; those whose files are there are kept
    #[arg(long, value_name = "A..B", value_parser = range)]
    pub frames: Option<FrameRange>,
    /// Draw one part of the frames, the Kth of N, for instance 2/5
    #[arg(long, value_name = "K/N", requires = "frames", value_parser = shard)]
    shard: Option<Shard>,
    /// Make a video of the frames with ffmpeg, which has to be installed
    #[arg(long, value_name = "FILE", requires = "frames", conflicts_with = "shard")]
    video: Option<PathBuf>,
}

/// The first and the last frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameRange {
    pub first: u32,
    pub last: u32,
}

/// One of several parts of equal length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shard {
    /// From 1.
    part: u32,
    parts: u32,
}

impl FrameArgs {
    /// Draws the frames that `render` asks for.
    pub fn draw(&self, render: &Render, range: FrameRange) -> Result<(), CliError> {
        let names = Names::new(&render.output)?;
        if let Some(video) = &self.video {
            video::check(video, &render.output)?;
        }
        let mut stages = Stages::default();
        let mut loader = Remembered::new(render.source.files());
        let scene = stages.time("load", || render.source.load_with(&mut loader))?;
        let Some(animation) = &scene.animation else {
            let why = "the scene has no `animation` node: without one all frames are the same";
            return Err(CliError::Usage(why.into()));
        };
        if range.last >= animation.frames {
            let (last, frames) = (range.last, animation.frames);
            let why = format!("there is no frame {last}: the animation has {frames}, which count from 0");
            return Err(CliError::Usage(why));
        }
        let mine = self.shard.map_or(range, |shard| shard.of(range));
        let missing: Vec<u32> = mine.numbers().filter(|&n| !names.of(n).exists()).collect();
        let kept = mine.numbers().count() - missing.len();
        if kept > 0 {
            note(&format!(
                "{kept} frame(s) are there already and are kept; remove them to have them drawn again"
            ));
        }
        if !missing.is_empty() {
            let mut sequence = Sequence::new(render, &scene, loader, &mut stages)?;
            let bar = frames_progress(missing.len() as u64);
            for &number in &missing {
                let frame = sequence.frame(number, &mut stages)?;
                stages.time("write", || save(&frame, &names.of(number), &[("Software", "vcsg")]))?;
                bar.inc(1);
            }
            bar.finish_and_clear();
        }
        if let Some(video) = &self.video {
            stages.time("video", || video::make(&names.pattern, range, animation.fps, video))?;
        }
        if render.timings {
            stages.show();
        }
        if render.json {
            let frames = mine.numbers().map(|n| names.of(n)).collect::<Vec<_>>();
            return print_json(&json!({
                "frames": frames,
                "drawn": missing.len(),
                "kept": kept,
                "video": self.video,
                "milliseconds": stages.to_json(),
            }));
        }
        Ok(())
    }
}

impl FrameRange {
    fn numbers(self) -> impl Iterator<Item = u32> {
        self.first..self.last.saturating_add(1).max(self.first)
    }

    /// How many there are.
    pub fn len(self) -> u32 {
        self.last - self.first + 1
    }
}

impl Shard {
    /// Its part of a range, all in one piece, so that a frame has much in common with the one before.
    fn of(self, range: FrameRange) -> FrameRange {
        let begin = |part: u32| {
            let frames = u64::from(range.len()) * u64::from(part) / u64::from(self.parts);
            u64::from(range.first) + frames
        };
        let (first, end) = (begin(self.part - 1), begin(self.part));
        FrameRange {
            first: first as u32,
            last: (end as u32).wrapping_sub(1),
        }
    }
}

/// Names of frames, from a pattern with `%d` or the like.
struct Names {
    pattern: String,
    before: String,
    digits: usize,
    behind: String,
}

impl Names {
    fn new(pattern: &Path) -> Result<Self, CliError> {
        let text = pattern.to_string_lossy().into_owned();
        let split = text.split_once('%').and_then(|(before, rest)| {
            let (digits, behind) = rest.split_once('d')?;
            let digits = if digits.is_empty() {
                0
            } else {
                digits.strip_prefix('0')?.parse().ok()?
            };
            (digits <= 20 && !behind.contains('%')).then(|| (before.to_owned(), digits, behind.to_owned()))
        });
        let Some((before, digits, behind)) = split else {
            let why = format!("{text}: the name of frames needs one %d or %04d, as in frame-%04d.png");
            return Err(CliError::Usage(why));
        };
        Ok(Self {
            pattern: text,
            before,
            digits,
            behind,
        })
    }

    fn of(&self, number: u32) -> PathBuf {
        let Self {
            before, digits, behind, ..
        } = self;
        format!("{before}{number:0digits$}{behind}").into()
    }
}

fn range(text: &str) -> Result<FrameRange, String> {
    let ends = text
        .split_once("..")
        .and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match ends {
        Some((first, last)) if first <= last => Ok(FrameRange { first, last }),
        _ => Err("not a range like 0..239, the first and the last frame".into()),
    }
}

fn shard(text: &str) -> Result<Shard, String> {
    let numbers = text
        .split_once('/')
        .and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((part, parts)) if (1..=parts).contains(&part) => Ok(Shard { part, parts }),
        _ => Err("not a part like 2/5".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_the_frames() {
        for (first, last, parts) in [(0, 239, 5), (3, 9, 3), (5, 6, 4), (7, 7, 1)] {
            let range = FrameRange { first, last };
            let all: Vec<u32> = (1..=parts)
                .flat_map(|part| Shard { part, parts }.of(range).numbers().collect::<Vec<_>>())
                .collect();
            assert_eq!(all, (first..=last).collect::<Vec<_>>());
        }
    }

    #[test]
    fn names_hold_the_number() {
        let name = |pattern: &str, n| Names::new(pattern.as_ref()).map(|names| names.of(n));
        assert_eq!(name("a/f-%04d.png", 7).unwrap(), PathBuf::from("a/f-0007.png"));
        assert_eq!(name("f%d.exr", 12345).unwrap(), PathBuf::from("f12345.exr"));
        for wrong in ["f.png", "f%s.png", "f%4d.png", "f%d-%d.png"] {
            assert!(name(wrong, 1).is_err(), "{wrong}");
        }
    }
}
