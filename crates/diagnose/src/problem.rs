//! An experiment and a model, laid out for scans: readings, base columns, libraries, noise bank.

use crate::DiagnoseError;
use crate::evidence::{Bank, Blocks, Entry, Library, stacked};
use crate::vocabulary::{self, Vocabulary};
use nalgebra::{DMatrix, DVector};
use std::sync::OnceLock;
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, Model, Shapes};
use trunnion_identify::Experiment;
use trunnion_identify::machine_noise::{Order, repeatable_motions};
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// A point farther out than this many robust standard deviations is set aside.
const OUTLIER_SIGMA: f64 = 5.0;
/// Median of the length of a standard normal vector with 1 and with 3 components.
const MEDIAN_LENGTH: [f64; 2] = [0.6745, 1.5382];
/// Longer runs of far points are structure, not outliers.
const LONGEST_OUTLIER_RUN: usize = 2;
/// A larger share of far points is a heavy tail, not outliers.
const MOST_OUTLIERS: f64 = 0.06;

/// Everything a search needs.
pub struct Problem<'a> {
    pub experiment: &'a Experiment,
    /// Catalogue instances that compete, one for each group of `named`.
    pub instances: Vec<Instance>,
    /// Shape grids of `instances`.
    pub shapes: Vec<Shapes>,
    /// Effects this scene cannot have.
    pub out_of_reach: Vec<String>,
    pub named: Library,
    named_blocks: Vec<Blocks>,
    pub vocabulary: Vocabulary,
    open_blocks: Vec<OnceLock<Blocks>>,
    /// Base columns, column × row.
    pub base: DMatrix<f64>,
    /// Readings minus the nominal prediction and what the model holds fixed, mm.
    pub readings: DVector<f64>,
    pub order: Order,
    pub bank: Bank,
}

/// What a fit of base and chosen columns leaves.
pub struct Fit {
    /// Readings with the outliers replaced by their prediction.
    pub readings: DVector<f64>,
    /// True for each point set aside.
    pub outlier: Vec<bool>,
    /// Root mean square of the residual without outliers, mm.
    pub rms_mm: f64,
}

impl<'a> Problem<'a> {
    pub fn new(experiment: &'a Experiment, model: &Model, without: &[String]) -> Result<Self, DiagnoseError> {
        let (base, readings) = base_columns(experiment, model)?;
        let in_model = |id: &str| BASE.contains(&id) || model.effects.iter().any(|entry| entry.id == id);
        let mut out_of_reach = Vec::new();
        let (mut instances, mut shapes, mut groups) = (Vec::new(), Vec::new(), Vec::new());
        for instance in Instance::all(experiment.machine()) {
            if in_model(&instance.id()) || without.contains(&instance.id()) {
                continue;
            }
            let grid = instance.shapes(&experiment.scene);
            if instance.parameters(&experiment.scene).is_empty() || grid.grid.is_empty() {
                out_of_reach.push(instance.id());
                continue;
            }
            let parts: Vec<DMatrix<f64>> =
                grid.grid.iter().map(|shape| finite(experiment.columns(&instance, shape))).collect();
            let natural = instance.id().contains("-error-motion");
            groups.push(Entry { parts, prior_ln: 0.0, natural });
            instances.push(instance);
            shapes.push(grid);
        }
        let prior = -(groups.len().max(1) as f64).ln();
        for group in &mut groups {
            group.prior_ln = prior;
        }
        let named = Library::new(experiment.rows(), groups);
        let order = Order::new(experiment);
        let vocabulary = vocabulary::vocabulary(experiment, &order);
        let bank = Bank::new(&order, &base, &repeatable_motions(experiment));
        let parameters = bank.base_rank();
        if experiment.rows() < 2 * parameters {
            return Err(DiagnoseError::TooFewReadings { rows: experiment.rows(), parameters });
        }
        let members: Vec<usize> = (0..bank.members.len()).collect();
        let named_blocks = bank.blocks(&named, &members);
        let open_blocks = members.iter().map(|_| OnceLock::new()).collect();
        Ok(Self {
            experiment,
            instances,
            shapes,
            out_of_reach,
            named,
            named_blocks,
            vocabulary,
            open_blocks,
            base,
            readings,
            order,
            bank,
        })
    }

