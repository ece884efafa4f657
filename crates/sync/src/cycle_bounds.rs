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
//! by = "signal"                  # the `signal` of the controller's [[device]] is on
//!
//! by = "dwells"                  # the machine stands so long, moves, stands so long …
//! dwells_s = [2.0, 1.0, 2.0]     # each at least 0.5 s, recognised to 0.3 s; the cycle begins with the motion after the last
//! still_s = 60                   # no motion for so long, longer than any stand of the cycle, ends it
//!
//! by = "motion"                  # an axis moves after rest_s of standing
//! rest_s = 2
//! still_s = 60
//! ```
//! Whatever begins it, a controller that was seen running and says that its program has ended ends it; a hold, or a lost
//! connection, does not. What began one cycle must go away before it begins another: a program that goes on after its
//! last pose is not taken for the next cycle. Pure: the readings carry their times.

mod motion;

use motion::{Motion, Step};
use trunnion_core::HostTime;
use trunnion_core::input::Table;
use trunnion_core::reading::{ControllerReading, Execution, Reading};

/// What begins a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum StartRule {
    /// The controller runs a program.
    #[default]
    Execution,
    /// The controller runs a program with this name.
    Program(Pattern),
    /// Blocks with these texts begin and end it.
    Block {
        /// First block.
        begin: Pattern,
        /// Last block; without one the end of the program.
        end: Option<Pattern>,
    },
    /// The signal of the controller is on.
    Signal,
    /// Stands of these lengths one after the other, s.
    Dwells {
        /// The stands in order.
        dwells_s: Vec<f64>,
        /// Standing so long ends the cycle, s.
        still_s: f64,
    },
    /// Motion after standing.
    Motion {
        /// Standing so long before, s.
        rest_s: f64,
        /// Standing so long ends the cycle, s.
        still_s: f64,
    },
}

/// A text in which `*` stands for anything; upper and lower case are alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern(String);

impl Pattern {
    /// As written.
    pub fn new(text: &str) -> Self {
        Self(text.to_lowercase())
    }

    /// True when the whole of `text` is like the pattern.
    pub fn matches(&self, text: &str) -> bool {
        let text = text.to_lowercase();
        let Some((head, rest)) = self.0.split_once('*') else { return self.0 == text };
        let (middle, tail) = rest.rsplit_once('*').unwrap_or(("", rest));
        let Some(mut left) = text.strip_prefix(head).and_then(|text| text.strip_suffix(tail)) else {
            return false;
        };
        middle.split('*').all(|piece| match left.find(piece) {
            Some(at) => {
                left = &left[at + piece.len()..];
                true
            }
            None => false,
        })
    }
}

impl StartRule {
    const NAMES: [&'static str; 6] = ["execution", "program", "block", "signal", "dwells", "motion"];

    /// Reads `[cycle_start]`; without the table, [`StartRule::Execution`].
    pub fn read(root: &Table<'_>) -> Option<Self> {
        let Some(table) = root.optional_table("cycle_start") else { return Some(Self::default()) };
        let still_s = || table.optional_number("still_s", 1.0..=3600.0).unwrap_or(60.0);
        let pattern = |key: &str| table.string(key).map(|text| Pattern::new(&text));
        let rule = match table.one_of("by", &Self::NAMES)?.as_str() {
            "program" => Self::Program(pattern("program")?),
            "block" => Self::Block {
                begin: pattern("begin")?,
                end: table.optional_string("end").map(|text| Pattern::new(&text)),
            },
            "signal" => Self::Signal,
            "dwells" => Self::Dwells { dwells_s: read_dwells(&table)?, still_s: still_s() },
            "motion" => {
                let rest_s = table.optional_number("rest_s", 0.2..=600.0).unwrap_or(2.0);
                Self::Motion { rest_s, still_s: still_s() }
            }
            _ => Self::Execution,
        };
        table.no_other_keys();
        Some(rule)
    }

    /// What is waited for, for the log.
    pub fn about(&self) -> String {
        match self {
            Self::Execution => "the controller to run a program".into(),
            Self::Program(Pattern(name)) => format!("the controller to run the program {name}"),
            Self::Block { begin: Pattern(text), .. } => format!("the block {text}"),
            Self::Signal => "the controller's signal".into(),
            Self::Dwells { dwells_s, .. } => format!("stands of {dwells_s:?} s"),
            Self::Motion { rest_s, .. } => format!("motion after {rest_s} s of standing"),
        }
    }
}

fn read_dwells(table: &Table<'_>) -> Option<Vec<f64>> {
    let dwells_s = table.optional_numbers("dwells_s");
    match dwells_s {
        Some(dwells_s) if !dwells_s.is_empty() && dwells_s.iter().all(|s| (0.5..=60.0).contains(s)) => {
            Some(dwells_s)
        }
        found => {
            let advice = "Give the stands at the head of the NC program, for example [2.0, 1.0, 2.0].";
            table.problem("dwells_s", format!("= {found:?}"), "one number or more, each 0.5..=60", advice);
            None
        }
    }
}

/// The beginning or the end of a cycle.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// It begins.
    Begins {
        /// When.
        at: HostTime,
        /// By what, for the recording.
        why: String,
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
    /// The cycle runs.
    running: bool,
    /// What begins a cycle is there, as last seen.
    was_there: bool,
    /// A program was seen running since the cycle began.
    program_ran: bool,
}

impl CycleBounds {
    /// Before the first reading.
    pub fn new(rule: StartRule) -> Self {
        let dwells =
            if let StartRule::Dwells { dwells_s, .. } = &rule { dwells_s.clone() } else { Vec::new() };
        Self { rule, motion: Motion::new(dwells), ..Self::default() }
    }

