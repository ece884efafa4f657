//! Shape numbers (time constants, lobes, teeth) that the model leaves open: the best on the grid, refined where
//! values in between make sense; of waves also the periods that the residual shows.
//!
//! For one effect at a time, the others projected out: score(θ) = ‖Q_θᵀ z‖², Q_θ an orthonormal basis of the effect's columns
//! at θ next to those of the others, z the readings without the small non-linear part. Effects take turns until nothing
//! changes; continuous numbers are refined by golden section between neighbours of the grid, one after the other, several then together.
//! Limits: long experiments are searched on every k-th point.

use crate::evidence::off;
use crate::fit::gauss_newton::{DAMPING_FACTOR, FIRST_DAMPING, converge};
use crate::fit::options::Options;
use crate::noise::weights::Weights;
use crate::problem::design::Design;
use crate::problem::side_by_side::SideBySide;
use crate::solve::collinear::{CONDITION_INDEX, condition_index};
use crate::solve::golden_section::golden_section;
use crate::solve::linear::Reduced;
use crate::spectrum::shapes::{at_rest, carriers, found};
use crate::spectrum::wave::Waves;
use crate::{Experiment, IdentifyError};
use nalgebra::{DMatrix, DVector};
use trunnion_core::Joint;
use trunnion_effects::{Instance, Unit};

/// Points that a search looks at.
const MOST_POINTS: usize = 4000;
/// Share of a column's norm that must survive the others, else it counts as theirs.
const SURVIVES: f64 = 1e-4;
/// Relative singular value of a direction that columns do not have.
const NO_DIRECTION: f64 = 1e-8;
/// Share of the largest column of an effect and unit below which another is rounding of positions: a micrometre in a millimetre, some arc seconds in a
/// degree.
const NOTHING: f64 = 1e-3;
const MOST_ROUNDS: usize = 4;
const GOLDEN_STEPS: usize = 24;
/// Steps of several numbers together, and the gain, as a share of what the effect explains, below which they stand.
const MOST_STEPS: usize = 20;
const STANDS: f64 = 1e-9;

/// Chooses every free shape in `joint`; true when there was one.
pub(crate) fn search_shapes(
    experiment: &Experiment,
    joint: &mut SideBySide,
    used: &[bool],
    weights: &Weights,
    options: &Options,
) -> Result<bool, IdentifyError> {
    let open: Vec<usize> = (0..joint.effects.len()).filter(|&k| joint.effects[k].shape_is_free).collect();
    if open.is_empty() {
        return Ok(false);
    }
    let rows = Rows { list: searched_rows(experiment, used), weights };
    let z = linear_readings(experiment, joint, used, weights, options)?.select_rows(&rows.list);
    for _ in 0..MOST_ROUNDS {
        let before: Vec<Vec<f64>> = joint.effects.iter().map(|placed| placed.shape.clone()).collect();
        for &k in &open {
            joint.effects[k].shape = best_shape(experiment, joint, k, &rows, &z);
        }
        if open.len() == 1 || joint.effects.iter().zip(&before).all(|(now, then)| now.shape == *then) {
            break;
        }
    }
    Ok(true)
}

fn searched_rows(experiment: &Experiment, used: &[bool]) -> Vec<usize> {
    let step = experiment.points.len().div_ceil(MOST_POINTS);
    (0..experiment.points.len())
        .step_by(step)
        .filter(|&i| used[i])
        .flat_map(|i| experiment.rows_of(i))
        .collect()
}

/// Rows that a search looks at.
struct Rows<'a> {
    list: Vec<usize>,
    weights: &'a Weights,
}

impl Rows<'_> {
    /// Position of an axis at every row looked at, mm or rad.
    fn positions(&self, experiment: &Experiment, joint: Joint) -> Vec<f64> {
        let positions = experiment.positions(joint);
        self.list.iter().map(|&row| positions[row]).collect()
    }
}

/// Weighted readings as a linear machine would give them: measured − (exact − linear) at a first fit.
fn linear_readings(
    experiment: &Experiment,
    joint: &SideBySide,
    used: &[bool],
    weights: &Weights,
    options: &Options,
) -> Result<DVector<f64>, IdentifyError> {
    let design = Design::new(experiment, joint, weights);
    let fit = converge(&design, used, options)?;
    let mut linear = fit.weighted_mm;
    design.blocks(&mut |_, rows, columns| {
        let mut part = linear.rows_mut(rows.start, rows.len());
        part.gemv(1.0, &columns, &fit.solution, 1.0);
    });
    Ok(linear)
}

