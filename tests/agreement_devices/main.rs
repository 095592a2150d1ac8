//! Slices on Vulkan against bounds derived from the device's own precision (design laws 2, 3 and 9), on every device that
//! `make setup` provides.
//!
//! Which driver is loaded is decided before a process first touches Vulkan. So one test runs all laws on whatever device is
//! there, and a test for each device runs that test in a process of its own, with its driver in the environment.

mod blocks;
mod bound_widths;
mod comparators;
mod device;
#[path = "../laws/raycast/drawing.rs"]
mod drawing;
mod edits;
mod hidden;
mod inside;
mod meshes;
mod meshes_inside;
mod modes;
mod random;
mod rays;
mod scene;
mod shapes;

use std::path::{Path, PathBuf};
use std::process::Command;

/// Every law; each panics with what is wrong.
const LAWS: [fn(); 24] = [
    blocks::one_block_or_many_the_picture_is_the_same,
    bound_widths::a_smooth_scene_has_narrow_bounds,
    comparators::a_shifted_pixel_is_out_of_bounds,
    comparators::a_dropped_block_is_out_of_bounds,
    comparators::swapped_blocks_are_out_of_bounds,
    comparators::flipped_operands_are_out_of_bounds,
    comparators::other_opacities_are_out_of_bounds,
    comparators::half_a_texel_is_out_of_bounds,
    edits::pages_follow_edits,
    edits::blocks_that_should_have_been_made_anew_are_out_of_bounds,
    meshes::meshes_are_within_bounds,
    meshes::a_sheet_has_narrow_bounds,
    meshes::odd_meshes_do_no_harm,
    meshes::wrong_meshes_are_out_of_bounds,
    meshes_inside::slices_stop_at_meshes,
    meshes_inside::a_mesh_too_far_back_is_out_of_bounds,
    modes::the_same_scene_gives_the_same_bytes,
    hidden::closed_tiles_are_passed_over,
    modes::what_is_hidden_may_be_left_out,
    modes::slices_agree_with_the_reference,
    modes::random_scenes_agree_with_the_reference,
    rays::slices_and_rays_agree,
    rays::slices_and_rays_agree_among_meshes,
    rays::a_shifted_pixel_is_seen_between_them,
];

/// Mesa's software rasteriser, as Debian installs it.
const LAVAPIPE: &str = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json";

fn swiftshader() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/deps/swiftshader/vk_swiftshader_icd.json")
}

/// Runs all laws with the driver of `manifest` and the further `environment`.
fn laws_hold(manifest: &Path, environment: &[(&str, &str)]) {
    assert!(manifest.exists(), "{} is missing: run `make setup`", manifest.display());
    let laws = std::env::current_exe().expect("this very program");
    let output = Command::new(laws)
        .args(["--exact", "this_device_keeps_the_laws", "--nocapture"])
        .env("VK_ICD_FILENAMES", manifest)
        .env_remove("VK_DRIVER_FILES")
        .env_remove("GALLIVM_PERF")
        .envs(environment.iter().copied())
        .output()
        .expect("this very program runs");
    let [said, complained] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{said}\n{complained}");
    assert!(said.contains("1 passed"), "no law was tested: {said}");
    println!("{said}\n{complained}");
}

#[test]
fn this_device_keeps_the_laws() {
    LAWS.iter().for_each(|law| law());
}

#[test]
fn lavapipe_keeps_the_laws() {
    laws_hold(Path::new(LAVAPIPE), &[(device::NAME, "llvmpipe")]);
}

/// The same driver without its 8-bit filtering computes in single precision throughout, and is held to that.
#[test]
fn lavapipe_in_single_precision_keeps_the_laws() {
    let environment = [
        (device::NAME, "llvmpipe"),
        (device::PRECISION, "single"),
        ("GALLIVM_PERF", "no_aos_sampling"),
    ];
    laws_hold(Path::new(LAVAPIPE), &environment);
}

#[test]
fn swiftshader_keeps_the_laws() {
    laws_hold(&swiftshader(), &[(device::NAME, "SwiftShader")]);
}
