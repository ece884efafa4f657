//! A problem laid out for a scan: what its fit leaves, the columns of its model and of all that competes, and the noise learned
//! from it.

use crate::diagnosis::options::DiagnoseError;
use crate::diagnosis::vocabulary::Vocabulary;
use crate::evidence::{joined, orthonormal, turned};
use crate::noise::learned::Real;
use crate::noise::learned::mode::{Mode, Readings};
use crate::noise::learned::remainder::{Remainder, weighted};
use crate::noise::learned::sigma::NOTHING;
use crate::problem::Problem;
use crate::problem::credible::Seen;
use crate::solve::logarithms::log_mean_exp;
use crate::spectrum::free_waves;
use crate::spectrum::left::Left;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, Role, Shapes};

/// Everything a search needs.
pub struct Scan<'a> {
    /// What the model leaves, for spectra.
    pub residual: Left,
    /// What the fit of the problem leaves, and the columns of the model.
    pub remainder: Remainder<'a>,
    /// All points, for columns at further shapes.
    seen: Seen<'a>,
    /// Named effects that compete.
    pub named: Vec<Named>,
    /// Their columns at all shapes, turned, side by side.
    pub columns: DMatrix<Real>,
    /// Width of each shape, effect after effect.
    pub widths: Vec<usize>,
    /// Effects this scene cannot have.
    pub out_of_reach: Vec<String>,
    pub vocabulary: Vocabulary,
    white: DVector<f64>,
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
        let remainder =
            Remainder::new(experiment, &fit.fitted(), |rows, root| problem.columns_on(rows, root))?;
        let (rows, parameters) = (remainder.rows.points.rows(), remainder.basis.ncols());
        if rows < 2 * parameters {
            return Err(DiagnoseError::TooFewReadings { rows, parameters });
        }
        let noise = fit.noise.clone().or_else(|| Some(remainder.learn()?.0)).ok_or(DiagnoseError::NoNoise)?;
        let first = remainder.mode_from(&noise).ok_or(DiagnoseError::NoNoise)?;
        let left = Left::of(problem)?;
        let seen = Seen::new(experiment);
        let (named, columns, widths, out_of_reach) = competitors(problem, &left, &remainder, &seen, without);
        let waves = free_waves(&left);
        let vocabulary = Vocabulary::new(&remainder.rows.points, &remainder.root, &waves);
        Ok(Self {
            residual: left,
            remainder,
            seen,
            named,
            columns,
            widths,
            out_of_reach,
            vocabulary,
            white: noise.white,
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
        let counts = |row: &usize| self.white[*row] < NOTHING;
        let Remainder { base, y, unit_mm, .. } = &self.remainder;
        let rows: Vec<usize> = (0..y.len()).filter(counts).collect();
        let basis = orthonormal(&joined(base, chosen).select_rows(&rows));
        let y = y.select_rows(&rows).cast::<f64>();
        let left = &y - &basis * basis.tr_mul(&y);
        (left.norm_squared() / rows.len().max(1) as f64).sqrt() * unit_mm
    }

    pub fn readings(&self) -> Readings<'_> {
        self.remainder.readings(&self.white)
    }

    /// Columns of an instance at a shape; rows count with their weights.
    pub fn columns_of(&self, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
        let Remainder { rows, root, .. } = &self.remainder;
        weighted(rows.of(self.seen.credible_columns(instance, shape)), root)
    }

    /// The same where they are numbers.
    pub fn finite_columns_of(&self, instance: &Instance, shape: &[f64]) -> Option<DMatrix<f64>> {
        Some(self.columns_of(instance, shape)).filter(|columns| columns.iter().all(|x| x.is_finite()))
    }
}

type Competitors = (Vec<Named>, DMatrix<Real>, Vec<usize>, Vec<String>);

/// Effects of the catalogue that are not in the model, with their columns.
fn competitors(
    problem: &Problem<'_>,
    left: &Left,
    remainder: &Remainder<'_>,
    seen: &Seen<'_>,
    without: &[String],
) -> Competitors {
    let (experiment, model) = (problem.experiment(), problem.model());
    let Remainder { rows, root, .. } = remainder;
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
            let columns = weighted(rows.of(seen.credible_columns(&instance, shape)), root);
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
