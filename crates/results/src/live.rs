//! What is read at this moment: for setting up at the machine, on the screen, the page and MQTT.

use crate::topics::Published;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-live/1`: the latest value of everything that is read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Live {
    /// Format and version.
    pub format: LiveFormat,
    /// When, by the wall clock, ISO 8601 in UTC.
    pub at: String,
    /// Probes and ball bar, in the order of the configuration.
    pub probes: Vec<LiveProbe>,
    /// The ball from the place where every probe is at its centre, directions of the machine, mm; null where that is not known.
    pub ball_offset_mm: Option<BallOffset>,
    /// The state of the setup in one sentence or some.
    pub say: String,
    /// Axes that the controller reports.
    pub axes: Vec<LiveAxis>,
    /// Devices, in the order of the configuration.
    pub devices: Vec<LiveDevice>,
    /// Temperatures.
    pub temperatures: Vec<LiveTemperature>,
    /// The cycle under way; null while none is.
    pub cycle: Option<LiveCycle>,
}

impl Published for Live {
    const TOPIC: &'static str = "live";
}

/// Format and version of live values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LiveFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-live/1")]
    V1,
}

/// A probe or a ball bar at this moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiveProbe {
    /// Name of the channel.
    pub name: String,
    /// Its device.
    #[serde(default)]
    pub device: String,
    /// What the channel is for, e.g. `probe-1`, `bar`.
    pub role: String,
    /// Latest value, mm; null without one.
    pub value_mm: Option<f64>,
    /// Measuring range, mm; null where the configuration does not say it.
    pub range_mm: Option<[f64; 2]>,
    /// Centre of the range, mm.
    pub centre_mm: Option<f64>,
    /// Where in its range the value lies.
    pub zone: Zone,
    /// The same as a sentence, with what to do.
    pub say: String,
}

/// Where a value lies in the range of its probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Zone {
    /// There is no value.
    #[default]
    NoValue,
    /// There is a value that does not change although those of its kind tremble.
    Stuck,
    /// There is a value, and nobody said what range the probe has.
    Unknown,
    /// In the middle half of the range.
    Centre,
    /// Between the middle half and the ends.
    Inside,
    /// In the first or last twentieth of the range.
    NearEnd,
    /// Beyond the range.
    Out,
}

/// Displacement of the ball, directions of the machine, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BallOffset {
    /// Along X.
    pub x: f64,
    /// Along Y.
    pub y: f64,
    /// Along Z.
    pub z: f64,
}

/// An axis at this moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiveAxis {
    /// Name.
    pub name: String,
    /// The device that reports it.
    #[serde(default)]
    pub device: String,
    /// Machine position.
    pub value: f64,
    /// `mm` or `deg`.
    pub unit: String,
}

/// A device at this moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiveDevice {
    /// Name.
    pub name: String,
    /// State of its connection, e.g. `Streaming`, `Absent`.
    pub state: String,
    /// What is wrong and what to do; null where it reads.
    pub remedy: Option<String>,
}

/// A temperature at this moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiveTemperature {
    /// Name of the channel.
    pub name: String,
    /// Its device.
    #[serde(default)]
    pub device: String,
    /// Temperature, °C; null without one.
    pub value_degc: Option<f64>,
}

/// The cycle at this moment.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LiveCycle {
    /// Name of the cycle.
    pub name: String,
    /// What becomes of it, e.g. `measuring`.
    pub state: String,
    /// Poses or passes done.
    pub done: usize,
    /// Poses or passes planned.
    pub planned: usize,
    /// Gaps so far.
    pub gaps: usize,
    /// The newest of them as sentences, the newest first.
    pub newest_gaps: Vec<String>,
}

/// Half of the range is the centre zone: from anywhere in it the ball can move by a quarter of the range both ways, which
/// is more than the errors and the setting of a ball that is placed by hand.
const CENTRE_SHARE: f64 = 0.5;
/// A twentieth of the range is 0.1 mm of the smallest, 2 mm: about what the errors of a machine and the setting of the ball
/// move a probe in a cycle (docs/measured/blind-trial.md draws them).
const END_SHARE: f64 = 0.05;

impl Zone {
    /// Where `value_mm` lies in a range.
    pub fn of(value_mm: Option<f64>, range_mm: Option<[f64; 2]>) -> Self {
        let Some(value_mm) = value_mm.filter(|value_mm| value_mm.is_finite()) else { return Self::NoValue };
        let Some([from_mm, to_mm]) = range_mm else { return Self::Unknown };
        let length_mm = to_mm - from_mm;
        let off_centre_mm = (value_mm - (from_mm + to_mm) / 2.0).abs();
        match off_centre_mm / length_mm {
            share if share > 0.5 => Self::Out,
            share if share > 0.5 - END_SHARE => Self::NearEnd,
            share if share > CENTRE_SHARE / 2.0 => Self::Inside,
            _ => Self::Centre,
        }
    }

    /// True where a cycle may begin: errors of some tenths of a millimetre stay in the range.
    pub fn is_good(self) -> bool {
        matches!(self, Self::Centre | Self::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_near_an_end_before_it_is_out() {
        let range_mm = Some([0.0, 2.0]);
        let check = |value_mm: f64, zone: Zone| assert_eq!(Zone::of(Some(value_mm), range_mm), zone);
        check(1.0, Zone::Centre);
        check(0.5, Zone::Centre);
        check(1.51, Zone::Inside);
        check(0.09, Zone::NearEnd);
        check(1.99, Zone::NearEnd);
        check(-0.01, Zone::Out);
        check(f64::NAN, Zone::NoValue);
        assert_eq!(Zone::of(Some(1.0), None), Zone::Unknown);
        assert_eq!(Zone::of(None, range_mm), Zone::NoValue);
    }
}