    /// Blocks of the named effects under every member.
    pub fn named_blocks(&self) -> Vec<&Blocks> {
        self.named_blocks.iter().collect()
    }

    /// Blocks of the vocabulary under some members, formed when first asked for.
    pub fn open_blocks(&self, members: &[usize]) -> Vec<&Blocks> {
        let missing: Vec<usize> =
            members.iter().copied().filter(|&m| self.open_blocks[m].get().is_none()).collect();
        for (m, blocks) in missing.iter().zip(self.bank.blocks(&self.vocabulary.library, &missing)) {
            self.open_blocks[*m].get_or_init(|| blocks);
        }
        members.iter().map(|&m| self.open_blocks[m].get().expect("formed above")).collect()
    }

    /// Ordinary least squares of base and `chosen` (column × row) with outliers set aside.
    pub fn fit(&self, chosen: &DMatrix<f64>) -> Fit {
        let design = stacked(&self.base, chosen);
        let points = self.experiment.points.len();
        let mut outlier = vec![false; points];
        let mut residual = self.readings.clone();
        for _ in 0..6 {
            residual = &self.readings - solve(&design, &self.readings, &self.weights(&outlier));
            let far = self.far_points(&residual);
            if far == outlier {
                break;
            }
            outlier = far;
        }
        let mut readings = self.readings.clone();
        let (mut sum, mut count) = (0.0, 0);
        for point in 0..points {
            for row in self.experiment.rows_of(point) {
                if outlier[point] {
                    readings[row] -= residual[row];
                } else {
                    sum += residual[row] * residual[row];
                    count += 1;
                }
            }
        }
        Fit { readings, outlier, rms_mm: (sum / f64::from(count.max(1))).sqrt() }
    }

