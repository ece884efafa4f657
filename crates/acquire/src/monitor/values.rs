//! What the values of a channel say about its device: it has none, or the same one for too long.
//!
//! *No value*: reported once when it begins; when it ends, the readings without value are one gap.
//!
//! *Stuck*: a number that stays while the device should not be able to keep it. An indicator that shows 1 µm keeps its
//! number for hours on a machine that stands, and that is no fault; so a channel is judged by how it behaved before.
//! It is judged only after it has shown its own noise at rest: in [`RESTLESS_WINDOWS`] windows of half a second its
//! number changed at most readings, back and forth, over [`LEAST_LEVELS`] of its steps and more, without going
//! anywhere. Such a channel is stuck when its number stays for [`SHORTEST_STUCK`] and over [`LEAST_READINGS`] readings,
//! and ten times more of them than ever before: readings, not seconds, because a computer that pauses once says nothing
//! of how long the channel keeps a number. From then on its readings carry no value until the number changes, and the
//! gap goes back to the first equal reading. A coarse channel shows such noise only when it is shaken for seconds without
//! being moved; it may then be called stuck once when the shaking ends, and has kept its number for so long that the
//! tenfold of it will not come again.
//!
//! Simulated at 50 readings a second: with a noise of 0.8 digits (standard deviation) and more every stuck channel is
//! found, after 2 s; with 0.6 digits and less none is judged; no false alarm in 20 h of rest at any noise.

use std::collections::HashMap;
use std::time::Duration;
use trunnion_core::HostTime;
use trunnion_core::reading::ProbeReading;

const SHORTEST_STUCK: Duration = Duration::from_secs(2);
const MORE_THAN_EVER: u64 = 10;
const LEAST_READINGS: u64 = 20;
const WINDOW: Duration = Duration::from_millis(500);
const WINDOW_READINGS: u32 = 32;
const EARLY_READINGS: u32 = WINDOW_READINGS / 2;
const RESTLESS_WINDOWS: u32 = 10;
const LEAST_LEVELS: u64 = 4;

/// Something to report about a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Finding {
    /// From here on the device sends no values but this number.
    NoValue { raw: i64 },
    /// There are values again, or the session ended.
    ValueAgain { from: HostTime, to: HostTime, readings: u64, raw: i64 },
    /// The number has not changed since.
    Stuck { raw: i64, since: HostTime },
    /// It has changed, or the session ended.
    Unstuck { from: HostTime, to: HostTime, readings: u64, raw: i64 },
}

/// The channels of one device.
#[derive(Debug, Default)]
pub(crate) struct ValueMonitor {
    channels: HashMap<u16, Channel>,
}

#[derive(Debug, Default)]
struct Channel {
    last_value: Option<HostTime>,
    without: Option<Without>,
    run: Option<Run>,
    /// Most readings of one number so far.
    longest: u64,
    stuck: bool,
    noise: Noise,
}

/// Readings without value.
#[derive(Clone, Copy, Debug)]
struct Without {
    from: HostTime,
    readings: u64,
    raw: i64,
}

/// Readings of one number.
#[derive(Clone, Copy, Debug)]
struct Run {
    raw: i64,
    since: HostTime,
    readings: u64,
}

impl ValueMonitor {
    /// Looks at a reading that arrived at `at`; takes its value away while the channel is stuck.
    pub fn see(&mut self, reading: &mut ProbeReading, at: HostTime) -> Option<Finding> {
        self.channels.entry(reading.channel).or_default().see(reading, at)
    }

    /// True while the channel's readings have no value.
    pub fn is_without_value(&self, channel: u16) -> bool {
        self.channels.get(&channel).is_some_and(|channel| channel.without.is_some())
    }

    /// True while any channel is stuck.
    pub fn is_stuck(&self) -> bool {
        self.channels.values().any(|channel| channel.stuck)
    }

    /// The session ended at `at`: what is open ends with it, and nothing is remembered of the device.
    pub fn end(&mut self, at: HostTime) -> Vec<(u16, Finding)> {
        let mut open: Vec<(u16, Finding)> = std::mem::take(&mut self.channels)
            .into_iter()
            .filter_map(|(index, channel)| Some((index, channel.open(at)?)))
            .collect();
        open.sort_by_key(|(index, _)| *index);
        open
    }
}

impl Channel {
    fn see(&mut self, reading: &mut ProbeReading, at: HostTime) -> Option<Finding> {
        if reading.value_mm.is_nan() {
            return self.see_none(reading.raw, at);
        }
        let ended = self.without.take().map(|without| without.ended(at));
        self.last_value = Some(at);
        let changed = self.see_number(reading.raw, at);
        if self.stuck {
            reading.value_mm = f64::NAN;
        }
        ended.or(changed)
    }

