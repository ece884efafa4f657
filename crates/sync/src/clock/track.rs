//! One device's clock through a run: its line, and the moments at which it was reset.
//!
//! A quartz does not jump; a clock that is set, a counter that wraps wrongly or a device that restarts does. After a jump
//! forward readings seem to arrive before they were taken; after a jump back all of them are late by the same time and stay
//! so. Either begins a new line. A hiccup of the host is neither: what was held up arrives at once. Nor is a queue that a busy host does not
//! empty for seconds: the clock of the device went on as usual when the lateness began.

use super::{ClockLine, Translation};
use trunnion_core::HostTime;

/// Neither a queue nor a timer makes this much of a steady difference, ns.
const JUMP_NS: i64 = 100_000_000;
/// A line younger than this still settles: its first arrivals may all have waited in a queue, ns.
const SETTLED_NS: i64 = 2_000_000_000;
/// Late for so long and so often is a clock that was set back, ns.
const STREAK_NS: i64 = 3_000_000_000;
const STREAK_READINGS: u32 = 10;

/// A clock was reset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Arrival of the last reading on the old line.
    pub from: HostTime,
    /// Arrival of the first reading that is known to belong to the new one.
    pub to: HostTime,
    /// By how much, s; negative: set back.
    pub by_s: f64,
    /// The line until then.
    pub before: Option<Translation>,
}

/// The line of a clock as it stands, restarted after a jump.
#[derive(Clone, Debug)]
pub struct ClockTrack {
    tick_s: f64,
    window_s: f64,
    line: ClockLine,
    begun: Option<HostTime>,
    last: Option<Last>,
    late: Option<Late>,
    /// Whether readings are late because they wait.
    is_queue: bool,
}

/// The reading before, and how far the clock went on to it, ticks.
#[derive(Clone, Copy, Debug)]
struct Last {
    ticks: u64,
    arrival: HostTime,
    step: i64,
}

impl Last {
    /// Whether a clock that went on by `step` went on about as far as before: it was not set, and nothing is missing between.
    fn is_usual(&self, step: i64) -> bool {
        2 * step >= self.step && 2 * step <= 3 * self.step && step > 0
    }
}

/// Readings that are all late: the line they make if the clock was set back.
#[derive(Clone, Debug)]
struct Late {
    before: HostTime,
    since: HostTime,
    readings: u32,
    least_ns: i64,
    line: ClockLine,
}

impl ClockTrack {
    /// As [`ClockLine::new`].
    pub fn new(tick_s: f64, window_s: f64) -> Self {
        let line = ClockLine::new(tick_s, window_s);
        Self { tick_s, window_s, line, begun: None, last: None, late: None, is_queue: false }
    }

    /// Takes an arrival; reports when it shows that the clock was reset.
    pub fn push(&mut self, ticks: u64, arrival: HostTime) -> Option<Jump> {
        let begun = *self.begun.get_or_insert(arrival);
        let last = self.last;
        let step = last.map_or(0, |last| ticks.wrapping_sub(last.ticks) as i64);
        self.last = Some(Last { ticks, arrival, step });
        let before = last.map_or(arrival, |last| last.arrival);
        let late_ns = self.line.to_host(ticks).map_or(0, |by_line| arrival.0 - by_line.0);
        let settled = arrival.0 - begun.0 >= SETTLED_NS;
        if settled && late_ns < -JUMP_NS {
            let jump =
                Jump { from: before, to: arrival, by_s: late_ns as f64 * -1e-9, before: self.translation() };
            self.restart(ClockLine::new(self.tick_s, self.window_s), arrival);
            self.line.push(ticks, arrival);
            return Some(jump);
        }
        let is_late = settled && late_ns > JUMP_NS;
        let begins_as_usual = self.late.is_none() && last.is_some_and(|last| last.is_usual(step));
        // Of a queue that loses readings the steps differ; a clock that runs back was set.
        self.is_queue = is_late && step > 0 && (self.is_queue || begins_as_usual);
        if is_late && !self.is_queue {
            return self.push_late(ticks, arrival, before, late_ns);
        }
        self.late = None;
        self.line.push(ticks, arrival);
        None
    }

