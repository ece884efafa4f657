//! The broker mosquitto of this computer.

use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Starts it for this computer alone, without a password.
///
/// # Errors
/// When it is not installed.
pub fn broker(port: u16) -> std::io::Result<Child> {
    // Debian installs it where only root looks.
    let usual = "/usr/sbin/mosquitto";
    let program = if Path::new(usual).exists() { usual } else { "mosquitto" };
    Command::new(program).args(["-p", &port.to_string()]).stderr(Stdio::null()).spawn()
}
