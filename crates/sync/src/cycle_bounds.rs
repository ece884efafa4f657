//! When a cycle begins and ends, from what the controller says or from the motion itself: the table `[cycle_start]`.
//!
//! ```toml
//! [cycle_start]
//! by = "execution"               # the controller runs any program (the rule without this table)
//!
//! by = "program"                 # it runs a program of this name
//! program = "TRUNNION*"          # `*` stands for anything; upper and lower case are alike
//!
//! by = "block"                   # a block of this text begins it, one of that text ends it
//! begin = "*MSG*CYCLE*BEGIN*"
//! end = "*MSG*CYCLE*END*"
//!
//! by = "signal"                  # the `signal` of the controller's [[device]] is on; where a [[program]] asks for its
//!                                # number, another number is another cycle
//!
//! by = "dwells"                  # the machine stands so long, moves, stands so long …
//! dwells_s = [2.0, 1.0, 2.0]     # each at least 0.5 s, recognised to 0.3 s; the cycle begins with the motion after the last
//! still_s = 60                   # no motion for so long, longer than any stand of the cycle, ends it
//!
//! by = "motion"                  # an axis moves after rest_s of standing
//! rest_s = 2
//! still_s = 60
//! ```
//! Whatever begins it, a controller that was seen running and says that its program is over or reset ends it; a hold of any
//! length, or a lost connection, does not. A program that stopped unasked (emergency stop, alarm) and runs again goes on,
//! unless its blocks began from the top. A beginning ends what ran before, so that none is lost. What began one cycle must go
//! away before it begins another, or the machine must come back to the first pose: a program that goes on after its last
//! pose is not taken for the next cycle. Pure: the readings carry their times. docs/measured/cycle-boundaries.md has the tables.

mod motion;
mod program;
mod rule;
mod signal;

pub use rule::{Pattern, StartRule};

use crate::static_cycle::StandsAt;
use motion::{Motion, Step};
use program::{Program, Way};
use signal::Signal;
use trunnion_core::HostTime;
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading};

/// A stand so long at the first pose is no corner on the way, s: as long as the static cycle calls a dwell.
const AT_FIRST_POSE_S: f64 = 0.2;

/// The beginning or the end of a cycle.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// It begins; one that runs ends with it.
    Begins {
        /// When.
        at: HostTime,
        /// By what, for the recording.
        why: String,
        /// Name of the program that the controller showed last; empty when it showed none.
        program: String,
        /// Number of the signal, where that begins cycles.
        signal: Option<u32>,
        /// It ran already when this was first asked.
        under_way: bool,
    },
    /// It ends.
    Ends {
        /// When.
        at: HostTime,
        /// By what.
        why: String,
    },
}

/// The state machine, kept from one cycle to the next.
#[derive(Clone, Debug, Default)]
pub struct CycleBounds {
    rule: StartRule,
    motion: Motion,
    program: Program,
    /// The cycle runs.
    running: bool,
    /// What begins a cycle is there, as last seen; `None` before the first report.
    was_there: Option<bool>,
    /// What begins a cycle was there since this one began, which a person may have begun.
    came: bool,
    /// A program was seen running since the cycle began.
    program_ran: bool,
    /// Name of the program that began it.
    began_by: String,
    /// Name of the program shown last.
    shown: String,
    /// Where that begins cycles.
    signal: Signal,
    /// The last program that ran under another name before, which may have called it.
    caller: Option<String>,
    first_pose: Option<FirstPose>,
}

/// The first pose of the cycle, where a program that goes on begins it again.
#[derive(Clone, Debug)]
struct FirstPose {
    place: StandsAt,
    /// The machine was elsewhere since the cycle ended.
    left: bool,
}

impl CycleBounds {
    /// Before the first reading.
    pub fn new(rule: StartRule) -> Self {
        let dwells =
            if let StartRule::Dwells { dwells_s, .. } = &rule { dwells_s.clone() } else { Vec::new() };
        Self { rule, motion: Motion::new(dwells), ..Self::default() }
    }

    /// With numbers of the signal that are cycles of their own; without, all but 0 is *on*, as where the signal is a counter.
    #[must_use]
    pub fn by_number(self, by_number: bool) -> Self {
        Self { signal: Signal::by_number(by_number), ..self }
    }

