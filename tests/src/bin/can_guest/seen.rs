//! What came of a device from a fault on, and whether the gaps account for everything that is missing.

use anyhow::ensure;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use trunnion_acquire::DeviceStatus;
use trunnion_core::HostTime;
use trunnion_core::reading::{Message, ProbeReading, Reading, SourceGap};
use trunnion_tests::course::Course;
use trunnion_tests::pattern::is_like;

/// Without readings for so long a gap must say so: ten SYNCs.
const LONGEST_HOLE: Duration = Duration::from_millis(100);
/// A gap may begin or end so much off a reading: it counts from SYNC to SYNC.
const SLACK: Duration = Duration::from_millis(20);

/// From a moment on.
#[derive(Debug)]
pub struct Seen {
    pub course: Course,
    /// Lines of the log.
    pub reported: Vec<String>,
    /// With the connection that they came from.
    pub gaps: Vec<(u32, SourceGap)>,
    pub readings: Vec<(u32, ProbeReading)>,
}

impl Seen {
    pub fn from(status: &DeviceStatus) -> Self {
        Self { course: Course::from(status), reported: Vec::new(), gaps: Vec::new(), readings: Vec::new() }
    }

    pub fn take(&mut self, message: &Message) {
        match &message.reading {
            Reading::Probe(reading) => self.readings.push((message.epoch, *reading)),
            Reading::Gap(gap) => self.gaps.push((message.epoch, gap.clone())),
            Reading::Log(line) => self.reported.push(line.text.clone()),
            _ => {}
        }
    }

    /// The gap with this reason.
    pub fn gap(&self, reason: &str) -> Option<&SourceGap> {
        self.gaps.iter().map(|(_, gap)| gap).find(|gap| is_like(&gap.reason, reason))
    }

    /// Every value is there once or counted as missing, and no hole is without its gap.
    pub fn check(&self) -> anyhow::Result<()> {
        let mut of_channel: BTreeMap<u16, Vec<(u32, ProbeReading)>> = BTreeMap::new();
        for (epoch, reading) in &self.readings {
            of_channel.entry(reading.channel).or_default().push((*epoch, *reading));
        }
        let mut missing: BTreeMap<u32, i64> = BTreeMap::new();
        for readings in of_channel.values() {
            for pair in readings.windows(2) {
                let [(before, a), (after, b)] = pair else { continue };
                ensure!(
                    self.accounts_for(a.arrival, b.arrival),
                    "no gap from {a:?} to {b:?}; {:?}",
                    self.gaps
                );
                if before == after {
                    ensure!(a.sequence < b.sequence, "a value came twice: {a:?}, {b:?}");
                    *missing.entry(*after).or_default() += (b.sequence - a.sequence - 1) as i64;
                }
            }
        }
        // At the end of a session, what others still answered.
        for epoch in self.readings.iter().map(|(epoch, _)| *epoch).collect::<BTreeSet<_>>() {
            let last = |of: &Vec<(u32, ProbeReading)>| {
                of.iter().filter(|(of, _)| *of == epoch).map(|(_, reading)| reading.sequence).max()
            };
            let lasts: Vec<u64> = of_channel.values().filter_map(last).collect();
            let answered = lasts.iter().copied().max().unwrap_or_default();
            if self.readings.iter().any(|(of, _)| *of > epoch) {
                *missing.entry(epoch).or_default() +=
                    lasts.iter().map(|last| (answered - last) as i64).sum::<i64>();
            }
        }
        for (epoch, missing) in missing {
            let (counted, _) = self.lost(epoch, "missed SYNCs");
            ensure!(counted == missing, "{missing} values are missing, {counted} counted: {:?}", self.gaps);
        }
        for epoch in self.readings.iter().map(|(epoch, _)| *epoch) {
            let of_epoch =
                self.readings.iter().filter(|(of, reading)| *of == epoch && reading.value_mm.is_nan());
            let (counted, without) = (self.lost(epoch, "no value"), of_epoch.count() as i64);
            ensure!(counted.0 == without, "{without} readings have no value, {counted:?} counted");
        }
        Ok(())
    }

    /// Readings lost by gaps of this reason, and how many gaps.
    fn lost(&self, epoch: u32, reason: &str) -> (i64, usize) {
        let gaps = self.gaps.iter().filter(|(of, gap)| *of == epoch && gap.reason.contains(reason));
        let lost: Vec<i64> = gaps.map(|(_, gap)| gap.lost_readings.unwrap_or(0) as i64).collect();
        (lost.iter().sum(), lost.len())
    }

    fn accounts_for(&self, from: HostTime, to: HostTime) -> bool {
        // One gap may go on where another ends.
        let mut gaps: Vec<&SourceGap> = self.gaps.iter().map(|(_, gap)| gap).collect();
        gaps.sort_by_key(|gap| gap.from);
        let reach = |until: HostTime, gap: &&SourceGap| {
            if gap.from - until <= SLACK { until.max(gap.to) } else { until }
        };
        to - from <= LONGEST_HOLE || to - gaps.iter().fold(from, reach) <= SLACK
    }

    /// States in words.
    pub fn states(&self) -> String {
        let states: Vec<String> = self.course.states.iter().map(|state| format!("{state:?}")).collect();
        if states.is_empty() { "Streaming".into() } else { states.join(" → ") }
    }

    /// True where this was said.
    pub fn has_reported(&self, message: &str) -> bool {
        message.is_empty() || self.reported.iter().any(|text| is_like(text, message))
    }
}