fn best_shape(
    experiment: &Experiment,
    joint: &SideBySide,
    effect: usize,
    rows: &Rows<'_>,
    z: &DVector<f64>,
) -> Vec<f64> {
    let instance = &joint.effects[effect].instance;
    let shapes = &joint.effects[effect].shapes;
    let others = basis(others(experiment, joint, effect, rows));
    let left = z - &others * others.tr_mul(z);
    let score = |shape: &[f64]| score(experiment, instance, shape, rows, &others, &left);
    let mut grid = shapes.grid.clone();
    if let Some(wave) = shapes.wave {
        let moving = carriers(&selected(experiment, &[(instance, &at_rest(wave))], rows));
        let positions = rows.positions(experiment, wave.joint());
        let waves = Waves::new(positions, moving, others.clone(), left.clone());
        let found = found(wave, &waves);
        grid.extend(found.into_iter().flat_map(|found| found.shapes));
    }
    let scores: Vec<f64> = grid.iter().map(|shape| score(shape)).collect();
    let best = (0..scores.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b])).unwrap_or(0);
    let mut shape = grid[best].clone();
    if shapes.continuous {
        let mut reached = scores[best];
        for axis in 0..shape.len() {
            let (low, high) = neighbours(&shapes.grid, axis, shape[axis]);
            let at = |value: f64| {
                let mut tried = shape.clone();
                tried[axis] = value;
                score(&tried)
            };
            let value = golden_section(low, high, GOLDEN_STEPS, &mut |value| at(value));
            let found = at(value);
            if found > reached {
                (shape[axis], reached) = (value, found);
            }
        }
        if shape.len() > 1 {
            let index = |shape: &[f64]| condition_index(&selected(experiment, &[(instance, shape)], rows));
            let most = index(&shape).max(CONDITION_INDEX);
            // Terms that have become one have values that mean nothing, large and opposite.
            let score = |shape: &[f64]| if index(shape) <= most { score(shape) } else { f64::NEG_INFINITY };
            let step = |shape: &[f64], damping: f64| {
                step(experiment, instance, shape, rows, &others, &left, damping)
            };
            shape = together(shape, reached, &shapes.grid, step, score);
        }
    }
    shape
}

