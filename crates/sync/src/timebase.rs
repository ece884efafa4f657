//! Run time: every reading on its device clock becomes a sample in seconds since the run began.
//!
//! One [`crate::clock::ClockTrack`] for each connection of each device. The time of a device's samples never goes back, even when
//! a new arrival lowers its line. Readings taken before the run began have negative times.

use crate::clock::{ClockTrack, Jump, WINDOW_S};
use std::collections::HashMap;
use trunnion_core::reading::{AxisReading, Message, ProbeReading, Reading};
use trunnion_core::{AxisSample, Event, Gap, HostTime, ProbeSample, Stamp};

/// Axis stamps are in ns.
const AXIS_TICK_S: f64 = 1e-9;

/// A reading in run time.
#[derive(Clone, Debug, PartialEq)]
pub enum Timed {
    /// A displacement.
    Probe(ProbeSample),
    /// Axis positions.
    Axes(AxisSample),
    /// Something missing.
    Gap(Gap),
    /// A temperature: channel name, °C, time.
    Temperature {
        /// Name of the channel.
        name: String,
        /// Temperature, °C.
        degc: f64,
        /// When, s since the run began.
        time_s: f64,
    },
    /// Controller states and log lines.
    Event(Event),
}

/// Translates the readings of one run.
#[derive(Clone, Debug)]
pub struct TimeBase {
    origin: HostTime,
    lines: HashMap<u16, DeviceLine>,
    jumps: Vec<(u16, Jump)>,
}

#[derive(Clone, Debug)]
struct DeviceLine {
    epoch: u32,
    clock: ClockTrack,
    last: Option<(u64, HostTime)>,
}

impl TimeBase {
    /// `origin` is time zero of the run.
    pub fn new(origin: HostTime) -> Self {
        Self { origin, lines: HashMap::new(), jumps: Vec::new() }
    }

    /// A run begins at `origin`; what is known of the clocks stays.
    pub fn begin_run(&mut self, origin: HostTime) {
        self.origin = origin;
    }

    /// Run time of a host time, s.
    pub fn seconds(&self, at: HostTime) -> f64 {
        at.seconds_since(self.origin)
    }

    /// Clocks that were reset since this was asked last: index of the device, and the time between as a gap of `source`.
    pub fn take_jumps(&mut self) -> Vec<(u16, Jump)> {
        std::mem::take(&mut self.jumps)
    }

    /// The time around a jump as a gap in the words of a recording.
    pub fn jump_gap(&self, source: &str, jump: &Jump) -> Gap {
        Gap {
            source: source.into(),
            from_s: self.seconds(jump.from),
            to_s: self.seconds(jump.to),
            lost_samples: None,
            reason: format!(
                "its clock was set by {:+.3} s; times of readings between are uncertain by that much",
                jump.by_s
            ),
        }
    }

    /// The message in run time; `None` for counters, which have none.
    pub fn translate(&mut self, message: &Message) -> Option<Timed> {
        let (device, epoch) = (message.device, message.epoch);
        Some(match &message.reading {
            Reading::Probe(reading) => Timed::Probe(self.probe(device, epoch, reading)),
            Reading::Axes(reading) => Timed::Axes(self.axes(device, epoch, reading)),
            Reading::Gap(gap) => Timed::Gap(Gap {
                source: gap.source.clone(),
                from_s: self.seconds(gap.from),
                to_s: self.seconds(gap.to),
                lost_samples: gap.lost_readings,
                reason: gap.reason.clone(),
            }),
            Reading::Temperature(reading) => Timed::Temperature {
                name: reading.name.clone(),
                degc: reading.degc,
                time_s: self.seconds(reading.arrival),
            },
            Reading::Controller(reading) => Timed::Event(Event {
                time_s: self.seconds(reading.arrival),
                kind: "controller".into(),
                text: format!("{:?} {} {}", reading.execution, reading.program, reading.block).trim().into(),
            }),
            Reading::Log(line) => Timed::Event(Event {
                time_s: self.seconds(line.at),
                kind: if line.warning { "warning" } else { "log" }.into(),
                text: line.text.clone(),
            }),
            Reading::Counters(_) => return None,
        })
    }

