//! `vcsg render --video` with the ffmpeg that setup installs: the video is read back.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// 63 · 47 pixels become 64 · 48. The sphere leaves the corners to the background.
const SCENE: &str = "scene spacing=2 { sphere radius=20 value=100 }
transfer {
    point 0 opacity=0 color=\"#000000\"
    point 100 opacity=0.8 color=\"#20c0ff\"
}
background \"#e03010\"
view zoom=0.6
render size=\"63x47\"
animation frames=8 fps=12.5 {
    track \"view\" property=\"zoom\" { at 0 0.4; at 7 0.9 }
}
";

const BACKGROUND: [f64; 3] = [0xe0 as f64, 0x30 as f64, 0x10 as f64];
const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// Frames 2 to 6 as PNG files and as `v.mp4`.
fn filmed() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.kdl"), SCENE).unwrap();
    let arguments = [
        "render",
        "scene.kdl",
        "-o",
        "f-%d.png",
        "--frames",
        "2..6",
        "--video",
        "v.mp4",
    ];
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    let output = command.current_dir(folder.path()).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}; without ffmpeg, run `make setup`");
    folder
}

fn output(folder: &Path, program: &str, arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(program).current_dir(folder).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("{program}: {error}: run `make setup`"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// The frames of a file, RGB.
fn decoded(folder: &Path, file: &str) -> Vec<Vec<u8>> {
    let raw = ["-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"];
    let bytes = output(folder, "ffmpeg", &raw);
    bytes.chunks(3 * WIDTH * HEIGHT).map(<[u8]>::to_vec).collect()
}

/// The mean colour of 8 · 8 pixels.
fn mean(frame: &[u8], left: usize, top: usize) -> [f64; 3] {
    let at = |n: usize, c: usize| f64::from(frame[3 * ((top + n / 8) * WIDTH + left + n % 8) + c]);
    std::array::from_fn(|c| (0..64).map(|n| at(n, c)).sum::<f64>() / 64.0)
}

#[test]
fn a_video_has_the_frames_their_size_and_their_rate() {
    let folder = filmed();
    let entries = "stream=codec_name,width,height,r_frame_rate,nb_read_frames,pix_fmt,color_space";
    let arguments = [
        "-v",
        "error",
        "-count_frames",
        "-show_entries",
        entries,
        "-of",
        "json",
        "v.mp4",
    ];
    let probed: Value = serde_json::from_slice(&output(folder.path(), "ffprobe", &arguments)).unwrap();
    let stream = &probed["streams"][0];
    let text = |key: &str| stream[key].as_str().unwrap_or_default().to_owned();
    assert_eq!(
        (stream["width"].as_u64(), stream["height"].as_u64()),
        (Some(64), Some(48))
    );
    assert_eq!(text("nb_read_frames"), "5");
    assert_eq!(text("r_frame_rate"), "25/2");
    assert_eq!(
        (text("pix_fmt"), text("color_space")),
        ("yuv420p".into(), "bt709".into())
    );
    assert_eq!(decoded(folder.path(), "v.mp4").len(), 5);
}

/// In blocks of one colour only the coder's quantisation and 8 bits are between picture and video. x264's usual step, at a quality
/// of 23, is 9 levels of a transform whose constant part is four times the mean of 4 · 4 pixels; what is rounded off is at most two
/// thirds of a step, so 1.5 levels of luma and chroma, and half a level for 8 bits. A channel is at most 1.17 times luma and 2.12 times
/// chroma: 6.6 levels. The wrong matrix would move the red of this background by 15.
const LEVELS: f64 = 6.6;

#[test]
fn a_video_has_the_colours_of_its_frames() {
    let folder = filmed();
    let frames = decoded(folder.path(), "v.mp4");
    let middles: Vec<_> = frames.iter().map(|frame| mean(frame, 28, 20)).collect();
    for frame in &frames {
        for (left, top) in [(0, 0), (WIDTH - 16, 0), (0, HEIGHT - 16)] {
            let seen = mean(frame, left, top);
            let apart = (0..3).map(|c| (seen[c] - BACKGROUND[c]).abs()).fold(0.0, f64::max);
            assert!(apart <= LEVELS, "{seen:?} at {left}, {top}");
        }
    }
    // The sphere is blue, whatever it is that the coder makes of its shading.
    assert!(middles.iter().all(|[r, _, b]| b > r), "{middles:?}");
    assert!(frames.windows(2).all(|pair| pair[0] != pair[1]));
}
