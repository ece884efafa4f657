//! Joint least squares over all effects of a model.
//!
//! shapes (grid) → converge (Gauss–Newton to the exact prediction) → outliers excluded, until they stay the same → readings
//! weighted by the noise of their run and their samples, and fitted again → uncertainties under the parts of the machine's noise
//! (`structured`; else from clusters, `uncertainty`), tilts that no reading shows (`second_order`) and null directions, noise, held-out proof.

pub mod between_runs;
pub mod doubts;
pub(crate) mod errors;
pub(crate) mod gauss_newton;
mod holdout;
pub mod identification;
mod mixture;
pub mod options;
pub mod reading_noise;
mod second_order;
mod sensitivity;
mod shape;
mod structured;
mod uncertainty;

pub use options::Options;

use crate::fit::gauss_newton::{Converged, converge};
use crate::fit::holdout::holdout;
use crate::fit::identification::{FittedEffect, FittedParameter, Identification, Outlier};
use crate::fit::second_order::second_order;
use crate::fit::sensitivity::Sensitivity;
use crate::fit::shape::search_shapes;
use crate::fit::structured::{Structured, structured};
use crate::fit::uncertainty::{covariance, sums};
use crate::noise::outliers::excluded;
use crate::noise::repeatability::repeatability;
use crate::noise::weights::{Weights, weights_of};
use crate::problem::design::Design;
use crate::problem::passes::passes;
use crate::problem::side_by_side::SideBySide;
use crate::solve::combinations::seen_together;
use crate::solve::direction::{Named, Status};
use crate::solve::null_space::{Direction, Share, of_null_directions};
use crate::solve::words::describe;
use crate::{Experiment, HeldOut, IdentifyError, Outliers, Uncertainties};
use nalgebra::{DMatrix, DVector};
use trunnion_core::convert;
use trunnion_core::number::fixed;
use trunnion_effects::{Model, Parameter, Role};
use trunnion_machine::Axis;

/// Rounds of weighing.
const MOST_WEIGHINGS: usize = 3;

/// Fits every effect of `model` to the runs of `experiment` together.
///
/// # Errors
/// The model does not fit the machine or the runs, a reading is no number, there are too few readings, or the fit
/// does not converge.
pub fn identify(
    experiment: &Experiment,
    model: &Model,
    options: &Options,
) -> Result<Identification, IdentifyError> {
    identify_sharing(experiment, model, options, None)
}

/// The same next to another fit of the same points, of which it takes what depends on the points alone.
pub(crate) fn identify_sharing(
    experiment: &Experiment,
    model: &Model,
    options: &Options,
    other: Option<&Identification>,
) -> Result<Identification, IdentifyError> {
    let mut joint = SideBySide::place(experiment, model)?;
    let everything = vec![true; experiment.points.len()];
    let mut weights = Weights::even(experiment);
    let searched = search_shapes(experiment, &mut joint, &everything, &weights, options)?;
    let (mut used, mut fit) = converge_robustly(&Design::new(experiment, &joint, &weights), options)?;
    for _ in 0..MOST_WEIGHINGS {
        let (next, _) = weights_of(experiment, &fit.residual_mm, &used, fit.datum.determined.len());
        if next.like(&weights) {
            weights.reference_mm = next.reference_mm;
            break;
        }
        weights = next;
        (used, fit) = converge_robustly(&Design::new(experiment, &joint, &weights), options)?;
    }
    if searched && (used != everything || !weights.even) {
        search_shapes(experiment, &mut joint, &used, &weights, options)?;
        (used, fit) = converge_robustly(&Design::new(experiment, &joint, &weights), options)?;
    }
    Ok(gather(&Design::new(experiment, &joint, &weights), &used, fit, options, other))
}

fn converge_robustly(
    design: &Design<'_>,
    options: &Options,
) -> Result<(Vec<bool>, Converged), IdentifyError> {
    if options.outliers == Outliers::Keep {
        let used = vec![true; design.experiment.points.len()];
        let fit = converge(design, &used, options)?;
        return Ok((used, fit));
    }
    excluded(design.experiment, |used| converge(design, used, options), |fit| &fit.weighted_mm)
}

