//! The columns in which an estimate is linear about itself: those of the determined parameters, then one for each shape number that the fit
//! found.
//!
//! ŷ(x̂ + δ, θ̂ + ε) = ŷ + A δ + D ε,   D_k = (A(θ̂ + h e_k) − A(θ̂ − h e_k)) x̂ / 2h,   N = ([A D]ᵀ[A D] + P)⁻¹      [Rust 2013]
//!
//! so that what the data leave open of a time constant is part of the u of the growth that goes with it. h is u(θ̂) itself: where the course
//! bends, the secant over what is open says more than the tangent. P: the priors of the model, and for each shape number the stretch that
//! its grid covers, evenly [GUM 4.3.7].
//! Limits: a change that is sudden has its moment between two readings, and none of its parameters depends on where between them; counts
//! (lobes, teeth) are what they are.

use crate::fit::gauss_newton::Converged;
use crate::problem::design::{Design, Visit};
use crate::problem::side_by_side::{Placed, SideBySide};
use nalgebra::{DMatrix, DVector};

/// Rounds in which h becomes u(θ̂): it stands within a few per cent after two.
const ROUNDS: usize = 3;

/// A shape number that the fit found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    /// Index of its effect.
    pub effect: usize,
    /// Which of the effect's shape numbers.
    pub at: usize,
    /// Standard deviation of the stretch that its grid covers.
    pub u_beforehand: f64,
    /// Weight w with which that entered as a reading w θ = w θ̂.
    pub weight: f64,
}

pub(crate) struct Sensitivity<'d, 'e> {
    pub design: &'d Design<'e>,
    determined: &'d [usize],
    pub numbers: Vec<Number>,
    /// D, weighted: rows × numbers.
    of_numbers: DMatrix<f64>,
    /// N.
    pub cofactor: DMatrix<f64>,
}

impl<'d, 'e> Sensitivity<'d, 'e> {
    pub fn new(design: &'d Design<'e>, fit: &'d Converged, used: &[bool]) -> Self {
        let determined = &fit.datum.determined[..];
        let sigma_mm = fit.reading_mm(design.weights);
        let numbers = numbers(design.joint, sigma_mm);
        let of_numbers = DMatrix::zeros(design.experiment.rows(), 0);
        let mut known =
            Self { design, determined, numbers: vec![], of_numbers, cofactor: fit.solver.cofactor() };
        if numbers.is_empty() {
            return known;
        }
        let alone = known.cofactor.clone();
        // A tangent first: the least step that the number allows.
        let mut h = vec![0.0; numbers.len()];
        for _ in 0..ROUNDS {
            let of_numbers = secants(design, &numbers, &fit.solution, &h);
            let Some(cofactor) = joined(design, determined, &alone, &of_numbers, &numbers, used) else {
                break;
            };
            for (k, h) in h.iter_mut().enumerate() {
                *h = sigma_mm * cofactor[(determined.len() + k, determined.len() + k)].sqrt();
            }
            (known.of_numbers, known.cofactor) = (of_numbers, cofactor);
            known.numbers.clone_from(&numbers);
        }
        known
    }

    /// Determined parameters and shape numbers.
    pub fn width(&self) -> usize {
        self.cofactor.ncols()
    }

    /// Visits the columns block by block: points, rows, columns in these rows.
    pub fn blocks(&self, visit: Visit<'_>) {
        self.design.blocks(&mut |points, rows, columns| {
            let mut chosen = DMatrix::zeros(columns.nrows(), self.width());
            for (k, &j) in self.determined.iter().enumerate() {
                chosen.set_column(k, &columns.column(j));
            }
            let of_numbers = self.of_numbers.rows(rows.start, rows.len());
            chosen.columns_mut(self.determined.len(), self.numbers.len()).copy_from(&of_numbers);
            visit(points, rows, chosen.as_view());
        });
    }

