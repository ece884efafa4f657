//! Mistakes between readings and positions, each tried: the base model is fitted to the readings as they are and with the mistake undone.

mod at_a_point;
mod axes;
pub(super) mod delayed;
mod mirror;
mod parts;
mod physics;
mod reordered;
mod scaled;
mod turned;
mod turning;
mod unsettled;
mod unsigned;

use super::fitted::{Fitted, Tried};
use super::found::Implausible;
use super::looked::Looked;
use crate::Experiment;
use crate::noise::repeatability::repeatability;
use crate::problem::passes::passes;
use axes::{PROBES, ways};
use nalgebra::DVector;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{Joint, NestSide};
use trunnion_cycles::{Run, RunKind};

/// A mistake is believed where undoing it divides what the model leaves by this: mean square by nine, which no effect that
/// resembles the mistake reaches by chance where dozens of readings are left.
pub(super) const BELIEVED: f64 = 3.0;
/// Below this nothing is gross, µm rms. Of readings that vary by more, what is left of them is gross from so many repeatabilities on, where
/// these are known and finer: but not as a mistake of one setup alone, which a lean of the tool, left by a correction, resembles.
pub(super) const GROSS_UM: f64 = 2.0;
const GROSS_REPEATABILITIES: f64 = 5.0;
/// What leaves no more than this times the least explains as much: the simpler mistake, tried first, is named. A free angle takes up a
/// little of every effect.
const AS_GOOD: f64 = 1.25;
/// Rows by which readings may be late; more are another measurement.
const MOST_ROWS_LATE: usize = 5;

/// The mistake with which readings and positions belong together.
pub(super) fn exchanged(looked: &Looked) -> Option<Implausible> {
    let Looked { run, experiment, model, .. } = looked;
    let before_um = um_from_mm(model.rms_mm(&experiment.readings_mm()));
    let repeated = repeatability(experiment, &passes(experiment));
    let gross_um =
        repeated.map_or(GROSS_UM, |of| GROSS_UM.min(GROSS_REPEATABILITIES * um_from_mm(of.sigma_mm)));
    if before_um < gross_um || variation_um(run) < GROSS_UM {
        return None;
    }
    let trial = Trial { looked, run, experiment, model };
    let tried = trial.all(before_um >= GROSS_UM);
    let least_mm = tried.iter().map(|(_, left_mm)| *left_mm).fold(f64::INFINITY, f64::min);
    let (mistake, left_mm) = tried.into_iter().find(|(_, left_mm)| *left_mm <= AS_GOOD * least_mm)?;
    let left_um = um_from_mm(left_mm);
    let is_believed = BELIEVED * left_um < before_um && trial.of_an_axis_mm() > AS_GOOD * left_mm;
    is_believed.then(|| {
        let hypothesis = match (trial.mirror(AS_GOOD * least_mm), repeated) {
            // What is left is gross itself: it would be doubted again.
            (_, Some(of)) if left_um >= gross_um => {
                let repeats_um = um_from_mm(of.sigma_mm);
                format!(
                    "With {mistake}, {left_um:.1} µm are left, and readings of one pose repeat within {repeats_um:.2} µm: no full explanation. \
                     Look for another mistake, alone or with it, before you change anything."
                )
            }
            (Some((mirror, told_apart)), _) => {
                format!("With {mistake}, or {mirror}, {left_um:.1} µm are left. {told_apart}")
            }
            (None, _) => format!("With {mistake}, {left_um:.1} µm are left. Change it?"),
        };
        Implausible {
            finding: format!(
                "{}: the readings do not fit their positions: {before_um:.1} µm rms are left.",
                run.name
            ),
            hypothesis,
            rms_um_with_it: Some(left_um),
        }
    })
}

/// Scatter of the readings of each channel of a setup about their mean, rms, µm.
fn variation_um(run: &Run) -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for setup in 0..run.setups.len() {
        let own: Vec<[f64; 3]> = run
            .good_points()
            .filter(|point| point.state.setup == setup)
            .map(|point| point.reading_mm)
            .collect();
        for channel in 0..run.setups[setup].instrument.components().len() {
            let mean = own.iter().map(|reading| reading[channel]).sum::<f64>() / own.len().max(1) as f64;
            squares += own.iter().map(|reading| (reading[channel] - mean).powi(2)).sum::<f64>();
            count += own.len();
        }
    }
    um_from_mm((squares / count.max(1) as f64).sqrt())
}

