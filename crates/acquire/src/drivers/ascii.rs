//! Indicators and counters that say one value as a line of ASCII. Keys: `port`, `role` (probe-1 …, bar, temperature),
//! `preset`, and where the preset does not fit: `baud`, `framing` ("7E2"), `request`, `poll_ms`, `unit` (mm, um, inch, degC).
//!
//! `preset` is a name of [`trunnion_protocol::ascii::PRESETS`] or "custom", which needs `baud`, `pattern` and `unit`, and takes `request` (none: the
//! device talks on its own), `framing` ("8N1"), `errors` (words that stand instead of a value) and `stamp`.
//! What a pattern looks like: [`trunnion_protocol::ascii::Pattern`]: "GN##,{value}".
//!
//! When a value was taken: devices that latch at the request are stamped with the request, others with the middle
//! between the request and the beginning of the answer, those that talk on their own with the arrival
//! (`stamp` = "request", "between", "arrival"). A temperature carries the arrival.

mod probe;
mod settings;

use crate::driver::{Device, Driver, Session};
use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::asked::{Decode, Exchange, exchange};
use crate::transport::serial;
use crate::transport::serial::Port;
use settings::Settings;
use std::convert::Infallible;
use std::time::Duration;
use tokio::time::{Interval, MissedTickBehavior, interval};
use trunnion_core::reading::{ProbeReading, Reading, TemperatureReading};
use trunnion_core::{HostTime, Role};
use trunnion_protocol::ascii::{Decoder, Line, Measured, Stamp};

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "ascii",
    about: "Indicators that say a value as a line: Heidenhain, Magnescale, Mahr, Mitutoyo, Sylvac, TESA, custom",
    default_silence_ms: 3000.0,
    read: settings::read,
    probe: Some(probe::PROBE),
};

/// The slowest of them takes 50 ms to begin and 30 ms to say it.
const ANSWER_LIMIT: Duration = Duration::from_millis(500);
/// Lines of text that are none of the preset's, before the first that is, prove another device.
const STRANGE_LINES: usize = 3;
const TICK_S: f64 = 1e-6;

impl Device for Settings {
    fn channels(&self) -> Vec<(String, Role)> {
        vec![(String::new(), self.role)]
    }

    fn bar_zero_mm(&self) -> Option<f64> {
        self.bar_zero_mm
    }

    fn asked_every(&self) -> Option<Duration> {
        (self.role != Role::Temperature).then_some(self.poll)
    }

    fn address(&self) -> &str {
        &self.port
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(async move {
            let port = serial::open(&self.port, self.baud, self.framing, link)?;
            let mut ticker = interval(self.poll);
            ticker.set_missed_tick_behavior(MissedTickBehavior::Delay);
            let mut reader = Reader {
                settings: self,
                port,
                decoder: Decoder::new(self.format.clone()),
                ticker,
                begun: link.now(),
                sequence: 0,
                last: None,
                strange: 0,
            };
            reader.run(link).await
        })
    }
}

/// Of the values that came at once on one request those before the last are of requests before.
fn latest(lines: &[Line]) -> &[Line] {
    let is_value = |line: &Line| matches!(line, Line::Value(_) | Line::Error { .. });
    &lines[lines.iter().rposition(is_value).unwrap_or(0)..]
}

impl Decode<Vec<Line>> for Decoder {
    fn push(&mut self, bytes: &[u8]) -> Option<Vec<Line>> {
        Some(Self::push(self, bytes)).filter(|lines| !lines.is_empty())
    }

    fn is_half(&self) -> bool {
        Self::is_half(self)
    }

    fn restart(&mut self) {
        Self::restart(self);
    }

    fn spoil(&mut self) {
        Self::spoil(self);
    }
}

struct Reader<'a> {
    settings: &'a Settings,
    port: Port,
    decoder: Decoder,
    ticker: Interval,
    begun: HostTime,
    /// Requests, or lines of a device that is not asked.
    sequence: u64,
    /// Sequence and arrival of the last line that was one.
    last: Option<(u64, HostTime)>,
    /// Strange lines before the first right one.
    strange: usize,
}

