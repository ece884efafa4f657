//! What sessions deliver: readings as the devices sent them, on the devices' own clocks, with host arrival stamps.

use crate::{AxisValues, HostTime};

/// One message of one device.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Index of the device in the configuration.
    pub device: u16,
    /// Which connection it came from, counted from 1; device clocks restart with each.
    pub epoch: u32,
    /// What it says.
    pub reading: Reading,
}

/// Content of a [`Message`].
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// One displacement.
    Probe(ProbeReading),
    /// The axis positions of one instant.
    Axes(AxisReading),
    /// What the controller is doing, sent when it changes.
    Controller(ControllerReading),
    /// One temperature.
    Temperature(TemperatureReading),
    /// For the log of the run.
    Log(LogLine),
    /// Totals of this connection, about once a second.
    Counters(Counters),
    /// Something is missing.
    Gap(SourceGap),
}

/// One reading of one displacement channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeReading {
    /// Index into the channels of the run, [`crate::Channel`].
    pub channel: u16,
    /// Device clock, ticks, unwrapped.
    pub device_ticks: u64,
    /// Nominal length of a tick, s.
    pub tick_s: f64,
    /// Count of measurements at the device (SYNC index on CANopen): a jump is a loss.
    pub sequence: u64,
    /// Number as sent.
    pub raw: i64,
    /// Displacement, mm; NaN when the device reports an error, whose code is then `raw`.
    pub value_mm: f64,
    /// When the bytes were read; where the host itself stamps the reading, that stamp.
    pub arrival: HostTime,
}

/// Axis positions with one stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisReading {
    /// Stamp of the source, ns on its own clock.
    pub stamp_ns: i64,
    /// When the bytes were read.
    pub arrival: HostTime,
    /// Machine positions, mm and rad.
    pub position: AxisValues<f64>,
    /// Which axes the controller reports.
    pub present: AxisValues<bool>,
    /// Sequence number of the newest observation in it.
    pub sequence: u64,
    /// True when the source said only that nothing has changed: the stamp is then carried on by the host's clock.
    pub held: bool,
    /// Largest difference between the stamps of the axes, ns; 0 with a common stamp.
    pub skew_ns: i64,
}

/// State of the controller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControllerReading {
    /// Whether a program runs.
    pub execution: Execution,
    /// Program name, empty when unknown.
    pub program: String,
    /// Block or line text, empty when unknown.
    pub block: String,
    /// The signal named in the configuration: 0 while it is off, else its number, 1 of one that is only on; `None` when there is none or
    /// its state is unknown.
    pub signal: Option<u32>,
    /// Stamp of the source, ns on its own clock.
    pub stamp_ns: i64,
    /// When the bytes were read.
    pub arrival: HostTime,
}

/// What a program does, whatever its controller calls it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Execution {
    /// Not reported.
    #[default]
    Unknown,
    /// No program is under way: reset, ready to run.
    Ready,
    /// Running.
    Active,
    /// Held, and goes on: M0, M1, feed hold, interrupted, waiting.
    Held,
    /// Stopped without having been asked to (emergency stop, alarm): it goes on or is reset, which is not known yet.
    Stopped,
    /// Over: completed or aborted.
    Ended,
}

/// One temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureReading {
    /// Name of the channel.
    pub name: String,
    /// Temperature, °C; NaN when the sensor reports an error.
    pub degc: f64,
    /// When the bytes were read.
    pub arrival: HostTime,
}

/// A line for the log of the run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// True when a person should look at it.
    pub warning: bool,
    /// What happened.
    pub text: String,
    /// When.
    pub at: HostTime,
}

/// Totals of one connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Readings decoded.
    pub readings: u64,
    /// Readings in which the device reported an error.
    pub error_readings: u64,
    /// Measurements the device made that did not arrive.
    pub lost_readings: u64,
    /// Bytes that belonged to no message.
    pub dropped_bytes: u64,
    /// Messages or blocks thrown away because they were damaged.
    pub damaged: u64,
    /// Times the order of the stream was lost.
    pub resyncs: u64,
}

/// Time in which a source delivered nothing although it should have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceGap {
    /// Name of the device or channel.
    pub source: String,
    /// Last moment with data.
    pub from: HostTime,
    /// First moment with data again.
    pub to: HostTime,
    /// Readings missing, where they are counted.
    pub lost_readings: Option<u64>,
    /// Why.
    pub reason: String,
}
