//! Surfaces in the pictures of `vcsg render`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::RgbaImage;
use serde_json::Value;
use tempfile::TempDir;

/// A ball, and the surface of it.
const BALL: &str = "scene spacing=2 { sphere radius=20 value=100 }
surface iso=50 color=\"#ff0000\"
render shading=#false size=\"64x48\"
background \"transparent\"
";

/// A small dense ball in a large thin one, and the surface of the dense one.
const TWO_BALLS: &str = "scene spacing=1 {
    union rule=\"max\" { sphere radius=20 value=10 filter=0; sphere radius=8 value=100 filter=0 }
}
surface iso=50 color=\"#ff0000\"
render shading=#false size=\"48x48\"
background \"transparent\"
";

/// A thin blue veil.
const VEIL: &str =
    "transfer unit-mm=10 { point 0 opacity=0.3 color=\"#0000ff\"; point 100 opacity=0.3 color=\"#0000ff\" }\n";

fn render(folder: &Path, text: &str, options: &[&str]) -> Output {
    fs::write(folder.join("scene.kdl"), text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_vcsg"));
    command
        .current_dir(folder)
        .args(["render", "scene.kdl", "-o", "a.png", "--validation", "--json"]);
    let output = command.args(options).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{options:?}: {message}");
    output
}

/// The picture and what `--json` says of it.
fn drawn(text: &str, options: &[&str]) -> (RgbaImage, Value) {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let output = render(folder.path(), text, options);
    let picture = image::open(folder.path().join("a.png")).unwrap().to_rgba8();
    (picture, serde_json::from_slice(&output.stdout).unwrap())
}

/// The bounding sphere of a ball of 20 mm's box fits the frame's shorter side, so that is 40√3 mm long.
fn pixels_per_mm(picture: &RgbaImage) -> f64 {
    f64::from(picture.width().min(picture.height())) / (40.0 * 3f64.sqrt())
}

/// How far a pixel's centre is from the middle of the picture, in millimetres.
fn radius_mm(picture: &RgbaImage, x: u32, y: u32) -> f64 {
    let off = |at: u32, size: u32| f64::from(at) + 0.5 - 0.5 * f64::from(size);
    off(x, picture.width()).hypot(off(y, picture.height())) / pixels_per_mm(picture)
}

const RED: [u8; 4] = [255, 0, 0, 255];
const NOTHING: [u8; 4] = [0; 4];

#[test]
fn a_surface_fills_the_silhouette_of_its_solid() {
    let (picture, about) = drawn(BALL, &[]);
    assert_eq!(about["surfaces"][0]["iso"], 50.0);
    assert!(about["surfaces"][0]["triangles"].as_u64().unwrap() > 500, "{about}");
    assert!(about["milliseconds"]["extract"].is_number(), "{about}");
    for (x, y, pixel) in picture.enumerate_pixels() {
        // Vertices are on the sphere but for a last halving, well below 0.01 mm. A point of weights w on a triangle of edges e has
        // |p|² = R² − Σ wᵢwⱼ eᵢⱼ², of which the sum is at most a third of the square of a cell's diagonal: 12 / 3, so it is less
        // than 0.11 mm inside.
        let radius = radius_mm(&picture, x, y);
        if radius > 20.01 {
            assert_eq!(pixel.0, NOTHING, "{x} {y}");
        } else if radius < 19.88 {
            assert_eq!(pixel.0, RED, "{x} {y}");
        }
    }
}

/// On the processor the same surface fills it, and a veil lies over it as on the device: of 8 bits a step apart, where both round.
#[test]
fn surfaces_are_drawn_among_cast_rays_too() {
    for text in [BALL.to_owned(), format!("{TWO_BALLS}{VEIL}")] {
        let (on_device, _) = drawn(&text, &[]);
        let (cast, about) = drawn(&text, &["--renderer", "raycast"]);
        assert!(about["surfaces"][0]["triangles"].as_u64().unwrap() > 500, "{about}");
        let differ =
            |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 1);
        let differing = on_device.pixels().zip(cast.pixels()).filter(differ).count();
        let shown = cast.pixels().filter(|pixel| pixel.0 != NOTHING).count();
        println!("{differing} of {shown} differ");
        assert!(shown > 500 && differing == 0, "{differing} of {shown} differ");
    }
}

#[test]
fn samples_are_drawn_too_where_a_transfer_function_says_how() {
    let (alone, _) = drawn(TWO_BALLS, &[]);
    let (both, _) = drawn(&format!("{TWO_BALLS}{VEIL}"), &[]);
    for (x, y, pixel) in alone.enumerate_pixels() {
        let veiled = both.get_pixel(x, y).0;
        // The surface is within a sample of the inner sphere, and samples show up to a pixel of 1.5 mm beyond the outer one's.
        match radius_mm(&alone, x, y) {
            r if r < 7.0 => {
                assert_eq!(pixel.0, RED, "{x} {y}");
                assert!(veiled[0] > 50 && veiled[2] > 50 && veiled[3] == 255, "{veiled:?}");
            }
            r if (9.0..18.0).contains(&r) => {
                assert_eq!(pixel.0, NOTHING, "{x} {y}");
                assert!(veiled[0] == 0 && veiled[3] > 0 && veiled[3] < 255, "{veiled:?}");
            }
            r if r > 22.0 => assert_eq!((pixel.0, veiled), (NOTHING, NOTHING), "{x} {y}"),
            _ => {}
        }
    }
}

#[test]
fn options_say_which_surfaces_and_whether_samples_are_drawn() {
    let bare = TWO_BALLS.replace("surface iso=50 color=\"#ff0000\"\n", "");
    let (surfaces, about) = drawn(&bare, &["--surface", "5", "--surface", "50"]);
    assert_eq!(about["surfaces"].as_array().unwrap().len(), 2);
    assert_eq!(
        surfaces.get_pixel(24, 14).0[3],
        255,
        "the surface at 5 is the outer ball's"
    );
    let (replaced, about) = drawn(TWO_BALLS, &["--surface", "5"]);
    assert_eq!(about["surfaces"][0]["iso"], 5.0);
    assert_eq!(replaced.get_pixel(24, 14).0[3], 255);
    let preset = ["--preset", "grey", "--window", "100", "--level", "50"];
    for shows_samples in [&preset[..], &["--mode", "mip"]] {
        let (picture, _) = drawn(TWO_BALLS, shows_samples);
        let alpha = picture.get_pixel(24, 14).0[3];
        assert!(alpha > 0, "{shows_samples:?}: the outer ball is there");
    }
}

#[test]
fn an_empty_surface_is_remarked_on() {
    let folder = tempfile::tempdir().unwrap();
    let output = render(folder.path(), BALL, &["--surface", "101"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("note: the surface at 101 is empty: values go from"),
        "{said}"
    );
    let picture = image::open(folder.path().join("a.png")).unwrap().to_rgba8();
    assert!(picture.pixels().all(|pixel| pixel.0 == NOTHING));
}
