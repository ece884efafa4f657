//! What each device counted, against what came and what gaps say: no reading is missing without a record.
//!
//! A device's counter goes on by one step a reading; its step is the smallest seen. Where it goes on by more, the readings between are
//! missing, and gaps of the device since its last reading must say so. Gaps of one device are not kept by channel:
//! of several nodes on a bus, one gap may speak for two.

use std::collections::BTreeMap;
use trunnion_core::reading::{Message, ProbeReading, Reading};
use trunnion_core::{Channel, Event, Gap};

/// The counters of a run.
#[derive(Default)]
pub(super) struct Tally {
    channels: BTreeMap<u16, Counted>,
    /// Readings that gaps of a device name, since the run began.
    in_gaps: BTreeMap<u16, u64>,
}

/// One channel.
#[derive(Default)]
struct Counted {
    epoch: u32,
    last: Option<u64>,
    step: Option<u64>,
    /// Of the device, at the last reading.
    in_gaps: u64,
    came: u64,
    missing: u64,
    unexplained: u64,
}

impl Tally {
    /// Takes a message of a device.
    pub(super) fn take(&mut self, message: &Message) {
        match &message.reading {
            Reading::Probe(reading) => {
                let in_gaps = self.in_gaps.get(&message.device).copied().unwrap_or(0);
                self.channels.entry(reading.channel).or_default().take(message.epoch, reading, in_gaps);
            }
            Reading::Gap(gap) => {
                *self.in_gaps.entry(message.device).or_default() += gap.lost_readings.unwrap_or(0);
            }
            _ => {}
        }
    }

    /// What is recorded of it at the end of the run, and a gap for what no gap explains.
    pub(super) fn result(&self, channels: &[Channel], end_s: f64) -> (Vec<Event>, Vec<Gap>) {
        let name = |index: u16| Some(&channels.get(usize::from(index))?.name);
        let named: Vec<(&String, &Counted)> =
            self.channels.iter().filter_map(|(index, counted)| Some((name(*index)?, counted))).collect();
        let event = |(name, counted): &(&String, &Counted)| {
            let Counted { came, missing, unexplained, .. } = counted;
            let text = format!(
                "{name} counted {} readings: {came} came, {} are in gaps, {unexplained} in none",
                came + missing,
                missing - unexplained
            );
            Event { time_s: end_s, kind: "counted".into(), text }
        };
        let gap = |(name, counted): &(&String, &Counted)| Gap {
            source: (*name).clone(),
            from_s: 0.0,
            to_s: end_s,
            lost_samples: Some(counted.unexplained),
            reason: "the counter of the device shows readings that did not come and that no gap explains"
                .into(),
        };
        let unexplained = named.iter().filter(|(_, counted)| counted.unexplained > 0);
        (named.iter().map(event).collect(), unexplained.map(gap).collect())
    }
}

impl Counted {
    fn take(&mut self, epoch: u32, reading: &ProbeReading, in_gaps: u64) {
        let before = self.last.filter(|_| self.epoch == epoch);
        // A counter that began again is a gap of its own, without a number.
        if let Some(increment) = before.and_then(|last| reading.sequence.checked_sub(last)).filter(|i| *i > 0)
        {
            let step = self.step.map_or(increment, |step| step.min(increment));
            let missing = (increment / step).saturating_sub(1);
            self.missing += missing;
            self.unexplained += missing.saturating_sub(in_gaps - self.in_gaps);
            self.step = Some(step);
        }
        (self.epoch, self.last, self.in_gaps) = (epoch, Some(reading.sequence), in_gaps);
        self.came += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_core::reading::SourceGap;
    use trunnion_core::{HostTime, Role};

    fn reading(epoch: u32, sequence: u64) -> Message {
        let reading = ProbeReading {
            channel: 0,
            device_ticks: sequence,
            tick_s: 1e-3,
            sequence,
            raw: 0,
            value_mm: 0.0,
            arrival: HostTime(0),
        };
        Message { device: 3, epoch, reading: Reading::Probe(reading) }
    }

    fn lost(readings: u64) -> Message {
        let gap = SourceGap {
            source: "probe-1".into(),
            from: HostTime(0),
            to: HostTime(0),
            lost_readings: Some(readings),
            reason: "lost on the line".into(),
        };
        Message { device: 3, epoch: 1, reading: Reading::Gap(gap) }
    }

    fn result(messages: &[Message]) -> (String, Option<u64>) {
        let mut tally = Tally::default();
        messages.iter().for_each(|message| tally.take(message));
        let channel = Channel { device: 3, name: "probe-1".into(), role: Role::Probe(0) };
        let (events, gaps) = tally.result(&[channel], 9.0);
        (events[0].text.clone(), gaps.first().and_then(|gap| gap.lost_samples))
    }

    #[test]
    fn what_the_counter_shows_and_no_gap_explains_is_a_gap() {
        let first: Vec<Message> = (100..110).map(|count| reading(1, count)).collect();
        assert_eq!(
            result(&first),
            ("probe-1 counted 10 readings: 10 came, 0 are in gaps, 0 in none".into(), None)
        );
        let explained = [first.clone(), vec![lost(5), reading(1, 115)]].concat();
        assert_eq!(result(&explained).0, "probe-1 counted 16 readings: 11 came, 5 are in gaps, 0 in none");
        let half = [first.clone(), vec![lost(2), reading(1, 115)]].concat();
        assert_eq!(
            result(&half),
            ("probe-1 counted 16 readings: 11 came, 2 are in gaps, 3 in none".into(), Some(3))
        );
        // Another connection counts from zero; a gap from before explains nothing later.
        let again = [vec![lost(9)], first, vec![reading(2, 1), reading(2, 2), reading(2, 4)]].concat();
        assert_eq!(result(&again).1, Some(1));
        // Every fourth SYNC.
        let fourth: Vec<Message> = [4, 8, 12, 20].map(|count| reading(1, count)).to_vec();
        assert_eq!(result(&fourth).1, Some(1));
    }
}
