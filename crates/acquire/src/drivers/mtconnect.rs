//! Controllers behind an MTConnect agent. Keys: `url`, `device` (name, where the agent has several), `interval_ms` (10),
//! `signal` (id or name of a data item that begins and ends cycles, see `cycle_bounds`), and a table `axes` that names
//! the data item of an axis (`axes = { C = "Cpos" }`, id or name) where it cannot be found by itself: `Position` of a
//! `Linear` or `Angle` of a `Rotary` component, `ACTUAL`, machine coordinates, whose component is named after the axis
//! (`C`, `C1`). `user` with `password_file` or `password` where the agent's web server asks for them (Basic, RFC 7617).
//!
//! The session asks `/probe`, `/current`, then streams `/sample` from the next sequence number. A changed `instanceId` ends
//! it (`Restarted`). When the agent no longer has what we ask for (`OUT_OF_RANGE`) it goes on from `/current` and records
//! a gap. An agent sends changes only: while it says that nothing changed, held positions are sent.

mod answer;
mod items;
mod model;
mod probe;

use crate::driver::{Device, Driver, Session};
use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::http;
use crate::transport::http_login::HttpLogin;
use answer::{parse, unexpected};
use items::Items;
use model::{Absent, Model};
use std::convert::Infallible;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use trunnion_core::input::Table;
use trunnion_core::{AxisValues, Joint, Role, Secret};
use trunnion_protocol::mtconnect::{DevicesDocument, Document, MultipartDecoder, StreamsDocument};

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "mtconnect",
    about: "machine controllers behind an MTConnect agent (HTTP)",
    default_silence_ms: 2000.0,
    read,
    probe: Some(probe::PROBE),
};

/// How often the agent reports that nothing changed, ms.
const HEARTBEAT_MS: u32 = 100;

#[derive(Debug)]
struct MtConnect {
    url: String,
    server: http::Server,
    device: Option<String>,
    interval_ms: u32,
    axes: AxisValues<Option<String>>,
    signal: Option<String>,
    /// Identity of the device at the first connection.
    uuid: OnceLock<String>,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let url = Secret::read_address(table, "url");
    let base = url.as_deref().and_then(|url| {
        http::parse_base(url)
            .map_err(|why| table.problem("url", format!("= \"{url}\" {why}"), "http://host:port", ""))
            .ok()
    });
    let login = HttpLogin::read(table);
    let device = table.optional_string("device");
    let interval_ms = table.optional_number("interval_ms", 0.0..=1000.0).unwrap_or(10.0) as u32;
    let signal = table.optional_string("signal");
    let mut axes = AxisValues::default();
    if let Some(named) = table.optional_table("axes") {
        axes = AxisValues::of(Joint::ISO, |letter| named.optional_string(letter.as_str()));
        named.no_other_keys();
    }
    Some(Arc::new(MtConnect {
        url: url?,
        server: http::Server { base: base?, login },
        device,
        interval_ms,
        axes,
        signal,
        uuid: OnceLock::new(),
    }))
}

impl Device for MtConnect {
    fn channels(&self) -> Vec<(String, Role)> {
        Vec::new()
    }

    fn address(&self) -> &str {
        &self.url
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(self.run(link))
    }
}

/// Why a stream of samples ended without ending the session.
enum StreamEnd {
    /// The agent no longer has what was asked for.
    OutOfRange,
    /// The agent closed the stream after this sequence number.
    Closed(u64),
    /// Bytes after this sequence number were damaged; the agent still has them.
    Damaged(u64),
}

impl MtConnect {
    async fn run(&self, link: &mut Link) -> Result<Infallible, SessionEnd> {
        let devices = match self.document("/probe", link).await? {
            Document::Devices(devices) => devices,
            other => return Err(unexpected("asking /probe", &other)),
        };
        let instance = devices.header.instance_id;
        let items = self.find_items(&devices)?;
        link.identified(format!(
            "MTConnect agent {} {}, axes {}",
            devices.header.sender,
            devices.header.version,
            items.letters().iter().map(|letter| letter.as_str()).collect::<Vec<_>>().join(" ")
        ));
        let mut model = Model::new(items);
        let mut next = self.current(instance, &mut model, link).await?;
        loop {
            match self.stream(instance, next, &mut model, link).await? {
                StreamEnd::Closed(from) => next = from,
                StreamEnd::Damaged(from) => {
                    let text = "a part of the agent's stream was damaged; it is asked for again";
                    link.log(true, text.into());
                    next = from;
                }
                StreamEnd::OutOfRange => {
                    let before = next;
                    let from = link.last_reading();
                    next = self.current(instance, &mut model, link).await?;
                    let (lost, now) = (next.saturating_sub(before), link.now());
                    let reason = "the agent's buffer had moved on (OUT_OF_RANGE)".into();
                    link.gap(from.unwrap_or(now), now, Some(lost), reason);
                }
            }
        }
    }

