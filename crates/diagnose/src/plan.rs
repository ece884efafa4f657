//! What to measure next: the cycle that tells rival effects apart, per minute of machine time (DIAGNOSIS §6).
//!
//! Rivals are effects that the data cannot tell apart, or that the present cycle cannot see at all. Candidate cycles are made
//! from the machine and the present setups (`candidates`); for each the states it visits, the columns of rivals and model there
//! together with the present data (same location errors, ball mounted anew), whitened under a few noise models (`survey`),
//! and from these the expected ln Bayes factor of every two rivals: T-optimality (`separation`). Cycles that tell every pair
//! apart come first, then those that separate the pairs farthest on average, per minute.
//! Limits: linear in small errors; the noise stays what it is; nothing is charged for the number of parameters.

mod answer;
mod candidates;
mod present;
mod preview;
mod separation;
mod survey;
mod wanted;

pub use answer::{Considered, LeftOpen, Plan};
pub use preview::{Alias, Preview, preview};
pub use wanted::{Rivals, rivals_named, wanted};

use candidates::{Candidate, candidates};
use nalgebra::DVector;
use present::Present;
use separation::{Known, expected_ln, with_unknown_noise};
use std::ops::Range;
use survey::{Part, Survey, typical_size};
use trunnion_effects::{Instance, Model, ModelEffect, Scene, UnknownEffect};
use trunnion_identify::{Experiment, ExperimentError, IdentifyError};
use trunnion_machine::State;
use trunnion_measurement::cycle::{Motion, Pace, VisitError};
use trunnion_measurement::{Cycle, RunKind, Setup};

/// What a plan may assume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How fast the machine goes about a cycle.
    pub pace: Pace,
    /// ln of the Bayes factor that counts as separated.
    pub separated_ln: f64,
    /// Points of each run that take part; more are thinned evenly.
    pub most_points: usize,
}

impl Default for Options {
    /// A factor of a thousand separates.
    fn default() -> Self {
        Self { pace: Pace::default(), separated_ln: 1000f64.ln(), most_points: 600 }
    }
}

/// Beyond this ln of the Bayes factor more is of no use.
const ENOUGH_LN: f64 = 20.0;
/// Below this ln no cycle is worth its time.
const HOPELESS_LN: f64 = 3.0;
/// Shapes of a rival that may imitate another one.
const MOST_SHAPES: usize = 12;
/// The same where many effects are compared.
const FEW_SHAPES: usize = 3;

