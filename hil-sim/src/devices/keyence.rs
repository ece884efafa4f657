//! A DL-RS1A box with GT2-70 gauges: answers `M0` and reads of the error state, refreshes its values on a clock of its
//! own, and takes the line's time to say them. A gauge reads the deflection along its direction; 0 is its preset.
//!
//! Source of the formats: [`trunnion_protocol::keyence`].

use super::clock::TimeOrigin;
use super::faults::{Fault, ReplyFault, ScheduledFault};
use super::handle::{DeviceError, Handle};
use super::serial::{self, Outbox, SerialDevice};
use super::value_faults::ValueFaults;
use super::world::World;
use std::path::Path;
use std::sync::Arc;
use trunnion_protocol::keyence::{Command, CommandDecoder, ERROR_STATE, Family, Refusal, Reply, Value};

/// A number outside ±199.9999 is a state of the amplifier.
const NO_POSITION: i64 = 9_999_998;
/// Bit 1 of the error state: no signal from the head.
const HEAD_ERROR: &str = "00002";
/// Time to understand a command, s.
const THINKING_S: f64 = 0.002;
/// Bits of a byte on the line, 8N1.
const BITS_PER_BYTE: f64 = 10.0;

/// One box.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxConfig {
    /// Amplifiers, 1..=3: amplifier k reads probe k of the world.
    pub amplifiers: usize,
    /// Line speed, bit/s; answers take their time.
    pub baud: u32,
    /// Time between two refreshes of the values, s.
    pub refresh_s: f64,
    /// What happens to the reply of this number, counted from 0.
    pub reply_fault: Option<(u64, ReplyFault)>,
}

impl BoxConfig {
    /// Three gauges at 38 400 baud, refreshed every 13 ms.
    pub fn three_gauges() -> Self {
        Self { amplifiers: 3, baud: 38_400, refresh_s: 0.013, reply_fault: None }
    }

    fn check(&self) -> Result<(), DeviceError> {
        let refuse = |setting, found, allowed| {
            Err(DeviceError::Setting { device: "DL-RS1A", setting, found, allowed })
        };
        if !(1..=3).contains(&self.amplifiers) {
            return refuse("amplifiers", self.amplifiers as f64, "1..=3");
        }
        if !(1200..=115_200).contains(&self.baud) {
            return refuse("baud", f64::from(self.baud), "1200..=115200");
        }
        if !(0.001..=1.0).contains(&self.refresh_s) {
            return refuse("refresh_s", self.refresh_s, "0.001..=1");
        }
        Ok(())
    }
}

/// Starts a box on a pseudo-terminal that `port` will link to. Must be called within a tokio runtime.
pub fn spawn(
    world: Arc<dyn World>,
    config: BoxConfig,
    port: &Path,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    config.check()?;
    let outbox = Outbox::with_fault(config.reply_fault);
    let device =
        DlRs1a { world, config, commands: CommandDecoder::default(), outbox, faults: ValueFaults::default() };
    serial::spawn("DL-RS1A", device, port, origin, faults)
}

/// The box without its port.
struct DlRs1a {
    world: Arc<dyn World>,
    config: BoxConfig,
    commands: CommandDecoder,
    outbox: Outbox,
    faults: ValueFaults,
}

impl DlRs1a {
    /// Another box, with one amplifier, may have taken the place of this one.
    fn amplifiers(&self) -> usize {
        if self.faults.wrong_identity { 1 } else { self.config.amplifiers }
    }

    fn values(&self, now_s: f64) -> Vec<Value> {
        let refreshed_s = (now_s / self.config.refresh_s).floor() * self.config.refresh_s;
        let readings_mm = self.world.probe_readings_mm(self.faults.seen_s(refreshed_s));
        let out = self.faults.is_out(refreshed_s);
        let value = |&reading_mm: &f64| match out {
            true => Value { family: Family::Gt2, digits: NO_POSITION },
            false => Value::of_position_mm(Family::Gt2, reading_mm),
        };
        readings_mm[..self.amplifiers()].iter().map(value).collect()
    }

    fn answer(&self, command: Result<Command, String>, now_s: f64) -> Reply {
        let refused = |command: &str, number| Reply::Refused(Refusal { command: command.into(), number });
        match command {
            Ok(Command::ReadAll) => Reply::All(self.values(now_s)),
            Ok(Command::Read { amplifier, .. }) if usize::from(amplifier) >= self.amplifiers() => {
                refused("SR", 65)
            }
            Ok(Command::Read { amplifier, data: ERROR_STATE }) => {
                let text = if self.faults.is_out(now_s) { HEAD_ERROR } else { "00000" };
                Reply::Data { amplifier, number: ERROR_STATE, text: text.into() }
            }
            Ok(Command::Read { .. }) => refused("SR", 22),
            Err(letters) => refused(&letters, 0),
        }
    }
}

impl SerialDevice for DlRs1a {
    fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        let line_s = |bytes: usize| bytes as f64 * BITS_PER_BYTE / f64::from(self.config.baud);
        let asked_s = now_s + line_s(bytes.len()) + THINKING_S;
        for command in self.commands.push(bytes) {
            let answer = self.answer(command, asked_s).encode();
            self.outbox.put(asked_s + line_s(answer.len()), answer);
        }
        Vec::new()
    }

    fn next_due_s(&self) -> Option<f64> {
        self.outbox.next_due_s()
    }

    fn send_due(&mut self, now_s: f64) -> Vec<u8> {
        self.outbox.take_due(now_s)
    }

    /// The box has its own supply; only the converter was away.
    fn plugged_in(&mut self) {
        self.outbox.clear();
    }

    fn has(fault: &Fault) -> bool {
        ValueFaults::are(fault)
    }

    fn suffer(&mut self, fault: Fault, now_s: f64) {
        self.faults.suffer(fault, now_s);
    }
}