    /// Estimated drift of a device's clock; `None` before its first reading.
    pub fn drift(&self, device: u16) -> Option<f64> {
        Some(self.lines.get(&device)?.clock.translation()?.drift)
    }

    fn probe(&mut self, device: u16, epoch: u32, reading: &ProbeReading) -> ProbeSample {
        let ticks = reading.device_ticks;
        ProbeSample {
            channel: reading.channel,
            time_s: self.time(device, epoch, reading.tick_s, ticks, Some(reading.arrival)),
            stamp: self.stamp(epoch, reading.tick_s, ticks, reading.arrival),
            raw: reading.raw,
            value_mm: reading.value_mm,
        }
    }

    fn axes(&mut self, device: u16, epoch: u32, reading: &AxisReading) -> AxisSample {
        let ticks = reading.stamp_ns.cast_unsigned();
        // The stamp of held positions comes from the host's clock and says nothing about the controller's.
        let arrival = Some(reading.arrival).filter(|_| !reading.held);
        AxisSample {
            time_s: self.time(device, epoch, AXIS_TICK_S, ticks, arrival),
            stamp: self.stamp(epoch, AXIS_TICK_S, ticks, reading.arrival),
            held: reading.held,
            skew_s: reading.skew_ns as f64 * 1e-9,
            position: reading.position,
        }
    }

    fn stamp(&self, epoch: u32, tick_s: f64, ticks: u64, arrival: HostTime) -> Stamp {
        Stamp { epoch, ticks, tick_s, arrival_s: self.seconds(arrival) }
    }

    /// Run time of a tick; an arrival improves the line first.
    fn time(&mut self, device: u16, epoch: u32, tick_s: f64, ticks: u64, arrival: Option<HostTime>) -> f64 {
        let known = self.lines.remove(&device).filter(|known| known.epoch == epoch);
        let mut known = known.unwrap_or_else(|| DeviceLine {
            epoch,
            clock: ClockTrack::new(tick_s, WINDOW_S),
            last: None,
        });
        if let Some(jump) = arrival.and_then(|arrival| known.clock.push(ticks, arrival)) {
            self.jumps.push((device, jump));
        }
        let by_line = known.clock.to_host(ticks).or(arrival).unwrap_or(self.origin);
        let at = match known.last {
            Some((last_ticks, last)) if last_ticks == ticks => last,
            Some((_, last)) => by_line.max(last),
            None => by_line,
        };
        known.last = Some((ticks, at));
        self.lines.insert(device, known);
        self.seconds(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(epoch: u32, device_ticks: u64, arrival_ms: i64) -> Message {
        let arrival = HostTime(1_000_000_000 + arrival_ms * 1_000_000);
        let reading = ProbeReading {
            channel: 0,
            device_ticks,
            tick_s: 1e-3,
            sequence: 0,
            raw: 0,
            value_mm: 0.0,
            arrival,
        };
        Message { device: 0, epoch, reading: Reading::Probe(reading) }
    }

    #[test]
    fn time_never_goes_back_and_a_new_connection_begins_a_new_clock() {
        let mut base = TimeBase::new(HostTime(1_000_000_000));
        let mut time = |message| match base.translate(&message) {
            Some(Timed::Probe(sample)) => sample.time_s,
            other => panic!("{other:?}"),
        };
        assert_eq!(time(probe(1, 100, 20)), 0.020);
        // The next arrival shows that the first was 15 ms late; its own time must still not lie before it.
        assert_eq!(time(probe(1, 101, 6)), 0.020);
        assert_eq!(time(probe(1, 120, 30)), 0.025);
        assert_eq!(time(probe(2, 5, 500)), 0.500);
    }
}
