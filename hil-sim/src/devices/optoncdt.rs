//! A triangulation probe of the optoNCDT family: streams blocks of distance, counter and time stamp of its own clock,
//! and answers commands. distance = middle of the measuring range + reading.
//!
//! The values are sampled on the probe's clock and reach the host in batches, as a USB converter delivers them.
//! Source of the formats: [`trunnion_protocol::optoncdt`].

use super::clock::{DeviceClock, TimeOrigin};
use super::faults::{Fault, ReplyFault, ScheduledFault};
use super::handle::{DeviceError, Handle};
use super::serial::{self, SerialDevice};
use super::value_faults::ValueFaults;
use super::world::World;
use std::path::Path;
use std::sync::Arc;
use trunnion_protocol::optoncdt::command::{CommandDecoder, Notice};
use trunnion_protocol::optoncdt::values::TIMESTAMP_TICK_S;
use trunnion_protocol::optoncdt::{
    Command, Layout, Measurement, Reply, SensorInfo, encode_block, raw_distance,
};

/// Samples that lie further back are not sent any more, s: a computer asleep does not replay its sleep.
const BACKLOG_S: f64 = 1.0;
/// Measuring rates of the family, Hz.
const RATES_HZ: [f64; 5] = [250.0, 500.0, 1000.0, 2000.0, 4000.0];

/// One probe.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeConfig {
    /// Which of the three readings of [`World::probe_readings_mm`] it sees, 0..=2.
    pub channel: usize,
    /// Model, reported by `GETINFO`.
    pub model: String,
    /// Serial number, reported by `GETINFO`.
    pub serial: String,
    /// Measuring range, mm; reading 0 is in its middle.
    pub range_mm: f64,
    /// Measuring rate at start: 250, 500, 1000, 2000 or 4000 Hz.
    pub rate_hz: f64,
    /// True when the stored settings make it stream without being asked.
    pub streams_at_start: bool,
    /// Time between two deliveries, s.
    pub batch_s: f64,
    /// Shortest time from sampling to delivery, s.
    pub latency_s: f64,
    /// Its clock.
    pub clock: DeviceClock,
    /// What happens to the reply of this number, counted from 0.
    pub reply_fault: Option<(u64, ReplyFault)>,
}

impl ProbeConfig {
    /// A probe of 2 mm at 1 kHz behind a converter that delivers every 4 ms; silent until asked to stream.
    pub fn new(channel: usize, clock: DeviceClock) -> Self {
        Self {
            channel,
            model: "ILD1420-2".into(),
            serial: format!("2105{:04}", channel + 1),
            range_mm: 2.0,
            rate_hz: 1000.0,
            streams_at_start: false,
            batch_s: 0.004,
            latency_s: 0.0005,
            clock,
            reply_fault: None,
        }
    }

    fn check(&self) -> Result<(), DeviceError> {
        let refuse = |setting, found, allowed| {
            Err(DeviceError::Setting { device: "optoNCDT probe", setting, found, allowed })
        };
        if self.channel > 2 {
            return refuse("channel", self.channel as f64, "0..=2");
        }
        if !RATES_HZ.contains(&self.rate_hz) {
            return refuse("rate_hz", self.rate_hz, "250, 500, 1000, 2000, 4000");
        }
        if !(0.001..=0.1).contains(&self.batch_s) {
            return refuse("batch_s", self.batch_s, "0.001..=0.1");
        }
        if !(0.0..=0.1).contains(&self.latency_s) {
            return refuse("latency_s", self.latency_s, "0..=0.1");
        }
        if !(self.range_mm.is_finite() && self.range_mm > 0.0) {
            return refuse("range_mm", self.range_mm, "above 0");
        }
        Ok(())
    }
}

/// Starts a probe on a pseudo-terminal that `port` will link to. Must be called within a tokio runtime.
pub fn spawn(
    world: Arc<dyn World>,
    config: ProbeConfig,
    port: &Path,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    config.check()?;
    serial::spawn("optoNCDT probe", Probe::new(world, config), port, origin, faults)
}

/// The probe without its port. Sample n is taken when its clock shows `epoch + n · period`.
struct Probe {
    world: Arc<dyn World>,
    config: ProbeConfig,
    commands: CommandDecoder,
    /// Additional outputs, in the words of `OUTADD_RS422`.
    additional: Vec<&'static str>,
    streaming: bool,
    rate_hz: f64,
    epoch_device_s: f64,
    /// Counter of sample 0 of this epoch.
    epoch_counter: u64,
    next_sample: u64,
    due_s: f64,
    faults: ValueFaults,
    /// By how much the clock was set, s.
    clock_jump_s: f64,
    /// Replies so far, and one that waits: when it leaves, s; infinite to leave with the next.
    replies: u64,
    waiting: Option<(f64, Vec<u8>)>,
}

