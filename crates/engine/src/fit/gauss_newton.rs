//! Gauss–Newton to the exact prediction, columns at the nominal machine.
//!
//! x ← x + argmin ‖W^½ (A δ − (measured − predicted(x)))‖ over the used points. The columns are the analytic linear ones, so
//! each step shrinks what is left by about the size of the errors (0.005 for a tilt of 0.3°). A step that does not lower the
//! residual is not taken but damped (Levenberg–Marquardt); a direction that does not come to rest is left out, a fit that does not is an error, and so is one that
//! comes to rest at numbers that no machine has.

use crate::IdentifyError;
use crate::fit::Options;
use crate::noise::weights::Weights;
use crate::problem::design::Design;
use crate::problem::side_by_side::Expected;
use crate::solve::linear::{Reduced, Solver};
use crate::solve::null_space::{Datum, Limits, Zero, datum};
use nalgebra::DVector;
use trunnion_core::Joint;
use trunnion_effects::Unit;
use trunnion_effects::catalogue::conventional_zeros;

/// The fit stands when no prediction moves by more than this, mm.
const CONVERGED_MM: f64 = 1e-9;
/// The noise is known well enough to judge weak directions by when no prediction moves by more than this part of it. Such
/// directions wander far and converge slowly; they are left out before they need to.
const NOISE_KNOWN: f64 = 0.1;
const MOST_STEPS: usize = 40;
/// A direction that shows up to so many times what one that creeps does is left out with it.
const CREEPING: f64 = 2.0;
/// Damping after a first step that does not lower the residual, against scaled columns whose norms are near one, and its factor
/// from step to step [Marquardt 1963: ten in the square].
pub(crate) const FIRST_DAMPING: f64 = 1e-2;
pub(crate) const DAMPING_FACTOR: f64 = 3.162;
/// Columns at the nominal machine lead to where J₀ᵀ r = 0, which lies above the least sum of squares by this share at most: errors of
/// 3 % in the columns, squared.
const RISE: f64 = 1e-3;
/// Larger than any error of a machine or its mounting: the dead path of an interferometer, and a turn whose sine is no longer it.
const LARGEST_MM: f64 = 1e4;
const LARGEST_RAD: f64 = 0.5;
/// Noise is never taken below this against a prior, mm.
const FINEST_MM: f64 = 1e-6;

/// A converged fit for one choice of points.
pub(crate) struct Converged {
    pub solution: DVector<f64>,
    pub predicted_mm: DVector<f64>,
    pub residual_mm: DVector<f64>,
    /// Residual times the root of the weight of its row, mm.
    pub weighted_mm: DVector<f64>,
    pub datum: Datum,
    pub solver: Solver,
    pub condition: f64,
    pub iterations: usize,
    /// Weighted residual standard deviation of the used rows, mm.
    pub sigma_mm: f64,
    pub rows_used: usize,
    /// Weight w of each prior of the joint model, which entered as a reading w x = w x₀; 0 for one that did not.
    pub prior_weights: Vec<f64>,
}

impl Converged {
    pub fn degrees_of_freedom(&self) -> usize {
        self.rows_used - self.datum.determined.len()
    }

    /// Standard deviation of a reading of weight one, not below that which the weights stand for, mm.
    pub fn reading_mm(&self, weights: &Weights) -> f64 {
        self.sigma_mm.max(weights.reference_mm)
    }
}

