//! What devices deliver before it becomes points: samples, gaps and events, all in run time.

use crate::AxisValues;

/// When a sample was taken, as it came: nothing here is corrected, so that clocks can be fitted again later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// Which connection it came by: device clocks restart with each.
    pub epoch: u32,
    /// Device clock, ticks as counted (unwrapped).
    pub ticks: u64,
    /// Nominal length of a tick, s.
    pub tick_s: f64,
    /// When its bytes were read, s since the run began; NaN when nobody knows.
    pub arrival_s: f64,
}

impl Default for Stamp {
    /// Nothing known.
    fn default() -> Self {
        Self { epoch: 0, ticks: 0, tick_s: 0.0, arrival_s: f64::NAN }
    }
}

/// One reading of one displacement channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProbeSample {
    /// Channel: index of the device in the configuration.
    pub channel: u16,
    /// Corrected acquisition time, s since the run began.
    pub time_s: f64,
    /// Device clock and arrival.
    pub stamp: Stamp,
    /// Raw count as sent by the device.
    pub raw: i64,
    /// Displacement, mm; NaN when the device reported an error.
    pub value_mm: f64,
}

/// Axis positions with one time stamp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisSample {
    /// Corrected acquisition time, s since the run began.
    pub time_s: f64,
    /// The controller's clock and arrival.
    pub stamp: Stamp,
    /// True when the controller said only that nothing has changed; the stamp is then the host's and reports nothing of its clock.
    pub held: bool,
    /// Largest difference between the stamps of the axes, s; 0 with a common stamp.
    pub skew_s: f64,
    /// Positions, mm and rad.
    pub position: AxisValues<f64>,
}

/// Time in which a source delivered nothing although it should have.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Name of the source.
    pub source: String,
    /// From, s since the run began.
    pub from_s: f64,
    /// To, s since the run began.
    pub to_s: f64,
    /// Samples missing, where the device counts them.
    pub lost_samples: Option<u64>,
    /// Why.
    pub reason: String,
}

/// Something that happened during a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, s since the run began.
    pub time_s: f64,
    /// Kind in the words of the product, e.g. `cycle-start`, `point`, `setup-change`.
    pub kind: String,
    /// Detail for a person.
    pub text: String,
}