struct Trial<'a> {
    looked: &'a Looked<'a>,
    run: &'a Run,
    experiment: &'a Experiment,
    model: &'a Fitted,
}

impl Trial<'_> {
    /// Every mistake, the simpler ones first; of all readings, then, where asked for, of those of one setup or part.
    fn all(&self, of_setups: bool) -> Vec<Tried> {
        let setups = &self.run.setups;
        let has_three = setups.iter().all(|setup| setup.instrument.components().len() == 3);
        let each: Vec<usize> =
            if of_setups && setups.len() > 1 { (0..setups.len()).collect() } else { Vec::new() };
        let mut tried = Vec::new();
        if has_three {
            tried.extend(
                ways()
                    .iter()
                    .filter(|way| way.is_first_of_two())
                    .map(|way| (way.words_of_all(), self.changed_mm(None, |reading| way.apply(reading)))),
            );
        }
        if self.run.kind == RunKind::Static {
            tried.extend(self.shifted(None));
        }
        if self.run.kind == RunKind::Static && has_three {
            tried.extend(
                PROBES
                    .iter()
                    .enumerate()
                    .flat_map(|(probe, name)| self.late(None, &format!("the readings {name}"), &[probe], 1)),
            );
        }
        if self.run.kind == RunKind::Static && has_three {
            tried.extend(self.unsettled());
            tried.push(self.added_up());
        }
        if has_three {
            tried.extend(self.absolute());
            tried.extend(self.unsigned(None));
            tried.extend(self.other_side(None));
            tried.extend(self.probes_scaled());
            tried.extend(self.turned(None));
            tried.extend(self.inclined());
            tried.extend(self.turning());
        }
        for setup in each {
            let of = |words: String| format!("{words} (setup {} alone)", setups[setup].name);
            if has_three {
                tried.extend(ways().iter().map(|way| {
                    (of(way.words()), self.changed_mm(Some(setup), |reading| way.apply(reading)))
                }));
            }
            if self.run.kind == RunKind::Static {
                tried.extend(self.shifted(Some(setup)).into_iter().map(|(words, left)| (of(words), left)));
            }
            if has_three {
                tried.extend(self.other_side(Some(setup)).map(|(words, left)| (of(words), left)));
                tried.extend(self.setup_scaled(setup));
                tried.extend(self.unsigned(Some(setup)).map(|(words, left)| (of(words), left)));
                tried.extend(self.turned(Some(setup)).into_iter().map(|(words, left)| (of(words), left)));
            }
            tried.extend((0..setup).filter_map(|other| self.of_setups_exchanged(other, setup)));
        }
        if has_three {
            tried.extend(self.changed_at_a_point());
            tried.extend(self.late_between_points());
        }
        // What a correction leaves of a lean of the tool differs with the length of the tool, so with the setup.
        if has_three && of_setups {
            tried.extend(self.of_parts());
        }
        // One channel says too little of an order.
        if has_three {
            tried.extend(self.reordered());
        }
        tried
    }

    /// Of one setup, or all.
    fn points_of(&self, setup: Option<usize>) -> Vec<usize> {
        let points = &self.experiment.points;
        let own = |at: &usize| setup.is_none_or(|setup| points[*at].state.setup == setup);
        (0..points.len()).filter(own).collect()
    }

    fn changed_mm(&self, setup: Option<usize>, change: impl Fn(&mut [f64; 3])) -> f64 {
        let own = self.points_of(setup);
        self.left_mm(|readings| own.iter().for_each(|&at| change(&mut readings[at])))
    }

    fn left_mm(&self, change: impl FnOnce(&mut [[f64; 3]])) -> f64 {
        self.model.rms_mm(&self.changed_rows(change))
    }

    fn changed_rows(&self, change: impl FnOnce(&mut [[f64; 3]])) -> DVector<f64> {
        let points = &self.experiment.points;
        let mut readings: Vec<[f64; 3]> = points.iter().map(|point| point.reading_mm).collect();
        change(&mut readings);
        let mut rows = DVector::zeros(self.experiment.rows());
        for (at, reading) in readings.iter().enumerate() {
            let own = self.experiment.rows_of(at);
            own.zip(reading).for_each(|(row, value)| rows[row] = *value);
        }
        rows
    }

    /// Of every probe together, by one row and, of all setups, by more.
    fn shifted(&self, setup: Option<usize>) -> Vec<Tried> {
        let most = if setup.is_none() { MOST_ROWS_LATE } else { 1 };
        (1..=most).flat_map(|by| self.late(setup, "the readings", &[0, 1, 2], by)).collect()
    }

    /// Some of the probes rows late or early.
    fn late(&self, setup: Option<usize>, which: &str, probes: &[usize], by: usize) -> Vec<Tried> {
        let tried = self.late_rows(&self.points_of(setup), probes, by);
        tried.map(|(words, rows)| (format!("{which} {words}"), self.model.rms_mm(&rows))).into()
    }

    /// Those of some points.
    fn late_rows(&self, own: &[usize], probes: &[usize], by: usize) -> [(String, DVector<f64>); 2] {
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

    /// Readings relative to the row before.
    fn added_up(&self) -> Tried {
        let points = &self.experiment.points;
        let left_mm = self.left_mm(|readings| {
            for at in 1..points.len() {
                if points[at].state.setup == points[at - 1].state.setup {
                    let before = readings[at - 1];
                    readings[at].iter_mut().zip(before).for_each(|(value, before)| *value += before);
                }
            }
        });
        ("the readings added up from row to row: each is relative to the one before".into(), left_mm)
    }

    /// The readings of two setups of as many points.
    fn of_setups_exchanged(&self, a: usize, b: usize) -> Option<Tried> {
        let [of_a, of_b] = [a, b].map(|setup| self.points_of(Some(setup)));
        let names = [a, b].map(|setup| self.run.setups[setup].name.as_str());
        (of_a.len() == of_b.len()).then(|| {
            let left_mm = self.left_mm(|readings| {
                of_a.iter().zip(&of_b).for_each(|(&a, &b)| readings.swap(a, b));
            });
            (format!("the readings of the setups {} and {} exchanged", names[0], names[1]), left_mm)
        })
    }

    /// Readings that hold the positions of the linear axes.
    fn absolute(&self) -> Vec<Tried> {
        let joints = [Joint::X, Joint::Y, Joint::Z];
        let has = self.experiment.machine().linear_joints();
        if joints.iter().any(|joint| !has.contains(joint)) {
            return Vec::new();
        }
        let without = |sign: f64| {
            self.left_mm(|readings| {
                for (reading, point) in readings.iter_mut().zip(&self.experiment.points) {
                    reading
                        .iter_mut()
                        .zip(joints)
                        .for_each(|(value, joint)| *value -= sign * point.state.position[joint]);
                }
            })
        };
        let words = "the positions of X, Y and Z taken off the readings: they are no deviations";
        vec![(words.into(), without(1.0)), (format!("{words}, with the opposite sign"), without(-1.0))]
    }

    /// The nest of one setup, or all, on the other side.
    fn other_side(&self, setup: Option<usize>) -> Option<Tried> {
        let mut other = self.run.clone();
        for (k, setup_k) in other.setups.iter_mut().enumerate() {
            if setup.is_none_or(|setup| setup == k) {
                setup_k.nest =
                    if setup_k.nest == NestSide::Table { NestSide::Spindle } else { NestSide::Table };
            }
        }
        let is_table = other.setups[setup.unwrap_or(0)].nest == NestSide::Table;
        let side = if is_table { "on the table" } else { "at the spindle" };
        let other = Experiment::of_points(&[other]).ok()?;
        let left_mm = Fitted::new(&other)?.rms_mm(&self.experiment.readings_mm());
        Some((format!("the nest {side}, not on the other side"), left_mm))
    }
}
