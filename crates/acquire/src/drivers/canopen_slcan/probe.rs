//! Is there an slcan adapter at a port? `V` and `N` give its version and serial number; the bus is left alone.

use crate::probe::{Answer, Found, Medium, Probe, Probing, ask_at};
use crate::transport::serial::Framing;
use std::time::Duration;
use trunnion_protocol::slcan::{AdapterMessage, HostCommand, HostDecoder};

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Serial,
    asks: "slcan: version V and serial number N at 115200 and 57600 baud",
    run: |port| Box::pin(Answer::first(BAUDS.map(|baud| at(port, baud)))),
};

/// USB adapters do not care; the CAN232 leaves its factory with the second.
const BAUDS: [u32; 2] = [115_200, 57_600];
const LIMIT: Duration = Duration::from_millis(300);

fn at(port: &str, baud: u32) -> Probing<'_> {
    Box::pin(async move {
        // An empty line first ends whatever is in the adapter's buffer.
        let request = [HostCommand::Empty, HostCommand::Version, HostCommand::SerialNumber]
            .map(|command| command.encode());
        let bytes = match ask_at(port, baud, Framing::PLAIN, &request.concat(), LIMIT).await {
            Ok(bytes) => bytes,
            Err(end) => return Answer::Trouble(end),
        };
        let (mut version, mut serial) = (None, String::new());
        for message in HostDecoder::default().push(&bytes) {
            match message {
                AdapterMessage::Version(text) if is_version(&text) => version = Some(text),
                AdapterMessage::SerialNumber(text) => serial = format!(", serial number {text}"),
                _ => {}
            }
        }
        let Some(version) = version else { return Answer::none_in(&bytes) };
        Answer::Found(Found {
            identity: format!(
                "slcan CAN adapter, version {version}{serial}; set the bit rate of the bus and the node ids of the probes"
            ),
            keys: vec![
                format!("port = \"{port}\""),
                format!("baud = {baud}"),
                "bitrate = 1000000".into(),
                "nodes = [{ id = 1, role = {role} }]".into(),
            ],
        })
    })
}

/// Four hex digits: hardware and software, two each.
fn is_version(text: &str) -> bool {
    text.len() == 4 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}
