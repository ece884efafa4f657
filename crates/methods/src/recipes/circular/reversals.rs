//! Since when an axis has gone on without reversing, reading by reading of a circle.
//!
//! An axis reverses at the ends of its diameter, so its travel since is known from the first end on that a pass goes through: R (1 + sgn v · x/R), x its
//! place from the centre. Before that end it depends on how the tool came to the beginning. A run in along the circle, which no row shows, brings no
//! reversal; from rest or out of a straight line the axis may reverse right at the beginning, and so stick there as it does at an end, or not. Where the
//! travel that the run states begins at zero there, it is the rows that begin, not known to be the axis: what sticks at that beginning is a size of its own.

use super::sample::{Reversal, Sample};

/// The travel that a run states may be this share of the radius less than that since the end of the diameter: the shortest decay of a spike.
const APART: f64 = 0.002;

/// Readings by an end that the run counts to the way before it, of so many steps. A direction from row to row changes one row late.
const LATE_STEPS: f64 = 1.5;

/// A row is the end of a diameter itself within this share of a step: tables of whole or half degrees have such rows, and the last digit of their
/// positions, not the machine, gives the way. One row in fifty lies so by chance.
const AT_END_STEPS: f64 = 0.01;

/// True at the very end of a diameter, and just beyond it where the run says that the axis has not reversed yet, or where the axis came from the row `before` of the
/// same pass against the way it goes: direction from row to row and direction by speed differ there, and by one of both the reading would be wrong.
pub(super) fn is_between(before: Option<&Sample>, sample: &Sample, usual_step_rad: f64) -> bool {
    let (sin, cos) = sample.angle_rad.sin_cos();
    let is_late = |k: usize| {
        let from_end = [sin, cos][k].abs();
        sample.direction[k] != sample.heading(k) && from_end <= LATE_STEPS * usual_step_rad
    };
    let came_against = |k: usize| {
        let came = |before: &Sample| [cos, sin][k] - [before.angle_rad.cos(), before.angle_rad.sin()][k];
        before.is_some_and(|before| came(before) * sample.heading(k) <= 0.0)
    };
    let is_at_end = |k: usize| [sin, cos][k].abs() < AT_END_STEPS * usual_step_rad;
    [0, 1].into_iter().any(|k| is_at_end(k) || is_late(k) || came_against(k))
}

/// Fills `reversal` of the samples, which hold what the run states, pass by pass. Gives the number of beginnings that are not known.
pub(super) fn find(
    samples: &mut [Sample],
    radius_mm: f64,
    begins: impl Fn(&Sample, &Sample) -> bool,
) -> usize {
    let mut unknown = 0;
    let mut pass_from = 0;
    while pass_from < samples.len() {
        let further = samples[pass_from..].windows(2).position(|two| begins(&two[0], &two[1]));
        let pass_to = further.map_or(samples.len(), |at| pass_from + at + 1);
        for k in [0, 1] {
            unknown += usize::from(of_pass(&mut samples[pass_from..pass_to], k, radius_mm, unknown));
        }
        pass_from = pass_to;
    }
    unknown
}

/// One axis of one pass; whether its beginning is unknown, which has this number then.
fn of_pass(pass: &mut [Sample], k: usize, radius_mm: f64, beginning: usize) -> bool {
    let first_end = pass.windows(2).position(|two| two[0].heading(k) != two[1].heading(k));
    let (head, rest) = pass.split_at_mut(first_end.map_or(pass.len(), |at| at + 1));
    let is_short =
        |sample: &Sample| sample.stated_mm(k) < sample.since_end_mm(k, radius_mm) - APART * radius_mm;
    let is_unknown = head.iter().any(is_short);
    let from_mm = head[0].position_mm[k];
    for sample in head {
        if is_unknown {
            let travel_mm = (sample.position_mm[k] - from_mm).abs();
            sample.reversal[k] = Reversal::Unknown { beginning, travel_mm };
        }
    }
    for sample in rest {
        // Where the run says that the axis has yet to reverse, its travel is that of before.
        if sample.direction[k] == sample.heading(k) {
            sample.reversal[k] = Reversal::Since(sample.since_end_mm(k, radius_mm));
        }
    }
    is_unknown
}

impl Sample {
    /// ±1 by the way an axis goes on the circle here.
    fn heading(&self, k: usize) -> f64 {
        let (sin, cos) = self.angle_rad.sin_cos();
        (self.way * [-sin, cos][k]).signum()
    }

    /// Travel since the last end of the diameter, mm.
    fn since_end_mm(&self, k: usize, radius_mm: f64) -> f64 {
        let (sin, cos) = self.angle_rad.sin_cos();
        radius_mm * (1.0 + self.heading(k) * [cos, sin][k])
    }

    fn stated_mm(&self, k: usize) -> f64 {
        match self.reversal[k] {
            Reversal::Since(travel_mm) | Reversal::Unknown { travel_mm, .. } => travel_mm,
        }
    }
}