fn gather(
    design: &Design<'_>,
    used: &[bool],
    fit: Converged,
    options: &Options,
    other: Option<&Identification>,
) -> Identification {
    let (experiment, joint) = (design.experiment, design.joint);
    let passes = passes(experiment);
    let sums = sums(design, &passes, &fit, used);
    let determined = &fit.datum.determined;
    let known = Sensitivity::new(design, &fit, used);
    let structured = match options.uncertainties {
        Uncertainties::NoiseParts => {
            structured(&known, &fit, used, other.and_then(|other| other.noise.as_ref()))
        }
        Uncertainties::Clusters => None,
    };
    let (mut small, noise_parts, noise) = match structured {
        Some(Structured { covariance, parts, noise }) => (covariance, parts, Some(noise)),
        None => (known.opened(&covariance(&fit, &sums, design.weights), &fit), Vec::new(), None),
    };
    let mut of_parameters = small.view_mut((0, 0), (determined.len(), determined.len()));
    if let Some(of_tilts) = second_order(design, &fit, used) {
        of_parameters += of_tilts;
    }
    of_parameters += of_null_directions(&fit.datum);
    let numbers = &known.numbers;
    let places: Vec<usize> =
        determined.iter().copied().chain((0..numbers.len()).map(|k| joint.width() + k)).collect();
    let mut covariance = DMatrix::zeros(joint.width() + numbers.len(), joint.width() + numbers.len());
    for (a, &i) in places.iter().enumerate() {
        for (b, &j) in places.iter().enumerate() {
            covariance[(i, j)] = small[(a, b)];
        }
    }
    let in_covariance = |effect: usize, at: usize| {
        let number = numbers.iter().position(|number| (number.effect, number.at) == (effect, at))?;
        Some(joint.width() + number)
    };
    let names = names(joint);
    let without_number: Vec<usize> = (0..joint.width())
        .filter(|&j| fit.datum.status[j] == Status::Unobservable)
        .filter(|&j| joint.effects[joint.effect_of[j]].instance.role() != Role::Setting)
        .collect();
    let seen_together =
        seen_together(&fit.datum.directions, &without_number, &names, &fit.solution, &covariance);
    let unobservable: Vec<_> =
        fit.datum.directions.iter().map(|direction| describe(direction, &names, &fit.datum.status)).collect();
    let parameters = (0..joint.width()).map(|j| parameter(joint, &fit, &covariance, j)).collect();
    let degrees_of_freedom = fit.degrees_of_freedom();
    let used_rows = (0..used.len()).filter(|&i| used[i]).flat_map(|i| experiment.rows_of(i));
    let squares: f64 = used_rows.map(|row| fit.residual_mm[row].powi(2)).sum();
    let (_, noise_by_run) = weights_of(experiment, &fit.residual_mm, used, determined.len());
    Identification {
        machine: experiment.machine().name.clone(),
        runs: experiment.runs.clone(),
        effects: joint
            .effects
            .iter()
            .enumerate()
            .map(|(k, placed)| FittedEffect {
                id: placed.id.clone(),
                shape_names: placed.shapes.names.clone(),
                shape: placed.shape.clone(),
                shape_in_covariance: (0..placed.shape.len()).map(|at| in_covariance(k, at)).collect(),
            })
            .collect(),
        points: experiment.points.len(),
        parameters,
        unobservable,
        seen_together,
        covariance,
        repeatability: repeatability(experiment, &passes),
        holdout: match options.holdout {
            HeldOut::Computed => holdout(&sums, &added(joint, &fit)),
            HeldOut::Skipped => None,
        },
        noise_parts,
        noise,
        row_weights: design.weights.root.clone(),
        noise_by_run,
        rms_mm: (squares / fit.rows_used as f64).sqrt(),
        outliers: outliers(experiment, used, &fit.residual_mm),
        used: used.to_vec(),
        rank: fit.datum.rank,
        condition: fit.condition,
        iterations: fit.iterations,
        degrees_of_freedom,
        solution: fit.solution,
        predicted_mm: fit.predicted_mm,
        residual_mm: fit.residual_mm,
    }
}

