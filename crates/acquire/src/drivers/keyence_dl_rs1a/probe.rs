//! Is there a DL-RS1A at a port? `M0` reads all its values.

use crate::probe::{Answer, Found, Medium, Probe, Probing, ask_at};
use crate::session_end::SessionEnd;
use crate::transport::serial::Framing;
use std::time::Duration;
use trunnion_protocol::keyence::{Command, Decoder, Reply};

/// The reply of 15 heads takes 160 ms at 9600 baud.
pub(super) const REPLY_LIMIT: Duration = Duration::from_millis(300);

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Serial,
    asks: "Keyence DL-RS1A: M0 at 9600, 38400, 19200, 4800 baud",
    run: |port| Box::pin(Answer::first(BAUDS.map(|baud| at(port, baud)))),
};

/// The factory's first.
const BAUDS: [u32; 4] = [9600, 38_400, 19_200, 4800];
/// More heads than an R-test has roles.
const MOST_ROLES: usize = 3;

fn at(port: &str, baud: u32) -> Probing<'_> {
    Box::pin(async move {
        let bytes = match ask_at(port, baud, Framing::PLAIN, &Command::ReadAll.encode(), REPLY_LIMIT).await {
            Ok(bytes) => bytes,
            Err(end) => return Answer::Trouble(end),
        };
        let reply = Decoder::default().push(&bytes).into_iter().next();
        let values = match reply {
            Some(Reply::All(values)) => values,
            Some(Reply::Refused(refusal)) => {
                return Answer::Trouble(SessionEnd::Protocol {
                    doing: "asking M0",
                    fault: refusal.to_string(),
                });
            }
            Some(Reply::Data { .. }) | None => return Answer::none_in(&bytes),
        };
        let series = values.first().map_or("", |value| value.family.name());
        let head = |number| format!("{{ head = {number}, role = {{role}} }}");
        let heads: Vec<String> = (1..=values.len().min(MOST_ROLES)).map(head).collect();
        Answer::Found(Found {
            identity: format!("Keyence DL-RS1A with {} amplifiers {series}, at {baud} baud", values.len()),
            keys: vec![
                format!("port = \"{port}\""),
                format!("baud = {baud}"),
                format!("heads = [{}]", heads.join(", ")),
            ],
        })
    })
}
