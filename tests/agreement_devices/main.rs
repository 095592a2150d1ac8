//! Slices on Vulkan against bounds derived from the device's own precision (design laws 2, 3 and 9), on every device that
//! `make setup` provides.
//!
//! Which driver is loaded is decided before a process first touches Vulkan. So the laws are ignored tests, and a test for
//! each device runs them all in a process of its own, with its driver in the environment. They can be run by themselves on
//! whatever device is there: `cargo test --test agreement_devices -- --ignored`.

mod blocks;
mod bound_widths;
mod comparators;
mod device;
mod modes;
mod random;
mod scene;

use std::path::{Path, PathBuf};
use std::process::Command;

/// Mesa's software rasteriser, as Debian installs it.
const LAVAPIPE: &str = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json";

fn swiftshader() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/deps/swiftshader/vk_swiftshader_icd.json")
}

/// Runs all laws with the driver of `manifest` and the further `environment`.
fn laws_hold(manifest: &Path, environment: &[(&str, &str)]) {
    assert!(
        manifest.exists(),
        "{} is missing: run `make setup`",
        manifest.display()
    );
    let laws = std::env::current_exe().expect("this very program");
    let output = Command::new(laws)
        .args(["--ignored", "--nocapture", "--test-threads=1"])
        .env("VK_ICD_FILENAMES", manifest)
        .env_remove("VK_DRIVER_FILES")
        .env_remove("GALLIVM_PERF")
        .envs(environment.iter().copied())
        .output()
        .expect("this very program runs");
    let [said, complained] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{said}\n{complained}");
    println!("{said}\n{complained}");
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
