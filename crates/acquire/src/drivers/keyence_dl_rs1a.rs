//! Keyence contact gauges (GT2-70, GT-70A, IG) behind a DL-RS1A box. Keys: `port`, `baud` (9600), `delimiter` ("CRLF";
//! "CR"), `poll_ms` (15), and `heads`, each with `head` (1 for the main unit, 2 for the first next to it, …) and `role`.
//!
//! The session asks `M0`, which must give a value for every configured head, and the error state of each (`SR,ii,006`);
//! then it asks `M0` for as long as it lives. All heads of one reply share one moment: the middle between the request
//! and the beginning of the reply, µs since the session began, by the host's clock. The box refreshes its values every
//! 13 ms with three heads, so a value is older than that moment by 0 to 13 ms: a delay that cannot be seen from here
//! and belongs to the `sync-delay` of the fit.
//!
//! A number outside the range of its amplifier is a state: the reading carries the number and no value, and the error
//! state of the amplifier is asked once, which says why.

mod probe;

use crate::bar_zero;
use crate::driver::{Device, Driver, Session};
use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::asked::{Decode, Exchange, exchange};
use crate::transport::serial;
use crate::transport::serial::{Framing, Port};
use probe::REPLY_LIMIT;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};
use trunnion_core::input::Table;
use trunnion_core::reading::{ProbeReading, Reading};
use trunnion_core::{HostTime, Role};
use trunnion_protocol::keyence::{
    AmplifierFaults, Command, Decoder, ERROR_STATE, MOST_AMPLIFIERS, Reply, Value,
};

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "keyence-dl-rs1a",
    about: "Keyence GT2-70, GT-70A or IG gauges behind a DL-RS1A box, ASCII over RS-232",
    default_silence_ms: 1000.0,
    read,
    probe: Some(probe::PROBE),
};

/// Requests that may stay without answer before a session gives up identifying.
const ATTEMPTS: usize = 3;
const TICK_S: f64 = 1e-6;

#[derive(Debug)]
struct DlRs1a {
    port: String,
    baud: u32,
    cr_only: bool,
    poll: Duration,
    heads: Vec<Head>,
}

#[derive(Clone, Copy, Debug)]
struct Head {
    /// Number of the amplifier, from 0.
    amplifier: u8,
    role: Role,
    bar_zero_mm: Option<f64>,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let port = table.string("port");
    let baud = table.optional_number("baud", 1200.0..=38_400.0).unwrap_or(9600.0) as u32;
    let delimiter = table.optional_one_of("delimiter", &["CRLF", "CR"]);
    let poll_ms = table.optional_number("poll_ms", 1.0..=10_000.0).unwrap_or(15.0);
    let tables = table.tables("heads");
    let mut heads: Vec<Head> = Vec::new();
    for entry in &tables {
        let number =
            entry.number("head", 1.0..=MOST_AMPLIFIERS as f64).filter(|number| number.fract() == 0.0);
        let role = Role::read(entry);
        if role == Some(Role::Temperature) {
            entry.problem("role", "= \"temperature\"", "probe-1, probe-2, probe-3, bar", "");
        }
        let bar_zero_mm = bar_zero::read(entry, role);
        entry.no_other_keys();
        let (Some(number), Some(role)) = (number, role) else { continue };
        let amplifier = number as u8 - 1;
        if heads.iter().any(|other| other.amplifier == amplifier) {
            entry.problem("head", format!("= {number} appears twice"), "each head once", "");
        }
        heads.push(Head { amplifier, role, bar_zero_mm });
    }
    if tables.is_empty() {
        table.problem("heads", "has no entry", "[{ head = 1, role = \"probe-1\" }, …]", "");
    }
    let complete = !heads.is_empty() && heads.len() == tables.len();
    let cr_only = delimiter.as_deref() == Some("CR");
    let poll = Duration::from_secs_f64(poll_ms / 1e3);
    let port = port?;
    complete.then(|| Arc::new(DlRs1a { port, baud, cr_only, poll, heads }) as Arc<_>)
}

