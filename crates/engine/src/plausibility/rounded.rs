//! Numbers that were rounded when they were written: what that hides, and what to do.
//!
//! Rounding to a step q leaves errors of q/√12 [GUM F.2.2.1].

pub(super) mod lengths;
pub(super) mod positions;

use super::found::{Implausible, plain};
use super::path::HIDDEN_UM;

/// What is hidden counts from this part of the noise on: a third of it adds 5 % to the standard uncertainty, √(1 + 1/9).
const PART_OF_NOISE: f64 = 1.0 / 3.0;
/// And from the last digit of good probes on, µm.
const FINEST_UM: f64 = 0.1;

/// What rounding hides in a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Rounded {
    /// Name of the run.
    pub run: String,
    /// To what: `in steps of 0.01 mm`.
    pub given: String,
    /// What it hides, µm rms.
    pub hidden_um: f64,
    /// What was rounded.
    pub what: What,
}

/// Numbers that were rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// Positions on the fly.
    Positions,
    /// Lengths along a line.
    Lengths {
        /// Readings of one pose scatter by so much, µm.
        scatter_um: f64,
    },
}

impl Rounded {
    /// So much that nothing can be judged.
    pub fn is_gross(&self) -> bool {
        self.hidden_um > HIDDEN_UM
    }

    /// What is wrong, where, and how large.
    pub fn finding(&self) -> String {
        let Self { run, given, hidden_um, what } = self;
        match what {
            What::Positions => format!(
                "{run}: on the fly the positions are given {given}. From row to row this takes ball and nest {hidden_um:.1} µm rms apart, and the \
                 readings do not show it."
            ),
            What::Lengths { scatter_um } => format!(
                "{run}: the readings are given {given}. That adds u = {hidden_um:.1} µm to each, the same at every visit of a place; readings of one \
                 pose scatter by {scatter_um:.2} µm."
            ),
        }
    }

    /// What to do.
    pub fn advice(&self) -> &'static str {
        match self.what {
            What::Positions => {
                "The positions were rounded when they were written, and hide what is to be found. Give them with four decimals."
            }
            What::Lengths { .. } => {
                "The readings were rounded when they were written, which looks like a wave or another error of the axis. Give them with four \
                 decimals."
            }
        }
    }

    /// As the reason to judge nothing.
    pub fn implausible(&self) -> Implausible {
        plain(self.finding(), self.advice())
    }
}