impl Probe {
    fn new(world: Arc<dyn World>, config: ProbeConfig) -> Self {
        Self {
            world,
            commands: CommandDecoder::default(),
            additional: Vec::new(),
            streaming: config.streams_at_start,
            rate_hz: config.rate_hz,
            epoch_device_s: config.clock.offset_s,
            epoch_counter: 0,
            next_sample: 0,
            due_s: config.batch_s,
            faults: ValueFaults::default(),
            clock_jump_s: 0.0,
            replies: 0,
            waiting: None,
            config,
        }
    }

    fn sample_device_s(&self, sample: u64) -> f64 {
        self.epoch_device_s + sample as f64 / self.rate_hz
    }

    /// The first sample taken at `t_s` or later.
    fn sample_from(&self, t_s: f64) -> u64 {
        ((self.config.clock.device_s(t_s) - self.epoch_device_s) * self.rate_hz).ceil().max(0.0) as u64
    }

    fn names(&self) -> Vec<&'static str> {
        let halves = |name: &&'static str| match *name {
            "TIMESTAMP" => vec!["TIMESTAMP_LO", "TIMESTAMP_HI"],
            name => vec![name],
        };
        std::iter::once("DIST1").chain(self.additional.iter().flat_map(halves)).collect()
    }

    fn measurement(&self, sample: u64) -> Measurement {
        let device_s = self.sample_device_s(sample);
        let t_s = self.config.clock.cell_s(device_s);
        let reading_mm = self.world.probe_readings_mm(self.faults.seen_s(t_s))[self.config.channel];
        let in_range_mm = 0.5 * self.config.range_mm + reading_mm;
        // The sensor's own words for a target behind its range.
        let distance_mm = if self.faults.is_out(t_s) { f64::INFINITY } else { in_range_mm };
        let ticks = ((device_s + self.clock_jump_s) / TIMESTAMP_TICK_S).round() as i64 as u64;
        Measurement {
            distance: Some(raw_distance(distance_mm, self.config.range_mm)),
            counter: Some((self.epoch_counter + sample) as u32),
            timestamp_ticks: Some(ticks as u32),
            intensity: Some(32_736), // 50 %
            ..Measurement::default()
        }
    }

    fn answer(&mut self, command: &Command, now_s: f64) -> Reply {
        let parameters: Vec<&str> = command.parameters.iter().map(String::as_str).collect();
        match (command.name.as_str(), parameters.as_slice()) {
            ("GETINFO", []) => {
                let ProbeConfig { model, serial, range_mm, .. } = &self.config;
                let (name, serial, range_mm) = match self.faults.wrong_identity {
                    false => (model.clone(), serial.clone(), *range_mm),
                    true => ("ILD1420-50".into(), "15030002".into(), 50.0),
                };
                SensorInfo { name, serial, range_mm, version: "001.010".into() }.reply()
            }
            ("GETOUTINFO_RS422", []) => setting(command, &self.names().join(" ")),
            ("OUTADD_RS422", []) => setting(command, &self.additional.join(" ")),
            ("OUTADD_RS422", ["NONE"]) => {
                self.additional.clear();
                Reply::default()
            }
            ("OUTADD_RS422", wanted) => match additional_outputs(wanted) {
                Some(additional) => {
                    self.additional = additional;
                    Reply::default()
                }
                None => refused(232, "Wrong parameter"),
            },
            ("OUTPUT", []) => setting(command, if self.streaming { "RS422" } else { "NONE" }),
            ("OUTPUT", ["NONE"]) => {
                self.streaming = false;
                Reply::default()
            }
            ("OUTPUT", ["RS422"]) => {
                if !self.streaming {
                    self.next_sample = self.sample_from(now_s);
                    self.due_s = now_s + self.config.batch_s;
                }
                self.streaming = true;
                Reply::default()
            }
            ("MEASRATE", []) => setting(command, &(self.rate_hz / 1000.0).to_string()),
            ("MEASRATE", [rate]) => match rate.parse::<f64>().map(|khz| khz * 1000.0) {
                Ok(rate_hz) if RATES_HZ.contains(&rate_hz) => {
                    self.change_rate(rate_hz, now_s);
                    Reply::default()
                }
                _ => refused(232, "Wrong parameter"),
            },
            _ => refused(210, "Unknown command"),
        }
    }

    fn change_rate(&mut self, rate_hz: f64, now_s: f64) {
        let taken = self.sample_from(now_s);
        self.epoch_device_s = self.sample_device_s(taken);
        self.epoch_counter += taken;
        self.rate_hz = rate_hz;
        self.next_sample = 0;
    }
}

