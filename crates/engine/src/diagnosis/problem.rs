//! An experiment and a model, laid out for scans: readings, base columns, libraries, noise bank.

use crate::diagnosis::columns::credible_columns;
use crate::diagnosis::least_squares::solve;
use crate::diagnosis::vocabulary::Vocabulary;
use crate::evidence::{Bank, Blocks, Entry, Library, Natural, WHITE, stacked};
use crate::fit::Options;
use crate::noise::machine_noise::{Order, repeatable_motions};
use crate::{DiagnoseError, Experiment, Identification, identify};
use nalgebra::{DMatrix, DVector};
use std::sync::OnceLock;
use trunnion_cycles::RunKind;
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, Model, Role, Shapes};
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// Second-order part of a prediction that counts, mm.
const LEAST_BEND_MM: f64 = 0.05e-3;

/// Share in the repeatable motions above which an effect looks like one of them.
const ALIKE: f64 = 0.9;

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
    /// Readings minus the nominal prediction and what the model holds fixed, mm, weighted.
    pub readings: DVector<f64>,
    pub order: Order,
    pub bank: Bank,
    /// Root of the weight of each row: base, readings and every column are multiplied by it.
    pub root: DVector<f64>,
}

impl<'a> Problem<'a> {
    pub fn new(experiment: &'a Experiment, model: &Model, without: &[String]) -> Result<Self, DiagnoseError> {
        // A model that does not settle is judged with all rows alike, by its columns alone; `identify` says so itself.
        let fit = identify(experiment, model, &Options::quick()).ok();
        let root = roots(experiment, fit.as_ref());
        let (mut base, mut readings) = base_columns(experiment, model, fit.as_ref())?;
        base.row_iter_mut().for_each(|mut row| row.component_mul_assign(&root.transpose()));
        readings.component_mul_assign(&root);
        let in_model = |id: &str| BASE.contains(&id) || model.effects.iter().any(|entry| entry.id == id);
        let mut out_of_reach = Vec::new();
        let (mut instances, mut shapes, mut groups) = (Vec::new(), Vec::new(), Vec::new());
        for instance in Instance::all(experiment.machine()) {
            if instance.role() == Role::Description
                || in_model(&instance.id())
                || without.contains(&instance.id())
            {
                continue;
            }
            let grid = instance.shapes(&experiment.scene);
            if instance.parameters(&experiment.scene).is_empty() || grid.grid.is_empty() {
                out_of_reach.push(instance.id());
                continue;
            }
            let parts: Vec<DMatrix<f64>> = grid
                .grid
                .iter()
                .map(|shape| weighted(credible_columns(experiment, &instance, shape), &root))
                .collect();
            let natural = if instance.role() == Role::Natural { Natural::Yes } else { Natural::No };
            groups.push(Entry { parts, prior_ln: 0.0, natural });
            instances.push(instance);
            shapes.push(grid);
        }
        let prior = -(groups.len().max(1) as f64).ln();
        for (group, instance) in groups.iter_mut().zip(&instances) {
            group.prior_ln = prior - instance.role().price_ln();
        }
        let mut named = Library::new(experiment.rows(), groups);
        let order = Order::new(experiment).weighted(&root);
        let vocabulary = Vocabulary::new(experiment, &order, &root);
        let bare = model.effects.iter().all(|entry| BASE.contains(&entry.id.as_str()));
        let motions = weighted(repeatable_motions(experiment).transpose(), &root).transpose();
        let bank = Bank::new(&order, &base, &motions, bare);
        let parameters = bank.base_rank();
        if experiment.rows() < 2 * parameters {
            return Err(DiagnoseError::TooFewReadings { rows: experiment.rows(), parameters });
        }
        let members = bank.all();
        let named_blocks = bank.blocks(&named, &members);
        let like_motions = bank.members[WHITE].like_motions(&named, &named_blocks[WHITE]);
        let mut of_part = like_motions.iter();
        for group in &mut named.groups {
            let most = of_part.by_ref().take(group.parts.len()).copied().fold(0.0, f64::max);
            if group.natural == Natural::No && most > ALIKE {
                group.natural = Natural::Alike;
            }
        }
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
            root,
        })
    }

    /// Columns of an instance, column × row; rows count with their weights.
    pub fn columns(&self, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
        weighted(credible_columns(self.experiment, instance, shape), &self.root).transpose()
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
}

/// Roots of the weights of the rows: blocks of a stream and runs of several kinds are worth what `identify` finds; points at rest of
/// one run count alike.
fn roots(experiment: &Experiment, fit: Option<&Identification>) -> DVector<f64> {
    let alike = DVector::from_element(experiment.rows(), 1.0);
    if experiment.kinds.iter().all(|kind| *kind == RunKind::Static) && experiment.runs.len() == 1 {
        return alike;
    }
    fit.map_or(alike, |fit| fit.row_weights.clone())
}

/// Columns (rows × columns) multiplied by the roots of the weights.
fn weighted(mut columns: DMatrix<f64>, root: &DVector<f64>) -> DMatrix<f64> {
    columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(root));
    columns
}

/// What the exact prediction of the fitted model has beyond its columns, mm: stations and artefacts are a millimetre off
/// their places, and the square of that over their distance shows. `None` when it is too little to count.
fn nonlinear_mm(
    experiment: &Experiment,
    model: &Model,
    fit: &Identification,
    nominal_mm: &DVector<f64>,
) -> Option<DVector<f64>> {
    let mut beyond_mm = &fit.predicted_mm - nominal_mm;
    let mut first = 0;
    for (entry, effect) in model.effects.iter().zip(&fit.effects) {
        let instance = Instance::from_model_effect(entry, experiment.machine()).ok()?;
        let columns = experiment.columns(&instance, &effect.shape);
        beyond_mm -= &columns * fit.solution.rows(first, columns.ncols());
        first += columns.ncols();
    }
    (beyond_mm.amax() > LEAST_BEND_MM).then_some(beyond_mm)
}

/// Columns of the model (column × row) and readings minus nominal prediction, its second-order part and held parameters.
fn base_columns(
    experiment: &Experiment,
    model: &Model,
    fit: Option<&Identification>,
) -> Result<(DMatrix<f64>, DVector<f64>), DiagnoseError> {
    let machine = experiment.machine();
    let mut readings = experiment.readings_mm();
    for (i, point) in experiment.points.iter().enumerate() {
        let setup = &experiment.setups[point.state.setup];
        let nominal = predict(machine, setup, &point.state, &Errors::default());
        for (k, row) in experiment.rows_of(i).enumerate() {
            readings[row] -= nominal[k];
        }
    }
    let nominal_mm = experiment.readings_mm() - &readings;
    if let Some(bent_mm) = fit.and_then(|fit| nonlinear_mm(experiment, model, fit, &nominal_mm)) {
        readings -= bent_mm;
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
        let parts = grid.iter().map(|shape| credible_columns(experiment, &instance, shape).transpose());
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