    fn push_late(&mut self, ticks: u64, arrival: HostTime, before: HostTime, late_ns: i64) -> Option<Jump> {
        let late = self.late.get_or_insert_with(|| Late {
            before,
            since: arrival,
            readings: 0,
            least_ns: late_ns,
            line: ClockLine::new(self.tick_s, self.window_s),
        });
        late.line.push(ticks, arrival);
        late.readings += 1;
        late.least_ns = late.least_ns.min(late_ns);
        let (from, since, by_ns) = (late.before, late.since, late.least_ns);
        if arrival.0 - since.0 < STREAK_NS || late.readings < STREAK_READINGS {
            return None;
        }
        let line = std::mem::replace(&mut late.line, ClockLine::new(self.tick_s, self.window_s));
        let jump = Jump { from, to: arrival, by_s: by_ns as f64 * -1e-9, before: self.translation() };
        self.restart(line, since);
        Some(jump)
    }

    fn restart(&mut self, line: ClockLine, begun: HostTime) {
        (self.line, self.begun, self.late) = (line, Some(begun), None);
    }

    /// True while readings are so late that the clock may have been set back.
    pub fn is_late(&self) -> bool {
        self.late.is_some()
    }

    /// The line now; `None` before the first arrival.
    pub fn translation(&self) -> Option<Translation> {
        self.line.translation()
    }

    /// Host time of a device tick by the line as it stands; `None` before the first arrival.
    pub fn to_host(&self, ticks: u64) -> Option<HostTime> {
        self.line.to_host(ticks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings every ms, each 3 ms late; from 5 s on the clock shows `jump_ms` more. Gives the jumps, and the errors at the end.
    fn run(jump_ms: i64, stall: impl Fn(i64) -> i64) -> (Vec<Jump>, f64) {
        let mut track = ClockTrack::new(1e-3, 200.0);
        let (mut jumps, mut error) = (Vec::new(), 0.0);
        for k in 0..10_000_i64 {
            let ticks = 1_000_000 + k + if k >= 5000 { jump_ms } else { 0 };
            let arrival = HostTime((k + 3) * 1_000_000 + stall(k) * 1_000_000);
            jumps.extend(track.push(ticks as u64, arrival));
            error = track.to_host(ticks as u64).unwrap().seconds_since(HostTime((k + 3) * 1_000_000));
        }
        (jumps, error)
    }

    #[test]
    fn a_clock_set_forward_or_back_begins_a_new_line_and_says_by_how_much() {
        for jump_ms in [200, -200, 3_600_000, -100_000] {
            let (jumps, error) = run(jump_ms, |_| 0);
            assert_eq!(jumps.len(), 1, "{jump_ms}");
            assert!((jumps[0].by_s - jump_ms as f64 * 1e-3).abs() < 1e-6, "{jumps:?}");
            assert!(jumps[0].to.seconds_since(jumps[0].from) < 3.1);
            assert!(error.abs() < 1e-6, "{error}");
        }
    }

    #[test]
    fn a_hiccup_of_the_host_is_no_jump() {
        // Nothing is read for 1.5 s, then all of it at once.
        let (jumps, error) = run(0, |k| if (6000..7500).contains(&k) { 7500 - k } else { 0 });
        assert!(jumps.is_empty() && error.abs() < 1e-6);
        let (jumps, _) = run(60, |_| 0);
        assert!(jumps.is_empty(), "below what a queue can do");
    }

    #[test]
    fn a_queue_that_is_not_emptied_for_seconds_is_no_jump() {
        for held_ms in [150, 300, 900] {
            let (jumps, error) = run(0, |k| if k >= 3000 { held_ms } else { 0 });
            assert!(jumps.is_empty() && error.abs() < 1e-6, "{held_ms}: {jumps:?}, {error}");
        }
        // A clock that is set back while readings wait: what they wait is in its line until the queue is empty.
        let (jumps, error) = run(-400, |k| if (4000..9000).contains(&k) { 200 } else { 0 });
        let by_s: f64 = jumps.iter().map(|jump| jump.by_s).sum();
        assert!((by_s + 0.4).abs() < 1e-6 && error.abs() < 1e-6, "{jumps:?}, {error}");
    }
}
