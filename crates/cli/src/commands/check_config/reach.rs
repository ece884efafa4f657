//! What a configuration names is touched: the folder of the recordings, files of passwords and of the encryption, ports, controllers, the
//! broker.
//!
//! What must be there before the service can do its work is a failure: a folder that takes no file, a password file or a certificate that cannot be
//! read.
//! What may come and go is a state, which the service waits for: a port that is not plugged in, a controller or broker that is off.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};
use trunnion_acquire::credentials;
use trunnion_acquire::transport::tcp::host_and_port;
use trunnion_core::Secret;
use trunnion_core::input::Document;
use trunnion_service::config::Config;

/// Longest wait for all addresses together: the way to a name server and to a host in the same plant, with one packet lost and sent again
/// after 1 s [RFC 6298 §2].
const LIMIT: Duration = Duration::from_secs(3);

/// What was touched and is not as it should be, one sentence each with what to do.
#[derive(Default)]
pub struct Reached {
    /// The service cannot do its work like this.
    pub failures: Vec<String>,
    /// The service waits for these.
    pub absent: Vec<String>,
}

/// Touches everything, all addresses at once.
pub fn reach(config: &Config) -> Reached {
    let mut reached = Reached::default();
    reached.failures.extend(takes_no_file(&config.recordings));
    reached.failures.extend(unread_passwords(config));
    let tls = config.mqtt.as_ref().and_then(|mqtt| mqtt.broker.tls.as_ref());
    reached
        .failures
        .extend(tls.and_then(|tls| tls.check().err()).map(|error| format!("[mqtt.tls]: {error}")));
    let end = Instant::now() + LIMIT;
    let mut asked: Vec<(String, mpsc::Receiver<io::Result<()>>)> = Vec::new();
    for device in &config.devices {
        let address = device.device.address();
        let words = format!("device {} ({})", device.name, device.driver);
        match place(address) {
            Place::Port(path) => reached.absent.extend(no_port(&words, &path)),
            Place::Interface(name) => reached.absent.extend(no_interface(&words, &name)),
            Place::Server(host, port) => {
                asked.push((format!("{words} at {address}"), connecting(host, port, end)));
            }
        }
    }
    if let Some(mqtt) = &config.mqtt {
        let (host, port) = (mqtt.broker.host.clone(), mqtt.broker.port);
        asked.push((format!("the broker of [mqtt] at {host}:{port}"), connecting(host, port, end)));
    }
    for (words, answer) in asked {
        let said = match answer.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(Ok(())) => continue,
            Ok(Err(error)) => error.to_string(),
            Err(_) => format!("no answer within {} s", LIMIT.as_secs()),
        };
        reached.absent.push(format!(
            "{words} is not there now: {said}. Switch it on, and check the address and the network; the service waits for it."
        ));
    }
    reached
}

/// Where a device is.
#[derive(Debug, PartialEq)]
enum Place {
    Port(PathBuf),
    Interface(String),
    /// Host and port.
    Server(String, u16),
}

/// A URL or `HOST:PORT`, the path of a port, or the name of a CAN interface, which holds none of their marks.
fn place(address: &str) -> Place {
    let usual = match address.split_once("://") {
        Some(("opc.tcp", _)) => Some(4840),
        Some(_) => Some(80),
        None => None,
    };
    match (usual, address.contains('/'), address.contains(':')) {
        (None, true, _) => Place::Port(address.into()),
        (None, false, false) => Place::Interface(address.into()),
        (usual, ..) => {
            let (host, port) = host_and_port(address, usual.unwrap_or_default());
            Place::Server(host, port)
        }
    }
}

