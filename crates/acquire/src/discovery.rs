//! `trunnion devices`: which ports and interfaces there are, and what answers on them.

use crate::drivers::DRIVERS;
use crate::probe::{Answer, Found, Medium, Probe, Scheme};
use crate::session_end::SessionEnd;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use tokio_serial::SerialPortType;
use trunnion_core::Role;
use trunnion_core::secret::has_login;

/// Where the system keeps names of serial ports that stay when others are plugged in, the best first.
const LASTING_NAMES: [&str; 2] = ["/dev/serial/by-id", "/dev/serial/by-path"];
/// `ARPHRD_CAN`, the type of a CAN interface.
const TYPE_CAN: &str = "280";

/// A place where a device may be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// What kind of address it is.
    pub medium: Medium,
    /// The address for the configuration: a name that lasts, where there is one.
    pub address: String,
    /// The address of the moment, `/dev/ttyUSB0`.
    pub device: String,
    /// What the system knows of it.
    pub about: String,
}

impl Place {
    /// A serial port named by the user.
    pub fn serial_port(path: &str) -> Self {
        let device = fs::canonicalize(path).ok().and_then(|path| path.to_str().map(str::to_owned));
        let device = device.unwrap_or_else(|| path.to_owned());
        Self { medium: Medium::Serial, address: path.to_owned(), device, about: String::new() }
    }

    fn server(scheme: Scheme, url: String) -> Self {
        Self { medium: Medium::Network(scheme), device: url.clone(), address: url, about: String::new() }
    }
}

/// An address that is not asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownAddress {
    /// No driver asks there.
    #[error(
        "{address} is no address that can be asked; allowed: {allowed}, or a host alone, which is asked in all these ways"
    )]
    Unknown {
        /// The address.
        address: String,
        /// What can be asked.
        allowed: String,
    },
    /// It would be shown, and is not.
    #[error(
        "an address holds a user or a password, which screens and logs show; give the address without them, and user and \
         password_file in the table of the device"
    )]
    Login,
}

/// What an address on the network may mean to the drivers, or to the one named by `only`: its scheme shows which; a host alone
/// may be each kind of server, at the port given or at its usual one.
///
/// # Errors
/// A scheme that no driver knows; a user or a password in the address.
pub fn servers(address: &str, only: Option<&str>) -> Result<Vec<Place>, UnknownAddress> {
    if has_login(address) {
        return Err(UnknownAddress::Login);
    }
    let schemes = asked_by(only).filter_map(|(_, probe)| match probe.medium {
        Medium::Network(scheme) => Some(scheme),
        Medium::Serial | Medium::Can => None,
    });
    let schemes: Vec<Scheme> = schemes.collect();
    let places: Vec<Place> = match address.split_once("://") {
        Some((name, _)) => {
            let fitting = schemes.iter().filter(|scheme| scheme.name == name);
            fitting.map(|scheme| Place::server(*scheme, address.into())).collect()
        }
        None => schemes.iter().map(|scheme| Place::server(*scheme, url(*scheme, address))).collect(),
    };
    if places.is_empty() {
        let allowed = schemes.iter().map(|scheme| format!("{}://HOST:PORT", scheme.name));
        let allowed = allowed.collect::<Vec<_>>().join(", ");
        return Err(UnknownAddress::Unknown { address: address.into(), allowed });
    }
    Ok(places)
}

/// The URL of a server at a host, with the usual port where none is given.
fn url(scheme: Scheme, host: &str) -> String {
    let (authority, path) = host.split_at(host.find('/').unwrap_or(host.len()));
    let has_port = authority.rsplit(']').next().is_some_and(|end| end.contains(':'));
    let port = if has_port { String::new() } else { format!(":{}", scheme.port) };
    format!("{}://{authority}{port}{path}", scheme.name)
}

/// The drivers that ask something, with what they ask.
fn asked_by(only: Option<&str>) -> impl Iterator<Item = (&'static str, Probe)> {
    let wanted = DRIVERS.iter().filter(move |driver| only.is_none_or(|only| only == driver.name));
    wanted.filter_map(|driver| Some((driver.name, driver.probe?)))
}

