//! Can these runs be what they say they are? Asked before any physics is blamed.
//!
//! Positions must belong to the setup, readings to the positions, times to the order of the points. What does not fit is
//! tried as a named mistake: with the mistake undone everything must fit. The rules look only for gross mistakes; what a
//! machine itself can do is never one.

mod chance;
mod changed;
mod channels;
mod claim;
mod clock;
mod copies;
mod digits;
mod exchanged;
mod fitted;
mod found;
mod looked;
mod lost_count;
mod mirrored;
mod order;
mod path;
mod places;
mod positions;
mod readings;
mod repeats;
mod rounded;
mod same_place;
mod sensors;
mod shown;
mod sizes;
mod stretches;
mod temperatures;
mod tip;
mod together;
mod travel;
mod ways;

pub use changed::Remainders;
pub use clock::{ClockDoubt, clock_doubt};
pub use found::Implausible;
pub use readings::FEWEST_POINTS;
pub use rounded::positions::PositionDigits;
pub use rounded::{Rounded, What as RoundedWhat};
pub use together::{Differs, How, Unlike, unlike};

use rounded::lengths::rounded_lengths;
use trunnion_core::InstrumentKind;
use trunnion_cycles::Run;

/// What the instruments are called of whose positions and readings nothing is asked: they keep no known distance.
pub fn not_asked(runs: &[Run]) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = runs
        .iter()
        .flat_map(|run| &run.setups)
        .map(|setup| setup.instrument)
        .filter(|kind| {
            !matches!(kind, InstrumentKind::RTest | InstrumentKind::Diagonal) && !kind.keeps_bar_length()
        })
        .map(InstrumentKind::name)
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// What is asked of runs before they are judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked {
    /// Everything that is not plausible, the gravest first; empty for good runs.
    pub implausible: Vec<Implausible>,
    /// Lengths that were rounded, and so little that the runs are still judged.
    pub rounded: Vec<Rounded>,
}

/// Everything about these runs that is not plausible, the gravest first; empty for good runs.
pub fn implausible(runs: &[Run]) -> Vec<Implausible> {
    asked(runs).implausible
}

/// The same, and what is only to be doubted.
pub fn asked(runs: &[Run]) -> Asked {
    let positions = positions::implausible(runs);
    let channels = channels::implausible(runs);
    let travel = if positions.is_empty() { travel::implausible(runs) } else { Vec::new() };
    let lost = if travel.is_empty() { lost_count::implausible(runs) } else { Vec::new() };
    let sizes = if channels.is_empty() { sizes::implausible(runs) } else { Vec::new() };
    // Readings say nothing of their own where they are attached to wrong positions, or where a probe is dead.
    let belong = positions.is_empty() && travel.is_empty() && channels.is_empty() && sizes.is_empty();
    let mut readings: Vec<Implausible> = Vec::new();
    if belong {
        readings.extend(runs.iter().filter_map(same_place::implausible));
        readings.extend(readings::implausible(runs));
    }
    if belong && readings.is_empty() {
        readings = together::implausible(runs);
    }
    // Of rows in another order than their readings the directions say nothing.
    let order = order::implausible(runs, positions.is_empty() && readings.is_empty());
    let belong = belong && readings.is_empty() && order.is_empty();
    let ways = if belong { runs.iter().flat_map(ways::not_filled_in).collect() } else { Vec::new() };
    let temperatures = temperatures::implausible(runs);
    let lengths =
        if travel.is_empty() { runs.iter().filter_map(rounded_lengths).collect() } else { Vec::new() };
    let (gross, rounded): (Vec<Rounded>, Vec<Rounded>) = lengths.into_iter().partition(Rounded::is_gross);
    let implausible = [
        positions,
        travel,
        lost,
        gross.iter().map(Rounded::implausible).collect(),
        channels,
        sizes,
        temperatures,
        readings,
        copies::implausible(runs),
        order,
        ways,
    ]
    .concat();
    Asked { implausible, rounded }
}
