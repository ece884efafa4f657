//! The units that are left out of a fit in turn: whole passes, and blocks of one pass where there is only one.
//!
//! Errors that stay alike within a pass pass for knowledge when single readings are left out; so the unit is the largest that
//! repeats. It is called by what it is: a run or a setup that was measured in one pass is left out as a whole.

use crate::Experiment;
use crate::problem::passes::Passes;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// The unit that is left out in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LeftOut {
    /// Whole runs: each was measured in one pass.
    Runs,
    /// Whole setups: each was measured in one pass.
    Setups,
    /// Whole passes: one setup in one combination of directions and feed.
    Passes,
    /// Blocks of equal position of the slowest axis.
    Blocks,
}

impl LeftOut {
    /// One of them, in a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Runs => "run",
            Self::Setups => "setup",
            Self::Passes => "pass",
            Self::Blocks => "block",
        }
    }

    /// Several of them, in a word.
    pub fn plural(self) -> &'static str {
        match self {
            Self::Runs => "runs",
            Self::Setups => "setups",
            Self::Passes => "passes",
            Self::Blocks => "blocks",
        }
    }
}

/// Which unit each point belongs to.
pub(crate) struct Folds<'a> {
    pub left_out: LeftOut,
    pub of_point: &'a [usize],
    pub count: usize,
}

/// The folds of an experiment.
pub(crate) fn folds<'a>(experiment: &Experiment, passes: &'a Passes) -> Folds<'a> {
    if passes.passes < 2 {
        return Folds { left_out: LeftOut::Blocks, of_point: &passes.block, count: passes.blocks };
    }
    let runs: HashSet<usize> = experiment.run_of_point.iter().copied().collect();
    let setups: HashSet<usize> = experiment.points.iter().map(|point| point.state.setup).collect();
    let left_out = match passes.passes {
        n if n == runs.len() => LeftOut::Runs,
        n if n == setups.len() => LeftOut::Setups,
        _ => LeftOut::Passes,
    };
    Folds { left_out, of_point: &passes.pass, count: passes.passes }
}
