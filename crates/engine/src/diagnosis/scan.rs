//! A problem laid out for a scan: what its fit leaves, the columns of its model and of all that competes, and the noise learned
//! from it.

use crate::diagnosis::options::DiagnoseError;
use crate::diagnosis::rows::Rows;
use crate::diagnosis::vocabulary::Vocabulary;
use crate::evidence::{beside, log_mean_exp, orthonormal, turned};
use crate::noise::learned::display::Display;
use crate::noise::learned::kernels::Kernels;
use crate::noise::learned::mode::{Effort, Mode, Readings};
use crate::noise::learned::{Real, tails};
use crate::noise::outliers::median;
use crate::problem::Problem;
use crate::problem::credible::credible_columns;
use crate::spectrum::free_waves;
use crate::spectrum::left::Left;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, Role, Shapes};

/// Median of |x| for a standard normal x.
const MEDIAN_LENGTH: f64 = 0.6745;
/// Of the robust size of the residual, what is white to begin with.
const WHITE_FIRST: f64 = 0.7;
/// Readings are never trusted below this, mm: ten times under the resolution of any probe.
const FINEST_MM: f64 = 1e-6;
/// Rounds of learning the weights of points.
const WEIGHINGS: usize = 2;

/// Everything a search needs.
pub struct Scan<'a> {
    /// What the model leaves, for spectra.
    pub residual: Left,
    /// The rows that are looked at.
    pub rows: Rows<'a>,
    /// Named effects that compete.
    pub named: Vec<Named>,
    /// Their columns at all shapes, turned, side by side.
    pub columns: DMatrix<Real>,
    /// Width of each shape, effect after effect.
    pub widths: Vec<usize>,
    /// Effects this scene cannot have.
    pub out_of_reach: Vec<String>,
    pub vocabulary: Vocabulary,
    /// Columns of the model, weighted.
    pub base: DMatrix<f64>,
    /// What the fit of the problem leaves, weighted, in units of `unit_mm`: exact, so that nothing of second order is taken for an effect.
    pub y: DVector<Real>,
    pub unit_mm: f64,
    /// The display of the readings where its step is coarser than the residual.
    pub coarse_display: Option<Display>,
    pub kernels: Kernels,
    white: DVector<f64>,
    least_ln: f64,
    /// Root of the weight of each row: base, readings and every column are multiplied by it.
    pub root: DVector<f64>,
    /// The noise when nothing is added.
    pub first: Mode,
}

/// A named effect that competes.
pub struct Named {
    pub instance: Instance,
    pub shapes: Shapes,
    /// Independent values that its shapes were chosen from: those of its grid, of waves also what the spectrum was searched for.
    pub tries: f64,
    /// Its shapes among all.
    pub parts: Range<usize>,
    /// What its prior costs beyond the number of effects, ln.
    pub price_ln: f64,
    pub natural: bool,
}

impl Named {
    /// ln of the mean Bayes factor over all that its shapes were chosen from, from `ln` of each shape: those not listed explain nothing.
    pub fn averaged(&self, ln: &[f64]) -> f64 {
        log_mean_exp(ln) + (ln.len() as f64 / self.tries.max(1.0)).ln()
    }
}

impl<'a> Scan<'a> {
    pub fn new(problem: &Problem<'a>, without: &[String]) -> Result<Self, DiagnoseError> {
        let (experiment, fit) = (problem.experiment(), problem.fit());
        let rows = Rows::new(experiment);
        let of_rows = |columns: DMatrix<f64>| rows.of(columns);
        let root = rows.of_vector(fit.row_weights.clone());
        let mut base = weighted(of_rows(problem.columns(experiment)?), &root);
        let residual = rows.of_vector(fit.residual_mm.clone()).component_mul(&root);
        let sizes: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
        let unit_mm = (median(&sizes) / MEDIAN_LENGTH).max(FINEST_MM);
        let display = Display::of(experiment);
        let least_mm = display.as_ref().map_or(0.0, |display| display.hidden_mm()).max(FINEST_MM);
        let least_ln = (least_mm / unit_mm).ln();
        let coarse_display = display.filter(|display| display.step_mm > unit_mm);
        if let Some(display) = &coarse_display {
            base = beside(&base, &weighted(of_rows(display.saw(experiment, &fit.predicted_mm)), &root));
        }
        let left = Left::of(problem)?;
        let (named, columns, widths, out_of_reach) = competitors(problem, &left, &rows, &root, without);
        let vocabulary = Vocabulary::new(&rows.points, &root, &free_waves(&left));
        let basis = orthonormal(&base);
        if rows.points.rows() < 2 * basis.ncols() {
            let (rows, parameters) = (rows.points.rows(), basis.ncols());
            return Err(DiagnoseError::TooFewReadings { rows, parameters });
        }
        let kernels = Kernels::new(&rows.points, &root, rows.readings_of_one().sqrt());
        let y = (residual / unit_mm).cast::<Real>();
        let used: Vec<bool> = (0..rows.points.points.len())
            .map(|node| rows.points_of(node).iter().all(|&point| fit.used[point]))
            .collect();
        let (white, first) = learned(&kernels, &y, &basis.cast::<Real>(), &used, least_ln);
        let first = first.ok_or(DiagnoseError::NoNoise)?;
        Ok(Self {
            residual: left,
            rows,
            named,
            columns,
            widths,
            out_of_reach,
            vocabulary,
            base,
            y,
            unit_mm,
            coarse_display,
            kernels,
            white,
            least_ln,
            root,
            first,
        })
    }