impl SerialDevice for Probe {
    fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        let mut answers = Vec::new();
        for command in self.commands.push(bytes) {
            let reply = self.answer(&command, now_s).encode(&command);
            answers.extend(self.on_its_way(reply, now_s));
        }
        answers
    }

    fn next_due_s(&self) -> Option<f64> {
        let waiting_s = self.waiting.as_ref().map(|(due_s, _)| *due_s).filter(|due_s| due_s.is_finite());
        let streaming_s = self.streaming.then_some(self.due_s);
        [waiting_s, streaming_s].into_iter().flatten().min_by(f64::total_cmp)
    }

    fn send_due(&mut self, now_s: f64) -> Vec<u8> {
        let late = self.waiting.take_if(|(due_s, _)| *due_s <= now_s).map(|(_, reply)| reply);
        let mut bytes = late.unwrap_or_default();
        if self.streaming && self.due_s <= now_s {
            bytes.extend(self.blocks_due(now_s));
        }
        bytes
    }

    /// The probe has its own supply; only the converter was away.
    fn plugged_in(&mut self) {}

    fn has(fault: &Fault) -> bool {
        ValueFaults::are(fault) || matches!(fault, Fault::CounterJump { .. } | Fault::ClockJump { .. })
    }

    fn suffer(&mut self, fault: Fault, now_s: f64) {
        match fault {
            Fault::CounterJump { by } => self.epoch_counter += u64::from(by),
            Fault::ClockJump { by_s } => self.clock_jump_s += by_s,
            // The other sensor has just been switched on and streams only when asked to.
            Fault::WrongIdentity => {
                self.faults.suffer(fault, now_s);
                self.streaming = false;
            }
            _ => self.faults.suffer(fault, now_s),
        }
    }
}

impl Probe {
    /// What of a reply leaves now.
    fn on_its_way(&mut self, reply: Vec<u8>, now_s: f64) -> Vec<u8> {
        let number = self.replies;
        self.replies += 1;
        match self.config.reply_fault.filter(|(at, _)| *at == number).map(|(_, fault)| fault) {
            Some(ReplyFault::Late(by_s)) => self.waiting = Some((now_s + by_s, reply)),
            Some(ReplyFault::Merged) => self.waiting = Some((f64::INFINITY, reply)),
            Some(ReplyFault::Dropped) => {}
            Some(ReplyFault::Cut) => return reply[..reply.len() / 2].to_vec(),
            Some(ReplyFault::Doubled) => return [reply.clone(), reply].concat(),
            None => {
                let before = self.waiting.take_if(|(due_s, _)| due_s.is_infinite());
                return [before.map(|(_, bytes)| bytes).unwrap_or_default(), reply].concat();
            }
        }
        Vec::new()
    }

    fn blocks_due(&mut self, now_s: f64) -> Vec<u8> {
        let batches = ((now_s - self.due_s) / self.config.batch_s).floor().max(0.0) + 1.0;
        self.due_s += batches * self.config.batch_s;
        self.next_sample = self.next_sample.max(self.sample_from(now_s - BACKLOG_S));
        let layout = Layout::from_names(self.names());
        let end = self.sample_from(now_s - self.config.latency_s);
        let blocks = (self.next_sample..end)
            .flat_map(|sample| encode_block(&layout.write(&self.measurement(sample))))
            .collect();
        self.next_sample = self.next_sample.max(end);
        blocks
    }
}

/// The sensor's names of the outputs it can add, in the order it sends them whatever the order asked for.
fn additional_outputs(wanted: &[&str]) -> Option<Vec<&'static str>> {
    const KNOWN: [&str; 3] = ["COUNTER", "TIMESTAMP", "INTENSITY"];
    let known = wanted.iter().all(|word| KNOWN.contains(word));
    known.then(|| KNOWN.into_iter().filter(|name| wanted.contains(name)).collect())
}

/// A read command answers with its name and the setting.
fn setting(command: &Command, value: &str) -> Reply {
    let value = if value.is_empty() { "NONE" } else { value };
    Reply { lines: vec![format!("{} {value}", command.name)], ..Reply::default() }
}

fn refused(number: u16, text: &str) -> Reply {
    Reply { error: Some(Notice { number, text: text.into() }), ..Reply::default() }
}
