//! How much memory reading may take.
//!
//! *Practice.* A declared size is a claim even where the file can hold it: four megabytes of gzip may say that they are four gigabytes
//! of zeros, and be right. So what a reader allocates because a header says so is held against a budget first: half the machine's
//! memory, unless the user says another. Voxels that go chunk by chunk into bricks take what their bricks take, and that is what
//! is held against it.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use super::error::{Problem, ReadError};

/// The most memory that reading may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    bytes: u64,
}

impl Budget {
    /// The machine's memory that is taken for what it has where it does not tell.
    const UNKNOWN_MEMORY: u64 = 8 << 30;

    /// A budget of so many bytes.
    pub const fn of_bytes(bytes: u64) -> Self {
        Self { bytes }
    }

    /// Its bytes.
    pub const fn bytes(self) -> u64 {
        self.bytes
    }

    /// Whether `bytes` of memory for what the file at `path` declares are within it: asked before they are allocated.
    ///
    /// # Errors
    /// [`Problem::Budget`] where they are not.
    pub(super) fn check(self, path: &Path, bytes: u64) -> Result<(), ReadError> {
        let budget = self.bytes;
        match bytes <= budget {
            true => Ok(()),
            false => Err(ReadError::new(path, Problem::Budget { bytes, budget })),
        }
    }
}

impl Default for Budget {
    /// Half of the memory that this process can have.
    fn default() -> Self {
        static HALF: LazyLock<u64> = LazyLock::new(|| memory().unwrap_or(Budget::UNKNOWN_MEMORY) / 2);
        Self { bytes: *HALF }
    }
}

/// The machine's memory, or what this process may have of it.
fn memory() -> Option<u64> {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| total(&text));
    let group = fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let group = group.and_then(|text| text.trim().parse().ok());
    [machine, group].into_iter().flatten().min()
}

/// The bytes of the line `MemTotal: … kB`.
fn total(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machines_memory_is_read() {
        assert_eq!(
            total("MemFree: 3 kB\nMemTotal:       24576 kB\nX: 1"),
            Some(24576 * 1024)
        );
        assert_eq!(total("MemTotal: many kB"), None);
        assert_eq!(total(""), None);
    }

    #[test]
    fn what_is_beyond_the_budget_is_refused_with_both_numbers() {
        let budget = Budget::of_bytes(1 << 20);
        let path = Path::new("a.nrrd");
        assert!(budget.check(path, 1 << 20).is_ok());
        let error = budget.check(path, 4 << 30).unwrap_err().to_string();
        for word in ["a.nrrd", "4096 MiB", "1 MiB", "--read-budget-mib"] {
            assert!(error.contains(word), "{error}");
        }
    }
}
