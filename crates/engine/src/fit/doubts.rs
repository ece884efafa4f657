//! Fitted numbers that a person should doubt although the fit gives them.
//!
//! - Temperatures that changed together: condition index η_k = s_1/s_k of the columns of the coefficients, scaled to unit length, with the
//!   settings projected out; share of the variance of coefficient j in direction k: π_jk = (v_jk²/s_k²) / Σ_k (v_jk²/s_k²). Where η_k > 30
//!   and the π_jk of those directions add up to more than ½ for two or more coefficients, these are collinear [Belsley 1980].
//! - A parameter larger than its cause allows (`Limit`).
//! - A time constant longer than the longest run: its course was never seen.
//! - Terms of one effect, each with a time constant, of which one is so uncertain that its 95 % interval goes beyond what a
//!   secant covers (`SECANT`): the terms imitate each other, in steps that no linear covariance follows.
//! - An effect of time alone where an axis goes one way while time goes on: an error along the axis reads the same.
//! - One stated direction of an axis that goes both ways: an approach from one side, or a column that was never filled in.
//! - Readings at rest that scatter as no machining centre in order does: a wrong unit, or something loose.

use crate::evidence::joined;
use crate::fit::identification::{FittedEffect, FittedParameter, Identification};
use crate::noise::repeatability::repeatability;
use crate::problem::experiment::SECANT;
use crate::problem::one_way::one_way;
use crate::problem::passes::passes;
use crate::problem::steps::{self, OneDirection};
use crate::solve::collinear::collinear;
use crate::written::joint;
use crate::{Experiment, Status};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use trunnion_core::Joint;
use trunnion_core::convert::um_from_mm;
use trunnion_core::statistics::{COVERAGE_95, upper_median};
use trunnion_cycles::RunKind;
use trunnion_effects::{Instance, Limit, Model, Parameter, Role, Unit};

/// Repeatability of a reading at rest beyond which unit, ball and probes are doubted, µm. Four of it are the unidirectional repeatability of
/// ISO 230-2: 10 µm, where machining centres are sold with 2 to 5. A judgement, tuned on no data.
const SCATTER_UM: f64 = 2.5;

/// Numbers to doubt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Doubt {
    /// Effect id; none where the readings themselves are doubted.
    pub effect: Option<String>,
    /// Names of the parameters or shape numbers.
    pub names: Vec<String>,
    /// What is wrong with them.
    pub reason: DoubtReason,
}

/// What is wrong with fitted numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum DoubtReason {
    /// Their temperatures changed together: only their sum is determined.
    Collinear {
        /// Largest condition index.
        condition_index: f64,
    },
    /// Larger than the cause allows.
    BeyondPhysical {
        /// The largest size.
        limit: Limit,
        /// Its unit.
        unit: Unit,
    },
    /// A time constant longer than the record.
    LongerThanRun {
        /// Its value, s.
        tau_s: f64,
        /// The longest run, s.
        longest_s: f64,
    },
    /// The readings do not separate the terms of an effect, each with a shape number of its own.
    TermsNotSeparated {
        /// The least certain shape number, the first of the names.
        value: f64,
        /// Its standard uncertainty.
        u: f64,
        /// Unit of both.
        unit: Unit,
    },
    /// The effect depends on time alone, and an axis goes one way while time goes on.
    PlaceAndTime {
        /// The axis.
        #[serde(with = "joint")]
        joint: Joint,
    },
    /// One direction is stated at every point of an axis that went both ways.
    OneDirection {
        /// The axis.
        #[serde(with = "joint")]
        joint: Joint,
        /// What is stated.
        stated: f64,
        /// Steps that went the other way, and all.
        contrary: [usize; 2],
    },
    /// Readings of one pose scatter more than those of a machining centre in order.
    Scatter {
        /// Repeatability of a reading, µm.
        noise_um: f64,
    },
}

impl Doubt {
    /// Whether another cause that no cycle like this one separates may be behind the whole effect.
    pub(crate) fn is_of_another_cause(&self) -> bool {
        matches!(self.reason, DoubtReason::PlaceAndTime { .. })
    }
}

/// What to doubt in a fit of `model`.
pub fn doubts(experiment: &Experiment, model: &Model, fit: &Identification) -> Vec<Doubt> {
    fit.effects.iter().flat_map(|effect| doubts_of(experiment, model, fit, effect)).collect()
}

