//! Temperatures without value: reported once when that begins, one gap when it ends.

use std::collections::HashMap;
use trunnion_core::HostTime;
use trunnion_core::reading::TemperatureReading;

/// Something to report about a temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Absence {
    /// From here on it has no value.
    Begun,
    /// It has one again, or the session ended.
    Ended { from: HostTime, to: HostTime, readings: u64 },
}

/// The temperatures of one device that have no value at present: since when, and how many readings.
#[derive(Debug, Default)]
pub(crate) struct TemperatureMonitor(HashMap<String, (HostTime, u64)>);

impl TemperatureMonitor {
    /// Looks at a reading.
    pub fn see(&mut self, reading: &TemperatureReading) -> Option<Absence> {
        if reading.degc.is_finite() {
            let (from, readings) = self.0.remove(&reading.name)?;
            return Some(Absence::Ended { from, to: reading.arrival, readings });
        }
        if let Some((_, readings)) = self.0.get_mut(&reading.name) {
            *readings += 1;
            return None;
        }
        self.0.insert(reading.name.clone(), (reading.arrival, 1));
        Some(Absence::Begun)
    }

    /// What is to be reported at the end of a session.
    pub fn end(&mut self, to: HostTime) -> Vec<(String, Absence)> {
        let ended = |(name, (from, readings))| (name, Absence::Ended { from, to, readings });
        self.0.drain().map(ended).collect()
    }
}
