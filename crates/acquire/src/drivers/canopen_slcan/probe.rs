//! Is there an slcan adapter at a port, and which nodes are on its bus? `V` and `N` give version and serial number. Then the adapter
//! listens at one bit rate after the other, without a word on the bus; nodes are asked at the one at which something was heard. A bus
//! that is silent at all of them is asked at each. With an adapter that cannot only listen (`L`), nothing is asked.

use super::adapter::OpenAdapter;
use crate::drivers::canopen::{FoundNodes, Heard, listen, scan};
use crate::probe::{Answer, Medium, Probe, Probing, ask_at, link};
use crate::session_end::SessionEnd;
use crate::transport::serial::Framing;
use std::time::Duration;
use trunnion_protocol::slcan::{AdapterMessage, Bitrate, HostCommand, HostDecoder};

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Serial,
    asks: "slcan: version V and serial number N at 115200 and 57600 baud; listens for 1.1 s at each bit rate; CANopen nodes 1 to 127: device type 1000h",
    run: |port| Box::pin(Answer::first(BAUDS.map(|baud| at(port, baud)))),
};

/// USB adapters do not care; the CAN232 leaves its factory with the second.
const BAUDS: [u32; 2] = [115_200, 57_600];
const LIMIT: Duration = Duration::from_millis(300);
/// Bit rates of CANopen at which gauges are used, the usual one first.
const BITRATES: [Bitrate; 4] = [Bitrate::K1000, Bitrate::K500, Bitrate::K250, Bitrate::K125];
/// A question at a wrong bit rate would disturb whoever talks there.
const WITHOUT_LISTENING: &str = "the adapter cannot listen without writing (command `L`): nobody is asked, as a wrong bit rate would \
                                 disturb the bus; put `bitrate` and the ids in `nodes` in by hand";

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
        match look_at_the_bus(port, baud).await {
            Ok((bitrate, nodes)) => Answer::Found(nodes.found(
                &format!("slcan CAN adapter, version {version}{serial}"),
                vec![
                    format!("port = \"{port}\""),
                    format!("baud = {baud}"),
                    format!("bitrate = {}", bitrate.bits_per_s()),
                ],
            )),
            Err(end) => Answer::Trouble(end),
        }
    })
}

/// The nodes, and the bit rate at which they answer.
async fn look_at_the_bus(port: &str, baud: u32) -> Result<(Bitrate, FoundNodes), SessionEnd> {
    let mut link = link(LIMIT);
    let mut heard = None;
    for bitrate in BITRATES {
        let Some(mut adapter) = OpenAdapter::listen(port, baud, bitrate, &mut link).await? else {
            return Ok((bitrate, FoundNodes::not_asked(WITHOUT_LISTENING.into())));
        };
        let found = listen(&mut adapter, &link).await;
        adapter.close().await?;
        match found? {
            Heard::NotToBeAsked(why) => return Ok((bitrate, FoundNodes::not_asked(why))),
            Heard::Nodes => {
                heard = Some(bitrate);
                break;
            }
            Heard::Nothing => {}
        }
    }
    let asked = heard.map_or(BITRATES.to_vec(), |heard| vec![heard]);
    for bitrate in asked {
        let mut adapter = OpenAdapter::open(port, baud, bitrate, &mut link).await?;
        let nodes = scan(&mut adapter, &mut link).await;
        adapter.close().await?;
        let nodes = nodes?;
        if !nodes.is_empty() {
            return Ok((bitrate, nodes));
        }
    }
    Ok((heard.unwrap_or(BITRATES[0]), FoundNodes::default()))
}

/// Four hex digits: hardware and software, two each.
fn is_version(text: &str) -> bool {
    text.len() == 4 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}
