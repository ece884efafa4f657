//! Readings of some rows that are those of other rows, digit by digit: a block that was pasted over its neighbour.
//!
//! A coarse display makes rows equal, and so does a quiet machine. So the base model has to expect other readings at their poses: fitted without
//! these n readings it leaves Σr₀², with them Σr², and they are off by √((Σr² − Σr₀²)/n), which of good readings is what it leaves elsewhere [F test of n
//! more readings]. They have to be farther off, and farther than a display rounds.
//! A copy to the same poses (a way back that was not measured) only repeats too well (`repeats`).

use crate::Experiment;
use crate::plausibility::exchanged::BELIEVED;
use crate::plausibility::fitted::{Fitted, columns, rms};
use crate::plausibility::found::{Implausible, plain};
use crate::plausibility::looked::{MOST_POINTS, with_points};
use crate::plausibility::shown::{SAME_MM, Shown};
use nalgebra::DVector;
use trunnion_core::Point;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::fixed;
use trunnion_cycles::Run;

/// Two readings that a display rounds differ by no more than a step, and as much is what the model does not know of a display.
const ROUNDED_STEPS: f64 = 2.0;

/// Good points that hold the readings of others, in the same order.
#[derive(Clone, Copy)]
struct Stretch {
    /// The first of each, the earlier one first.
    begins: [usize; 2],
    length: usize,
}

/// Of so many rows at least.
pub(super) fn copied(run: &Run, fewest: usize) -> Option<Implausible> {
    let (rows, good): (Vec<usize>, Vec<&Point>) =
        (1..).zip(&run.points).filter(|(_, point)| point.is_good()).unzip();
    if good.len() > MOST_POINTS {
        return None;
    }
    let stretch = longest(run, &good, fewest)?;
    let experiment = Experiment::of_points(&[with_points(run, good.clone())]).ok()?;
    let columns = columns(&experiment)?;
    let readings_mm = experiment.readings_mm();
    let squares = Fitted::on(&columns, |_| true).left_mm(&readings_mm).norm_squared();
    // Whichever of the two is the copy: what is left without it is less.
    let without = |which: usize| {
        let mut is_out = vec![false; experiment.rows()];
        let copied = stretch.begins[which]..stretch.begins[which] + stretch.length;
        copied.for_each(|at| is_out[experiment.rows_of(at)].fill(true));
        let left_mm = Fitted::on(&columns, |row| !is_out[row]).left_mm(&readings_mm);
        let used = (0..left_mm.len()).filter(|row| !is_out[*row]).map(|row| left_mm[row]);
        let left_mm = DVector::from_vec(used.collect());
        let count = (readings_mm.len() - left_mm.len()).max(1) as f64;
        // A setup that is a copy as a whole has a setting of its own: what that takes up is not off.
        let off_mm = ((squares - left_mm.norm_squared()).max(0.0) / count).sqrt();
        (which, rms(&left_mm), off_mm)
    };
    let (copy, left_mm, off_mm) = [0, 1].map(without).into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let step_mm =
        Shown::of(&run.setups[good[stretch.begins[copy]].state.setup], good.iter().copied()).step_mm;
    (off_mm > (BELIEVED * left_mm).max(ROUNDED_STEPS * step_mm)).then(|| {
        let named = |which: usize| {
            let first = stretch.begins[which];
            let setup = &run.setups[good[first].state.setup].name;
            format!("rows {} to {} (setup {setup})", rows[first], rows[first + stretch.length - 1])
        };
        let [off_um, left_um] = [off_mm, left_mm].map(|mm| fixed(um_from_mm(mm), 1));
        plain(
            format!(
                "{}: the readings of {} are those of {}, digit by digit, at other poses; they are {off_um} µm rms off what all other rows say of \
                 these poses; of those {left_um} µm are left.",
                run.name,
                named(copy),
                named(1 - copy),
            ),
            "A block of readings was pasted over another one. Put in the readings that were measured there, or remove these rows.",
        )
    })
}

/// The longest that could be a copy and is no pause of the display.
fn longest(run: &Run, good: &[&Point], fewest: usize) -> Option<Stretch> {
    let is_same = |a: usize, b: usize| {
        let (a, b) = (good[a], good[b]);
        let channels = run.setups[a.state.setup].instrument.components().len();
        let of = |point: &Point| run.setups[point.state.setup].instrument;
        let close = |channel: usize| (a.reading_mm[channel] - b.reading_mm[channel]).abs() < SAME_MM;
        of(a) == of(b)
            && (0..channels).all(close)
            && (a.state.setup != b.state.setup || a.state.position != b.state.position)
    };
    let mut longest: Option<Stretch> = None;
    for lag in fewest..good.len() {
        let mut length = 0;
        for second in lag..good.len() {
            length = if is_same(second - lag, second) { length + 1 } else { 0 };
            let first = second + 1 - length;
            let stretch = Stretch { begins: [first.saturating_sub(lag), first], length: length.min(lag) };
            if length >= fewest
                && longest.is_none_or(|longest| stretch.length > longest.length)
                && changes(&good[first..first + stretch.length])
            {
                longest = Some(stretch);
            }
        }
    }
    longest
}

/// Most rows are another reading than the one before: not a probe that rests, which is another doubt.
fn changes(points: &[&Point]) -> bool {
    let moved = points.windows(2).filter(|pair| pair[0].reading_mm != pair[1].reading_mm).count();
    2 * moved > points.len()
}
