//! `vcsg devices`: the Vulkan devices, and what each lacks.

use clap::Args;
use serde_json::json;

use super::CliError;
use super::console::{print, print_json};
use crate::gpu::{DeviceInfo, Instance, Validation};
use crate::render::SliceRenderer;

/// List the Vulkan devices, and what each lacks for drawing
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg devices
  vcsg devices --json
  vcsg render head.nii.gz -o head.png --device llvmpipe")]
pub(super) struct Devices {
    /// Describe the devices as JSON on stdout
    #[arg(long)]
    json: bool,
}

impl Devices {
    /// Lists them.
    pub fn run(&self) -> Result<(), CliError> {
        let devices = Instance::new(Validation::Off)?.devices(&SliceRenderer::REQUIREMENTS)?;
        if self.json {
            let list: Vec<_> = devices.iter().map(described).collect();
            return print_json(&json!({ "devices": list }));
        }
        let lines: Vec<_> = devices.iter().map(line).collect();
        match lines.is_empty() {
            true => Err(crate::gpu::GpuError::NoDevice.into()),
            false => print(&lines.join("\n")),
        }
    }
}

fn line(device: &DeviceInfo) -> String {
    let lacks = match device.missing.is_empty() {
        true => String::new(),
        false => format!("\n    lacks {}", device.missing.join(", ")),
    };
    format!(
        "{}  {}\n    Vulkan {}, {} {}, 3D images to {}, {} MiB\n    uuid:{}{lacks}",
        device.index,
        device.name,
        device.api_version,
        device.driver,
        device.driver_version,
        device.limits.image_dimension_3d,
        device.limits.memory_bytes >> 20,
        device.uuid_text(),
    )
}

fn described(device: &DeviceInfo) -> serde_json::Value {
    json!({
        "index": device.index,
        "name": device.name,
        "uuid": device.uuid_text(),
        "kind": format!("{:?}", device.kind).to_lowercase(),
        "driver": device.driver,
        "driver_version": device.driver_version,
        "api_version": device.api_version,
        "image_dimension_3d": device.limits.image_dimension_3d,
        "memory_bytes": device.limits.memory_bytes,
        "missing": device.missing,
    })
}
