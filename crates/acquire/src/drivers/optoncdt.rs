//! Micro-Epsilon optoNCDT 1320/1420 on RS422. Keys: `port`, `baud` (921600), `role`, `range_mm`, `rate_khz` (1).
//!
//! The session stops the output, asks `GETINFO` (model and range must be those configured), sets the rate, adds
//! counter and time stamp, asks for the order of the values, and starts the output. A reply is matched to its command by the
//! echo; a late one is dropped, and the command is sent again. Only a well-formed `GETINFO` of another sensor is a wrong device.

mod probe;

use crate::bar_zero;
use crate::driver::{Device, Driver, Session};
use crate::link::Link;
use crate::moments::Moments;
use crate::session_end::SessionEnd;
use crate::transport::serial;
use crate::transport::serial::{Framing, Port};
use probe::is_of_the_family;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::input::Table;
use trunnion_core::reading::{ProbeReading, Reading};
use trunnion_core::{HostTime, Role};
use trunnion_protocol::optoncdt::values::TIMESTAMP_TICK_S;
use trunnion_protocol::optoncdt::{
    BlockLength, Command, Decoder, Event, Layout, Reply, SensorInfo, Unwrap, distance_mm,
};

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "optoncdt",
    about: "Micro-Epsilon optoNCDT 1320/1420 laser sensor, RS422 binary stream",
    default_silence_ms: 250.0,
    read,
    probe: Some(probe::PROBE),
};

/// The sensor answers within some ms.
const REPLY_LIMIT: Duration = Duration::from_millis(700);
/// A reply may be late, or cut in half by the stop of the output: so often a command is sent.
const ATTEMPTS: usize = 3;
/// Before a command is sent again the line is read until it is silent for so long, or until the limit of a reply: what a late
/// reply has begun to say is not the answer to what is asked next.
const QUIET: Duration = Duration::from_millis(50);
const RATES_KHZ: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
/// Two lengths this close are one measuring range, mm.
const RANGE_SLACK_MM: f64 = 0.01;

#[derive(Debug)]
struct Optoncdt {
    port: String,
    baud: u32,
    role: Role,
    bar_zero_mm: Option<f64>,
    range_mm: f64,
    rate_khz: f64,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let port = table.string("port");
    let baud = table.optional_number("baud", 9600.0..=4_000_000.0);
    let role = Role::read(table);
    let bar_zero_mm = bar_zero::read(table, role);
    let range_mm = table.number("range_mm", 1.0..=1000.0);
    let rate_khz = table.optional_number("rate_khz", 0.25..=4.0).unwrap_or(1.0);
    if !RATES_KHZ.contains(&rate_khz) {
        table.problem("rate_khz", format!("= {rate_khz}"), "0.25, 0.5, 1, 2, 4", "");
    }
    if role == Some(Role::Temperature) {
        table.problem("role", "= \"temperature\"", "probe-1, probe-2, probe-3, bar", "");
    }
    let baud = baud.unwrap_or(921_600.0) as u32;
    Some(Arc::new(Optoncdt { port: port?, baud, role: role?, bar_zero_mm, range_mm: range_mm?, rate_khz }))
}

impl Device for Optoncdt {
    fn channels(&self) -> Vec<(String, Role)> {
        vec![(String::new(), self.role)]
    }

    fn range_mm(&self) -> Option<[f64; 2]> {
        Some([0.0, self.range_mm])
    }

    fn bar_zero_mm(&self) -> Option<f64> {
        self.bar_zero_mm
    }

    fn address(&self) -> &str {
        &self.port
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(async move {
            let port = serial::open(&self.port, self.baud, Framing::PLAIN, link)?;
            let decoder = Decoder::new(BlockLength::UntilNext);
            Connection { port, decoder, blocks: Vec::new(), sent: Vec::new() }.run(self, link).await
        })
    }
}

struct Connection {
    port: Port,
    decoder: Decoder,
    /// Events read together with a reply and not yet handled.
    blocks: Vec<Event>,
    /// Commands sent before, whose replies may still come.
    sent: Vec<Command>,
}

impl Connection {
    async fn run(&mut self, config: &Optoncdt, link: &mut Link) -> Result<Infallible, SessionEnd> {
        self.identify(config, link).await?;
        let layout = self.configure(config, link).await?;
        self.stream(config, &layout, link).await
    }