    /// The covariance of all, from that of the determined parameters with the shape numbers as they are.
    pub fn opened(&self, of_determined: &DMatrix<f64>, fit: &Converged) -> DMatrix<f64> {
        let embedded = |part: &DMatrix<f64>| part.clone().resize(self.width(), self.width(), 0.0);
        let of_numbers = &self.cofactor - embedded(&fit.solver.cofactor());
        embedded(of_determined) + of_numbers * fit.reading_mm(self.design.weights).powi(2)
    }
}

/// Those that may have any value and that the fit chose.
fn numbers(joint: &SideBySide, sigma_mm: f64) -> Vec<Number> {
    let is_sudden = |effect: usize| {
        joint.parameters.iter().zip(&joint.effect_of).any(|(parameter, of)| *of == effect && parameter.sudden)
    };
    let of_effect = |(effect, placed): (usize, &Placed)| -> Vec<Number> {
        let any_value = placed.shapes.continuous || placed.shapes.wave.is_some();
        if !placed.shape_is_free || !any_value || is_sudden(effect) {
            return Vec::new();
        }
        let number = |at: usize| {
            let u_beforehand = stretch(placed, at);
            (u_beforehand > 0.0 && placed.shape[at] != 0.0).then(|| Number {
                effect,
                at,
                u_beforehand,
                weight: sigma_mm / u_beforehand,
            })
        };
        (0..placed.shape.len()).filter_map(number).collect()
    };
    joint.effects.iter().enumerate().flat_map(of_effect).collect()
}

/// Standard deviation of an even distribution over all that the grid has, and what was found.
fn stretch(placed: &Placed, at: usize) -> f64 {
    let found = placed.shape[at];
    let values = || placed.shapes.grid.iter().map(|shape| shape[at]).chain([found]);
    let covered = values().fold(found, f64::max) - values().fold(found, f64::min);
    (if covered > 0.0 { covered } else { found.abs() }) / 12f64.sqrt()
}

/// D with the steps `h`, weighted.
fn secants(design: &Design<'_>, numbers: &[Number], solution: &DVector<f64>, h: &[f64]) -> DMatrix<f64> {
    let Design { experiment, joint, weights, .. } = design;
    let of_number = |(number, h): (&Number, &f64)| {
        let placed = &joint.effects[number.effect];
        let own: Vec<usize> = (0..joint.width()).filter(|&j| joint.effect_of[j] == number.effect).collect();
        let values = solution.select_rows(&own);
        let change = experiment.change_with_shape(&placed.instance, &placed.shape, number.at, *h, &values);
        change.component_mul(&weights.root)
    };
    DMatrix::from_columns(&numbers.iter().zip(h).map(of_number).collect::<Vec<_>>())
}

/// N from that of the determined parameters alone; `None` where rounding leaves no inverse.
fn joined(
    design: &Design<'_>,
    determined: &[usize],
    alone: &DMatrix<f64>,
    of_numbers: &DMatrix<f64>,
    numbers: &[Number],
    used: &[bool],
) -> Option<DMatrix<f64>> {
    let mut counted = of_numbers.clone();
    design.experiment.unused_rows(used).for_each(|row| counted.row_mut(row).fill(0.0));
    let across = design.on_columns(determined, &counted);
    let followed = -(alone * &across);
    let priors = DVector::from_iterator(numbers.len(), numbers.iter().map(|number| number.weight.powi(2)));
    let own = counted.tr_mul(&counted) + across.tr_mul(&followed) + DMatrix::from_diagonal(&priors);
    let inverse = own.cholesky()?.inverse();
    let (width, all) = (determined.len(), determined.len() + numbers.len());
    let both = &followed * &inverse;
    let mut cofactor = DMatrix::zeros(all, all);
    cofactor.view_mut((0, 0), (width, width)).copy_from(&(alone + &both * followed.transpose()));
    cofactor.view_mut((0, width), (width, numbers.len())).copy_from(&both);
    cofactor.view_mut((width, 0), (numbers.len(), width)).copy_from(&both.transpose());
    cofactor.view_mut((width, width), (numbers.len(), numbers.len())).copy_from(&inverse);
    Some(cofactor)
}
