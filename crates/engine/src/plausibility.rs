//! Can these runs be what they say they are? Asked before any physics is blamed.
//!
//! Positions must belong to the setup, readings to the positions, times to the order of the points. What does not fit is
//! tried as a named mistake: with the mistake undone everything must fit. The rules look only for gross mistakes; what a
//! machine itself can do is never one.

mod found;
mod order;
mod positions;
mod readings;

pub use found::Implausible;

use trunnion_cycles::Run;

/// Everything about these runs that is not plausible, the gravest first; empty for good runs.
pub fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let positions = positions::implausible(runs);
    // Readings say nothing of their own where they are attached to wrong positions.
    let readings = if positions.is_empty() { readings::implausible(runs) } else { Vec::new() };
    [positions, readings, order::implausible(runs)].concat()
}