    fn find_items(&self, devices: &DevicesDocument) -> Result<Items, SessionEnd> {
        let names: Vec<&str> = devices.devices.iter().map(|device| device.name.as_str()).collect();
        let wanted = |name: &str| self.device.as_deref().is_none_or(|wanted| wanted == name);
        let device = devices.devices.iter().find(|device| wanted(&device.name) && device.name != "Agent");
        let wrong = |found: String, expected: String| SessionEnd::WrongDevice { found, expected };
        let device = device.ok_or_else(|| {
            let expected = self.device.clone().unwrap_or_else(|| "a device".into());
            wrong(format!("an agent with {}", names.join(", ")), expected)
        })?;
        let uuid = self.uuid.get_or_init(|| device.uuid.clone());
        if *uuid != device.uuid {
            let expected = format!(
                "{uuid}, as at the first connection (restart the service if the machine was changed)"
            );
            return Err(wrong(format!("device {} ({})", device.name, device.uuid), expected));
        }
        Items::find(device, &self.axes, self.signal.as_deref())
            .map_err(|missing| wrong(format!("device {}", device.name), missing))
    }

    /// Takes the present values; gives the sequence number to go on from.
    async fn current(&self, instance: u64, model: &mut Model, link: &mut Link) -> Result<u64, SessionEnd> {
        match self.document("/current", link).await? {
            Document::Streams(streams) => {
                model.forget();
                take(model, &streams, instance, link)?;
                Ok(streams.next_sequence)
            }
            other => Err(unexpected("asking /current", &other)),
        }
    }

    async fn stream(
        &self,
        instance: u64,
        from: u64,
        model: &mut Model,
        link: &mut Link,
    ) -> Result<StreamEnd, SessionEnd> {
        // Not below the interval, which some agents refuse; often enough to see a machine stand.
        let heartbeat = (link.silence.as_millis() as u32 / 4).min(HEARTBEAT_MS).max(self.interval_ms).max(10);
        let query =
            format!("/sample?from={from}&interval={}&count=1000&heartbeat={heartbeat}", self.interval_ms);
        let mut answer = http::get(&self.server, &self.path(&query)).await?;
        if !answer.content_type.to_ascii_lowercase().starts_with("multipart/") {
            let body = answer.whole(link.silence).await?;
            return match parse(&body)? {
                Document::Error(error) if error.is_out_of_range() => Ok(StreamEnd::OutOfRange),
                other => Err(unexpected("asking /sample", &other)),
            };
        }
        let mut parts = MultipartDecoder::new(&answer.content_type)
            .map_err(|error| SessionEnd::Protocol { doing: "asking /sample", fault: error.to_string() })?;
        let mut next = from;
        let mut last_part = link.now();
        loop {
            let waited = link.now() - last_part;
            let left = link.silence.saturating_sub(waited).max(Duration::from_millis(1));
            let Some(bytes) = answer.chunk(left).await? else { return Ok(StreamEnd::Closed(next)) };
            let whole = parts.push(&bytes);
            let losses = parts.losses();
            if losses.bad_parts + losses.dropped_bytes > 0 {
                link.counters.dropped_bytes += losses.dropped_bytes;
                link.counters.damaged += losses.bad_parts.max(1);
                link.report_counters(link.now());
                if next > from {
                    return Ok(StreamEnd::Damaged(next));
                }
                let fault =
                    "it is damaged again and again; check the network between here and the agent".into();
                return Err(SessionEnd::Protocol { doing: "reading the agent's stream", fault });
            }
            for part in whole {
                last_part = link.now();
                match parse(&part.body)? {
                    Document::Streams(streams) => {
                        take(model, &streams, instance, link)?;
                        next = streams.next_sequence;
                    }
                    Document::Error(error) if error.is_out_of_range() => return Ok(StreamEnd::OutOfRange),
                    other => return Err(unexpected("reading samples", &other)),
                }
            }
            link.report_counters(last_part);
            if link.now() - last_part >= link.silence {
                let waited = link.now() - last_part;
                return Err(SessionEnd::Silent { who: format!("{} sends no samples", self.url), waited });
            }
        }
    }

    fn path(&self, query: &str) -> String {
        self.device.as_ref().map_or_else(|| query.to_owned(), |device| format!("/{device}{query}"))
    }

    async fn document(&self, query: &str, link: &Link) -> Result<Document, SessionEnd> {
        let answer = http::get(&self.server, &self.path(query)).await?;
        parse(&answer.whole(link.silence.max(Duration::from_secs(2))).await?)
    }
}

fn take(
    model: &mut Model,
    streams: &StreamsDocument,
    instance: u64,
    link: &mut Link,
) -> Result<(), SessionEnd> {
    let found = streams.header.instance_id;
    if found != instance {
        return Err(SessionEnd::Restarted(format!("agent instance {instance} became {found}")));
    }
    let arrival = link.now();
    for line in model.warnings(streams) {
        link.log(true, line);
    }
    for reading in model.take(streams, arrival) {
        link.reading(reading, arrival);
    }
    if let Some(by_s) = model.clock_was_set() {
        link.log(
            true,
            format!("the controller's clock was set by {by_s:+.3} s; time of the axes begins again"),
        );
    }
    if let Some((letter, why)) = model.began_absence() {
        let text = match why {
            Absent::Unavailable => format!(
                "the agent has no value for axis {letter} (UNAVAILABLE); check that the controller is on and that its adapter runs"
            ),
            Absent::NoTime => format!(
                "the time stamp of axis {letter} is no time (before 1970 or after 2242); check the clocks of the controller and of its \
                 adapter"
            ),
        };
        link.log(true, text);
    }
    if let Some((from, to, why)) = model.ended_absence() {
        let reason = match why {
            Absent::Unavailable => "the agent had no value for an axis (UNAVAILABLE)",
            Absent::NoTime => "the time stamp of an axis was no time",
        };
        link.gap(from, to, None, reason.into());
    }
    Ok(())
}