    /// Turned columns of one shape.
    pub fn part(&self, part: usize) -> DMatrix<f64> {
        let first = self.widths[..part].iter().sum();
        self.columns.columns(first, self.widths[part]).map(f64::from)
    }

    /// Root mean square in units of a reading of what the model and `chosen` leave of the points that count, plain least squares.
    pub fn left(&self, chosen: &DMatrix<f64>) -> f64 {
        let counts = |row: &usize| self.white[*row] < tails::NOTHING;
        let rows: Vec<usize> = (0..self.y.len()).filter(counts).collect();
        let basis = orthonormal(&beside(&self.base, chosen).select_rows(&rows));
        let y = self.y.select_rows(&rows).cast::<f64>();
        let left = &y - &basis * basis.tr_mul(&y);
        (left.norm_squared() / rows.len().max(1) as f64).sqrt() * self.unit_mm
    }

    pub fn readings(&self) -> Readings<'_> {
        Readings { kernels: &self.kernels, y: &self.y, white: &self.white, least_ln: self.least_ln }
    }

    /// Columns of an instance at a shape; rows count with their weights.
    pub fn columns_of(&self, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
        weighted(self.rows.of(credible_columns(self.rows.whole(), instance, shape)), &self.root)
    }
}

/// The noise when nothing is added, with the weights of points that it asks for.
fn learned(
    kernels: &Kernels,
    y: &DVector<Real>,
    basis: &DMatrix<Real>,
    used: &[bool],
    least_ln: f64,
) -> (DVector<f64>, Option<Mode>) {
    let of_point = |i: &usize| if used[*i] { 1.0 } else { tails::NOTHING };
    let mut white = DVector::from_iterator(y.len(), kernels.point_of_row.iter().map(of_point));
    let mut x: Vec<f64> = std::iter::once(WHITE_FIRST.ln()).chain(kernels.means()).collect();
    let mut effort = Effort::FULL;
    let mut mode = None;
    for round in 0..=WEIGHINGS {
        let readings = Readings { kernels, y, white: &white, least_ln };
        mode = readings.sigma(&x).and_then(|start| readings.learn(basis, start, effort));
        let Some(found) = mode.as_ref().filter(|_| round < WEIGHINGS) else { break };
        let Some(weights) = tails::weights(found, &kernels.rows_of_point, &white, used) else { break };
        x = found.x().to_vec();
        (white, effort) = (weights, Effort { steps: Effort::FULL.steps / 2, ..Effort::FULL });
    }
    (white, mode)
}

type Competitors = (Vec<Named>, DMatrix<Real>, Vec<usize>, Vec<String>);

/// Effects of the catalogue that are not in the model, with their columns.
fn competitors(
    problem: &Problem<'_>,
    left: &Left,
    rows: &Rows<'_>,
    root: &DVector<f64>,
    without: &[String],
) -> Competitors {
    let (experiment, model) = (problem.experiment(), problem.model());
    let in_model = |id: &str| BASE.contains(&id) || model.effects.iter().any(|entry| entry.id == id);
    let (mut named, mut blocks, mut out_of_reach) = (Vec::new(), Vec::new(), Vec::new());
    for instance in Instance::all(experiment.machine()) {
        let id = instance.id();
        if instance.role() == Role::Description || in_model(&id) || without.contains(&id) {
            continue;
        }
        let mut shapes = instance.shapes(&experiment.scene);
        if instance.parameters(&experiment.scene).is_empty() || shapes.grid.is_empty() {
            out_of_reach.push(id);
            continue;
        }
        let mut tries = shapes.grid.len() as f64;
        if let Some(found) = left.found(&instance, &shapes) {
            tries += found.tries;
            shapes.grid.extend(found.shapes);
        }
        let first = blocks.len();
        for shape in &shapes.grid {
            let columns = weighted(rows.of(credible_columns(experiment, &instance, shape)), root);
            blocks.push(turned(&columns).cast::<Real>());
        }
        let (price_ln, natural) = (instance.role().price_ln(), instance.role() == Role::Natural);
        named.push(Named { instance, shapes, tries, parts: first..blocks.len(), price_ln, natural });
    }
    let widths: Vec<usize> = blocks.iter().map(DMatrix::ncols).collect();
    let mut columns = DMatrix::zeros(rows.points.rows(), widths.iter().sum());
    let mut next = 0;
    for block in blocks {
        columns.columns_mut(next, block.ncols()).copy_from(&block);
        next += block.ncols();
    }
    (named, columns, widths, out_of_reach)
}

/// Columns (rows × columns) multiplied by the roots of the weights.
fn weighted(mut columns: DMatrix<f64>, root: &DVector<f64>) -> DMatrix<f64> {
    columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(root));
    columns
}
