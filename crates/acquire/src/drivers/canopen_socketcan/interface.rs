//! What the system says of a CAN interface before it is opened: is it there, is it one, is it up, is it bus-off.
//! Source: Linux, Documentation/ABI/testing/sysfs-class-net; a CAN controller that is bus-off has no carrier
//! (drivers/net/can/dev/dev.c, `can_bus_off`).

use crate::session_end::SessionEnd;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// `ARPHRD_CAN`.
const TYPE_CAN: &str = "280";
/// `IFF_UP`.
const FLAG_UP: u32 = 1;

/// Refuses an interface that cannot be used now, with the command that helps.
pub(super) fn check(name: &str) -> Result<(), SessionEnd> {
    check_in(Path::new("/sys/class/net"), name)
}

fn check_in(all: &Path, name: &str) -> Result<(), SessionEnd> {
    let folder = all.join(name);
    if !folder.exists() {
        return Err(absent(name));
    }
    let read = |file: &str| match fs::read_to_string(folder.join(file)) {
        Ok(text) => Ok(Some(text.trim().to_string())),
        // The carrier of an interface that is down cannot be read.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::NotFound) => Ok(None),
        Err(error) => Err(refused(name, &format!("reading its {file}: {error}"))),
    };
    if read("type")?.is_some_and(|kind| kind != TYPE_CAN) {
        return Err(refused(name, "it is no CAN interface; `ip -br link` lists those there are"));
    }
    let flags = read("flags")?.and_then(|text| u32::from_str_radix(text.trim_start_matches("0x"), 16).ok());
    if flags.is_some_and(|flags| flags & FLAG_UP == 0) {
        return Err(down(name));
    }
    if read("carrier")?.as_deref() == Some("0") {
        return Err(bus_off(name));
    }
    Ok(())
}

pub(super) fn absent(name: &str) -> SessionEnd {
    SessionEnd::Absent {
        address: format!("CAN interface {name}"),
        remedy: "plug it in and load its driver, or correct `interface`; `ip -br link` lists those there are",
    }
}

pub(super) fn refused(name: &str, why: &str) -> SessionEnd {
    SessionEnd::Refused { address: name.into(), why: why.into() }
}

pub(super) fn down(name: &str) -> SessionEnd {
    refused(name, &format!("the interface is down; bring it up: {}", bring_up(name)))
}

pub(super) fn bus_off(name: &str) -> SessionEnd {
    SessionEnd::Disconnected(format!(
        "{name} is bus-off after too many errors: check cable, both 120 Ω terminators and the bit rate, then restart \
         it with `ip link set {name} type can restart`; with `restart-ms 100` it restarts by itself"
    ))
}

fn bring_up(name: &str) -> String {
    format!("ip link set {name} up type can bitrate 1000000 restart-ms 100")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reported(type_: &str, flags: &str, carrier: Option<&str>) -> Result<(), String> {
        let all = tempfile::tempdir().unwrap();
        let folder = all.path().join("can0");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("type"), format!("{type_}\n")).unwrap();
        fs::write(folder.join("flags"), format!("{flags}\n")).unwrap();
        if let Some(carrier) = carrier {
            fs::write(folder.join("carrier"), format!("{carrier}\n")).unwrap();
        }
        check_in(all.path(), "can0").map_err(|end| end.to_string())
    }

    #[test]
    fn an_interface_that_cannot_be_used_is_reported_with_the_command_that_helps() {
        assert_eq!(reported("280", "0x40081", Some("1")), Ok(()));
        let says = |found: Result<(), String>, piece: &str| {
            let text = found.unwrap_err();
            assert!(text.contains(piece), "{text}");
        };
        says(reported("280", "0x40080", None), "ip link set can0 up type can bitrate 1000000");
        says(reported("280", "0x40081", Some("0")), "ip link set can0 type can restart");
        says(reported("1", "0x1003", Some("1")), "no CAN interface");
        let absent = check_in(tempfile::tempdir().unwrap().path(), "can7").unwrap_err();
        assert!(
            matches!(&absent, SessionEnd::Absent { address, .. } if address.contains("can7")),
            "{absent}"
        );
    }
}
