//! Mistakes between readings and positions, each tried: the base model is fitted to the readings as they are and with the mistake undone.

mod at_a_point;
mod axes;
pub(super) mod delayed;
mod late;
mod mirror;
mod parts;
mod physics;
pub(super) mod plain;
mod reordered;
pub(super) mod repeated;
mod scaled;
pub(super) mod small;
mod turned;
mod turning;
mod unsettled;
mod unsigned;

use super::fitted::{Fitted, Tried};
use super::found::Implausible;
use super::looked::Looked;
use crate::Experiment;
use crate::fit::identification::Repeatability;
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
pub(super) const AS_GOOD: f64 = 1.25;
/// With the mistake undone the base model alone leaves so many times less, where another effect has to be in the model for the mistake to be
/// believed: it explains at least as much as all else, in mean square. Else readings that hold little but that effect may be exchanged at will,
/// and one way of exchanging them looks like an effect of the catalogue.
const MOSTLY: f64 = std::f64::consts::SQRT_2;
/// An error motion that every rotary axis has a little of is believed instead of a mistake that leaves as little, unless it would be larger than
/// this, µm rms over all readings. A judgement: a table that runs out by 25 µm is seen without a measurement. What the second simulator hides
/// leaves 8.4 µm at most (50 runs looked at).
const LARGEST_NATURAL_UM: f64 = 8.0;
/// Standard deviations by which what is left may exceed what readings repeat within.
const SURE: f64 = 3.0;
/// Rows by which readings may be late; more are another measurement.
const MOST_ROWS_LATE: usize = 5;

/// What to do about a mistake that is undone in the file.
const CHANGE: &str = "Change it?";
/// And about rows of another state of the machine, which are right as they are.
const APART: &str = "Change none of these rows: take them out and import them as a run of their own, or measure the cycle again in one state.";
/// And about readings that did not wait for the probes: the settled ones are nowhere in the file.
const DWELL: &str = "Measure again with a longer dwell.";

/// The mistake with which readings and positions belong together; of a machine that lacks another effect too, next to whichever effect of one
/// axis leaves the least.
pub(super) fn exchanged(looked: &Looked) -> Option<Implausible> {
    let before_um = um_from_mm(looked.left_mm);
    if before_um < gross_um(looked) || variation_um(&looked.run) < GROSS_UM {
        return None;
    }
    believed(looked, BELIEVED, |trial| trial.all(before_um >= GROSS_UM))
}

fn gross_um(looked: &Looked) -> f64 {
    let repeated_um = looked.repeated().map(|of| um_from_mm(of.sigma_mm));
    repeated_um.map_or(GROSS_UM, |repeated_um| GROSS_UM.min(GROSS_REPEATABILITIES * repeated_um))
}

/// The mistake that is believed of those `tried`, next to the base model, then next to one more effect; `divided`: by how much undoing it has to
/// divide what the model leaves.
fn believed(
    looked: &Looked,
    divided: f64,
    tried: impl Fn(&Trial<'_>) -> Vec<(Tried, &'static str)>,
) -> Option<Implausible> {
    let alone = Trial::of(looked);
    let of_alone = tried(&alone);
    let mostly = of_alone.iter().filter(|((_, left_mm), _)| MOSTLY * left_mm < looked.left_mm);
    let mostly: Vec<String> = mostly.map(|((words, _), _)| words.clone()).collect();
    alone.believed(of_alone, divided, "").or_else(|| {
        let is_one = |((words, _), _): &(Tried, &str)| mostly.contains(words);
        // Of good runs there is none, which saves the time of trying all again.
        let model = &(!mostly.is_empty()).then(|| looked.model.with_an_effect(&looked.experiment))?;
        let with_effect = Trial { model, ..alone };
        let of_both = tried(&with_effect).into_iter().filter(is_one).collect();
        with_effect.believed(of_both, divided, ", and one more effect of an axis")
    })
}

/// Readings that are not gross, and do not fit their positions as well as they repeat: before and with the mistake undone, mm.
fn unfit(
    run: &Run,
    repeated: &Repeatability,
    before_mm: f64,
    (mistake, left_mm): Tried,
    to_do: &str,
) -> Implausible {
    let [before_um, left_um, repeat_um] = [before_mm, left_mm, repeated.sigma_mm].map(um_from_mm);
    Implausible {
        finding: format!(
            "{}: the readings do not fit their positions: {before_um:.2} µm rms are left, and they repeat within {repeat_um:.2} µm.",
            run.name
        ),
        hypothesis: format!("With {mistake}, {left_um:.2} µm are left. {to_do}"),
        rms_um_with_it: Some(left_um),
    }
}