/// Parameters of effects beyond location errors and settings: where they stand among the determined ones, and their values.
fn added(joint: &SideBySide, fit: &Converged) -> Vec<(usize, f64)> {
    let determined = fit.datum.determined.iter().enumerate();
    determined.filter(|(_, j)| joint.is_added(**j)).map(|(column, &j)| (column, fit.solution[j])).collect()
}

/// What parameters are called in sentences: by their effect where several effects have one of that name.
fn names(joint: &SideBySide) -> Vec<Named> {
    let count_of = |name: &str| joint.parameters.iter().filter(|other| other.name == name).count();
    let named = |(j, parameter): (usize, &Parameter)| Named {
        name: match count_of(&parameter.name) {
            1 => parameter.name.clone(),
            _ => format!("{}.{}", joint.effects[joint.effect_of[j]].id, parameter.name),
        },
        unit: parameter.unit.symbol,
        per_inside: parameter.unit.per_inside,
    };
    joint.parameters.iter().enumerate().map(named).collect()
}

fn parameter(joint: &SideBySide, fit: &Converged, covariance: &DMatrix<f64>, j: usize) -> FittedParameter {
    let status = fit.datum.status[j];
    let name = |k: usize| joint.parameters[k].name.as_str();
    let part_of = |share: Share| {
        let holds = move |direction: &&Direction| {
            direction.share == share && direction.terms[1..].iter().any(|(k, _)| *k == j)
        };
        fit.datum.directions.iter().filter(holds).map(|direction| direction.terms[0].0)
    };
    let effect_of = |k: usize| joint.effects[joint.effect_of[k]].id.as_str();
    let mut stands_for: Vec<String> = part_of(Share::Others).map(|k| name(k).into()).collect();
    if status == Status::Identified {
        stands_for.extend(part_of(Share::Base).map(|k| effect_of(k).into()));
        stands_for.dedup();
    }
    let of_resting: Vec<String> = part_of(Share::Mounting).map(|k| name(k).into()).collect();
    if !of_resting.is_empty() {
        stands_for.push(format!("{}, its axis at rest", of_resting.join(", ")));
    }
    let is_pivot = |d: &Direction| d.share == Share::Mounting && d.terms[0].0 == j;
    let of_standing = fit.datum.directions.iter().any(is_pivot);
    let note = match status {
        Status::Held => "held by the model".into(),
        Status::ZeroByConvention if of_standing => "its axis is at rest in these runs".into(),
        Status::ZeroByConvention => "zero by the datum convention: confounded with others".into(),
        Status::Unobservable => match second_order::u_beforehand(joint, fit, j) {
            Some(u) => {
                let unit = joint.parameters[j].unit;
                let (u, unit) = (u * unit.per_inside, unit.text());
                format!("not observable; other uncertainties hold what 0 ± {u:.0} {unit} of it makes")
            }
            None => "not observable".into(),
        },
        Status::Identified if stands_for.is_empty() => String::new(),
        Status::Identified => format!("contains {}", stands_for.join(", ")),
    };
    let identified = status == Status::Identified;
    FittedParameter {
        name: name(j).into(),
        effect: joint.effects[joint.effect_of[j]].id.clone(),
        unit: joint.parameters[j].unit,
        value: (identified || status == Status::Held).then(|| fit.solution[j]),
        u: identified.then(|| covariance[(j, j)].sqrt()),
        status,
        at_rest: if identified { of_resting } else { Vec::new() },
        note,
    }
}

fn outliers(experiment: &Experiment, used: &[bool], residual_mm: &DVector<f64>) -> Vec<Outlier> {
    (0..used.len())
        .filter(|&i| !used[i])
        .map(|i| {
            let state = &experiment.points[i].state;
            let degrees = |axis: &Axis| {
                format!("{} {}°", axis.letter, fixed(convert::deg_from_rad(state.position[axis.letter]), 3))
            };
            let pose: Vec<String> = experiment.machine().rotary().into_iter().map(degrees).collect();
            let rows = experiment.rows_of(i);
            Outlier {
                point: i,
                run: experiment.runs[experiment.run_of_point[i]].clone(),
                setup: experiment.setups[state.setup].name.clone(),
                pose: pose.join(" "),
                residual_mm: residual_mm.rows(rows.start, rows.len()).norm(),
            }
        })
        .collect()
}
