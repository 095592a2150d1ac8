//! A video of frames, by an installed ffmpeg.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::CliError;
use super::frames::FrameRange;

const PROGRAM: &str = "ffmpeg";

/// Most players want colours at half resolution, and so even sides. The matrix of the colours is said and written into the file: left to
/// themselves ffmpeg takes that of standard definition, and players that of high definition where a frame is large.
const FILTERS: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";

/// Refuses what cannot become a video before any frame is drawn.
///
/// # Errors
/// If no ffmpeg is installed, or the frames or the video have names that it cannot take.
pub(super) fn check(video: &Path, frames: &Path) -> Result<(), CliError> {
    if !frames
        .extension()
        .is_some_and(|suffix| suffix.eq_ignore_ascii_case("png"))
    {
        return Err(CliError::Usage(
            "a video is made of PNG frames: let their names end in .png".into(),
        ));
    }
    if video.extension().is_none() {
        let why = format!(
            "{}: the suffix of a video says its format, for instance .mp4",
            video.display()
        );
        return Err(CliError::Usage(why));
    }
    let found = Command::new(PROGRAM)
        .arg("-version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    match found {
        Ok(status) if status.success() => Ok(()),
        Err(error) if error.kind() == ErrorKind::NotFound => Err(CliError::Video(
            "no ffmpeg is installed, which --video needs: install it, or leave --video out; the frames can be made a video later".into(),
        )),
        Ok(status) => Err(CliError::Video(format!("{PROGRAM} -version: {status}"))),
        Err(error) => Err(CliError::Video(format!("{PROGRAM} cannot be run: {error}"))),
    }
}

/// Makes `video` of the frames that `pattern` names, whole or not at all.
///
/// # Errors
/// If ffmpeg fails.
pub(super) fn make(pattern: &str, range: FrameRange, fps: f64, video: &Path) -> Result<(), CliError> {
    let part = beside(video);
    let made = Command::new(PROGRAM)
        .args(["-y", "-loglevel", "error", "-nostdin", "-framerate", &fps.to_string()])
        .args(["-start_number", &range.first.to_string(), "-i", pattern])
        .args(["-frames:v", &range.len().to_string()])
        .args(["-vf", FILTERS])
        .args([
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "iec61966-2-1",
        ])
        .arg(&part)
        .stdout(Stdio::null())
        .status();
    let moved = match made {
        Ok(status) if status.success() => std::fs::rename(&part, video).map_err(|error| error.to_string()),
        Ok(status) => Err(format!("{PROGRAM}: {status}")),
        Err(error) => Err(format!("{PROGRAM} cannot be run: {error}")),
    };
    moved.map_err(|why| {
        // It may not have been begun.
        let _ = std::fs::remove_file(&part);
        CliError::Video(format!("cannot make {}: {why}", video.display()))
    })
}

/// A hidden name in the same folder, with the same suffix.
fn beside(video: &Path) -> PathBuf {
    let name = video.file_name().unwrap_or_default().to_string_lossy();
    video.with_file_name(format!(".{}-{name}", std::process::id()))
}
