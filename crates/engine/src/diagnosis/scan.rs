//! A problem laid out for a scan: what its fit leaves, the columns of its model, libraries of columns that compete, noise bank.

use crate::diagnosis::columns::credible_columns;
use crate::diagnosis::options::DiagnoseError;
use crate::diagnosis::thinning;
use crate::diagnosis::vocabulary::Vocabulary;
use crate::evidence::{Bank, Blocks, Entry, Library, Natural, WHITE};
use crate::fit::options::IdentifyError;
use crate::noise::machine_noise::{Order, repeatable_motions};
use crate::noise::weights::weigh;
use crate::problem::Problem;
use crate::problem::experiment::Experiment;
use crate::solve::direction::Status;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use std::sync::OnceLock;
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, Role, Shapes};

/// Share in the repeatable motions above which an effect looks like one of them.
const ALIKE: f64 = 0.9;

/// Everything a search needs.
pub struct Scan<'a> {
    /// The points scanned.
    pub experiment: Cow<'a, Experiment>,
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
    /// What the fit of the problem leaves, weighted, mm: exact, so that nothing of second order is taken for an effect.
    pub readings: DVector<f64>,
    pub bank: Bank,
    /// Root of the weight of each row: base, readings and every column are multiplied by it.
    pub root: DVector<f64>,
}

impl<'a> Scan<'a> {
    pub fn new(problem: &Problem<'a>, without: &[String]) -> Result<Self, DiagnoseError> {
        let (experiment, mut readings, root) = points(problem);
        let model = problem.model();
        let base = weighted(base_columns(&experiment, problem)?, &root).transpose();
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
                .map(|shape| weighted(credible_columns(&experiment, &instance, shape), &root))
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
        let order = Order::new(&experiment).weighted(&root);
        let vocabulary = Vocabulary::new(&experiment, &order, &root);
        let bare = model.effects.iter().all(|entry| BASE.contains(&entry.id.as_str()));
        let motions = weighted(repeatable_motions(&experiment).transpose(), &root).transpose();
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
            bank,
            root,
        })
    }

    /// Columns of an instance, column × row; rows count with their weights.
    pub fn columns(&self, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
        weighted(credible_columns(&self.experiment, instance, shape), &self.root).transpose()
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

/// The points scanned, what the fit leaves of them (mm), and the roots of the weights of their rows.
fn points<'a>(problem: &Problem<'a>) -> (Cow<'a, Experiment>, DVector<f64>, DVector<f64>) {
    let (experiment, fit) = (problem.experiment(), problem.fit());
    let Some(keep) = thinning::kept(experiment) else {
        return (Cow::Borrowed(experiment), fit.residual_mm.clone(), fit.row_weights.clone());
    };
    let kept: Vec<usize> = (0..keep.len()).filter(|&i| keep[i]).collect();
    let rows: Vec<usize> = kept.iter().flat_map(|&i| experiment.rows_of(i)).collect();
    let residual_mm = fit.residual_mm.select_rows(&rows);
    let used: Vec<bool> = kept.iter().map(|&i| fit.used[i]).collect();
    let thinned = experiment.kept(&keep);
    // Blocks farther apart err less alike, so that each of them counts for more.
    let determined = fit.parameters.iter().filter(|p| p.status == Status::Identified).count();
    let (weights, _) = weigh(&thinned, &residual_mm, &used, determined);
    (Cow::Owned(thinned), residual_mm, weights.root)
}

/// Columns (rows × columns) multiplied by the roots of the weights.
fn weighted(mut columns: DMatrix<f64>, root: &DVector<f64>) -> DMatrix<f64> {
    columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(root));
    columns
}

/// Columns of the free parameters of the model at the shapes fitted, rows × columns.
fn base_columns(experiment: &Experiment, problem: &Problem<'_>) -> Result<DMatrix<f64>, IdentifyError> {
    let mut base = DMatrix::zeros(experiment.rows(), 0);
    for (entry, fitted) in problem.model().effects.iter().zip(&problem.fit().effects) {
        let instance = Instance::from_model_effect(entry, experiment.machine())?;
        let columns = credible_columns(experiment, &instance, &fitted.shape);
        let parameters = instance.parameters(&experiment.scene);
        let is_free = |j: &usize| entry.fixed.iter().all(|(name, _)| *name != parameters[*j].name);
        let free: Vec<usize> = (0..parameters.len()).filter(is_free).collect();
        let first = base.ncols();
        base = base.resize_horizontally(first + free.len(), 0.0);
        base.columns_mut(first, free.len()).copy_from(&columns.select_columns(&free));
    }
    Ok(base)
}