/// Several numbers of one effect moved together: each found for itself depends on the others. `step`: a damped step from a shape.
fn together(
    mut shape: Vec<f64>,
    mut reached: f64,
    grid: &[Vec<f64>],
    step: impl Fn(&[f64], f64) -> Option<DVector<f64>>,
    score: impl Fn(&[f64]) -> f64,
) -> Vec<f64> {
    let range = |k: usize| {
        let values = || grid.iter().map(|shape| shape[k]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let mut damping = FIRST_DAMPING;
    for _ in 0..MOST_STEPS {
        let Some(change) = step(&shape, damping) else { break };
        let moved = |(k, change): (usize, &f64)| {
            let (low, high) = range(k);
            (shape[k] + change).clamp(low, high)
        };
        let tried: Vec<f64> = change.iter().enumerate().map(moved).collect();
        let found = score(&tried);
        if found <= reached {
            damping *= DAMPING_FACTOR;
            continue;
        }
        let is_last = found - reached < STANDS * found;
        (shape, reached, damping) = (tried, found, damping / DAMPING_FACTOR);
        if is_last {
            break;
        }
    }
    shape
}

/// A step of the shape numbers towards the least squares of readings, values fitted at each shape [Rust 2013]; the diagonal of the normal matrix is
/// larger by `damping` [Marquardt 1963]. `left` has no part in the span of `others`.
fn step(
    experiment: &Experiment,
    instance: &Instance,
    shape: &[f64],
    rows: &Rows<'_>,
    others: &DMatrix<f64>,
    left: &DVector<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let columns = selected(experiment, &[(instance, shape)], rows);
    let own = off(&columns, others);
    let svd = own.svd(true, true);
    let least = SURVIVES * svd.singular_values.max();
    let values = svd.solve(left, least).ok()?;
    let seen: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&k| svd.singular_values[k] > least).collect();
    let own_basis = svd.u?.select_columns(&seen);
    let residual = left - &own_basis * own_basis.tr_mul(left);
    let change = |k: usize| {
        let all = experiment.change_with_shape(instance, shape, k, 0.0, &values);
        all.component_mul(&rows.weights.root).select_rows(&rows.list)
    };
    let changes = DMatrix::from_columns(&(0..shape.len()).map(change).collect::<Vec<_>>());
    let changes = off(&off(&changes, others), &own_basis);
    let mut normal = changes.tr_mul(&changes);
    for k in 0..shape.len() {
        normal[(k, k)] *= 1.0 + damping;
    }
    Some(normal.cholesky()?.solve(&changes.tr_mul(&residual)))
}

fn others(experiment: &Experiment, joint: &SideBySide, effect: usize, rows: &Rows<'_>) -> DMatrix<f64> {
    let chosen: Vec<(&Instance, &[f64])> = joint
        .effects
        .iter()
        .enumerate()
        .filter(|(k, _)| *k != effect)
        .map(|(_, placed)| (&placed.instance, placed.shape.as_slice()))
        .collect();
    selected(experiment, &chosen, rows)
}

fn selected(experiment: &Experiment, effects: &[(&Instance, &[f64])], rows: &Rows<'_>) -> DMatrix<f64> {
    let Rows { list: rows, weights } = rows;
    let width = effects.iter().map(|(instance, _)| instance.parameters(&experiment.scene).len()).sum();
    let mut columns = DMatrix::zeros(rows.len(), width);
    let mut k = 0;
    for i in 0..experiment.points.len() {
        let of_point = experiment.rows_of(i);
        if k < rows.len() && rows[k] == of_point.start {
            let mut part = DMatrix::zeros(of_point.len(), width);
            experiment.add_columns(effects, i..i + 1, &mut part);
            let root = weights.root.rows(of_point.start, of_point.len());
            part.column_iter_mut().for_each(|mut column| column.component_mul_assign(&root));
            columns.rows_mut(k, of_point.len()).copy_from(&part);
            k += of_point.len();
        }
    }
    columns
}

fn score(
    experiment: &Experiment,
    instance: &Instance,
    shape: &[f64],
    rows: &Rows<'_>,
    others: &DMatrix<f64>,
    left: &DVector<f64>,
) -> f64 {
    let mut columns = selected(experiment, &[(instance, shape)], rows);
    let units = instance.parameters(&experiment.scene).into_iter().map(|parameter| parameter.unit);
    let sizes: Vec<(Unit, f64)> = units.zip(columns.column_iter().map(|column| column.norm())).collect();
    for (mut column, (unit, norm)) in columns.column_iter_mut().zip(&sizes) {
        let of_unit = sizes.iter().filter(|(other, _)| other == unit).map(|(_, norm)| *norm);
        // What is left of a sine that is read at its zeros is no column: the fit gives it no number either.
        if *norm > NOTHING * of_unit.fold(0.0, f64::max) {
            column.unscale_mut(*norm)
        } else {
            column.fill(0.0)
        }
    }
    let own = off(&columns, others);
    let svd = own.svd(true, false);
    let u = svd.u.expect("asked for");
    (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > SURVIVES)
        .map(|k| u.column(k).dot(left).powi(2))
        .sum()
}

/// Orthonormal basis of the span of `columns`.
fn basis(columns: DMatrix<f64>) -> DMatrix<f64> {
    if columns.is_empty() {
        return DMatrix::zeros(columns.nrows(), 0);
    }
    let turn = Reduced::from_design(&columns).orthonormal(NO_DIRECTION);
    columns * turn
}

fn neighbours(grid: &[Vec<f64>], axis: usize, value: f64) -> (f64, f64) {
    let below = grid
        .iter()
        .map(|g| g[axis])
        .filter(|g| *g < value)
        .fold(value, |a, b| if a == value { b } else { a.max(b) });
    let above = grid
        .iter()
        .map(|g| g[axis])
        .filter(|g| *g > value)
        .fold(value, |a, b| if a == value { b } else { a.min(b) });
    (below, above)
}