/// What answers at a place.
#[derive(Debug)]
pub struct Look {
    /// The place.
    pub place: Place,
    /// The driver whose questions were answered, and the answer.
    pub found: Option<(&'static str, Found)>,
    /// What is wrong, with what to do.
    pub trouble: Option<String>,
    /// What was asked, in words.
    pub asked: Vec<&'static str>,
}

/// Every serial port and CAN interface of this computer.
pub fn places() -> Result<Vec<Place>, tokio_serial::Error> {
    let mut lasting = BTreeMap::new();
    for folder in LASTING_NAMES.iter().rev() {
        lasting.extend(links(Path::new(folder)));
    }
    let mut places: Vec<Place> = tokio_serial::available_ports()?
        .into_iter()
        .map(|port| {
            let about = match port.port_type {
                SerialPortType::UsbPort(usb) => {
                    [usb.manufacturer, usb.product].into_iter().flatten().collect::<Vec<_>>().join(" ")
                }
                SerialPortType::PciPort => "built in".into(),
                SerialPortType::BluetoothPort => "Bluetooth".into(),
                SerialPortType::Unknown => String::new(),
            };
            let address = lasting.get(&port.port_name).cloned().unwrap_or_else(|| port.port_name.clone());
            Place { medium: Medium::Serial, address, device: port.port_name, about }
        })
        .collect();
    places.sort_by(|a, b| a.device.cmp(&b.device));
    places.extend(can_interfaces(Path::new("/sys/class/net")));
    Ok(places)
}

/// Devices by the links of a folder that point at them.
fn links(folder: &Path) -> Vec<(String, String)> {
    let text = |path: PathBuf| path.to_str().map(str::to_owned);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut links: Vec<(String, String)> = entries
        .filter_map(|entry| Some((text(fs::canonicalize(entry.path()).ok()?)?, text(entry.path())?)))
        .collect();
    links.sort();
    links
}

fn can_interfaces(folder: &Path) -> Vec<Place> {
    let is_can = |entry: &fs::DirEntry| {
        fs::read_to_string(entry.path().join("type")).is_ok_and(|kind| kind.trim() == TYPE_CAN)
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.filter(is_can).filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    let place = |name: String| Place {
        medium: Medium::Can,
        address: name.clone(),
        device: name,
        about: "CAN interface".into(),
    };
    names.into_iter().map(place).collect()
}

/// Asks what answers at a place, one driver after the other until one is sure; `only` names a single driver.
pub async fn look(place: Place, only: Option<&str>) -> Look {
    let mut look = Look { place, found: None, trouble: None, asked: Vec::new() };
    let mut senseless = 0;
    let medium = look.place.medium;
    for (driver, probe) in asked_by(only).filter(|(_, probe)| probe.medium == medium) {
        look.asked.push(probe.asks);
        match (probe.run)(&look.place.address).await {
            Answer::Found(found) => {
                look.found = Some((driver, found));
                return look;
            }
            Answer::Senseless { bytes } => senseless += bytes,
            Answer::Nothing => {}
            Answer::Trouble(end) => {
                let final_word = matches!(
                    end,
                    SessionEnd::Absent { .. } | SessionEnd::Refused { .. } | SessionEnd::WrongDevice { .. }
                );
                look.trouble = Some(end.to_string());
                if final_word {
                    return look;
                }
            }
        }
    }
    if look.trouble.is_none() {
        look.trouble = Some(silence(&look, senseless));
    }
    look
}

fn silence(look: &Look, senseless_bytes: u64) -> String {
    match (look.place.medium, senseless_bytes) {
        _ if look.asked.is_empty() => "no driver asks anything here".into(),
        (Medium::Serial, 0) => {
            "nothing answers: is the device switched on, is it RS-232 or RS-422 as the adapter, are \
                                transmit and receive crossed where they must be?"
                .into()
        }
        (Medium::Serial, bytes) => format!(
            "{bytes} bytes came that make no sense at any line speed asked: set the device to one of them, or it is a \
             device without a driver (the driver \"ascii\" with preset = \"custom\" reads lines of text)"
        ),
        (Medium::Can | Medium::Network(_), _) => "nothing answers".into(),
    }
}

/// What a person must say of devices that do not report their range: without it nobody can tell whether a probe is at its centre.
const RANGE_IS_MISSING: &str = "# travel_mm = [-1, 1]   # not reported: put both ends of what it shows in, mm, and take the first # away; without it \
                                the centre of the probes is not known";

/// Gives out roles, each once, as a configuration wants them.
#[derive(Debug, Default)]
pub struct Roles {
    given: usize,
    tables: usize,
}

impl Roles {
    /// The `[[device]]` lines of what was found, ready to paste. When there are no roles left, they are comments.
    pub fn table(&mut self, driver: &str, found: &Found) -> String {
        let names = Role::NAMES.map(|(name, _)| name);
        let guessable = names.len() - 1; // a temperature is nothing to guess
        let wanted: usize = found.keys.iter().map(|key| key.matches("{role}").count()).sum();
        let enough = self.given + wanted <= guessable;
        let mut roles = (self.given..).map(|index| names[index % guessable]);
        let name = if wanted == 1 {
            names[self.given % guessable].into()
        } else {
            format!("{driver}-{}", self.tables + 1)
        };
        let mut lines =
            vec!["[[device]]".into(), format!("name = \"{name}\""), format!("driver = \"{driver}\"")];
        for key in &found.keys {
            let mut pieces = key.split("{role}");
            let mut line = pieces.next().unwrap_or_default().to_owned();
            for piece in pieces {
                line += &format!("\"{}\"{piece}", roles.next().unwrap_or(names[0]));
            }
            lines.push(line);
        }
        if wanted > 0 && !found.keys.iter().any(|key| key.starts_with("range_mm")) {
            lines.push(RANGE_IS_MISSING.into());
        }
        self.tables += 1;
        if enough {
            self.given += wanted;
            return lines.join("\n") + "\n";
        }
        let comments: Vec<String> = lines.iter().map(|line| format!("# {line}\n")).collect();
        format!("# All roles are given away; choose the one that is meant.\n{}", comments.concat())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse_devices;

    fn found(keys: &[&str]) -> Found {
        Found { identity: "x".into(), keys: keys.iter().map(|key| (*key).to_owned()).collect() }
    }

    #[test]
    fn lines_to_paste_are_a_configuration_in_which_every_role_is_there_once() {
        let mut roles = Roles::default();
        let probe = |port: &str| found(&[&format!("port = \"{port}\""), "role = {role}", "range_mm = 2"]);
        let heads = found(&[
            "port = \"/dev/b\"",
            "heads = [{ head = 1, role = {role} }, { head = 2, role = {role} }, { head = 3, role = {role} }]",
        ]);
        let text = roles.table("optoncdt", &probe("/dev/a"))
            + &roles.table("keyence-dl-rs1a", &heads)
            + &roles.table("optoncdt", &probe("/dev/c"));
        let devices = parse_devices("pasted", &text).unwrap();
        assert_eq!(devices.len(), 2, "the last one is a comment:\n{text}");
        let open =
            text.split("[[device]]").map(|table| table.contains("# travel_mm = [-1, 1]   # not reported"));
        assert_eq!(
            open.collect::<Vec<_>>(),
            [false, false, true, false],
            "optoNCDT say their range:\n{text}"
        );
        assert!(
            text.contains("# All roles are given away") && text.contains("name = \"keyence-dl-rs1a-2\""),
            "{text}"
        );
    }

    #[test]
    fn an_address_means_the_server_of_its_scheme_and_a_host_alone_each_kind() {
        let addresses = |address: &str, only: Option<&str>| -> Vec<String> {
            servers(address, only).unwrap().into_iter().map(|place| place.address).collect()
        };
        let all = addresses("10.0.0.5", None);
        for url in ["http://10.0.0.5:5000", "linuxcnc://10.0.0.5:5007"] {
            assert!(all.iter().any(|address| address == url), "{all:?}");
        }
        assert_eq!(addresses("cnc:81/agent", Some("mtconnect")), ["http://cnc:81/agent"]);
        assert_eq!(addresses("[fe80::1]", Some("linuxcnc")), ["linuxcnc://[fe80::1]:5007"]);
        assert_eq!(addresses("linuxcnc://cnc", None), ["linuxcnc://cnc"]);
        for secret in ["http://ada:geheim@cnc:5000", "ada:geheim@cnc", "opc.tcp://ada@cnc"] {
            let refused = servers(secret, None).unwrap_err().to_string();
            let shows = ["ada", "geheim", "cnc"].into_iter().find(|part| refused.contains(part));
            assert!(shows.is_none() && refused.contains("user and password_file"), "{refused}");
        }
        let reported = servers("ftp://cnc", None).unwrap_err().to_string();
        assert!(reported.contains("ftp://cnc") && reported.contains("linuxcnc://HOST:PORT"), "{reported}");
    }

    #[test]
    fn lasting_names_and_can_interfaces_are_found_where_the_system_keeps_them() {
        let root = tempfile::tempdir().unwrap();
        let make = |path: &str, text: &str| {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        make("ttyUSB0", "");
        make("net/can0/type", "280\n");
        make("net/eth0/type", "1\n");
        fs::create_dir_all(root.path().join("by-id")).unwrap();
        std::os::unix::fs::symlink("../ttyUSB0", root.path().join("by-id/usb-FTDI_1-if00")).unwrap();
        let links = links(&root.path().join("by-id"));
        assert!(
            links[0].0.ends_with("/ttyUSB0") && links[0].1.ends_with("by-id/usb-FTDI_1-if00"),
            "{links:?}"
        );
        let interfaces = can_interfaces(&root.path().join("net"));
        assert_eq!(interfaces.iter().map(|place| place.address.as_str()).collect::<Vec<_>>(), ["can0"]);
    }
}
