//! Is there an optoNCDT at a port? `GETINFO` reports model, serial number and range, also while it streams.

use crate::probe::{Answer, Found, Medium, Probe, Probing, ask_at};
use crate::session_end::SessionEnd;
use crate::transport::serial::Framing;
use std::time::Duration;
use trunnion_protocol::optoncdt::{BlockLength, Command, Decoder, Event, Reply, SensorInfo};

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Serial,
    asks: "optoNCDT: GETINFO at 921600, 460800, 230400, 115200, 1000000, 691200, 38400, 9600 baud",
    run: |port| Box::pin(Answer::first(BAUDS.map(|baud| at(port, baud)))),
};

/// The factory's first.
const BAUDS: [u32; 8] = [FACTORY_BAUD, 460_800, 230_400, 115_200, 1_000_000, 691_200, 38_400, 9_600];
const FACTORY_BAUD: u32 = 921_600;
const LIMIT: Duration = Duration::from_millis(250);

fn at(port: &str, baud: u32) -> Probing<'_> {
    Box::pin(async move {
        let command = Command::get_info();
        let bytes = match ask_at(port, baud, Framing::PLAIN, &command.encode(), LIMIT).await {
            Ok(bytes) => bytes,
            Err(end) => return Answer::Trouble(end),
        };
        let mut decoder = Decoder::new(BlockLength::UntilNext);
        decoder.await_reply();
        let reply = decoder.push(&bytes).into_iter().find_map(|event| match event {
            Event::ReplyText(text) => Some(Reply::parse(&text, &command)),
            Event::Block(_) => None,
        });
        let Some(info) = reply.and_then(|reply| SensorInfo::parse(&reply).ok()) else {
            return Answer::none_in(&bytes);
        };
        let SensorInfo { name, serial, range_mm, version } = &info;
        let identity =
            format!("{name} serial {serial} range {range_mm} mm, firmware {version}, at {baud} baud");
        if !is_of_the_family(&info) {
            return Answer::Trouble(SessionEnd::WrongDevice {
                found: identity,
                expected: "an optoNCDT 1320 or 1420".into(),
            });
        }
        let mut keys = vec![format!("port = \"{port}\"")];
        if baud != FACTORY_BAUD {
            keys.push(format!("baud = {baud}"));
        }
        keys.extend(["role = {role}".into(), format!("range_mm = {range_mm}"), "rate_khz = 1".into()]);
        Answer::Found(Found { identity, keys })
    })
}

/// True for the sensors this driver speaks to.
pub(super) fn is_of_the_family(info: &SensorInfo) -> bool {
    ["ILD132", "ILD142"].iter().any(|family| info.name.to_ascii_uppercase().starts_with(family))
}