/// What to doubt in the readings whatever is fitted to them.
pub fn doubts_of_readings(experiment: &Experiment) -> Vec<Doubt> {
    scatter(experiment).into_iter().chain(one_direction(experiment)).collect()
}

/// What to doubt in the numbers of one effect in a fit of `model`.
pub(crate) fn doubts_of(
    experiment: &Experiment,
    model: &Model,
    fit: &Identification,
    effect: &FittedEffect,
) -> Vec<Doubt> {
    let columns = |effect: &FittedEffect| {
        let entry = model.effects.iter().find(|entry| entry.id == effect.id)?;
        let instance = Instance::from_model_effect(entry, experiment.machine()).ok()?;
        Some(experiment.columns(&instance, &effect.shape))
    };
    let of_effect: Vec<_> = fit.parameters.iter().filter(|p| p.effect == effect.id).collect();
    let coefficients: Vec<usize> = (0..of_effect.len())
        .filter(|&j| of_effect[j].status == Status::Identified && of_effect[j].unit == Unit::UM_PER_K)
        .collect();
    let mut found = beyond_physical(experiment, model, effect, &of_effect);
    if coefficients.len() > 1
        && let Some(all) = columns(effect)
    {
        let is_setting = |effect: &&FittedEffect| {
            trunnion_effects::catalogue::effect(&effect.id).is_some_and(|effect| effect.role == Role::Setting)
        };
        let settings = fit.effects.iter().filter(is_setting).filter_map(columns);
        let settings = settings.fold(DMatrix::zeros(experiment.rows(), 0), |all, own| joined(&all, &own));
        if let Some((condition_index, involved)) = collinear(all.select_columns(&coefficients), &settings) {
            let names = involved.into_iter().map(|k| of_effect[coefficients[k]].name.clone()).collect();
            let reason = DoubtReason::Collinear { condition_index };
            found.push(Doubt { effect: Some(effect.id.clone()), names, reason });
        }
    }
    found.extend(longer_than_run(experiment, effect));
    found.extend(terms_not_separated(fit, effect, &of_effect));
    found.extend(place_and_time(experiment, effect, &of_effect));
    found
}

/// A course in time that may be an error along an axis.
fn place_and_time(
    experiment: &Experiment,
    effect: &FittedEffect,
    fitted: &[&FittedParameter],
) -> Option<Doubt> {
    trunnion_effects::catalogue::effect(&effect.id).filter(|effect| effect.is_of_time_alone())?;
    let joint = one_way(experiment)?;
    let seen = fitted.iter().filter(|p| p.status == Status::Identified).map(|p| p.name.clone());
    let reason = DoubtReason::PlaceAndTime { joint };
    Some(Doubt { effect: Some(effect.id.clone()), names: seen.collect(), reason })
}

/// Parameters that are larger than their cause allows.
fn beyond_physical(
    experiment: &Experiment,
    model: &Model,
    effect: &FittedEffect,
    fitted: &[&FittedParameter],
) -> Vec<Doubt> {
    let entry = model.effects.iter().find(|entry| entry.id == effect.id);
    let instance = entry.and_then(|entry| Instance::from_model_effect(entry, experiment.machine()).ok());
    let parameters = instance.map_or_else(Vec::new, |instance| instance.parameters(&experiment.scene));
    // Axes of which one stands for both are placed so badly together; of causes only their sum counts.
    let is_place =
        trunnion_effects::catalogue::effect(&effect.id).is_some_and(|effect| effect.role == Role::Location);
    let doubt = |parameter: Parameter| {
        let limit = parameter.limit?;
        let fitted = fitted
            .iter()
            .find(|fitted| fitted.name == parameter.name && (is_place || fitted.stands_alone()))?;
        let value = fitted.screen_value()?;
        let reason = DoubtReason::BeyondPhysical { limit, unit: parameter.unit };
        let names = vec![parameter.name];
        limit.is_exceeded(value).then(|| Doubt { effect: Some(effect.id.clone()), names, reason })
    };
    parameters.into_iter().filter_map(doubt).collect()
}

