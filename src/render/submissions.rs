//! A frame's work on the device, in submissions of bounded time.

use std::sync::Arc;

use crate::gpu::{Device, GpuError, Recording, RenderPass, Submission};

/// Fragments of one submission, about: it ends within a second even on a processor.
pub const SUBMISSION_FRAGMENTS: f64 = 5e7;

/// The passes of a frame, in recordings that each end in bounded time.
#[derive(Default)]
pub struct Submissions {
    recordings: Vec<Recording>,
    /// Fragments of the last one.
    fragments: f64,
}

impl Submissions {
    /// The recording at hand.
    pub fn last(&mut self) -> &mut Recording {
        if self.recordings.is_empty() {
            self.recordings.push(Recording::new());
        }
        let last = self.recordings.len() - 1;
        &mut self.recordings[last]
    }

    /// Adds `pass` of about so many fragments.
    pub fn render(&mut self, pass: RenderPass, fragments: f64) {
        self.fragments += fragments;
        if self.fragments > SUBMISSION_FRAGMENTS {
            self.recordings.push(Recording::new());
            self.fragments = fragments;
        }
        self.last().render(pass);
    }

    /// Hands over what there is so far, without waiting, and begins anew.
    pub fn start(&mut self, device: &Arc<Device>) -> Result<Vec<Submission>, GpuError> {
        let recordings = std::mem::take(self).recordings;
        recordings.iter().map(|recording| device.submit(recording)).collect()
    }

    /// Does all of it.
    pub fn run(&self, device: &Arc<Device>) -> Result<(), GpuError> {
        for recording in &self.recordings {
            device.submit(recording)?.wait()?;
        }
        Ok(())
    }
}