    /// The cycle was ended by something else: all poses read, or stopped by a person.
    pub fn ended_otherwise(&mut self) {
        self.running = false;
    }

    /// The next reading in order.
    pub fn take(&mut self, reading: &Reading) -> Option<Bound> {
        match reading {
            Reading::Controller(controller) => self.controller(controller),
            Reading::Axes(axes) => {
                let step = self.motion.take(axes);
                self.moved(step, axes.arrival)
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
        if self.running {
            if self.program_ran && matches!(now.execution, Execution::Ready | Execution::Ended) {
                return self.end(now.arrival, format!("the controller says {:?}", now.execution));
            }
            self.program_ran |= runs;
        }
        // `Some(true)`: what begins a cycle is there; `None`: this reading says nothing about it.
        let (there, why) = match &self.rule {
            StartRule::Execution => (reported(now.execution), format!("runs {}", now.program)),
            StartRule::Program(name) => {
                let named = name.matches(&now.program);
                // A controller that never reports what it executes is judged by the name alone.
                let reported =
                    if now.execution == Execution::Unknown { Some(named) } else { reported(now.execution) };
                (reported.map(|runs| runs && named), format!("runs {}", now.program))
            }
            StartRule::Block { begin, end } => {
                let is_end = end.as_ref().is_some_and(|end| end.matches(&now.block));
                if self.running && is_end {
                    return self.end(now.arrival, format!("block {}", now.block));
                }
                (Some(begin.matches(&now.block)), format!("block {}", now.block))
            }
            StartRule::Signal => (now.signal, "the signal is on".into()),
            StartRule::Dwells { .. } | StartRule::Motion { .. } => return None,
        };
        let there = there?;
        let came = there && !self.was_there;
        self.was_there = there;
        if came && !self.running {
            return self.begin(now.arrival, format!("the controller: {why}"), runs);
        }
        // Held and subprograms pass through here with the rule unfulfilled; only these two are levels.
        let is_level = match self.rule {
            StartRule::Signal => true,
            StartRule::Program(_) => now.execution == Execution::Unknown,
            _ => false,
        };
        if self.running && is_level && !there {
            return self.end(now.arrival, "what began the cycle is gone".into());
        }
        None
    }

    fn moved(&mut self, step: Step, at: HostTime) -> Option<Bound> {
        let still_s = match &self.rule {
            StartRule::Motion { still_s, .. } | StartRule::Dwells { still_s, .. } => *still_s,
            _ => return None,
        };
        match step {
            Step::Stands { for_s } if self.running && for_s >= still_s => {
                self.end(at, format!("no axis moved for {still_s} s"))
            }
            Step::Stands { .. } => None,
            Step::Moves { stood_s, pattern } => {
                let (begins, why) = match self.rule {
                    StartRule::Motion { rest_s, .. } => (stood_s >= rest_s, "an axis moves"),
                    _ => (pattern, "the stands of the configuration"),
                };
                if self.running || !begins { None } else { self.begin(at, why.into(), false) }
            }
        }
    }

    fn begin(&mut self, at: HostTime, why: String, program_ran: bool) -> Option<Bound> {
        (self.running, self.program_ran) = (true, program_ran);
        Some(Bound::Begins { at, why: why.trim_end().into() })
    }

    fn end(&mut self, at: HostTime, why: String) -> Option<Bound> {
        self.running = false;
        // Reported by the same reading: what follows is another program.
        self.was_there &= !matches!(self.rule, StartRule::Execution | StartRule::Program(_));
        Some(Bound::Ends { at, why })
    }
}

/// Whether a program runs, where the controller reports that; in a hold it neither begins nor ends.
fn reported(execution: Execution) -> Option<bool> {
    match execution {
        Execution::Active => Some(true),
        Execution::Ready | Execution::Ended => Some(false),
        Execution::Held | Execution::Unknown => None,
    }
}

#[cfg(test)]
mod tests;
