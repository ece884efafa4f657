//! Readings that are rows late or early: each pose gets what another row holds.
//!
//! Rows are counted as the file has them. The first reading of a setup, in a file one row late, is one of the setup before, and no fit keeps it: it
//! has its place in the order all the same.

use super::{MOST_ROWS_LATE, Trial};
use crate::plausibility::fitted::Tried;
use crate::plausibility::looked::Looked;
use nalgebra::DVector;
use trunnion_cycles::RunKind;

impl Trial<'_> {
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
        let of = match (self.run.kind, by) {
            (RunKind::Static, 1) => "one pose".into(),
            (RunKind::Static, _) => format!("{by} poses"),
            _ if by == 1 => "one row".into(),
            _ => format!("{by} rows"),
        };
        let rows = if by == 1 { "one row".into() } else { format!("{by} rows") };
        let [earlier, later] = [by as isize, -(by as isize)].map(|by| self.shifted_rows(setup, probes, by));
        [
            (format!("shifted {rows} earlier: they are {of} late"), earlier),
            (format!("shifted {rows} later: they are {of} early"), later),
        ]
    }

    /// Every pose with what is read so many rows behind it.
    fn shifted_rows(&self, setup: Option<usize>, probes: &[usize], by: isize) -> DVector<f64> {
        let points = &self.experiment.points;
        let mut lost = Vec::new();
        let readings_mm = self.changed_rows(|readings| {
            for (to, from) in self.behind(setup, by) {
                match from {
                    Some(from) => {
                        probes.iter().for_each(|&probe| readings[to][probe] = points[from].reading_mm[probe]);
                    }
                    None => {
                        let rows = self.experiment.rows_of(to);
                        let of_probes = probes.iter().map(|probe| rows.start + probe);
                        lost.extend(of_probes.filter(|row| rows.contains(row)));
                    }
                }
            }
        });
        self.model.filled(&readings_mm, &lost)
    }

    /// Every point of the experiment with the one so many rows behind it in its setup, or in all; `None` where no fit keeps that, or there is none.
    pub(super) fn behind(&self, setup: Option<usize>, by: isize) -> Vec<(usize, Option<usize>)> {
        let Looked { kept, setup: setups, .. } = self.looked;
        let own = (0..kept.len()).filter(|&at| setup.is_none_or(|setup| setups[at] == setup));
        let own: Vec<usize> = own.collect();
        let mut count = 0;
        let mut next = || {
            count += 1;
            count - 1
        };
        let number: Vec<Option<usize>> = kept.iter().map(|is_kept| is_kept.then(&mut next)).collect();
        let pair = |(k, at): (usize, &usize)| {
            let other = k.checked_add_signed(by).and_then(|k| own.get(k));
            Some((number[*at]?, other.and_then(|&at| number[at])))
        };
        own.iter().enumerate().filter_map(pair).collect()
    }
}
