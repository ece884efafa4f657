//! An indicator that says its value as a line of ASCII, of any preset: asked, or talking on its own.
//!
//! Source of the formats: [`trunnion_protocol::ascii`].

use super::clock::TimeOrigin;
use super::faults::{Fault, ReplyFault, ScheduledFault};
use super::handle::{DeviceError, Handle};
use super::serial::{self, Outbox, SerialDevice};
use super::value_faults::ValueFaults;
use super::world::{World, mix};
use std::path::Path;
use std::sync::Arc;
use trunnion_protocol::ascii::{Preset, Stamp, Unit};

/// Longer than any request of a preset.
const LONGEST_REQUEST: usize = 64;

/// What the indicator is connected to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sees {
    /// Probe 0, 1 or 2 of the world.
    Probe(usize),
    /// The ball bar.
    Bar,
    /// The thermometer.
    Temperature,
}

/// One indicator.
#[derive(Debug, Clone, PartialEq)]
pub struct IndicatorConfig {
    /// What it measures.
    pub sees: Sees,
    /// What it is.
    pub preset: Preset,
    /// Time from the request to the end of the answer, s.
    pub answer_s: f64,
    /// When a value not latched at the request is taken: first and last moment, as a share of that time, any between with the same chance.
    pub taken: (f64, f64),
    /// Time between two lines of an indicator that talks on its own, s.
    pub period_s: f64,
    /// True when bytes carry an even parity bit, as a 7-bit format does on a port that does not take it away.
    pub parity_bits: bool,
    /// What happens to the answer of this number, counted from 0.
    pub reply_fault: Option<(u64, ReplyFault)>,
}

impl IndicatorConfig {
    /// An indicator that answers after 30 ms with the value of the middle, or talks ten times a second.
    pub fn new(sees: Sees, preset: Preset) -> Self {
        let parity_bits = preset.framing.starts_with("7E");
        Self {
            sees,
            preset,
            answer_s: 0.03,
            taken: (0.5, 0.5),
            period_s: 0.1,
            parity_bits,
            reply_fault: None,
        }
    }

    fn check(&self) -> Result<(), DeviceError> {
        let refuse = |setting, found, allowed| {
            Err(DeviceError::Setting { device: "indicator", setting, found, allowed })
        };
        if let Sees::Probe(channel) = self.sees
            && channel > 2
        {
            return refuse("channel", channel as f64, "0..=2");
        }
        if !(0.0..=1.0).contains(&self.answer_s) {
            return refuse("answer_s", self.answer_s, "0..=1");
        }
        let (first, last) = self.taken;
        if !(0.0..=1.0).contains(&first) || !(first..=1.0).contains(&last) {
            return refuse("taken", last - first, "two rising shares in 0..=1");
        }
        if !(0.001..=60.0).contains(&self.period_s) {
            return refuse("period_s", self.period_s, "0.001..=60");
        }
        Ok(())
    }
}

/// Starts an indicator on a pseudo-terminal that `port` will link to. Must be called within a tokio runtime.
pub fn spawn(
    world: Arc<dyn World>,
    config: IndicatorConfig,
    port: &Path,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    config.check()?;
    let device = Indicator {
        world,
        heard: Vec::new(),
        asked: 0,
        outbox: Outbox::with_fault(config.reply_fault),
        next_line_s: config.preset.request.is_empty().then_some(0.0),
        faults: ValueFaults::default(),
        config,
    };
    serial::spawn("indicator", device, port, origin, faults)
}

/// The indicator without its port.
struct Indicator {
    world: Arc<dyn World>,
    config: IndicatorConfig,
    /// Bytes of a request not yet whole.
    heard: Vec<u8>,
    /// Requests heard.
    asked: u64,
    outbox: Outbox,
    /// When an indicator that talks on its own says its next line.
    next_line_s: Option<f64>,
    faults: ValueFaults,
}

