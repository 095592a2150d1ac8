//! Threads that stay each on a processor.
//!
//! *Practice.* Linux wakes a thread where it ran before, and looks for an idle processor only sometimes. Of two threads that have
//! slept both may get the same one, and keep it for a dozen milliseconds, which is longer than a small surface takes. So threads
//! that are compared are told where to run, ours and the peers' in the same way.

use rayon::{ThreadPool, ThreadPoolBuilder};
use rustix::thread::{CpuSet, Pid, sched_getaffinity, sched_setaffinity};

use crate::Outcome;

/// So many threads for our own work.
pub fn pool(threads: usize) -> Outcome<ThreadPool> {
    let processors = processors()?;
    let pin = move |thread| {
        if let Err(error) = pin(None, &processors, thread) {
            eprintln!("peers: a thread is not pinned: {error}");
        }
    };
    Ok(ThreadPoolBuilder::new()
        .num_threads(threads)
        .start_handler(pin)
        .build()?)
}

/// Pins the threads that `process` has now, in the order in which they were made.
pub fn pin_threads_of(process: u32) -> Outcome<()> {
    let processors = processors()?;
    let mut threads = Vec::new();
    for entry in std::fs::read_dir(format!("/proc/{process}/task"))? {
        threads.push(entry?.file_name().to_string_lossy().parse()?);
    }
    threads.sort_unstable();
    for (n, thread) in threads.into_iter().enumerate() {
        pin(Pid::from_raw(thread), &processors, n)?;
    }
    Ok(())
}

/// Pins `thread`, this one if `None`, to the processor of number `n`, counted round.
fn pin(thread: Option<Pid>, processors: &[usize], n: usize) -> rustix::io::Result<()> {
    let mut only = CpuSet::new();
    only.set(processors[n % processors.len()]);
    sched_setaffinity(thread, &only)
}

/// The processors that this process may use, of which there is at least one.
fn processors() -> Outcome<Vec<usize>> {
    let allowed = sched_getaffinity(None)?;
    Ok((0..CpuSet::MAX_CPU).filter(|n| allowed.is_set(*n)).collect())
}
