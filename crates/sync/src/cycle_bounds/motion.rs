//! Standing and moving, from axis positions alone.

use trunnion_core::reading::AxisReading;
use trunnion_core::{AxisValues, HostTime, Slot};

/// An axis that stays so near to where it stood, stands: more than servo jitter and thermal drift of a long stand, mm.
const STILL_MM: f64 = 0.02;
/// The same for rotary axes, rad.
const STILL_RAD: f64 = 2e-4;
/// A stand of a pattern is as long as given within so much, s: agents report a dwell late.
const DWELL_TOLERANCE_S: f64 = 0.3;
/// A shorter stand is a corner of the path, s.
const SHORTEST_STAND_S: f64 = 0.2;

/// What an axis reading reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// All axes stand.
    Stands {
        /// Since then, s.
        for_s: f64,
    },
    /// An axis moves.
    Moves {
        /// How long they had stood when it began, s; 0 when it moved before.
        stood_s: f64,
        /// The stands of the pattern have just been seen.
        pattern: bool,
    },
}

/// The axes' motion so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    /// Where the axes stand, and since when.
    anchor: Option<(AxisValues<f64>, HostTime)>,
    dwells_s: Vec<f64>,
    /// How many stands of the pattern have been seen.
    seen: usize,
}

impl Motion {
    pub(super) fn new(dwells_s: Vec<f64>) -> Self {
        Self { dwells_s, ..Self::default() }
    }

    pub(super) fn take(&mut self, now: &AxisReading) -> Step {
        let (anchor, since) = *self.anchor.get_or_insert((now.position, now.arrival));
        let for_s = now.arrival.seconds_since(since);
        if !moved(&anchor, now) {
            return Step::Stands { for_s };
        }
        self.anchor = Some((now.position, now.arrival));
        let stood_s = if for_s >= SHORTEST_STAND_S { for_s } else { 0.0 };
        Step::Moves { stood_s, pattern: stood_s > 0.0 && self.follow(stood_s) }
    }

    /// True when this stand is the last of the pattern.
    fn follow(&mut self, stood_s: f64) -> bool {
        let is = |k: usize| self.dwells_s.get(k).is_some_and(|s| (stood_s - s).abs() <= DWELL_TOLERANCE_S);
        self.seen = if is(self.seen) { self.seen + 1 } else { usize::from(is(0)) };
        let complete = !self.dwells_s.is_empty() && self.seen == self.dwells_s.len();
        if complete {
            self.seen = 0;
        }
        complete
    }
}

fn moved(anchor: &AxisValues<f64>, now: &AxisReading) -> bool {
    Slot::ALL.iter().any(|&letter| {
        let limit = if letter.is_rotary() { STILL_RAD } else { STILL_MM };
        now.present[letter] && (now.position[letter] - anchor[letter]).abs() > limit
    })
}