    async fn identify(&mut self, config: &Optoncdt, link: &mut Link) -> Result<(), SessionEnd> {
        self.ask(&Command::output_none()).await?;
        let info = self.info().await?;
        let expected = || format!("an optoNCDT 1320 or 1420 with range {} mm", config.range_mm);
        let wrong = |found: String| SessionEnd::WrongDevice { found, expected: expected() };
        let found = format!("{} serial {} range {} mm", info.name, info.serial, info.range_mm);
        if !is_of_the_family(&info) || (info.range_mm - config.range_mm).abs() > RANGE_SLACK_MM {
            return Err(wrong(found));
        }
        link.identified(found);
        Ok(())
    }

    async fn info(&mut self) -> Result<SensorInfo, SessionEnd> {
        let mut fault = String::new();
        for _ in 0..ATTEMPTS {
            let reply = self.ask(&Command::get_info()).await?;
            match SensorInfo::parse(&reply) {
                Ok(info) => return Ok(info),
                Err(error) => fault = format!("{:?} ({error})", reply.lines),
            }
            self.drain().await?;
        }
        Err(SessionEnd::Protocol { doing: "asking which sensor it is", fault })
    }

    async fn configure(&mut self, config: &Optoncdt, link: &mut Link) -> Result<Layout, SessionEnd> {
        for command in [Command::measuring_rate_khz(config.rate_khz), Command::add_counter_and_timestamp()] {
            let reply = self.ask(&command).await?;
            if let Some(refusal) = reply.error.or(reply.warning) {
                link.log(true, format!("{} answered {refusal}", command.text()));
            }
        }
        let reply = self.ask(&Command::get_output_info()).await?;
        let layout = Layout::from_reply(&reply).ok_or_else(|| SessionEnd::Protocol {
            doing: "asking for the order of the values",
            fault: format!("{:?}", reply.lines),
        })?;
        self.decoder.set_block_length(BlockLength::Exactly(layout.values_per_block()));
        self.blocks.clear();
        let reply = self.ask(&Command::output_rs422()).await?;
        match reply.error {
            None => Ok(layout),
            Some(refusal) => {
                Err(SessionEnd::Protocol { doing: "starting the output", fault: refusal.to_string() })
            }
        }
    }

    /// Sends a command, again if need be, and waits for its reply.
    async fn ask(&mut self, command: &Command) -> Result<Reply, SessionEnd> {
        for _ in 0..ATTEMPTS {
            if let Some(reply) = self.ask_once(command).await? {
                self.port.makes_sense();
                return Ok(reply);
            }
            self.drain().await?;
        }
        Err(self.port.no_answer(&command.text(), REPLY_LIMIT * ATTEMPTS as u32))
    }

    /// `None` when no reply to this command came in time.
    async fn ask_once(&mut self, command: &Command) -> Result<Option<Reply>, SessionEnd> {
        self.decoder.await_reply();
        self.port.write(&command.encode()).await?;
        let deadline = tokio::time::Instant::now() + REPLY_LIMIT;
        let mut buffer = [0; 4096];
        let mut answer = None;
        while answer.is_none() {
            let left = deadline.saturating_duration_since(tokio::time::Instant::now());
            let Some(count) = self.port.read(&mut buffer, left).await? else { break };
            // Byte by byte: what follows a late reply is a reply too, not values.
            for byte in &buffer[..count] {
                for event in self.decoder.push(std::slice::from_ref(byte)) {
                    match event {
                        Event::ReplyText(text) if Reply::is_of_another(&text, command, &self.sent) => {
                            self.decoder.await_reply();
                        }
                        Event::ReplyText(text) => answer = Some(Reply::parse(&text, command)),
                        block => self.blocks.push(block),
                    }
                }
            }
        }
        self.decoder.give_up_reply();
        self.sent.push(command.clone());
        Ok(answer)
    }

    /// Reads what is still on its way, until the line is silent.
    async fn drain(&mut self) -> Result<(), SessionEnd> {
        let deadline = tokio::time::Instant::now() + REPLY_LIMIT;
        let mut buffer = [0; 4096];
        while tokio::time::Instant::now() < deadline {
            if self.port.read(&mut buffer, QUIET).await?.is_none() {
                return Ok(());
            }
        }
        Ok(())
    }

