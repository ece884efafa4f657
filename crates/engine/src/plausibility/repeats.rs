//! Readings of a pose that comes again which are those of the visit before, digit by digit: a pass that was copied, or the mean of passes written
//! into each of them.
//!
//! Two readings of noise σ fall on one step of a display with the chance step/(2σ√π), k channels with the k-th power of it (`same_within`). No axis
//! comes back within σ = `TOO_FINE_UM`, so that the chance is no larger on any machine. A coarse display whose readings a calibration turned into axes
//! of the nest has fine digits and equal readings all the same, here and there among others, which lie on a lattice: so either all are equal, or a
//! stretch of them is, longer than the share of equal ones elsewhere makes it, and the others lie on no lattice.
//! Limits: behind a display of 0.05 µm or more equal readings may be those of a quiet machine, and nothing is said.

use super::found::{Implausible, plain};
use super::looked::with_points;
use super::shown::{SAME_MM, Shown, same_within};
use crate::Experiment;
use std::collections::HashMap;
use std::ops::Range;
use trunnion_core::Point;
use trunnion_core::convert::mm_from_um;
use trunnion_core::number::fixed;
use trunnion_core::statistics::upper_median;
use trunnion_cycles::{Run, RunKind};

/// So many rows are needed before equal halves, or setups, are copies and no chance.
pub(super) const FEWEST: usize = 8;
/// More equal rows than by chance: four standard deviations of a count [Poisson], one in 30 000.
const SURE: f64 = 4.0;
/// Repeatability of a reading at rest below which the unit is doubted, µm: no axis comes back so well. 0.5 µm, a usual repeatability, is
/// 0.5/25.4 = 0.02 µm where readings in thousandths of an inch are taken for µm. A judgement, tuned on no data.
pub(super) const TOO_FINE_UM: f64 = 0.02;
/// All poses that come again but for single wrong readings.
const ALL: f64 = 0.9;
/// Chance of so long a stretch of equal readings: that of four standard deviations.
const BY_CHANCE: f64 = 1.0 / 30_000.0;
/// Fewer others say nothing of what is usual.
const FEWEST_OTHERS: usize = 24;
/// The differences of the others: the median is so many times the smallest where they lie on no lattice. The largest of three normal numbers has the
/// median 1.26 σ, and is below 0.42 σ in one of 27; on a lattice of one step, where equal ones are common, it is no more than twice the smallest.
const NO_LATTICE: f64 = 3.0;

/// Earlier visits of a pose that are looked at, the last ones. For time only.
const VISITS: usize = 8;

/// A pose that comes again, after others in between.
struct Again {
    /// Row of the run, from 1.
    row: usize,
    setup: usize,
    /// Earlier visits of the pose.
    visits: usize,
    /// The largest difference of a channel from the visit that is most alike, mm.
    differs_mm: f64,
}

impl Again {
    fn is_equal(&self) -> bool {
        self.differs_mm < SAME_MM
    }
}

pub(super) fn copied(run: &Run) -> Option<Implausible> {
    if run.kind != RunKind::Static || run.points.iter().any(|point| point.samples > 1) {
        return None;
    }
    let again = again(run)?;
    let equal = again.iter().filter(|one| one.is_equal()).count();
    let is_all = equal as f64 > ALL * again.len() as f64;
    let copied = if is_all { 0..again.len() } else { longest(&again) };
    let expected = by_display(run, &again);
    let is_copy = equal >= FEWEST
        && equal as f64 > expected + SURE * expected.sqrt()
        && (is_all || is_unlike_others(&again, &copied));
    is_copy.then(|| {
        let (first, last) = (&again[copied.start], &again[copied.end - 1]);
        let count = again[copied.clone()].iter().filter(|one| one.is_equal()).count();
        plain(
            format!(
                "{}: {count} of {} poses that come again in rows {} to {} read the same in every digit; by chance no more than {} would.",
                run.name,
                copied.len(),
                first.row,
                last.row,
                fixed(expected, 1)
            ),
            "The readings of one pass were copied into another, or their mean was written into both, so their repeats prove nothing. Put in the \
             readings that were measured, or remove these rows; unless the run was simulated without noise.",
        )
    })
}

/// In the order of the rows.
fn again(run: &Run) -> Option<Vec<Again>> {
    let (rows, good): (Vec<usize>, Vec<&Point>) =
        (1..).zip(&run.points).filter(|(_, point)| point.is_good()).unzip();
    let poses = Experiment::of_points(&[with_points(run, good.clone())]).ok()?.poses();
    let mut visits: HashMap<usize, Vec<usize>> = HashMap::new();
    let one = |at: usize| {
        let earlier = visits.entry(poses[at]).or_default();
        let setup = good[at].state.setup;
        let channels = run.setups[setup].instrument.components().len();
        let off_mm = |before: usize| {
            let off_mm = |k: usize| (good[at].reading_mm[k] - good[before].reading_mm[k]).abs();
            (0..channels).map(off_mm).fold(0.0, f64::max)
        };
        let differs_mm = earlier.iter().rev().take(VISITS).map(|&before| off_mm(before)).reduce(f64::min);
        let visits = earlier.len().min(VISITS);
        // Read again at once, an axis did not come back.
        let came_back = earlier.last().is_some_and(|last| poses[last + 1] != poses[at]);
        earlier.push(at);
        came_back.then(|| Again {
            row: rows[at],
            setup,
            visits,
            differs_mm: differs_mm.unwrap_or(f64::INFINITY),
        })
    };
    Some((0..good.len()).filter_map(one).collect())
}

/// How many of them the display of their setup makes equal on the quietest machine.
fn by_display(run: &Run, again: &[Again]) -> f64 {
    let of_setup = |setup: usize| {
        let pairs: usize = again.iter().filter(|one| one.setup == setup).map(|one| one.visits).sum();
        let own = run.points.iter().filter(|point| point.is_good() && point.state.setup == setup);
        let step_mm = Shown::of(&run.setups[setup], own).step_mm;
        let channels = run.setups[setup].instrument.components().len();
        pairs as f64 * same_within(step_mm, mm_from_um(TOO_FINE_UM)).powi(channels as i32)
    };
    (0..run.setups.len()).map(of_setup).sum()
}

/// The longest stretch of equal ones.
fn longest(again: &[Again]) -> Range<usize> {
    let (mut longest, mut first) = (0..0, 0);
    for (at, one) in again.iter().enumerate() {
        if !one.is_equal() {
            first = at + 1;
        } else if at + 1 - first > longest.len() {
            longest = first..at + 1;
        }
    }
    longest
}

fn is_unlike_others(again: &[Again], copied: &Range<usize>) -> bool {
    let others: Vec<&Again> =
        again.iter().enumerate().filter(|(at, _)| !copied.contains(at)).map(|(_, one)| one).collect();
    let differ_mm: Vec<f64> = others.iter().filter(|one| !one.is_equal()).map(|one| one.differs_mm).collect();
    // One more equal, and one more that is not [Laplace].
    let share = (others.len() - differ_mm.len() + 1) as f64 / (others.len() + 2) as f64;
    let smallest_mm = differ_mm.iter().copied().fold(f64::INFINITY, f64::min);
    let is_on_no_lattice =
        upper_median(&differ_mm).is_some_and(|median_mm| median_mm > NO_LATTICE * smallest_mm);
    copied.len() >= FEWEST
        && differ_mm.len() >= FEWEST_OTHERS
        && is_on_no_lattice
        && again.len() as f64 * share.powi(copied.len() as i32) < BY_CHANCE
}