/// A connection that is tried until `end`, in a thread of its own, because a name may take longer. Its addresses share the time that is
/// left.
fn connecting(host: String, port: u16, end: Instant) -> mpsc::Receiver<io::Result<()>> {
    let (send, answer) = mpsc::channel();
    std::thread::spawn(move || {
        let tried = (host.as_str(), port).to_socket_addrs().and_then(|addresses| {
            let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
            for (address, left) in addresses.as_slice().iter().zip((1..=addresses.len() as u32).rev()) {
                // None is asked for no time at all, which is an error of its own.
                let share =
                    end.saturating_duration_since(Instant::now()).max(Duration::from_millis(1)) / left;
                match TcpStream::connect_timeout(address, share) {
                    Ok(_) => return Ok(()),
                    Err(error) => last = error,
                }
            }
            Err(last)
        });
        // Whoever asked may have given up.
        send.send(tried).ok();
    });
    answer
}

fn no_port(words: &str, path: &Path) -> Option<String> {
    let opened = std::fs::metadata(path);
    let error = opened.err()?;
    Some(format!(
        "{words}: the port {} is not there now: {error}. Plug the device in, or find its port with `trunnion devices`; the service waits for it.",
        path.display()
    ))
}

fn no_interface(words: &str, name: &str) -> Option<String> {
    let there = Path::new("/sys/class/net").join(name).exists();
    (!there).then(|| {
        format!(
            "{words}: the CAN interface {name} is not there now. Plug the adapter in and set the interface up (ip link); the service waits for it."
        )
    })
}

/// Why the recordings cannot be written; a folder that is not there yet is made by the service.
fn takes_no_file(folder: &Path) -> Option<String> {
    let nearest = nearest(folder)?;
    let trial = nearest.join(format!(".trunnion-check-{}", std::process::id()));
    let written = std::fs::File::create_new(&trial).and_then(|_| std::fs::remove_file(&trial));
    let error = written.err()?;
    let what = if nearest == folder { "written" } else { "made" };
    Some(format!(
        "recordings = \"{}\" cannot be {what}: {error}. Give the service a folder that its user may write.",
        folder.display()
    ))
}

/// The folder itself, or the one in which it would be made.
fn nearest(folder: &Path) -> Option<&Path> {
    // The last ancestor of a relative path is empty: the folder in which the command runs.
    let named =
        folder.ancestors().map(|path| if path.as_os_str().is_empty() { Path::new(".") } else { path });
    named.into_iter().find(|ancestor| ancestor.exists())
}

/// Password files that cannot be read; what they hold is not said.
fn unread_passwords(config: &Config) -> Vec<String> {
    let file = config.file.display().to_string();
    let Ok(document) = Document::parse(&file, &config.text) else { return Vec::new() };
    let root = document.root();
    let broker = root.optional_table("mqtt").into_iter().map(|table| ("[mqtt]".to_string(), table));
    let devices = root.tables("device").into_iter().map(|table| {
        let name = table.optional_string("name").unwrap_or_default();
        (format!("device {name}"), table)
    });
    let named = broker.chain(devices);
    let secrets =
        named.filter_map(|(words, table)| Some((words, Secret::read_file(&table, "password_file")?)));
    let unread = secrets.filter_map(|(words, secret)| Some((words, credentials::value(&secret).err()?)));
    let remedy = "Write the password into it, with rights for the service alone (chmod 640).";
    unread.map(|(words, error)| format!("{words}: {error}. {remedy}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_a_port_an_interface_or_a_server() {
        assert_eq!(
            place("/dev/serial/by-id/usb-probe:1"),
            Place::Port("/dev/serial/by-id/usb-probe:1".into())
        );
        assert_eq!(place("can0"), Place::Interface("can0".into()));
        assert_eq!(place("192.168.1.5:5007"), Place::Server("192.168.1.5".into(), 5007));
        assert_eq!(place("http://cnc/VMC-3Axis"), Place::Server("cnc".into(), 80));
        assert_eq!(place("http://[fe80::1]:5000"), Place::Server("fe80::1".into(), 5000));
        assert_eq!(place("opc.tcp://cnc/UA/Server"), Place::Server("cnc".into(), 4840));
    }

    #[test]
    fn a_relative_folder_would_be_made_where_the_command_runs() {
        assert_eq!(nearest(Path::new("no-such-folder/runs")), Some(Path::new(".")));
    }
}