/// Whether what is left is no more than readings repeat: it exceeds that by no more than so many standard deviations of it.
fn fits(repeated: &Repeatability, left_mm: f64) -> bool {
    // The variance of so many repeats has the relative standard deviation √(2/ν) [normal distribution].
    let chance = SURE * (2.0 / repeated.degrees_of_freedom.max(1) as f64).sqrt();
    left_mm.powi(2) <= repeated.sigma_mm.powi(2) * (1.0 + chance)
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

impl<'a> Trial<'a> {
    /// With the base model alone.
    fn of(looked: &'a Looked<'a>) -> Self {
        Self { looked, run: &looked.run, experiment: &looked.experiment, model: &looked.model }
    }

    /// The mistake of those `tried` that is believed; `next_to`: what else the model of the trial has, in words.
    fn believed(
        &self,
        tried: Vec<(Tried, &'static str)>,
        divided: f64,
        next_to: &str,
    ) -> Option<Implausible> {
        let before_um = um_from_mm(self.looked.left_mm);
        let as_given_mm = self.model.rms_mm(&self.experiment.readings_mm());
        let least_mm = tried.iter().map(|((_, left_mm), _)| *left_mm).fold(f64::INFINITY, f64::min);
        let ((mistake, left_mm), to_do) =
            tried.into_iter().find(|((_, left_mm), _)| *left_mm <= AS_GOOD * least_mm)?;
        let left_um = um_from_mm(left_mm);
        let is_alone = self.of_an_effect_mm() > AS_GOOD * left_mm;
        let is_too_large =
            || before_um > LARGEST_NATURAL_UM && self.of_a_large_effect_mm() > AS_GOOD * left_mm;
        let is_believed = divided * left_mm < as_given_mm && (is_alone || is_too_large());
        is_believed.then(|| {
            let mut hypothesis = match (self.mirror(AS_GOOD * least_mm), self.looked.repeated()) {
                // What is left is gross itself: it would be doubted again.
                (_, Some(of)) if left_um >= gross_um(self.looked) => {
                    let repeats_um = um_from_mm(of.sigma_mm);
                    format!(
                        "With {mistake}{next_to}, {left_um:.1} µm are left, and readings of one pose repeat within {repeats_um:.2} µm: no full explanation. \
                         Look for another mistake, alone or with it, before you change anything."
                    )
                }
                (Some((mirror, distinguished_by)), _) => {
                    format!("With {mistake}, or {mirror}{next_to}, {left_um:.1} µm are left. {distinguished_by}")
                }
                (None, _) => format!("With {mistake}{next_to}, {left_um:.1} µm are left. {to_do}"),
            };
            if !is_alone {
                hypothesis +=
                    " An error motion of a rotary axis leaves as little, but no machine has one so large: rule the mistake out first.";
            }
            Implausible {
                finding: format!(
                    "{}: the readings do not fit their positions: {before_um:.1} µm rms are left.",
                    self.run.name
                ),
                hypothesis,
                rms_um_with_it: Some(left_um),
            }
        })
    }

    /// Whether three probes read the ball in every setup.
    fn has_three(&self) -> bool {
        self.run.setups.iter().all(|setup| setup.instrument.components().len() == 3)
    }

    /// Every mistake with what to do, the simpler ones first; of all readings, then, where asked for, of those of one setup or part.
    fn all(&self, of_setups: bool) -> Vec<(Tried, &'static str)> {
        let setups = &self.run.setups;
        let (has_three, is_static) = (self.has_three(), self.run.kind == RunKind::Static);
        let mut tried: Vec<(Tried, &str)> = Vec::new();
        let mut add = |to_do, all: Vec<Tried>| tried.extend(all.into_iter().map(|one| (one, to_do)));
        add(CHANGE, self.plain());
        if is_static && has_three {
            add(CHANGE, self.of_probes_late());
            add(DWELL, self.unsettled().into_iter().collect());
            add(CHANGE, vec![self.added_up()]);
        }
        if has_three {
            add(CHANGE, self.absolute());
            add(CHANGE, self.unsigned(None).into_iter().collect());
            add(CHANGE, self.other_side(None).into_iter().collect());
            add(CHANGE, self.probes_scaled());
            add(CHANGE, self.turned(None));
            add(CHANGE, self.inclined());
            add(CHANGE, self.turning());
        }
        if of_setups && setups.len() > 1 {
            (0..setups.len()).for_each(|setup| add(CHANGE, self.of_setup(setup, has_three)));
        }
        if has_three {
            add(CHANGE, self.changed_at_a_point());
            add(CHANGE, self.changed_between_points());
        }
        // What a correction leaves of a lean of the tool differs with the length of the tool, so with the setup.
        if has_three && of_setups {
            add(APART, self.of_parts());
        }
        // One channel says too little of an order.
        if has_three {
            add(CHANGE, self.reordered().into_iter().collect());
        }
        tried
    }

    /// Each probe alone one row late or early.
    fn of_probes_late(&self) -> Vec<Tried> {
        let probes = PROBES.iter().enumerate();
        probes
            .flat_map(|(probe, name)| self.late(None, &format!("the readings {name}"), &[probe], 1))
            .collect()
    }

    /// In one setup, and with one before it.
    fn of_setup(&self, setup: usize, has_three: bool) -> Vec<Tried> {
        let name = &self.run.setups[setup].name;
        let of = |(words, left_mm): Tried| (format!("{words} (setup {name} alone)"), left_mm);
        let mut tried = Vec::new();
        if has_three {
            tried.extend(
                ways()
                    .iter()
                    .map(|way| of((way.words(), self.changed_mm(Some(setup), |reading| way.apply(reading))))),
            );
        }
        if self.run.kind == RunKind::Static {
            tried.extend(self.shifted(Some(setup)).into_iter().map(of));
        }
        if has_three {
            tried.extend(self.other_side(Some(setup)).map(of));
            tried.extend(self.setup_scaled(setup));
            tried.extend(self.unsigned(Some(setup)).map(of));
            tried.extend(self.turned(Some(setup)).into_iter().map(of));
        }
        tried.extend((0..setup).filter_map(|other| self.of_setups_exchanged(other, setup)));
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