/// Axes at rest that were approached from one side, as stated, while they went both ways.
fn one_direction(experiment: &Experiment) -> Vec<Doubt> {
    if experiment.kinds.iter().any(|kind| *kind != RunKind::Static) {
        return Vec::new();
    }
    let of_joint = |joint: Joint| {
        let OneDirection { stated, contrary } = steps::one_direction(&experiment.points, joint)?;
        let reason = DoubtReason::OneDirection { joint, stated, contrary };
        let names = vec![format!("direction_{}", joint.lower())];
        Some(Doubt { effect: None, names, reason })
    };
    experiment.machine().joints().into_iter().filter_map(of_joint).collect()
}

/// Probes in a nest, read at rest, that do not repeat.
fn scatter(experiment: &Experiment) -> Option<Doubt> {
    let at_rest = experiment.kinds.iter().all(|kind| *kind == RunKind::Static);
    let in_nest = experiment.setups.iter().all(|setup| setup.instrument.deflects_probes());
    let repeatability = || repeatability(experiment, &passes(experiment));
    let noise_um = um_from_mm((at_rest && in_nest).then(repeatability)??.sigma_mm);
    let reason = DoubtReason::Scatter { noise_um };
    (noise_um > SCATTER_UM).then(|| Doubt { effect: None, names: Vec::new(), reason })
}

/// Time constants whose course was not seen to the end.
fn longer_than_run(experiment: &Experiment, effect: &FittedEffect) -> Option<Doubt> {
    let length_s = |times: Vec<f64>| match times.iter().copied().reduce(f64::max) {
        Some(last) => last - times.iter().copied().fold(last, f64::min),
        None => 0.0,
    };
    let longest_s = times_of_runs(experiment).map(length_s).fold(0.0, f64::max);
    let long = time_constants(effect).filter(|(_, tau_s)| longest_s > 0.0 && *tau_s > longest_s);
    let (names, values): (Vec<String>, Vec<f64>) =
        long.map(|(name, tau_s)| (name.to_string(), tau_s)).unzip();
    let tau_s = values.into_iter().reduce(f64::max)?;
    let reason = DoubtReason::LongerThanRun { tau_s, longest_s };
    Some(Doubt { effect: Some(effect.id.clone()), names, reason })
}

/// Several terms that the readings do not separate.
fn terms_not_separated(
    fit: &Identification,
    effect: &FittedEffect,
    fitted: &[&FittedParameter],
) -> Option<Doubt> {
    let u = fit.shape_u(effect);
    let found = (0..effect.shape.len()).filter_map(|k| Some((k, effect.shape[k], u[k]?)));
    let found: Vec<(usize, f64, f64)> = found.collect();
    let share = |(_, value, u): &(usize, f64, f64)| u / value.abs();
    let least = found.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
    let is_open = found.len() > 1 && COVERAGE_95 * share(least) > SECANT;
    let &(k, value, u) = least;
    let name = &effect.shape_names[k];
    let shared = fitted.iter().filter(|p| p.status == Status::Identified).map(|p| p.name.clone());
    is_open.then(|| Doubt {
        effect: Some(effect.id.clone()),
        names: std::iter::once(name.clone()).chain(shared).collect(),
        reason: DoubtReason::TermsNotSeparated { value, u, unit: Unit::in_name(name) },
    })
}

/// What a time constant shorter than the usual time from one reading to the next says: nothing is wrong with it.
pub(crate) fn no_lag(experiment: &Experiment, effect: &FittedEffect) -> Option<String> {
    let step =
        |times: Vec<f64>| -> Vec<f64> { times.windows(2).map(|two| (two[1] - two[0]).abs()).collect() };
    let step_s = upper_median(&times_of_runs(experiment).flat_map(step).collect::<Vec<f64>>())?;
    let (name, _) = time_constants(effect).find(|(_, tau_s)| *tau_s < step_s)?;
    Some(format!("No lag was seen: {name} is shorter than the time between two readings ({step_s:.0} s)."))
}

fn times_of_runs(experiment: &Experiment) -> impl Iterator<Item = Vec<f64>> {
    (0..experiment.runs.len()).map(|run| {
        let own = (0..experiment.points.len()).filter(|&i| experiment.run_of_point[i] == run);
        own.filter_map(|i| experiment.points[i].state.time_s).collect()
    })
}

fn time_constants(effect: &FittedEffect) -> impl Iterator<Item = (&str, f64)> {
    let numbers = effect.shape_names.iter().zip(&effect.shape).map(|(name, value)| (name.as_str(), *value));
    numbers.filter(|(name, _)| name.starts_with("tau") && name.ends_with("_s"))
}