    /// Root mean square of predictions of parts of the data from the rest, mm: whole passes, or stations of the slow axis
    /// where a setup was measured in one pass only.
    pub fn holdout_rms_mm(&self, chosen: &DMatrix<f64>, outlier: &[bool]) -> f64 {
        let design = stacked(&self.base, chosen);
        let fold_of_point = self.folds();
        let folds = fold_of_point.iter().max().map_or(0, |last| last + 1);
        let (mut sum, mut count) = (0.0, 0);
        for fold in 0..folds {
            let out: Vec<bool> = (0..outlier.len()).map(|i| outlier[i] || fold_of_point[i] == fold).collect();
            let residual = &self.readings - solve(&design, &self.readings, &self.weights(&out));
            for point in (0..outlier.len()).filter(|&i| fold_of_point[i] == fold && !outlier[i]) {
                for row in self.experiment.rows_of(point) {
                    sum += residual[row] * residual[row];
                    count += 1;
                }
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }

    fn folds(&self) -> Vec<usize> {
        let axis = self.order.slow.or(self.order.fast);
        let direction = |i: usize| axis.map_or(0, |l| self.experiment.points[i].state.direction[l] as i64);
        let mut passes: Vec<(usize, i64)> = Vec::new();
        let of_point: Vec<usize> = (0..self.experiment.points.len())
            .map(|i| {
                let pass = (self.experiment.points[i].state.setup, direction(i));
                passes.iter().position(|p| *p == pass).unwrap_or_else(|| {
                    passes.push(pass);
                    passes.len() - 1
                })
            })
            .collect();
        let setups = self.experiment.setups.len();
        let both_ways = (0..setups).all(|s| passes.iter().filter(|p| p.0 == s).count() != 1);
        if both_ways { of_point } else { self.order.stations().into_iter().map(|s| s % 4).collect() }
    }

    fn weights(&self, outlier: &[bool]) -> Vec<bool> {
        let mut used = vec![true; self.experiment.rows()];
        for (point, _) in outlier.iter().enumerate().filter(|(_, out)| **out) {
            for row in self.experiment.rows_of(point) {
                used[row] = false;
            }
        }
        used
    }

    fn far_points(&self, residual: &DVector<f64>) -> Vec<bool> {
        let points = self.experiment.points.len();
        let relative: Vec<f64> = (0..points)
            .map(|i| {
                let rows = self.experiment.rows_of(i);
                residual.rows(rows.start, rows.len()).norm() / MEDIAN_LENGTH[usize::from(rows.len() == 3)]
            })
            .collect();
        let mut sorted = relative.clone();
        sorted.sort_by(f64::total_cmp);
        let sigma = sorted[points / 2];
        let mut far: Vec<bool> = relative.iter().map(|r| *r > OUTLIER_SIGMA * sigma).collect();
        let sequence: Vec<usize> = self.order.points().collect();
        let mut k = 0;
        while k < points {
            let length = sequence[k..].iter().take_while(|&&i| far[i]).count();
            if length > LONGEST_OUTLIER_RUN {
                for &i in &sequence[k..k + length] {
                    far[i] = false;
                }
            }
            k += length.max(1);
        }
        let share = far.iter().filter(|f| **f).count() as f64 / points as f64;
        if share > MOST_OUTLIERS { vec![false; points] } else { far }
    }
}

/// Prediction of least squares on the rows used; directions the design cannot see stay zero.
pub fn solve(design: &DMatrix<f64>, readings: &DVector<f64>, used: &[bool]) -> DVector<f64> {
    let mut masked = design.clone();
    for (row, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
        masked.column_mut(row).fill(0.0);
    }
    let scale: Vec<f64> = masked.row_iter().map(|c| c.norm()).collect();
    for (j, mut column) in masked.row_iter_mut().enumerate() {
        column /= scale[j].max(1e-300);
    }
    let gram = &masked * masked.transpose();
    let right = &masked * readings;
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut along = eigen.eigenvectors.transpose() * right;
    for (j, value) in along.iter_mut().enumerate() {
        let eigenvalue = eigen.eigenvalues[j];
        *value = if eigenvalue > 1e-12 * largest { *value / eigenvalue } else { 0.0 };
    }
    let mut values = &eigen.eigenvectors * along;
    for (j, value) in values.iter_mut().enumerate() {
        *value /= scale[j].max(1e-300);
    }
    design.tr_mul(&values)
}

/// Columns of the model (column × row) and readings minus nominal prediction and held parameters.
fn base_columns(
    experiment: &Experiment,
    model: &Model,
) -> Result<(DMatrix<f64>, DVector<f64>), DiagnoseError> {
    let machine = experiment.machine();
    let mut readings = experiment.readings_mm();
    for (i, point) in experiment.points.iter().enumerate() {
        let setup = &experiment.setups[point.state.setup];
        let nominal = predict(machine, setup, &point.state.position, &Errors::default());
        for (k, row) in experiment.rows_of(i).enumerate() {
            readings[row] -= nominal[k];
        }
    }
    let mut base = DMatrix::zeros(0, experiment.rows());
    for entry in &model.effects {
        let instance = Instance::from_model_effect(entry, machine)?;
        let grid = if entry.shape.is_empty() {
            instance.shapes(&experiment.scene).grid
        } else {
            vec![entry.shape.clone()]
        };
        let used = vec![true; experiment.rows()];
        let parts = grid.iter().map(|shape| finite(experiment.columns(&instance, shape)).transpose());
        let left = |part: &DMatrix<f64>| (&readings - solve(&stacked(&base, part), &readings, &used)).norm();
        let best = parts.map(|part| (left(&part), part)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, columns)) = best else { continue };
        let parameters = instance.parameters(&experiment.scene);
        let mut free = Vec::new();
        for (j, parameter) in parameters.iter().enumerate() {
            match entry.fixed.iter().find(|(name, _)| *name == parameter.name) {
                Some((_, value)) => {
                    readings -= columns.row(j).transpose() * (value / parameter.unit.per_inside)
                }
                None => free.push(j),
            }
        }
        base = stacked(&base, &columns.select_rows(&free));
    }
    Ok((base, readings))
}

/// A column that is not finite everywhere takes no part.
fn finite(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in columns.column_iter_mut() {
        if column.iter().any(|x| !x.is_finite()) {
            column.fill(0.0);
        }
    }
    columns
}
