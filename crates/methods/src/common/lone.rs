//! Readings that a fit of the base model excludes: a single one would be every largest value of a standard.

use crate::Findings;
use trunnion_core::Point;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, HeldOut, Uncertainties, identify};

/// Runs without the readings that `identify` excludes, and these in words. Where no model fits nothing is excluded.
pub(crate) fn without_outliers(runs: &[Run]) -> (Vec<Run>, Vec<String>) {
    // Which are used does not depend on how uncertainties come about; these cost least.
    let uncertainties = Uncertainties::Clusters;
    let options = Options { holdout: HeldOut::Skipped, uncertainties, ..Options::default() };
    let used = Experiment::new(runs).ok().and_then(|experiment| {
        let base = Model::base(&experiment.machine().name);
        identify(&experiment, &base, &options).ok().map(|fit| fit.used)
    });
    let mut used = used.unwrap_or_default().into_iter();
    let mut words = Vec::new();
    let kept = runs.iter().map(|run| {
        // The points of a fit are the good ones, run after run.
        let mut is_kept = |(row, point): &(usize, Point)| {
            let is_used = !point.is_good() || used.next().unwrap_or(true);
            if !is_used {
                let of_run = if runs.len() > 1 { format!(" of run {}", run.name) } else { String::new() };
                words.push(format!("row {row}{of_run}"));
            }
            is_used
        };
        let rows = (1..).zip(run.points.iter().cloned());
        let points = rows.filter(|of| is_kept(of)).map(|(_, point)| point).collect();
        Run { points, ..run.clone() }
    });
    (kept.collect(), words)
}

/// What a method found without them, with which readings they are. `standard`: whose definitions exclude nothing.
pub(crate) fn named(found: Findings, excluded: &[String], runs: &[Run], standard: &str) -> Findings {
    let all: usize = runs.iter().map(|run| run.good_points().count()).sum();
    let which = match excluded {
        [] => return found,
        [one] => format!("1 of {all} readings ({one}) lies far from the rest of the fit and counts"),
        [first, .., last] => format!(
            "{} of {all} readings ({first} to {last}) lie far from the rest of the fit and count",
            excluded.len()
        ),
    };
    let mut notes = vec![format!(
        "{which} in no value, as in `identify`. {standard} excludes nothing: where it was no fault of the measurement, look for the \
         cause, and measure again."
    )];
    notes.extend(found.notes);
    Findings { excluded: excluded.len(), notes, ..found }
}