/// Why a plan was not possible.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The model does not fit the data.
    #[error("the model cannot be fitted to the present runs")]
    Fit(#[from] IdentifyError),
    /// An effect this machine cannot have.
    #[error("a rival cannot be placed on this machine")]
    Rival(#[from] UnknownEffect),
    /// Runs and next cycle do not go together.
    #[error("the next cycle cannot be put together with the present runs")]
    Experiment(#[from] ExperimentError),
    /// A cycle the machine cannot run.
    #[error("the cycle cannot be run")]
    Visit(#[from] VisitError),
    /// The model holds one of the rivals already.
    #[error("the model holds {effect} already, so nothing is left to tell from it; name effects it lacks")]
    InModel {
        /// Effect id.
        effect: String,
    },
    /// Fewer than two.
    #[error("nothing to compare; name two or more effects with --rivals")]
    NoRivals,
}

/// Chooses the next cycle.
///
/// # Errors
/// A model or rival that does not fit machine or data.
pub fn plan(
    experiment: &Experiment,
    model: &Model,
    rivals: &Rivals,
    options: &Options,
) -> Result<Plan, PlanError> {
    let entries = rivals.entries();
    if let Some(entry) = entries.iter().find(|entry| model.effects.iter().any(|own| own.id == entry.id)) {
        return Err(PlanError::InModel { effect: entry.id.clone() });
    }
    if entries.is_empty() || (matches!(rivals, Rivals::Separate(_)) && entries.len() < 2) {
        return Err(PlanError::NoRivals);
    }
    let machine = experiment.machine();
    let instances: Vec<Instance> = entries
        .iter()
        .map(|entry| Instance::from_model_effect(entry, machine))
        .collect::<Result<_, UnknownEffect>>()?;
    let present = Present::new(experiment, model, options.most_points)?;
    let (entries, instances) = credible(&present.experiment, rivals, entries, instances);
    let (entries, instances) = (&entries[..], instances);
    let most_shapes = if entries.len() > 4 { FEW_SHAPES } else { MOST_SHAPES };
    let separated_ln = options.separated_ln.min(ENOUGH_LN);
    let desk = Desk { present: &present, entries, instances: &instances, rivals, most_shapes, separated_ln };
    let knowledge = desk.knowledge();
    let before = desk.value(&present.experiment, &knowledge);

    let again = desk.again(&knowledge, options)?;
    let states = present.last_states();
    let mut considered = vec![again];
    for candidate in candidates(machine, present.last_setups(), &states, &options.pace) {
        considered.extend(desk.consider(&candidate, &knowledge, options)?);
    }
    Ok(answer::answer(&desk, &before, considered, options))
}

/// Without the rivals that move nothing in the present data at any credible size: they explain nothing there.
fn credible(
    present: &Experiment,
    rivals: &Rivals,
    entries: &[ModelEffect],
    instances: Vec<Instance>,
) -> (Vec<ModelEffect>, Vec<Instance>) {
    let moves = |instance: &Instance| {
        let shapes = instance.shapes(&present.scene).grid;
        let shape = shapes.into_iter().next().unwrap_or_default();
        let columns = Part { instance, shape }.columns(present);
        columns.is_empty() || columns.amax() > 0.0
    };
    let all = || entries.iter().cloned().zip(instances.iter().cloned());
    let kept: Vec<_> = all().filter(|(_, instance)| moves(instance)).collect();
    match rivals {
        Rivals::Separate(_) if kept.len() > 1 => kept.into_iter().unzip(),
        _ => all().unzip(),
    }
}

/// Everything that stays the same for all candidates.
struct Desk<'a> {
    present: &'a Present,
    entries: &'a [ModelEffect],
    instances: &'a [Instance],
    rivals: &'a Rivals,
    most_shapes: usize,
    separated_ln: f64,
}

/// What the present data say of the rivals.
struct Knowledge {
    /// Best shape of each rival.
    shapes: Vec<Vec<f64>>,
    /// For each noise model how much worse than the best it explains the present data (ln), and its variance.
    noises: Vec<(f64, f64)>,
    /// For each rival and noise model: parameter names, values and precision; `None` where the data do not show it.
    fitted: Vec<Option<Fitted>>,
}

struct Fitted {
    names: Vec<String>,
    /// Values and precision for each noise model.
    by_noise: Vec<(DVector<f64>, nalgebra::DMatrix<f64>)>,
}

/// Expected ln Bayes factors in one situation.
#[derive(Clone, Debug)]
struct Value {
    /// Of each rival against nothing.
    seen_ln: Vec<f64>,
    /// `against_ln[a][b]`: of rival a, if it is the truth, against rival b.
    against_ln: Vec<Vec<f64>>,
}

impl Value {
    /// ln by which a rival is told from all others and from nothing.
    fn told_ln(&self, rival: usize) -> f64 {
        self.against_ln[rival].iter().copied().fold(self.seen_ln[rival], f64::min)
    }

    /// Every two rivals with the ln by which they are told apart, whichever is the truth.
    fn pairs(&self) -> Vec<(usize, usize, f64)> {
        let rivals = self.seen_ln.len();
        let ln = |a: usize, b: usize| self.against_ln[a][b].min(self.against_ln[b][a]);
        (0..rivals)
            .flat_map(|a| (a + 1..rivals).map(move |b| (a, b)))
            .map(|(a, b)| (a, b, ln(a, b)))
            .collect()
    }
}

/// The parts of a survey that belong to one rival: the chosen shape first, then others it may take.
struct Shaped<'a> {
    parts: Vec<Part<'a>>,
    of_rival: Vec<Range<usize>>,
}

impl Desk<'_> {
    fn ids(&self) -> Vec<String> {
        self.entries.iter().map(|entry| entry.id.clone()).collect()
    }

    fn shaped(&self, scene: &Scene, chosen: Option<&[Vec<f64>]>) -> Shaped<'_> {
        let (mut parts, mut of_rival) = (Vec::new(), Vec::new());
        for (i, (instance, entry)) in self.instances.iter().zip(self.entries).enumerate() {
            let mut shapes: Vec<Vec<f64>> = Vec::new();
            match chosen.map(|chosen| &chosen[i]) {
                Some(shape) => shapes.push(shape.clone()),
                None if !entry.shape.is_empty() => shapes.push(entry.shape.clone()),
                None => {}
            }
            let grid = instance.shapes(scene).grid;
            let most = if chosen.is_none() { grid.len() } else { self.most_shapes };
            let stride = grid.len().div_ceil(most.max(1)).max(1);
            for shape in grid.into_iter().skip(stride / 2).step_by(stride) {
                if !shapes.contains(&shape) {
                    shapes.push(shape);
                }
            }
            let first = parts.len();
            parts.extend(shapes.into_iter().map(|shape| Part { instance, shape }));
            of_rival.push(first..parts.len());
        }
        Shaped { parts, of_rival }
    }

    /// Shapes, values, noise from the present data.
    fn knowledge(&self) -> Knowledge {
        let experiment = &self.present.experiment;
        let shaped = self.shaped(&experiment.scene, None);
        let model = self.present.model_columns(experiment);
        let survey = Survey::new(experiment, &model, &shaped.parts, Some(&self.present.residual_mm));
        let best_of = |rival: &Range<usize>| {
            let gain = |p: usize| survey.views.iter().map(|v| v.explained(&survey.parts[p])).sum::<f64>();
            rival.clone().max_by(|&a, &b| gain(a).total_cmp(&gain(b)))
        };
        let best: Vec<Option<usize>> = shaped.of_rival.iter().map(best_of).collect();
        let shapes = best.iter().enumerate().map(|(i, part)| match part {
            // A rival the present scene cannot have takes its first shape.
            None => self.entries[i].shape.clone(),
            Some(p) => shaped.parts[*p].shape.clone(),
        });
        let mut noises: Vec<(f64, f64)> = survey
            .views
            .iter()
            .map(|view| {
                let gain =
                    best.iter().flatten().map(|&p| view.explained(&survey.parts[p])).fold(0.0, f64::max);
                let left = (view.readings_squared() - gain).max(1e-18);
                let freedom = (survey.rows as f64 - view.rank as f64 - 4.0).max(1.0);
                (-0.5 * view.log_det - 0.5 * freedom * left.ln(), left / freedom)
            })
            .collect();
        let top = noises.iter().map(|(ln, _)| *ln).fold(f64::NEG_INFINITY, f64::max);
        for (ln, _) in &mut noises {
            *ln = top - *ln;
        }
        let fitted = best.iter().enumerate().map(|(i, part)| {
            let range = &survey.parts[(*part)?];
            let by_noise: Vec<_> = survey
                .views
                .iter()
                .zip(&noises)
                .map(|(view, (_, variance))| (view.values(range), view.between(range, range) / *variance))
                .collect();
            let shown = by_noise.iter().all(|(values, precision)| Known::is_significant(values, precision));
            let parameters = self.instances[i].parameters(&experiment.scene);
            let names = parameters.into_iter().map(|parameter| parameter.name).collect();
            shown.then_some(Fitted { names, by_noise })
        });
        let fitted = match self.rivals {
            Rivals::Separate(_) => fitted.collect(),
            // What cannot be seen has no values worth keeping.
            Rivals::Reveal(_) => self.entries.iter().map(|_| None).collect(),
        };
        Knowledge { shapes: shapes.collect(), noises, fitted }
    }

    /// What an experiment would tell.
    fn value(&self, experiment: &Experiment, knowledge: &Knowledge) -> Value {
        let shaped = self.shaped(&experiment.scene, Some(&knowledge.shapes));
        let model = self.present.model_columns(experiment);
        let survey = Survey::new(experiment, &model, &shaped.parts, None);
        let rivals = 0..self.instances.len();
        let nothing = vec![f64::INFINITY; rivals.len()];
        let mut value = Value { seen_ln: vec![0.0; rivals.len()], against_ln: vec![nothing; rivals.len()] };
        for a in rivals.clone() {
            let own = survey.parts.get(shaped.of_rival[a].start).filter(|_| !shaped.of_rival[a].is_empty());
            let own = own.filter(|own| !own.is_empty());
            // A rival may take refuge in another noise model, at the price of explaining the present data worse with it.
            let least = |own: &Range<usize>, other: Option<&Range<usize>>| -> f64 {
                let one = |m: usize| {
                    let (price_ln, variance) = knowledge.noises[m];
                    let view = &survey.views[m];
                    let left = view.left_by(own, other) / variance;
                    let ln = expected_ln(&left, &self.known(a, m, knowledge, &experiment.scene));
                    price_ln + with_unknown_noise(ln, survey.rows.saturating_sub(view.rank))
                };
                (0..survey.views.len()).map(one).fold(f64::INFINITY, f64::min)
            };
            value.seen_ln[a] = own.map_or(0.0, |own| least(own, None));
            for b in rivals.clone().filter(|&b| b != a) {
                let parts = shaped.of_rival[b].clone();
                let against = |own| {
                    parts.map(|part| least(own, Some(&survey.parts[part]))).fold(value.seen_ln[a], f64::min)
                };
                value.against_ln[a][b] = own.map_or(0.0, against);
            }
        }
        value
    }

    /// What is known of a rival's parameters, in the order the scene gives them.
    fn known(&self, rival: usize, noise: usize, knowledge: &Knowledge, scene: &Scene) -> Known {
        let parameters = self.instances[rival].parameters(scene);
        let Some(fitted) = &knowledge.fitted[rival] else {
            let sizes = parameters.iter().map(|p| typical_size(p.unit));
            return Known::Typical(DVector::from_iterator(parameters.len(), sizes));
        };
        let (values, precision) = &fitted.by_noise[noise];
        let from: Vec<Option<usize>> =
            parameters.iter().map(|p| fitted.names.iter().position(|name| *name == p.name)).collect();
        let n = parameters.len();
        Known::Fitted(
            DVector::from_fn(n, |i, _| from[i].map_or(0.0, |k| values[k])),
            nalgebra::DMatrix::from_fn(n, n, |i, j| match (from[i], from[j]) {
                (Some(k), Some(l)) => precision[(k, l)],
                _ => 0.0,
            }),
        )
    }

    /// One candidate cycle; `None` when the machine cannot run it.
    fn consider(
        &self,
        candidate: &Candidate,
        knowledge: &Knowledge,
        options: &Options,
    ) -> Result<Option<Considered>, PlanError> {
        let cycle = &candidate.cycle;
        let machine = self.present.experiment.machine();
        let Ok(visits) = cycle.visits(machine, &options.pace) else { return Ok(None) };
        if !within_feeds(machine, &visits.states, &options.pace) {
            return Ok(None);
        }
        let states = thinned(visits.states, options.most_points);
        let value = self.after(&cycle.setups, &states, kind_of(cycle), knowledge)?;
        Ok(Some(self.row(&candidate.what, Some(cycle), visits.duration_s, value)))
    }

    /// The same cycle measured once more: the baseline.
    fn again(&self, knowledge: &Knowledge, options: &Options) -> Result<Considered, PlanError> {
        let states = self.present.last_states();
        let times = || states.iter().filter_map(|state| state.time_s);
        let duration_s = times().fold(f64::NEG_INFINITY, f64::max) - times().fold(f64::INFINITY, f64::min);
        let duration_s = if duration_s.is_finite() { duration_s } else { 4.0 * states.len() as f64 };
        let setups = self.present.last_setups();
        let value = self.after(setups, &states, self.present.last_kind(), knowledge)?;
        Ok(self.row("the same once more", None, duration_s + options.pace.mount_s, value))
    }

    fn after(
        &self,
        setups: &[Setup],
        states: &[State],
        kind: RunKind,
        knowledge: &Knowledge,
    ) -> Result<Value, PlanError> {
        let both = self.present.with(setups, states, kind)?;
        Ok(self.value(&both, knowledge))
    }

    fn row(&self, what: &str, cycle: Option<&Cycle>, duration_s: f64, value: Value) -> Considered {
        let pairs = value.pairs();
        let hardest = pairs.iter().min_by(|a, b| a.2.total_cmp(&b.2));
        let id = |i: usize| self.entries[i].id.clone();
        let ids =
            |test: &dyn Fn(usize) -> bool| (0..self.entries.len()).filter(|&i| test(i)).map(id).collect();
        let apart = |pair: &&(usize, usize, f64)| pair.2 >= self.separated_ln;
        Considered {
            name: cycle.map_or("again".into(), |cycle| cycle.name.clone()),
            what: what.into(),
            minutes: duration_s / 60.0,
            separation_ln: hardest.map_or(value.seen_ln[0], |pair| pair.2),
            hardest: hardest.map_or([id(0), id(0)], |&(a, b, _)| [id(a), id(b)]),
            apart: pairs.iter().filter(apart).map(|&(a, b, _)| [id(a), id(b)]).collect(),
            gain: self.gain(&value),
            shows: ids(&|i| value.seen_ln[i] > HOPELESS_LN),
            tells: ids(&|i| value.told_ln(i) > HOPELESS_LN),
            cycle: cycle.cloned(),
        }
    }

    /// What is to be made large: how far every two are apart, or how much of what was invisible is seen and told apart.
    fn gain(&self, value: &Value) -> f64 {
        match self.rivals {
            Rivals::Separate(_) => {
                let pairs = value.pairs();
                pairs.iter().map(|pair| pair.2.min(ENOUGH_LN)).sum::<f64>() / pairs.len().max(1) as f64
            }
            Rivals::Reveal(_) => {
                let rivals = 0..self.entries.len();
                rivals
                    .map(|i| 0.5 * (value.seen_ln[i].min(ENOUGH_LN) + value.told_ln(i).min(ENOUGH_LN)))
                    .sum()
            }
        }
    }
}

fn kind_of(cycle: &Cycle) -> RunKind {
    match cycle.motion {
        Motion::Static { .. } => RunKind::Static,
        Motion::OnTheFly { .. } => RunKind::OnTheFly,
    }
}

/// Every so many-th state, at most `most`.
fn thinned(states: Vec<State>, most: usize) -> Vec<State> {
    let stride = states.len().div_ceil(most).max(1);
    states.into_iter().step_by(stride).collect()
}

/// True when no axis has to follow faster than it can.
fn within_feeds(machine: &trunnion_machine::Machine, states: &[State], pace: &Pace) -> bool {
    machine.axes().all(|axis| {
        let usual = if axis.is_rotary() { pace.rotary_rad_per_s } else { pace.linear_mm_per_s };
        // A limit that the machine file gives is exact, the usual one is not.
        let limit = axis.facts.feed_limit.unwrap_or(1.5 * usual);
        states.iter().all(|state| state.velocity[axis.letter].abs() <= limit * (1.0 + 1e-9))
    })
}

#[cfg(test)]
mod tests;