    /// With the place of the first pose: a program that measures the cycle twice begins it there a second time.
    #[must_use]
    pub fn with_first_pose(self, place: Option<StandsAt>) -> Self {
        Self { first_pose: place.map(|place| FirstPose { place, left: false }), ..self }
    }

    /// The cycle was ended by something else: all poses read, or stopped by a person.
    pub fn ended_otherwise(&mut self) {
        self.running = false;
        if let Some(first) = &mut self.first_pose {
            first.left = false;
        }
    }

    /// A person began the cycle: its end is recognised like that of any other. The name of the program that the controller
    /// shows; empty when it shows none.
    pub fn begun_otherwise(&mut self) -> String {
        // A program that the controller already runs ends it; one that begins later is seen to run then.
        let is_there = self.was_there == Some(true);
        (self.running, self.came, self.program_ran) = (true, is_there, is_there);
        self.shown.clone()
    }

    /// The program waits for a person, or for what stopped it: standing still is not its end.
    pub fn is_held(&self) -> bool {
        self.program.is_held()
    }

    /// The next reading in order.
    pub fn take(&mut self, reading: &Reading) -> Option<Bound> {
        match reading {
            Reading::Controller(controller) => self.controller(controller),
            Reading::Axes(axes) => {
                let step = self.motion.take(axes);
                self.given_up(axes.arrival).or_else(|| match self.rule {
                    StartRule::Motion { .. } | StartRule::Dwells { .. } => self.moved(step, axes.arrival),
                    _ => self.back_at_first_pose(step, axes),
                })
            }
            Reading::Probe(_)
            | Reading::Temperature(_)
            | Reading::Log(_)
            | Reading::Counters(_)
            | Reading::Gap(_) => None,
        }
    }

    fn controller(&mut self, now: &ControllerReading) -> Option<Bound> {
        let runs = now.execution == Execution::Active;
        if self.shown != now.program {
            self.shown.clone_from(&now.program);
        }
        let way = self.program.take(now);
        let by_signal = self.rule == StartRule::Signal;
        let program_ends = matches!(now.execution, Execution::Ready | Execution::Ended);
        let ends = self.running && self.program_ran && program_ends;
        // The reading that ends one program may hold the signal of the next, whose beginning ends this cycle too.
        let next_comes = ends && by_signal && self.signal.comes(now.signal);
        if self.running {
            if ends && !next_comes {
                // It may take the signal back, which is new when it comes on again.
                if by_signal {
                    self.signal.take(now.signal);
                    self.was_there = now.signal.map(|number| number > 0).or(self.was_there);
                }
                return self.end(now.arrival, format!("the controller says {:?}", now.execution));
            }
            if runs && self.caller.as_deref().is_some_and(|caller| caller == now.program) {
                return self.end(now.arrival, format!("the program is back in {}", now.program));
            }
            self.program_ran |= runs;
        }
        let mut other_number = false;
        // `Some(true)`: what begins a cycle is there; `None`: this reading says nothing about it.
        let (there, why) = match &self.rule {
            StartRule::Execution => (reported(now.execution), format!("runs {}", now.program)),
            StartRule::Program(name) => {
                let named = name.matches(&now.program);
                // A controller that never reports what it executes is judged by the name alone.
                let reported =
                    if now.execution == Execution::Unknown { Some(named) } else { reported(now.execution) };
                if !self.running {
                    self.caller = Some(now.program.clone())
                        .filter(|_| runs && !named)
                        .or_else(|| self.caller.take().filter(|_| reported != Some(false)));
                }
                (reported.map(|runs| runs && named), format!("runs {}", now.program))
            }
            StartRule::Block { begin, end } => {
                let is_end = end.as_ref().is_some_and(|end| end.matches(&now.block));
                if self.running && is_end {
                    return self.end(now.arrival, format!("block {}", now.block));
                }
                let there = Some(begin.matches(&now.block)).filter(|_| !now.block.is_empty());
                (there, format!("block {}", now.block))
            }
            StartRule::Signal => {
                other_number = self.signal.is_another(now.signal);
                self.signal.take(now.signal);
                let why = match now.signal {
                    Some(number @ 2..) => format!("the signal is {number}"),
                    _ => "the signal is on".into(),
                };
                (now.signal.map(|number| number > 0), why)
            }
            StartRule::Dwells { .. } | StartRule::Motion { .. } => return None,
        };
        let there = there?;
        let other_name = !self.running && now.program != self.began_by;
        let is_another = match self.rule {
            StartRule::Program(_) => other_name || self.is_another(way),
            StartRule::Execution => self.is_another(way),
            StartRule::Signal => other_number,
            _ => false,
        };
        let was_there = self.was_there.replace(there);
        self.came |= there;
        let came = there && (was_there != Some(true) || is_another);
        let begins_again = is_another || next_comes || matches!(self.rule, StartRule::Block { .. });
        if came && (!self.running || begins_again) {
            self.began_by.clone_from(&now.program);
            let under_way = was_there.is_none();
            let late = if under_way { ", as it did when this was first asked" } else { "" };
            let why = format!("the controller: {}{late}", why.trim_end());
            return self.begin(now.arrival, why, runs, under_way);
        }
        // Held and subprograms pass through here with the rule unfulfilled; only these two are levels.
        let is_level = match self.rule {
            StartRule::Signal => true,
            StartRule::Program(_) => now.execution == Execution::Unknown,
            _ => false,
        };
        if self.running && is_level && self.came && !there {
            return self.end(now.arrival, "what began the cycle is gone".into());
        }
        None
    }

