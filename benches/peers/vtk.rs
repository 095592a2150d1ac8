//! VTK as a process that does one run whenever it is asked, so that ours and its runs take turns.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde::de::DeserializeOwned;

use crate::Outcome;
use crate::pinning;
use crate::runs::Run;

const PYTHON: &str = "target/deps/vtk/bin/python";

/// Files that `make setup` installs and this bench cannot do without.
const REQUIRED: [&str; 3] = [
    PYTHON,
    "target/deps/data/ch2.nii.gz",
    "target/deps/data/ch2better.nii.gz",
];

/// Fails if something is missing that `make setup` installs.
pub fn require_setup() -> Outcome<()> {
    match REQUIRED.iter().find(|path| !Path::new(path).exists()) {
        Some(path) => Err(format!("{path} is missing: run make setup").into()),
        None => Ok(()),
    }
}

/// Writes the benchmark volumes unless they are there.
pub fn write_volumes() -> Outcome<()> {
    run(Command::new(PYTHON).arg("tools/peers/volumes.py"))
}

/// Has `script` write what it writes into a folder.
pub fn write_with(script: &str, folder: &Path) -> Outcome<()> {
    run(Command::new(PYTHON).arg(script).arg(folder))
}

fn run(script: &mut Command) -> Outcome<()> {
    let status = script.stdout(Stdio::null()).status()?;
    match status.success() {
        true => Ok(()),
        false => Err(format!("{script:?}: {status}; run make setup").into()),
    }
}

/// A script or program of tools/peers that serves: it draws or computes once for every line it is sent.
pub struct Peer {
    child: Child,
    /// `None` once it has been told to end.
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    script: &'static str,
}

impl Peer {
    /// Starts `script`; returns it warmed up, with what it says about itself.
    pub fn start<T: DeserializeOwned>(script: &'static str, arguments: &[&str]) -> Outcome<(Self, T)> {
        let mut command = Command::new(PYTHON);
        command
            .arg(script)
            .args(arguments)
            .arg("--serve")
            // Both sides draw on Mesa's processor driver, whatever else the machine has.
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            // NumPy only holds the voxels: its threads would stand between those that are pinned.
            .env("OPENBLAS_NUM_THREADS", "1");
        Self::serve(&mut command, script)
    }

    /// Starts a program that serves, and is called `name`; returns it likewise.
    pub fn serve<T: DeserializeOwned>(program: &mut Command, name: &'static str) -> Outcome<(Self, T)> {
        let mut child = program.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let requests = child.stdin.take();
        let answers = child.stdout.take().ok_or("a pipe was asked for")?;
        let mut peer = Self {
            child,
            requests,
            answers: BufReader::new(answers),
            script: name,
        };
        let about = peer.answer()?;
        Ok((peer, about))
    }

    /// Keeps each of its threads on a processor.
    pub fn pin(&self) -> Outcome<()> {
        pinning::pin_threads_of(self.child.id())
    }

    /// One run.
    pub fn run(&mut self) -> Outcome<Run> {
        if let Some(requests) = &mut self.requests {
            requests.write_all(b"\n")?;
        }
        self.answer()
    }

    fn answer<T: DeserializeOwned>(&mut self) -> Outcome<T> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            let status = self.child.wait()?;
            return Err(format!("{} ended: {status}; run make setup", self.script).into());
        }
        let error = |e| format!("{} answered {line:?}: {e}", self.script);
        serde_json::from_str(&line).map_err(|e| error(e).into())
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // Without requests it ends by itself; how it ends changes nothing that was measured.
        self.requests = None;
        let _ = self.child.wait();
    }
}