impl Indicator {
    /// The line for the value of `t_s`.
    fn line(&self, t_s: f64) -> Vec<u8> {
        let preset = &self.config.preset;
        let (seen_s, error) = (self.faults.seen_s(t_s), preset.errors.last().map(|(word, _)| *word));
        let text = if self.faults.wrong_identity {
            "HELLO 17".to_owned()
        } else if let Some(word) = error.filter(|_| self.faults.is_out(t_s)) {
            word.to_owned()
        } else {
            preset.line(self.number(seen_s))
        };
        self.on_the_line(text + "\r\n")
    }

    /// When the value for a request heard at `now_s` is taken.
    fn taken_s(&mut self, now_s: f64) -> f64 {
        self.asked += 1;
        let (first, last) = self.config.taken;
        let share = (mix(self.asked) >> 11) as f64 / (1u64 << 53) as f64;
        match self.config.preset.stamp {
            Stamp::Request => now_s,
            Stamp::Between | Stamp::Arrival => {
                now_s + (first + share * (last - first)) * self.config.answer_s
            }
        }
    }

    fn number(&self, t_s: f64) -> f64 {
        let length_mm = match self.config.sees {
            Sees::Probe(channel) => self.world.probe_readings_mm(t_s)[channel],
            Sees::Bar => self.world.bar_reading_mm(t_s),
            Sees::Temperature => return self.world.temperature_degc(t_s),
        };
        match self.config.preset.unit {
            Unit::Millimetre | Unit::Celsius => length_mm,
            Unit::Micrometre => 1e3 * length_mm,
            Unit::Inch => length_mm / 25.4,
        }
    }

    fn on_the_line(&self, text: String) -> Vec<u8> {
        let parity = |byte: u8| if byte.count_ones() % 2 == 1 { byte | 0x80 } else { byte };
        let bytes = text.into_bytes();
        if self.config.parity_bits { bytes.into_iter().map(parity).collect() } else { bytes }
    }
}

impl SerialDevice for Indicator {
    fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        let Preset { request, identity: (question, names), .. } = self.config.preset;
        for &byte in bytes {
            self.heard.push(byte & 0x7F);
            let is = |text: &str| !text.is_empty() && self.heard.ends_with(text.as_bytes());
            let due_s = now_s + self.config.answer_s;
            if is(question) {
                let name = names.first().map_or(String::new(), |name| format!("{name} 4711\r\n"));
                let answer = self.on_the_line(name);
                self.outbox.put(due_s, answer);
            } else if is(request) {
                let taken_s = self.taken_s(now_s);
                let answer = self.line(taken_s);
                self.outbox.put(due_s, answer);
            } else if self.heard.len() < LONGEST_REQUEST {
                continue;
            }
            self.heard.clear();
        }
        Vec::new()
    }

    fn next_due_s(&self) -> Option<f64> {
        let answer_s = self.outbox.next_due_s();
        match (answer_s, self.next_line_s) {
            (Some(answer_s), Some(line_s)) => Some(answer_s.min(line_s)),
            (answer_s, line_s) => answer_s.or(line_s),
        }
    }

    fn send_due(&mut self, now_s: f64) -> Vec<u8> {
        let mut bytes = self.outbox.take_due(now_s);
        if let Some(due_s) = self.next_line_s.filter(|due_s| *due_s <= now_s) {
            bytes.extend(self.line(due_s.max(now_s - self.config.period_s)));
            let periods = ((now_s - due_s) / self.config.period_s).floor() + 1.0;
            self.next_line_s = Some(due_s + periods * self.config.period_s);
        }
        bytes
    }

    /// It has its own supply; only the converter was away.
    fn plugged_in(&mut self) {
        self.heard.clear();
        self.outbox.clear();
    }

    fn has(fault: &Fault) -> bool {
        ValueFaults::are(fault)
    }

    fn suffer(&mut self, fault: Fault, now_s: f64) {
        self.faults.suffer(fault, now_s);
    }
}