    /// Where the blocks do not show it, a cycle that was under way goes on, and one that was over begins again.
    fn is_another(&self, way: Way) -> bool {
        match way {
            Way::AsBefore => false,
            Way::FromTheTop => true,
            Way::FromSomewhere => !self.running,
        }
    }

    fn moved(&mut self, step: Step, at: HostTime) -> Option<Bound> {
        let still_s = match &self.rule {
            StartRule::Motion { still_s, .. } | StartRule::Dwells { still_s, .. } => *still_s,
            _ => return None,
        };
        match step {
            Step::Stands { for_s } if self.running && for_s >= still_s && !self.is_held() => {
                self.end(at, format!("no axis moved for {still_s} s"))
            }
            Step::Stands { .. } => None,
            Step::Moves { stood_s, pattern } => {
                let (begins, why) = match self.rule {
                    StartRule::Motion { rest_s, .. } => (stood_s >= rest_s, "an axis moves"),
                    _ => (pattern, "the dwells of the configuration"),
                };
                if self.running || !begins { None } else { self.begin(at, why.into(), false, false) }
            }
        }
    }

    /// A program that went on after the last pose stands at the first one again.
    fn back_at_first_pose(&mut self, step: Step, axes: &AxisReading) -> Option<Bound> {
        if self.running || self.was_there != Some(true) {
            return None;
        }
        let first = self.first_pose.as_mut()?;
        if !first.place.is_near(&axes.position) {
            first.left = true;
            return None;
        }
        match step {
            Step::Stands { for_s } if first.left && for_s >= AT_FIRST_POSE_S => {
                self.begin(axes.arrival, "the program is back at the first pose".into(), true, false)
            }
            Step::Stands { .. } | Step::Moves { .. } => None,
        }
    }

    fn given_up(&mut self, at: HostTime) -> Option<Bound> {
        if !self.program.has_given_up(at) {
            return None;
        }
        self.was_there = Some(false);
        if self.running { self.end(at, "the program stopped and was not resumed".into()) } else { None }
    }

    fn begin(&mut self, at: HostTime, why: String, program_ran: bool, under_way: bool) -> Option<Bound> {
        (self.running, self.came, self.program_ran) = (true, true, program_ran);
        let (program, signal) = (self.shown.clone(), self.signal.number());
        Some(Bound::Begins { at, why: why.trim_end().into(), program, signal, under_way })
    }

    fn end(&mut self, at: HostTime, why: String) -> Option<Bound> {
        self.running = false;
        // Reported by the same reading: what follows is another program.
        if matches!(self.rule, StartRule::Execution | StartRule::Program(_)) {
            self.was_there = Some(false);
        }
        Some(Bound::Ends { at, why })
    }
}

/// Whether a program runs, where the controller reports that; in a hold it neither begins nor ends.
fn reported(execution: Execution) -> Option<bool> {
    match execution {
        Execution::Active => Some(true),
        Execution::Ready | Execution::Ended => Some(false),
        Execution::Held | Execution::Stopped | Execution::Unknown => None,
    }
}

#[cfg(test)]
mod tests;