pub(crate) fn converge(
    design: &Design<'_>,
    used: &[bool],
    options: &Options,
) -> Result<Converged, IdentifyError> {
    let mut reduced = design.reduce(used)?;
    let rows = design.experiment.rows();
    let limits = Limits {
        tolerance: options.null_tolerance,
        off_nominal: design.off_nominal(),
        weakest: 0.0,
        rows,
        rows_moved: rows as f64 / design.experiment.setups.len().max(1) as f64,
    };
    let datum = named_datum(design, &reduced, &limits);
    let nothing = DVector::from_iterator(
        design.joint.width(),
        design.joint.held.iter().map(|held| held.unwrap_or(0.0)),
    );
    let to_noise = |datum| converge_within(design, &reduced, datum, &[], used, nothing.clone(), NOISE_KNOWN);
    let first = match to_noise(datum)? {
        End::Rest(fit) => *fit,
        // Directions too weak to go by may run away; the noise that the columns leave over shows which they are.
        End::Creeping(_) => {
            let noise_mm = linear_noise_mm(design, &reduced, &nothing, used);
            to_noise(named_datum(design, &reduced, &limits.with_noise(noise_mm, rows)))?.rest()?
        }
    };
    if design.joint.free().is_empty() {
        return Ok(first);
    }
    // Directions so weak that noise alone makes their numbers absurd, and the weight of priors against readings,
    // are known only after the noise is.
    let mut limits = limits.with_noise(first.sigma_mm, first.rows_used);
    let sigma_mm = first.sigma_mm.max(FINEST_MM);
    let priors: Vec<(&Expected, f64)> = design
        .joint
        .priors
        .iter()
        .filter(|prior| design.joint.held[prior.parameter].is_none())
        .map(|prior| (prior, sigma_mm / prior.u))
        .collect();
    let weights: Vec<(usize, f64)> = priors.iter().map(|(prior, w)| (prior.parameter, *w)).collect();
    reduced.add_priors(&weights);
    let to_rest = |datum: Datum, start| converge_within(design, &reduced, datum, &priors, used, start, 0.0);
    let mut datum = named_datum(design, &reduced, &limits);
    let start =
        if datum.rank == first.datum.rank && priors.is_empty() { first.solution } else { nothing.clone() };
    let mut determined = datum.determined.len();
    let mut end = to_rest(datum, start)?;
    // A direction that errors of the machine change by as much as it shows is not seen: of a ball 3 mm from its place, how far the axis C is
    // turned against the ball's y. Without it nothing more is left.
    let (mut least_mm, mut change_mm) = (f64::INFINITY, 0.0);
    while let End::Creeping(creeping) = &end {
        (least_mm, change_mm) = (least_mm.min(creeping.left_mm), creeping.change_mm);
        limits.weakest = limits.weakest.max(CREEPING * creeping.seen);
        datum = named_datum(design, &reduced, &limits);
        if datum.determined.len() >= determined {
            break;
        }
        determined = datum.determined.len();
        end = to_rest(datum, nothing.clone())?;
    }
    let fit = match end {
        End::Rest(fit) if counted_mm(design, &fit.residual_mm, used).norm() > (1.0 + RISE) * least_mm => {
            return Err(IdentifyError::NotConverged { steps: MOST_STEPS, change_mm });
        }
        end => end.rest()?,
    };
    check_possible(design, &fit)?;
    Ok(fit)
}

/// How steps end.
enum End {
    Rest(Box<Converged>),
    Creeping(Creeping),
}

/// The last of too many steps.
struct Creeping {
    steps: usize,
    change_mm: f64,
    /// Length of what it leaves, weighted.
    left_mm: f64,
    /// What its direction shows by the columns, for scaled parameters of length 1, mm.
    seen: f64,
}

impl End {
    fn rest(self) -> Result<Converged, IdentifyError> {
        match self {
            Self::Rest(fit) => Ok(*fit),
            Self::Creeping(Creeping { steps, change_mm, .. }) => {
                Err(IdentifyError::NotConverged { steps, change_mm })
            }
        }
    }
}

/// A fit may converge to numbers that no machine has; columns at the nominal machine mean nothing there.
fn check_possible(design: &Design<'_>, fit: &Converged) -> Result<(), IdentifyError> {
    let beyond = |&&j: &&usize| match design.joint.parameters[j].unit {
        Unit::UM => fit.solution[j].abs() > LARGEST_MM,
        Unit::URAD => fit.solution[j].abs() > LARGEST_RAD,
        _ => false,
    };
    let Some(&j) = fit.datum.determined.iter().find(beyond) else { return Ok(()) };
    let parameter = &design.joint.parameters[j];
    Err(IdentifyError::Impossible {
        effect: design.joint.effects[design.joint.effect_of[j]].id.clone(),
        name: parameter.name.clone(),
        value: fit.solution[j] * parameter.unit.per_inside,
        unit: parameter.unit.symbol,
    })
}

/// Weighted standard deviation of what no combination of the columns explains at `start`, mm.
fn linear_noise_mm(design: &Design<'_>, reduced: &Reduced, start: &DVector<f64>, used: &[bool]) -> f64 {
    let residual_mm = design.experiment.readings_mm() - design.joint.predict_mm(design.experiment, start);
    let counted = counted_mm(design, &residual_mm, used);
    let explained = design.project(reduced, &counted).norm_squared();
    let rows = counted.iter().filter(|value| **value != 0.0).count();
    let free = rows.saturating_sub(design.joint.width()).max(1);
    ((counted.norm_squared() - explained).max(0.0) / free as f64).sqrt()
}

/// Residuals as they count: weighted, of unused rows zero, mm.
fn counted_mm(design: &Design<'_>, residual_mm: &DVector<f64>, used: &[bool]) -> DVector<f64> {
    let mut counted = residual_mm.component_mul(&design.weights.root);
    for row in design.experiment.unused_rows(used) {
        counted[row] = 0.0;
    }
    counted
}

fn named_datum(design: &Design<'_>, reduced: &Reduced, limits: &Limits<'_>) -> Datum {
    let scene = &design.experiment.scene;
    // The line of an axis that is at rest is a matter of the mounting.
    let standing =
        scene.machine.rotary().into_iter().filter(|axis| !scene.moves(axis.letter)).flat_map(|axis| {
            Joint::ALL.map(|direction| Zero { name: format!("E{direction}0{}", axis.letter), standing: true })
        });
    let minimum = conventional_zeros(&scene.machine).into_iter().map(|name| Zero { name, standing: false });
    let zeros: Vec<Zero> = standing.chain(minimum).collect();
    datum(reduced, &design.joint.free_by_role(), &design.joint.parameters, &zeros, limits)
}