    async fn stream(
        &mut self,
        config: &Optoncdt,
        layout: &Layout,
        link: &mut Link,
    ) -> Result<Infallible, SessionEnd> {
        let mut sensor = Sensor::new(config, layout.clone(), link.first_channel);
        let mut last_block = link.now();
        let mut events = std::mem::take(&mut self.blocks);
        let mut buffer = [0; 16 * 1024];
        loop {
            let arrival = link.now();
            for event in events {
                let Event::Block(block) = event else { continue };
                last_block = arrival;
                sensor.take(&block, arrival, link)?;
            }
            link.report_counters(arrival);
            let waited = arrival - last_block;
            if waited >= link.silence {
                return Err(SessionEnd::Silent {
                    who: format!("{} sends no values", self.port.name()),
                    waited,
                });
            }
            let left = link.silence - waited;
            events = match self.port.read(&mut buffer, left).await? {
                Some(count) => self.decoder.push(&buffer[..count]),
                None => Vec::new(),
            };
            let seen = self.decoder.counts();
            link.counters.dropped_bytes = seen.dropped_bytes;
            link.counters.damaged = seen.damaged_blocks;
            link.counters.resyncs = seen.resyncs;
        }
    }
}

/// Blocks into readings.
struct Sensor {
    channel: u16,
    range_mm: f64,
    period_s: f64,
    layout: Layout,
    counter: Unwrap,
    timestamp: Unwrap,
    moments: Moments,
    last: Option<Last>,
    blocks: u64,
}

/// Where the last block stands.
struct Last {
    sequence: u64,
    device_s: f64,
    arrival: HostTime,
}

impl Sensor {
    fn new(config: &Optoncdt, layout: Layout, channel: u16) -> Self {
        Self {
            channel,
            range_mm: config.range_mm,
            period_s: 1e-3 / config.rate_khz,
            layout,
            counter: Unwrap::new(18),
            timestamp: Unwrap::new(32),
            moments: Moments::default(),
            last: None,
            blocks: 0,
        }
    }

    fn take(
        &mut self,
        block: &trunnion_protocol::optoncdt::Block,
        arrival: HostTime,
        link: &mut Link,
    ) -> Result<(), SessionEnd> {
        let values = self
            .layout
            .read(block)
            .map_err(|error| SessionEnd::Protocol { doing: "reading a block", fault: error.to_string() })?;
        let Some(distance) = values.distance else {
            return Err(SessionEnd::Protocol {
                doing: "reading a block",
                fault: "it has no distance".into(),
            });
        };
        self.blocks += 1;
        let sequence = values.counter.map_or(self.blocks, |raw| self.counter.push_nearest(raw));
        let (device_ticks, tick_s) = match values.timestamp_ticks {
            Some(raw) => (self.timestamp.push_nearest(raw), TIMESTAMP_TICK_S),
            None => (sequence, self.period_s),
        };
        let device_s = device_ticks as f64 * tick_s;
        let value_mm = distance_mm(distance, self.range_mm).unwrap_or_else(|error| {
            link.explain(link.first_channel, || error.to_string());
            f64::NAN
        });
        if let Some(last) = &self.last
            && sequence > last.sequence + 1
        {
            let lost = sequence - last.sequence - 1;
            // After a pause of the program blocks of before and after the hole arrive together: the clock of the sensor says where it is.
            let from = self.moments.of(last.device_s).unwrap_or(last.arrival);
            let to = self.moments.of(device_s).unwrap_or(arrival);
            link.gap(from.min(to), to, Some(lost), "values lost on the line (counter jumped)".into());
        }
        if let Some(last) = &self.last
            && sequence < last.sequence
        {
            let reason = "the sensor began to count again: it was restarted or reset";
            link.gap(last.arrival, arrival, None, reason.into());
            self.moments = Moments::default();
        }
        self.moments.arrived(device_s, arrival);
        self.last = Some(Last { sequence, device_s, arrival });
        let raw = i64::from(distance.get());
        let reading =
            ProbeReading { channel: self.channel, device_ticks, tick_s, sequence, raw, value_mm, arrival };
        link.reading(Reading::Probe(reading), arrival);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
