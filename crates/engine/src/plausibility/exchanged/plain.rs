//! Mistakes without a number to choose: signs and inputs of probes, and readings that are rows late or early.
//!
//! They cannot follow an effect, as a free angle or gain does. Next to other physics, or of balls set well, undoing one may divide what is left by less
//! than is asked of every mistake: it is named where it explains at least as much as all else, and neither an effect of one axis nor a slip
//! leaves as little. In 150 good runs of the second simulator, with its physics known and unknown, none divided what is left by more than
//! 1.09.

use super::axes::ways;
use super::{Asked, CHANGE, GROSS_UM, MOST_ROWS_LATE, MOSTLY, Trial, gross_um, variation_um};
use crate::noise::repeatability::repeatability;
use crate::plausibility::fitted::Tried;
use crate::plausibility::found::Implausible;
use crate::plausibility::looked::Looked;
use crate::problem::passes::passes;
use nalgebra::DVector;
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::RunKind;

pub(in crate::plausibility) fn plain(looked: &Looked) -> Option<Implausible> {
    let Looked { run, experiment, model, .. } = looked;
    if variation_um(run) < GROSS_UM {
        return None;
    }
    let before_um = um_from_mm(model.rms_mm(&experiment.readings_mm()));
    let repeated = repeatability(experiment, &passes(experiment));
    let asked = Asked { before_um, gross_um: gross_um(repeated), repeated, divided: MOSTLY };
    asked.of(looked, |trial| trial.plain().into_iter().map(|one| (one, CHANGE)).collect())
}

impl Trial<'_> {
    /// Of all readings.
    pub(super) fn plain(&self) -> Vec<Tried> {
        let mut tried = if self.has_three() { self.of_ways() } else { Vec::new() };
        if self.run.kind == RunKind::Static {
            tried.extend(self.shifted(None));
        }
        tried
    }

    /// Signs of probes and inputs of all readings.
    fn of_ways(&self) -> Vec<Tried> {
        let ways = ways();
        let first = ways.iter().filter(|way| way.is_first_of_two());
        first.map(|way| (way.words_of_all(), self.changed_mm(None, |reading| way.apply(reading)))).collect()
    }

    /// Of every probe together, by one row and, of all setups, by more.
    pub(super) fn shifted(&self, setup: Option<usize>) -> Vec<Tried> {
        let most = if setup.is_none() { MOST_ROWS_LATE } else { 1 };
        (1..=most).flat_map(|by| self.late(setup, "the readings", &[0, 1, 2], by)).collect()
    }

    /// Some of the probes rows late or early.
    pub(super) fn late(&self, setup: Option<usize>, which: &str, probes: &[usize], by: usize) -> Vec<Tried> {
        let tried = self.late_rows(&self.points_of(setup), probes, by);
        tried.map(|(words, rows)| (format!("{which} {words}"), self.model.rms_mm(&rows))).into()
    }

    /// Those of some points.
    pub(super) fn late_rows(
        &self,
        own: &[usize],
        probes: &[usize],
        by: usize,
    ) -> [(String, DVector<f64>); 2] {
        let points = &self.experiment.points;
        let of = match (self.run.kind, by) {
            (RunKind::Static, 1) => "one pose".into(),
            (RunKind::Static, _) => format!("{by} poses"),
            _ if by == 1 => "one row".into(),
            _ => format!("{by} rows"),
        };
        let rows = if by == 1 { "one row".into() } else { format!("{by} rows") };
        let shifted = |earlier: bool| {
            self.changed_rows(|readings| {
                for (&first, &second) in own.iter().zip(own.iter().skip(by)) {
                    let (to, from) = if earlier { (first, second) } else { (second, first) };
                    probes.iter().for_each(|&probe| readings[to][probe] = points[from].reading_mm[probe]);
                }
            })
        };
        [
            (format!("shifted {rows} earlier: they are {of} late"), shifted(true)),
            (format!("shifted {rows} later: they are {of} early"), shifted(false)),
        ]
    }
}
