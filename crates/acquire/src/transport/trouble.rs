//! Why a port cannot be opened or is slow, and what a person can do about it. Linux: the answers are in `/etc/group`,
//! `/proc` and `/sys`.

use crate::session_end::SessionEnd;
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Rules that give the ports to a group and make FTDI adapters quick; shipped with the service.
const RULES: &str = "systemd/60-trunnion.rules";
/// Longest time an FTDI adapter may hold bytes back without a warning, ms.
const PROMPT_LATENCY_MS: u32 = 1;

/// The end of a session whose port is not there.
pub fn absent(name: &str) -> SessionEnd {
    SessionEnd::Absent { address: name.into(), remedy: "plug it in or correct the port" }
}

/// The end of a session whose port did not open.
pub fn refusal(name: &str, error: &tokio_serial::Error) -> SessionEnd {
    let gone = matches!(error.kind, tokio_serial::ErrorKind::Io(ErrorKind::NotFound));
    if gone || !Path::new(name).exists() {
        return absent(name);
    }
    let why = match error.kind {
        tokio_serial::ErrorKind::Io(ErrorKind::PermissionDenied) => no_permission(name),
        tokio_serial::ErrorKind::NoDevice | tokio_serial::ErrorKind::Io(ErrorKind::WouldBlock) => {
            in_use(name)
        }
        _ => format!("{error}; is it a serial port?"),
    };
    SessionEnd::Refused { address: name.into(), why }
}

fn no_permission(name: &str) -> String {
    let group = fs::metadata(name).ok().filter(|port| port.gid() != 0 && port.mode() & 0o060 == 0o060);
    match group.and_then(|port| group_name(port.gid())) {
        Some(group) => format!(
            "no permission; it belongs to the group {group}: `sudo usermod -aG {group} $USER`, then log in again"
        ),
        None => format!(
            "no permission, and no group has it: install {RULES} in /etc/udev/rules.d, then plug the adapter in again"
        ),
    }
}

fn group_name(gid: u32) -> Option<String> {
    let groups = fs::read_to_string("/etc/group").ok()?;
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, id) = (fields.next()?, fields.nth(1)?);
        (id.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

fn in_use(name: &str) -> String {
    match users(name).as_slice() {
        [] => "another program uses it (`sudo fuser -v` names it); close that program".into(),
        users => format!("{} uses it; close that program", users.join(", ")),
    }
}

/// The programs that have the port open, as far as the system lets us see.
fn users(name: &str) -> Vec<String> {
    let (Ok(port), Ok(processes)) = (fs::canonicalize(name), fs::read_dir("/proc")) else {
        return Vec::new();
    };
    let me = std::process::id();
    let program = |entry: fs::DirEntry| -> Option<String> {
        let id: u32 = entry.file_name().to_str()?.parse().ok()?;
        let mut files = fs::read_dir(entry.path().join("fd")).ok()?.flatten();
        let holds = files.any(|file| fs::read_link(file.path()).is_ok_and(|target| target == port));
        if !holds {
            return None;
        }
        let command = fs::read_to_string(entry.path().join("comm")).unwrap_or_default();
        let whose = if id == me { "this very program" } else { command.trim() };
        Some(format!("{whose} (process {id})"))
    };
    processes.flatten().filter_map(program).collect()
}

/// A warning when the port is an FTDI adapter that holds bytes back.
pub fn slow_adapter(name: &str) -> Option<String> {
    let path = latency_file(name)?;
    let latency_ms: u32 = fs::read_to_string(path).ok()?.trim().parse().ok()?;
    (latency_ms > PROMPT_LATENCY_MS).then(|| {
        format!(
            "the adapter of {name} holds bytes back for up to {latency_ms} ms (latency_timer); install {RULES} in \
             /etc/udev/rules.d to make it {PROMPT_LATENCY_MS} ms, then plug it in again"
        )
    })
}

fn latency_file(name: &str) -> Option<PathBuf> {
    let port = fs::canonicalize(name).ok()?;
    Some(Path::new("/sys/class/tty").join(port.file_name()?).join("device/latency_timer"))
}