impl Device for DlRs1a {
    fn channels(&self) -> Vec<(String, Role)> {
        self.heads.iter().map(|head| (format!("head-{}", head.amplifier + 1), head.role)).collect()
    }

    fn bar_zero_mm(&self) -> Option<f64> {
        self.heads.iter().find_map(|head| head.bar_zero_mm)
    }

    fn asked_every(&self) -> Option<Duration> {
        Some(self.poll)
    }

    fn address(&self) -> &str {
        &self.port
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(async move {
            let mut poller = Poller {
                config: self,
                port: serial::open(&self.port, self.baud, Framing::PLAIN, link)?,
                decoder: Decoder::default(),
                begun: link.now(),
                polls: 0,
                last: None,
                without_value: vec![false; self.heads.len()],
            };
            poller.run(link).await
        })
    }
}

struct Poller<'a> {
    config: &'a DlRs1a,
    port: Port,
    decoder: Decoder,
    begun: HostTime,
    polls: u64,
    /// Number and arrival of the last poll that was answered.
    last: Option<(u64, HostTime)>,
    without_value: Vec<bool>,
}

impl Poller<'_> {
    async fn run(&mut self, link: &mut Link) -> Result<Infallible, SessionEnd> {
        let amplifiers = self.identify(link).await?;
        let mut ticker = interval(self.config.poll);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut answered = link.now();
        loop {
            ticker.tick().await;
            self.polls += 1;
            let exchange = self.ask(Command::ReadAll, link).await?;
            link.report_counters(exchange.arrival);
            match &exchange.answer {
                Some(Reply::All(values)) if values.len() == amplifiers => {
                    answered = exchange.arrival;
                    self.port.makes_sense();
                    self.publish(values, &exchange, link).await?;
                }
                Some(Reply::All(values)) => {
                    let change = format!("the box had {amplifiers} amplifiers and now has {}", values.len());
                    return Err(SessionEnd::Restarted(change));
                }
                // Error 29: the request was damaged on the line. It counts as a reply that is missing.
                Some(Reply::Refused(refusal)) if refusal.number != 29 => {
                    return Err(SessionEnd::Protocol { doing: "asking M0", fault: refusal.to_string() });
                }
                Some(Reply::Refused(_) | Reply::Data { .. }) | None => {
                    link.counters.damaged += 1;
                    let waited = exchange.arrival - answered;
                    if waited >= link.silence {
                        return Err(self.port.no_answer("M0", waited));
                    }
                }
            }
        }
    }

    /// How many amplifiers the box has, once it is certain that it is one and has those configured.
    async fn identify(&mut self, link: &mut Link) -> Result<usize, SessionEnd> {
        let mut found = None;
        for _ in 0..ATTEMPTS {
            let exchange = self.ask(Command::ReadAll, link).await?;
            if let Some(Reply::All(values)) = exchange.answer {
                found = Some(values);
                break;
            }
            if let Some(Reply::Refused(refusal)) = exchange.answer {
                link.log(true, refusal.to_string());
            }
        }
        let Some(values) = found else {
            return Err(self.port.no_answer("M0", REPLY_LIMIT * ATTEMPTS as u32));
        };
        let series = values.first().map_or("", |value| value.family.name());
        let identity = format!("Keyence DL-RS1A with {} amplifiers {series}", values.len());
        if let Some(missing) =
            self.config.heads.iter().find(|head| usize::from(head.amplifier) >= values.len())
        {
            return Err(SessionEnd::WrongDevice {
                found: identity,
                expected: format!("a box with head {} ({})", missing.amplifier + 1, missing.role.name()),
            });
        }
        for head in &self.config.heads {
            for cause in self.faults(head.amplifier, link).await? {
                link.log(true, format!("head {}: {cause}", head.amplifier + 1));
            }
        }
        link.identified(identity);
        Ok(values.len())
    }

    async fn publish(
        &mut self,
        values: &[Value],
        exchange: &Exchange<Reply>,
        link: &mut Link,
    ) -> Result<(), SessionEnd> {
        let arrival = exchange.arrival;
        if let Some((last, at)) = self.last
            && self.polls > last + 1
        {
            let lost = (self.polls - last - 1) * self.config.heads.len() as u64;
            link.gap(at, arrival, Some(lost), "replies of the box were missing or damaged".into());
        }
        self.last = Some((self.polls, arrival));
        let moment = exchange.middle();
        // The cause comes before the reading that it explains.
        for (index, head) in self.config.heads.iter().enumerate() {
            let value = values[usize::from(head.amplifier)];
            let is_without = value.position_mm().is_none();
            let was_without = std::mem::replace(&mut self.without_value[index], is_without);
            if is_without && !was_without {
                let causes = self.faults(head.amplifier, link).await?;
                link.explain(link.first_channel + index as u16, || no_position(value, &causes));
            }
        }
        for (index, head) in self.config.heads.iter().enumerate() {
            let value = values[usize::from(head.amplifier)];
            let position_mm = value.position_mm();
            let reading = ProbeReading {
                channel: link.first_channel + index as u16,
                device_ticks: ((moment - self.begun).as_secs_f64() / TICK_S) as u64,
                tick_s: TICK_S,
                sequence: self.polls,
                raw: value.digits,
                value_mm: position_mm.unwrap_or(f64::NAN),
                arrival: moment,
            };
            link.reading(Reading::Probe(reading), arrival);
        }
        Ok(())
    }

    /// Asks an amplifier for its error state: its causes in words.
    async fn faults(&mut self, amplifier: u8, link: &mut Link) -> Result<Vec<String>, SessionEnd> {
        let exchange = self.ask(Command::Read { amplifier, data: ERROR_STATE }, link).await?;
        match exchange.answer {
            Some(Reply::Data { text, .. }) => {
                Ok(AmplifierFaults::parse(&text).map(AmplifierFaults::causes).unwrap_or_default())
            }
            Some(Reply::Refused(refusal)) => {
                link.log(false, format!("head {}: {refusal}", amplifier + 1));
                Ok(Vec::new())
            }
            Some(Reply::All(_)) | None => Ok(Vec::new()),
        }
    }

    async fn ask(&mut self, command: Command, link: &mut Link) -> Result<Exchange<Reply>, SessionEnd> {
        let mut request = command.encode();
        if self.config.cr_only {
            request.pop();
        }
        let fits = |reply: &Reply| match (command, reply) {
            (Command::ReadAll, Reply::All(_)) | (_, Reply::Refused(_)) => true,
            (Command::Read { amplifier, data }, Reply::Data { amplifier: from, number, .. }) => {
                (amplifier, data) == (*from, *number)
            }
            (Command::ReadAll, Reply::Data { .. }) | (Command::Read { .. }, Reply::All(_)) => false,
        };
        let mut fitting = Fitting { decoder: &mut self.decoder, fits };
        let answered = exchange(&mut self.port, link, &request, REPLY_LIMIT, &mut fitting).await;
        let seen = self.decoder.counts();
        (link.counters.dropped_bytes, link.counters.resyncs) = (seen.dropped_bytes, seen.resyncs);
        answered
    }
}

/// Gives out what fits the command.
struct Fitting<'a, F> {
    decoder: &'a mut Decoder,
    fits: F,
}

impl<F: Fn(&Reply) -> bool> Decode<Reply> for Fitting<'_, F> {
    fn push(&mut self, bytes: &[u8]) -> Option<Reply> {
        // Two at once: the first is of a request before.
        self.decoder.push(bytes).into_iter().rfind(&self.fits)
    }

    fn is_half(&self) -> bool {
        self.decoder.is_half()
    }

    fn restart(&mut self) {
        self.decoder.restart();
    }

    fn spoil(&mut self) {
        self.decoder.spoil();
    }
}

/// Why a head has no value, and what to check.
fn no_position(value: Value, causes: &[String]) -> String {
    let says = if causes.is_empty() {
        "the amplifier reports no error; check that the head is within its range, connected, and not in a hold mode".into()
    } else {
        causes.join("; ")
    };
    format!("{value} is a state of the amplifier and no position: {says}")
}