impl Reader<'_> {
    async fn run(&mut self, link: &mut Link) -> Result<Infallible, SessionEnd> {
        let mut answered = link.now();
        loop {
            let asked = !self.settings.format.request.is_empty();
            let lines = if asked { self.ask(link).await? } else { self.listen(link).await? };
            let (arrival, seen) = (lines.arrival, self.decoder.counts());
            (link.counters.dropped_bytes, link.counters.resyncs) = (seen.dropped_bytes, seen.resyncs);
            let said = lines.answer.as_deref().unwrap_or_default();
            for line in if asked { latest(said) } else { said } {
                if self.take(line, &lines, link)? {
                    answered = arrival;
                    self.port.makes_sense();
                }
            }
            link.report_counters(arrival);
            let waited = arrival - answered;
            if waited >= link.silence {
                let what = if asked { self.settings.shown_request() } else { "on its own".into() };
                return Err(self.port.no_answer(&what, waited));
            }
        }
    }

    /// One request and the lines of its answer.
    async fn ask(&mut self, link: &Link) -> Result<Exchange<Vec<Line>>, SessionEnd> {
        self.ticker.tick().await;
        self.sequence += 1;
        let (request, decoder) = (&self.settings.format.request, &mut self.decoder);
        let limit = ANSWER_LIMIT.min(link.silence);
        exchange(&mut self.port, link, request, limit, decoder).await
    }

    /// What a device says on its own until something is whole or the silence is long enough.
    async fn listen(&mut self, link: &Link) -> Result<Exchange<Vec<Line>>, SessionEnd> {
        let mut buffer = [0; 1024];
        let count = self.port.read(&mut buffer, link.silence).await?;
        let arrival = link.now();
        let lines = count.map(|count| self.decoder.push(&buffer[..count]));
        Ok(Exchange { sent: arrival, begun: arrival, arrival, answer: lines })
    }

    /// Publishes a line; true when it is one of this device.
    fn take(
        &mut self,
        line: &Line,
        exchange: &Exchange<Vec<Line>>,
        link: &mut Link,
    ) -> Result<bool, SessionEnd> {
        let wrong = |found: String| SessionEnd::WrongDevice { found, expected: self.settings.shown() };
        match line {
            Line::Strange(text) => {
                link.counters.damaged += 1;
                self.strange += 1;
                if self.last.is_none() && self.strange >= STRANGE_LINES {
                    return Err(wrong(format!("a device that says \"{}\"", text.escape_default())));
                }
                return Ok(false);
            }
            Line::Unit(unit) => return Err(wrong(format!("a device set to the unit \"{unit}\""))),
            Line::Value(_) | Line::Error { .. } => {}
        }
        if self.settings.format.request.is_empty() {
            self.sequence += 1;
        }
        if self.last.is_none() {
            link.identified(self.settings.shown());
            if !self.settings.unconfirmed.is_empty() {
                link.log(false, format!("not confirmed by a manual: {}", self.settings.unconfirmed));
            }
        }
        if let Some((last, at)) = self.last
            && self.sequence > last + 1
        {
            let lost = self.sequence - last - 1;
            link.gap(at, exchange.arrival, Some(lost), "answers were missing or damaged".into());
        }
        self.last = Some((self.sequence, exchange.arrival));
        let reading = match line {
            Line::Value(measured) => self.value(*measured, exchange, link).map_err(wrong)?,
            Line::Error { index, text } => self.without_value(*index, text, exchange, link),
            Line::Strange(_) | Line::Unit(_) => return Ok(false),
        };
        link.reading(reading, exchange.arrival);
        Ok(true)
    }

    fn value(
        &self,
        measured: Measured,
        exchange: &Exchange<Vec<Line>>,
        link: &Link,
    ) -> Result<Reading, String> {
        let number = measured.number.value();
        match (self.settings.role, measured.unit.length_mm()) {
            (Role::Temperature, None) => Ok(self.temperature(number, exchange, link)),
            (Role::Probe(_) | Role::Bar, Some(unit_mm)) => {
                Ok(self.probe(measured.number.digits, number * unit_mm, exchange, link))
            }
            _ => Err(format!("a device set to the unit \"{}\"", measured.unit.name())),
        }
    }

    /// A word instead of a value; its number, or its place in the list, stands for it.
    fn without_value(
        &self,
        index: usize,
        text: &str,
        exchange: &Exchange<Vec<Line>>,
        link: &mut Link,
    ) -> Reading {
        let code = settings::error_code(text, index);
        let meaning = self.settings.format.errors.get(index).map_or("", |(_, meaning)| meaning.as_str());
        match self.settings.role {
            Role::Temperature => self.temperature(f64::NAN, exchange, link),
            Role::Probe(_) | Role::Bar => {
                link.explain(link.first_channel, || format!("\"{}\", {meaning}", text.escape_default()));
                self.probe(code, f64::NAN, exchange, link)
            }
        }
    }

    fn temperature(&self, degc: f64, exchange: &Exchange<Vec<Line>>, link: &Link) -> Reading {
        Reading::Temperature(TemperatureReading {
            name: link.name().to_owned(),
            degc,
            arrival: exchange.arrival,
        })
    }

    fn probe(&self, raw: i64, value_mm: f64, exchange: &Exchange<Vec<Line>>, link: &Link) -> Reading {
        let moment = match self.settings.stamp {
            Stamp::Request => exchange.sent,
            Stamp::Between => exchange.middle(),
            Stamp::Arrival => exchange.arrival,
        };
        Reading::Probe(ProbeReading {
            channel: link.first_channel,
            device_ticks: ((moment - self.begun).as_secs_f64() / TICK_S) as u64,
            tick_s: TICK_S,
            sequence: self.sequence,
            raw,
            value_mm,
            arrival: moment,
        })
    }
}
