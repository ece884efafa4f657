//! Readings on the fly that are some rows late or early.
//!
//! A row is a step of some degrees, by which errors of micrometres hardly change: what is left is never gross. It is named where the shifted
//! readings fit as well as they repeat: physics would have to be, at every angle and feed, what the rows make of all other errors. No hidden
//! physics of four sizes was taken for it (tests/tests/all/plausible_runs.rs). Blocks hold several rows each: their readings are taken between
//! neighbours, at the time that so many rows make.

use super::{AS_GOOD, BELIEVED, CHANGE, MOST_ROWS_LATE, Trial, Tried, fits, unfit};
use crate::plausibility::fitted::{Fitted, columns};
use crate::plausibility::found::Implausible;
use crate::plausibility::looked::Looked;
use nalgebra::DMatrix;
use std::collections::HashMap;
use trunnion_core::statistics::{median, rms};
use trunnion_cycles::RunKind;

/// Neighbours farther apart than so many usual steps do not follow each other.
const PAUSE_STEPS: f64 = 3.0;

pub(in crate::plausibility) fn by_rows(looked: &Looked) -> Option<Implausible> {
    let Looked { run, experiment, .. } = looked;
    if run.kind != RunKind::OnTheFly {
        return None;
    }
    let (repeated, before_mm) = (looked.repeated()?, looked.left_mm);
    let trial = Trial::of(looked);
    let columns = columns(experiment)?;
    let tried =
        (1..=MOST_ROWS_LATE as isize).flat_map(|by| [by, -by]).filter_map(|by| trial.late_by(&columns, by));
    let (mistake, left_mm) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
    // Readings that fit as they are need no shift: of ten, one fits better by chance. Between blocks the course of a reading is not known, so that
    // more is left than they repeat within.
    let is_explained =
        fits(&repeated, left_mm) && before_mm > AS_GOOD * left_mm || before_mm > BELIEVED * left_mm;
    let is_late = !fits(&repeated, before_mm) && is_explained;
    is_late.then(|| unfit(run, &repeated, before_mm, (mistake, left_mm), CHANGE))
}

/// Readings that another row holds; of the rows at an end of a setup none.
type Moved = Vec<Option<[f64; 3]>>;

impl Trial<'_> {
    /// Readings so many rows late or, negative, early.
    fn late_by(&self, columns: &DMatrix<f64>, by: isize) -> Option<Tried> {
        let is_of_blocks = self.run.points.iter().any(|point| point.samples > 1);
        let moved = if is_of_blocks { self.at_times(by as f64 * self.row_s()?) } else { self.of_rows(by) };
        let experiment = self.experiment;
        let readings_mm = self.changed_rows(|readings| {
            readings.iter_mut().zip(&moved).for_each(|(reading, moved)| *reading = moved.unwrap_or(*reading));
        });
        let used: Vec<bool> = moved
            .iter()
            .enumerate()
            .flat_map(|(at, moved)| experiment.rows_of(at).map(|_| moved.is_some()))
            .collect();
        let left_mm = Fitted::on(columns, |row| used[row]).left_mm(&readings_mm);
        let of_used = left_mm.iter().zip(&used).filter(|(_, used)| **used).map(|(left, _)| *left);
        let rows = if by.abs() == 1 { "one row".into() } else { format!("{} rows", by.abs()) };
        let words = match by > 0 {
            true => format!("the readings shifted {rows} earlier: they are {rows} late"),
            false => format!("the readings shifted {rows} later: they are {rows} early"),
        };
        Some((words, rms(of_used)?))
    }

    /// Of every row what the one so many rows behind it in its setup reads.
    fn of_rows(&self, by: isize) -> Moved {
        let points = &self.experiment.points;
        let mut moved = vec![None; points.len()];
        for (to, from) in (0..self.run.setups.len()).flat_map(|setup| self.behind(Some(setup), by)) {
            moved[to] = from.map(|from| points[from].reading_mm);
        }
        moved
    }

    /// Steps between neighbours of one setup: the first of them, s.
    fn steps(&self) -> Vec<(usize, f64)> {
        let points = &self.experiment.points;
        let step = |at: usize| {
            let [from, to] = [&points[at].state, &points[at + 1].state];
            let step_s = to.time_s? - from.time_s?;
            (from.setup == to.setup && step_s > 0.0).then_some((at, step_s))
        };
        (0..points.len().saturating_sub(1)).filter_map(step).collect()
    }

    /// Time from row to row: from the middle of a block to that of the next lie half of the rows of both.
    fn row_s(&self) -> Option<f64> {
        let points = &self.experiment.points;
        let rows = |at: usize| 0.5 * f64::from(points[at].samples + points[at + 1].samples);
        median(&self.steps().into_iter().map(|(at, step_s)| step_s / rows(at)).collect::<Vec<_>>())
    }

    /// Every reading as it was so much later, between its neighbours.
    fn at_times(&self, delay_s: f64) -> Moved {
        let points = &self.experiment.points;
        let steps = self.steps();
        let usual_s = median(&steps.iter().map(|(_, step_s)| *step_s).collect::<Vec<_>>()).unwrap_or(0.0);
        let follows: HashMap<usize, f64> =
            steps.into_iter().filter(|(_, step_s)| *step_s < PAUSE_STEPS * usual_s).collect();
        let of_point = |at: usize| {
            let (mut from, mut ahead_s) = (at, delay_s);
            // The neighbours between which the time lies.
            while ahead_s < 0.0 {
                from = from.checked_sub(1)?;
                ahead_s += follows.get(&from)?;
            }
            while ahead_s > *follows.get(&from)? {
                ahead_s -= follows[&from];
                from += 1;
            }
            let part = ahead_s / follows[&from];
            let [before, behind] = [from, from + 1].map(|k| points[k].reading_mm);
            Some(std::array::from_fn(|k| before[k] + part * (behind[k] - before[k])))
        };
        (0..points.len()).map(of_point).collect()
    }
}
