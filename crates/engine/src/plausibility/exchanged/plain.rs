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
        let tried = self.late_rows(setup, probes, by);
        tried.map(|(words, rows)| (format!("{which} {words}"), self.model.rms_mm(&rows))).into()
    }

    /// Those of one setup, or all. Where no row has what belongs to a pose, or one that no fit keeps, the others say it.
    pub(super) fn late_rows(
        &self,
        setup: Option<usize>,
        probes: &[usize],
        by: usize,
    ) -> [(String, DVector<f64>); 2] {
        let Looked { kept, setup: setups, .. } = self.looked;
        let own: Vec<usize> =
            (0..kept.len()).filter(|&at| setup.is_none_or(|setup| setups[at] == setup)).collect();
        // The number of each in the experiment.
        let mut count = 0;
        let number: Vec<Option<usize>> = kept
            .iter()
            .map(|&is_kept| {
                count += usize::from(is_kept);
                is_kept.then(|| count - 1)
            })
            .collect();
        let of = match (self.run.kind, by) {
            (RunKind::Static, 1) => "one pose".into(),
            (RunKind::Static, _) => format!("{by} poses"),
            _ if by == 1 => "one row".into(),
            _ => format!("{by} rows"),
        };
        let rows = if by == 1 { "one row".into() } else { format!("{by} rows") };
        let shifted = |earlier: bool| {
            let mut lost = Vec::new();
            let readings_mm = self.changed_rows(|readings| {
                for (k, to) in own.iter().enumerate().filter_map(|(k, &at)| Some((k, number[at]?))) {
                    let from = if earlier { Some(k + by) } else { k.checked_sub(by) };
                    let from = from.and_then(|from| number[*own.get(from)?]);
                    match from {
                        Some(from) => {
                            let other = &self.experiment.points[from].reading_mm;
                            probes.iter().for_each(|&probe| readings[to][probe] = other[probe]);
                        }
                        None => {
                            let rows = self.experiment.rows_of(to);
                            lost.extend(
                                probes
                                    .iter()
                                    .map(|probe| rows.start + probe)
                                    .filter(|row| rows.contains(row)),
                            );
                        }
                    }
                }
            });
            self.model.filled(&readings_mm, &lost)
        };
        [
            (format!("shifted {rows} earlier: they are {of} late"), shifted(true)),
            (format!("shifted {rows} later: they are {of} early"), shifted(false)),
        ]
    }
}
