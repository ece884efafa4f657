//! Programs of others, in Python, that run beside a test.

use crate::stopped::Stopped;
use crate::workspace_root;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{ChildStdout, Command, Stdio};

/// Python with the packages of `tests/peers/requirements.txt`.
///
/// # Panics
/// When `tests/peers/run` has not set it up: a peer test never passes without its peer.
pub fn peers_python() -> PathBuf {
    std::env::var_os("TRUNNION_PEERS_PYTHON").expect("run the peer tests through tests/peers/run").into()
}

/// A script of `tests/peers` in a process of its own, which ends with this.
pub struct PythonPeer {
    child: Stopped,
    output: BufReader<ChildStdout>,
    /// The line by which it says that it is ready.
    pub reported: String,
}

impl PythonPeer {
    /// Starts it and waits for its first line.
    ///
    /// # Panics
    /// When it does not start or says nothing.
    pub fn start(script: &str, args: &[&OsStr]) -> Self {
        let mut child = Command::new(peers_python())
            .arg(workspace_root().join("tests/peers").join(script))
            .args(args)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("python starts");
        let mut reported = String::new();
        let mut output = BufReader::new(child.stdout.take().expect("piped"));
        output.read_line(&mut reported).expect("the peer says when it is ready");
        Self { child: Stopped(child), output, reported: reported.trim().to_owned() }
    }

    /// The next line of JSON that it prints.
    ///
    /// # Panics
    /// When it has ended, as it does when nothing comes, or prints something else.
    pub fn json(&mut self) -> serde_json::Value {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("the peer prints");
        serde_json::from_str(&line).expect("a line of JSON; the peer has ended without one")
    }

    /// The pseudo-terminal it answers on, from its first line of JSON.
    ///
    /// # Panics
    /// When it reports none.
    pub fn port(&self) -> String {
        let reported: serde_json::Value = serde_json::from_str(&self.reported).expect("one JSON line");
        reported["port"].as_str().expect("a port").to_owned()
    }

    /// Writes it a line.
    ///
    /// # Panics
    /// When it does not listen any more.
    pub fn order(&mut self, word: &str) {
        writeln!(self.child.0.stdin.as_mut().expect("piped"), "{word}").expect("the peer listens");
    }
}