    fn see_none(&mut self, raw: i64, at: HostTime) -> Option<Finding> {
        if let Some(without) = &mut self.without {
            without.readings += 1;
            return None;
        }
        let stuck = self.open(at).filter(|_| self.stuck);
        (self.run, self.stuck) = (None, false);
        self.noise.interrupt();
        self.without = Some(Without { from: self.last_value.unwrap_or(at), readings: 1, raw });
        stuck.or(Some(Finding::NoValue { raw }))
    }

    fn see_number(&mut self, raw: i64, at: HostTime) -> Option<Finding> {
        self.noise.see(raw, at);
        let Some(run) = self.run.as_mut().filter(|run| run.raw == raw) else {
            let unstuck = self.open(at).filter(|_| self.stuck);
            if let Some(run) = self.run {
                self.longest = self.longest.max(run.readings);
            }
            (self.run, self.stuck) = (Some(Run { raw, since: at, readings: 1 }), false);
            return unstuck;
        };
        run.readings += 1;
        let most = LEAST_READINGS.max(self.longest.saturating_mul(MORE_THAN_EVER));
        let too_long = at - run.since >= SHORTEST_STUCK && run.readings >= most;
        if self.stuck || !too_long || self.noise.restless_windows < RESTLESS_WINDOWS {
            return None;
        }
        self.stuck = true;
        Some(Finding::Stuck { raw, since: run.since })
    }

    /// How what is under way would end at `at`.
    fn open(&self, at: HostTime) -> Option<Finding> {
        let stuck = self.run.filter(|_| self.stuck).map(|Run { raw, since, readings }| Finding::Unstuck {
            from: since,
            to: at,
            readings,
            raw,
        });
        stuck.or(self.without.map(|without| without.ended(at)))
    }
}

impl Without {
    fn ended(self, to: HostTime) -> Finding {
        Finding::ValueAgain { from: self.from, to, readings: self.readings, raw: self.raw }
    }
}

/// Whether the channel has shown noise of its own at rest.
#[derive(Debug, Default)]
struct Noise {
    window: Option<Window>,
    last: Option<i64>,
    /// Smallest change ever seen: the step of the device.
    step: Option<u64>,
    restless_windows: u32,
}

#[derive(Debug)]
struct Window {
    since: HostTime,
    first: i64,
    lowest: i64,
    highest: i64,
    readings: u32,
    changes: u32,
    reversals: u32,
    direction: i64,
    /// Sums of the distances from `first`: of the first readings, and of all.
    early: f64,
    all: f64,
}

impl Noise {
    fn interrupt(&mut self) {
        (self.window, self.last) = (None, None);
    }

    fn see(&mut self, raw: i64, at: HostTime) {
        let change = self.last.map_or(0, |last| raw.saturating_sub(last));
        self.last = Some(raw);
        if change != 0 {
            self.step = Some(self.step.map_or(change.unsigned_abs(), |step| step.min(change.unsigned_abs())));
        }
        let window = self.window.get_or_insert(Window {
            since: at,
            first: raw,
            lowest: raw,
            highest: raw,
            readings: 0,
            changes: 0,
            reversals: 0,
            direction: 0,
            early: 0.0,
            all: 0.0,
        });
        window.take(raw, change);
        if at - window.since >= WINDOW && window.readings >= WINDOW_READINGS {
            if self.step.is_some_and(|step| window.is_restless(step)) {
                self.restless_windows += 1;
            }
            self.window = None;
        }
    }
}

impl Window {
    fn take(&mut self, raw: i64, change: i64) {
        self.readings += 1;
        (self.lowest, self.highest) = (self.lowest.min(raw), self.highest.max(raw));
        let distance = raw as f64 - self.first as f64;
        self.all += distance;
        if self.readings <= EARLY_READINGS {
            self.early += distance;
        }
        if change != 0 {
            self.changes += 1;
            self.reversals += u32::from(self.direction == -change.signum());
            self.direction = change.signum();
        }
    }

