//! What all this was measured on.

use serde::Serialize;
use vcsg::gpu::DeviceInfo;

/// The machine and how busy it was.
#[derive(Serialize)]
pub struct Machine {
    processor: String,
    threads: usize,
    device: String,
    /// Averages over 1, 5 and 15 minutes when the bench began, in /proc's words.
    load_average: String,
}

impl Machine {
    /// This machine, drawing on `device`.
    pub fn now(device: &DeviceInfo) -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        let processor = read("/proc/cpuinfo")
            .lines()
            .find_map(|line| Some(line.strip_prefix("model name")?.split_once(':')?.1.trim().to_owned()));
        let load = read("/proc/loadavg");
        Self {
            processor: processor.unwrap_or_default(),
            threads: rayon::current_num_threads(),
            device: format!("{}, {} {}", device.name, device.driver, device.driver_version),
            load_average: load.split(' ').take(3).collect::<Vec<_>>().join(" "),
        }
    }

    /// Prints it on a line.
    pub fn print(&self) {
        println!(
            "{} · {} threads · {} · load {}",
            self.processor, self.threads, self.device, self.load_average
        );
    }
}