/// From `start` until no prediction moves by more than [`CONVERGED_MM`], or this part of the noise.
fn converge_within(
    design: &Design<'_>,
    reduced: &Reduced,
    datum: Datum,
    priors: &[(&Expected, f64)],
    used: &[bool],
    start: DVector<f64>,
    part_of_noise: f64,
) -> Result<End, IdentifyError> {
    let (experiment, joint) = (design.experiment, design.joint);
    let rows_used: usize = (0..used.len()).filter(|&i| used[i]).map(|i| experiment.rows_of(i).len()).sum();
    if rows_used <= datum.determined.len() {
        return Err(IdentifyError::TooFewReadings { rows: rows_used, determined: datum.determined.len() });
    }
    let solver = reduced.solver(&datum.determined);
    let condition = if datum.determined.is_empty() {
        1.0
    } else {
        let sigma = reduced.singular(&datum.determined).0;
        sigma[0] / sigma[sigma.len() - 1]
    };
    let readings = experiment.readings_mm();
    let surprise = |solution: &DVector<f64>| {
        DVector::from_iterator(
            priors.len(),
            priors.iter().map(|(prior, w)| w * (prior.value - solution[prior.parameter])),
        )
    };
    let mut solution = start;
    let mut predicted_mm = joint.predict_mm(experiment, &solution);
    check_finite(design, &(&readings - &predicted_mm))?;
    let mut counted = counted_mm(design, &(&readings - &predicted_mm), used);
    let mut missed = surprise(&solution);
    let (mut iterations, mut change_mm, mut damping, mut seen) = (0, f64::INFINITY, 0.0, 0.0);
    let root_rows = (rows_used as f64).sqrt();
    while !datum.determined.is_empty() {
        let enough_mm = CONVERGED_MM.max(part_of_noise * counted.norm() / root_rows);
        if damping == 0.0 && change_mm <= enough_mm {
            break;
        }
        if iterations == MOST_STEPS {
            let left_mm = counted.norm();
            return Ok(End::Creeping(Creeping { steps: iterations, change_mm, left_mm, seen }));
        }
        iterations += 1;
        let projected = design.project(reduced, &counted);
        let right: Vec<f64> = projected.iter().chain(missed.iter()).copied().collect();
        let change = solver.solve_damped(&DVector::from_vec(right), damping);
        let mut tried = solution.clone();
        for (k, &j) in datum.determined.iter().enumerate() {
            tried[j] += change[k];
        }
        let next_mm = joint.predict_mm(experiment, &tried);
        let next = counted_mm(design, &(&readings - &next_mm), used);
        let next_missed = surprise(&tried);
        let squares =
            |counted: &DVector<f64>, missed: &DVector<f64>| counted.norm_squared() + missed.norm_squared();
        let step_mm = (&next_mm - &predicted_mm).amax();
        seen = solver.seen(&change);
        // Below the tolerance the sum of squares changes by rounding alone.
        let fell = squares(&next, &next_missed) <= (1.0 + RISE) * squares(&counted, &missed)
            || step_mm <= CONVERGED_MM;
        if !fell {
            damping = if damping == 0.0 { FIRST_DAMPING } else { damping * DAMPING_FACTOR };
            continue;
        }
        damping = if damping <= FIRST_DAMPING { 0.0 } else { damping / DAMPING_FACTOR };
        (solution, predicted_mm, counted, missed, change_mm) = (tried, next_mm, next, next_missed, step_mm);
    }
    let weight_of = |prior: &Expected| {
        priors.iter().find(|(other, _)| std::ptr::eq(*other, prior)).map_or(0.0, |(_, weight)| *weight)
    };
    let prior_weights = joint.priors.iter().map(weight_of).collect();
    let residual_mm = readings - &predicted_mm;
    let weighted_mm = residual_mm.component_mul(&design.weights.root);
    let sigma_mm = (counted.norm_squared() / (rows_used - datum.determined.len()) as f64).sqrt();
    Ok(End::Rest(Box::new(Converged {
        solution,
        predicted_mm,
        residual_mm,
        weighted_mm,
        datum,
        solver,
        condition,
        iterations,
        sigma_mm,
        rows_used,
        prior_weights,
    })))
}

fn check_finite(design: &Design<'_>, residual: &DVector<f64>) -> Result<(), IdentifyError> {
    let experiment = design.experiment;
    let Some(row) = residual.iter().position(|r| !r.is_finite()) else { return Ok(()) };
    let reading = experiment.readings_mm()[row].is_finite();
    Err(experiment.not_finite(row, if reading { "prediction" } else { "reading" }))
}