    /// Back and forth at most readings, over some steps, and nowhere: the later ones have the mean of the early ones.
    fn is_restless(&self, step: u64) -> bool {
        let range = self.highest.abs_diff(self.lowest);
        let later = (self.all - self.early) / f64::from(self.readings - EARLY_READINGS);
        let gone = (later - self.early / f64::from(EARLY_READINGS)).abs();
        2 * self.changes >= self.readings
            && 3 * self.reversals >= self.changes
            && range >= step.saturating_mul(LEAST_LEVELS)
            && gone <= 0.25 * range as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Feeds 50 readings a second of `raw(t)`; NaN stands for no value.
    struct Bench {
        monitor: ValueMonitor,
        reading: u64,
        rng: ChaCha8Rng,
    }

    impl Bench {
        fn new() -> Self {
            Self { monitor: ValueMonitor::default(), reading: 0, rng: ChaCha8Rng::seed_from_u64(7) }
        }

        fn run(
            &mut self,
            seconds: f64,
            value: impl Fn(f64, f64) -> f64,
        ) -> (Vec<Finding>, Vec<ProbeReading>) {
            let (mut findings, mut readings) = (Vec::new(), Vec::new());
            for k in 0..(seconds * 50.0) as u64 {
                let noise = (0..4).map(|_| self.rng.random_range(-0.5..0.5)).sum::<f64>();
                let number = value(k as f64 / 50.0, noise);
                let at = HostTime(self.reading as i64 * 20_000_000);
                self.reading += 1;
                let raw = if number.is_nan() { 999 } else { number.round() as i64 };
                let value_mm = if number.is_nan() { f64::NAN } else { 1e-4 * number };
                let mut reading = ProbeReading {
                    channel: 0,
                    device_ticks: self.reading,
                    tick_s: 0.02,
                    sequence: self.reading,
                    raw,
                    value_mm,
                    arrival: at,
                };
                findings.extend(self.monitor.see(&mut reading, at));
                readings.push(reading);
            }
            (findings, readings)
        }
    }

    #[test]
    fn a_channel_that_trembled_at_rest_and_then_keeps_one_number_is_stuck_until_it_changes() {
        let mut bench = Bench::new();
        assert_eq!(bench.run(20.0, |_, noise| 100.0 + 10.0 * noise).0, []);
        let (findings, readings) = bench.run(6.0, |_, _| 104.0);
        assert!(matches!(findings[..], [Finding::Stuck { raw: 104, .. }]), "{findings:?}");
        let without = readings.iter().filter(|reading| reading.value_mm.is_nan()).count();
        assert!((150..=200).contains(&without), "{without} of 300 in the four seconds after the alarm");
        assert!(readings.iter().all(|reading| reading.raw == 104), "the number as sent stays");
        let (findings, readings) = bench.run(1.0, |_, noise| 100.0 + 10.0 * noise);
        let [Finding::Unstuck { from, to, readings: equal, .. }] = findings[..] else {
            panic!("{findings:?}")
        };
        assert!(equal >= 300 && (5.9..6.2).contains(&to.seconds_since(from)), "{equal} {from:?} {to:?}");
        assert!(readings.iter().all(|reading| !reading.value_mm.is_nan()));
    }

    #[test]
    fn a_pause_between_two_readings_does_not_hide_that_a_channel_is_stuck() {
        let mut bench = Bench::new();
        bench.run(10.0, |_, noise| 100.0 + 10.0 * noise);
        bench.reading += 150; // three seconds without any
        bench.run(10.0, |_, noise| 100.0 + 10.0 * noise);
        let findings = bench.run(4.0, |_, _| 104.0).0;
        assert!(matches!(findings[..], [Finding::Stuck { raw: 104, .. }]), "{findings:?}");
    }

    #[test]
    fn a_coarse_channel_on_a_machine_that_stands_is_never_stuck() {
        let moving = |t_s: f64, noise: f64| 500.0 * (0.8 * t_s).sin() + 0.3 * noise;
        let check = |name: &str, before: &dyn Fn(f64, f64) -> f64| {
            let mut bench = Bench::new();
            let mut findings = bench.run(60.0, before).0;
            findings.extend(bench.run(600.0, |_, noise| 40.0 + 0.3 * noise).0);
            findings.extend(bench.run(60.0, moving).0);
            findings.extend(bench.run(600.0, |_, _| 7.0).0);
            assert_eq!(findings, [], "{name}");
        };
        check("swept, then stood", &moving);
        check("flickered between two digits, then stood", &|_, noise| 40.5 + 0.3 * noise);
        check("swept slowly, then stood", &|t_s, noise| 3.0 * t_s + 0.3 * noise);
    }

    #[test]
    fn readings_without_value_are_reported_once_and_end_as_one_gap() {
        let mut bench = Bench::new();
        bench.run(1.0, |_, noise| noise);
        assert_eq!(bench.run(2.0, |_, _| f64::NAN).0, [Finding::NoValue { raw: 999 }]);
        let findings = bench.run(1.0, |_, noise| noise).0;
        let [Finding::ValueAgain { from, to, readings: 100, raw: 999 }] = findings[..] else {
            panic!("{findings:?}")
        };
        assert!((to.seconds_since(from) - 2.02).abs() < 1e-9, "from the last value to the next");
        bench.run(0.5, |_, _| f64::NAN);
        let open = bench.monitor.end(HostTime(5_000_000_000));
        assert!(matches!(open[..], [(0, Finding::ValueAgain { readings: 25, .. })]), "{open:?}");
    }
}
