//! What a configuration names is touched: the folder of the recordings, password files, ports, controllers, the broker.
//!
//! What must be there before the service can do its work is a failure: a folder that takes no file, a password file that cannot be read.
//! What may come and go is a state, which the service waits for: a port that is not plugged in, a controller or broker that is off.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;
use trunnion_acquire::credentials;
use trunnion_core::Secret;
use trunnion_core::input::Document;
use trunnion_service::config::Config;

/// Longest wait for an address: the way to a name server and to a host in the same plant, with one packet lost and sent again
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
    let mut asked: Vec<(String, mpsc::Receiver<io::Result<()>>)> = Vec::new();
    for device in &config.devices {
        let address = device.device.address();
        let words = format!("device {} ({})", device.name, device.driver);
        match place(address) {
            Place::Port(path) => reached.absent.extend(no_port(&words, &path)),
            Place::Interface(name) => reached.absent.extend(no_interface(&words, &name)),
            Place::Server(host) => asked.push((format!("{words} at {address}"), connecting(host))),
        }
    }
    if let Some(mqtt) = &config.mqtt {
        let host = format!("{}:{}", mqtt.broker.host, mqtt.broker.port);
        asked.push((format!("the broker of [mqtt] at {host}"), connecting(host)));
    }
    for (words, answer) in asked {
        let said = match answer.recv_timeout(LIMIT) {
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
enum Place {
    Port(PathBuf),
    Interface(String),
    /// `HOST:PORT`.
    Server(String),
}

fn place(address: &str) -> Place {
    if let Some((scheme, rest)) = address.split_once("://") {
        let host = rest.split('/').next().unwrap_or(rest);
        let has_port = host.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
        let usual = match scheme {
            "https" => 443,
            "opc.tcp" => 4840,
            "linuxcnc" => 5007,
            _ => 80,
        };
        return Place::Server(if has_port { host.into() } else { format!("{host}:{usual}") });
    }
    match address.contains('/') {
        true => Place::Port(address.into()),
        false => Place::Interface(address.into()),
    }
}

/// A connection that is tried in a thread of its own, because a name may take longer than the limit.
fn connecting(host: String) -> mpsc::Receiver<io::Result<()>> {
    let (send, answer) = mpsc::channel();
    std::thread::spawn(move || {
        let tried = host.to_socket_addrs().and_then(|addresses| {
            let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
            for address in addresses {
                match TcpStream::connect_timeout(&address, LIMIT) {
                    Ok(_) => return Ok(()),
                    Err(error) => last = error,
                }
            }
            Err(last)
        });
        // Who asked may have given up.
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
    let nearest = folder.ancestors().find(|ancestor| ancestor.exists())?;
    let trial = nearest.join(format!(".trunnion-check-{}", std::process::id()));
    let written = std::fs::File::create_new(&trial).and_then(|_| std::fs::remove_file(&trial));
    let error = written.err()?;
    let what = if nearest == folder { "written" } else { "made" };
    Some(format!(
        "recordings = \"{}\" cannot be {what}: {error}. Give the service a folder that its user may write.",
        folder.display()
    ))
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
