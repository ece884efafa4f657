//! The broker mosquitto of this computer.

use crate::stopped::Stopped;
use std::ffi::OsStr;
use std::io;
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for it to listen: a judgement, as of a computer that has much else to do.
const BEGINS_WITHIN: Duration = Duration::from_secs(20);

/// A broker that listens; killed when it is dropped, on whatever way out.
///
/// It has no part in what a test prints: one that outlives its test would keep the reader of that waiting.
pub struct Mosquitto {
    _program: Stopped,
}

impl Mosquitto {
    /// For this computer alone, without a password.
    ///
    /// # Errors
    /// When it is not installed, or does not listen in time.
    pub fn start(port: u16) -> io::Result<Self> {
        Self::with_words(port, ["-p".as_ref(), port.to_string().as_ref()])
    }

    /// With a file of settings, which let it listen at `port`.
    ///
    /// # Errors
    /// The same.
    pub fn with_settings(port: u16, settings: &Path) -> io::Result<Self> {
        Self::with_words(port, ["-c".as_ref(), settings.as_ref()])
    }

    fn with_words(port: u16, words: [&OsStr; 2]) -> io::Result<Self> {
        // Debian installs it where only root looks.
        let usual = "/usr/sbin/mosquitto";
        let program = if Path::new(usual).exists() { usual } else { "mosquitto" };
        let mut command = Command::new(program);
        command.args(words).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let started = Self { _program: Stopped(command.spawn()?) };
        let begun = Instant::now();
        loop {
            match TcpStream::connect(("127.0.0.1", port)) {
                Ok(_) => return Ok(started),
                Err(error) if begun.elapsed() > BEGINS_WITHIN => return Err(error),
                Err(_) => std::thread::sleep(Duration::from_millis(20)),
            }
        }
    }
}
