//! Waves of one frequency in a residual: how much they explain, and how well their frequency is known.

use super::band::{Band, OVERSAMPLING};
use super::moments::{Inner, Moments};
use crate::evidence::off;
use crate::solve::golden_section::golden_section;
use nalgebra::{DMatrix, DVector};

/// Columns that keep less than this share of their norm next to the model and the columns before them are imitated by them.
const SURVIVAL: f64 = 0.03;
/// Divisions of the golden section: 0.618^20 of a resolution.
const DIVISIONS: usize = 20;
/// Step of the second difference, in resolutions.
const CURVATURE_STEP: f64 = 0.02;

/// A residual and what may wave in it.
#[derive(Clone, Debug)]
pub(crate) struct Waves {
    /// Position of the axis at every row, mm or rad.
    pub position: Vec<f64>,
    /// Readings of a unit of motion, rows × components.
    pub carriers: DMatrix<f64>,
    /// Orthonormal columns of the model, rows × rank.
    pub basis: DMatrix<f64>,
    /// What the model leaves, mm, orthogonal to `basis`.
    pub residual_mm: DVector<f64>,
    moments: Moments,
}

/// What waves of one frequency explain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Explained {
    /// Sum of squares, mm².
    pub sum: f64,
    /// Directions that the model does not imitate.
    pub directions: usize,
}

impl Waves {
    /// `position`: of the axis at every row, mm or rad.
    pub fn new(
        position: Vec<f64>,
        carriers: DMatrix<f64>,
        basis: DMatrix<f64>,
        residual_mm: DVector<f64>,
    ) -> Self {
        let moments = Moments::new(&position, &carriers, &basis, &residual_mm);
        Self { position, carriers, basis, residual_mm, moments }
    }

    /// cos ωq and sin ωq times every carrier, rows × 2 carriers.
    fn columns(&self, omega: f64) -> DMatrix<f64> {
        let (rows, count) = self.carriers.shape();
        let mut columns = DMatrix::zeros(rows, 2 * count);
        for (row, position) in self.position.iter().enumerate() {
            let (sin, cos) = (omega * position).sin_cos();
            for k in 0..count {
                columns[(row, 2 * k)] = cos * self.carriers[(row, k)];
                columns[(row, 2 * k + 1)] = sin * self.carriers[(row, k)];
            }
        }
        columns
    }

    /// What waves of this frequency explain.
    pub fn explained(&self, omega: f64) -> Explained {
        self.moments.at(omega).map_or_else(Explained::default, explained)
    }

    /// Frequencies of a band, and what each explains.
    pub fn scan(&self, band: &Band) -> Vec<(f64, Explained)> {
        let step = band.resolution() / OVERSAMPLING;
        let count = ((band.high() - band.low()) / step).floor() as usize;
        let omegas = (0..=count).map(|k| band.low() + step * k as f64);
        omegas.zip(self.moments.at_steps(band.low(), step, count + 1).map(explained)).collect()
    }

    /// The highest peaks of a band, refined, highest first.
    pub fn peaks(&self, band: &Band, most: usize) -> Vec<f64> {
        let scanned = self.scan(band);
        let sum = |k: usize| scanned.get(k).map_or(0.0, |(_, explained)| explained.sum);
        let is_peak = |k: &usize| sum(*k) > 0.0 && sum(*k) >= sum(k + 1) && (*k == 0 || sum(*k) > sum(k - 1));
        let mut peaks: Vec<usize> = (0..scanned.len()).filter(is_peak).collect();
        peaks.sort_by(|&a, &b| sum(b).total_cmp(&sum(a)));
        peaks.truncate(most);
        peaks.into_iter().map(|k| self.refined(scanned[k].0, band)).collect()
    }

    /// The frequency near `omega` that explains most.
    pub fn refined(&self, omega: f64, band: &Band) -> f64 {
        let within = band.resolution() / OVERSAMPLING;
        let low = (omega - within).max(0.5 * band.low());
        golden_section(low, omega + within, DIVISIONS, &mut |omega| self.explained(omega).sum)
    }

    /// Standard uncertainty of a frequency where `variance` (mm²) is what scatters: with the amplitudes fitted at each frequency the
    /// sum of squares left is a parabola ½ |S″| Δω², which is the variance at one standard uncertainty.
    pub fn u(&self, omega: f64, variance: f64, band: &Band) -> f64 {
        let h = CURVATURE_STEP * band.resolution();
        let [below, at, above] = [-h, 0.0, h].map(|delta| self.explained(omega + delta).sum);
        let curvature = (2.0 * at - below - above) / (h * h);
        if curvature > 0.0 { (2.0 * variance / curvature).sqrt() } else { band.resolution() }
    }

    /// The same with waves of this frequency in the model.
    pub fn without(mut self, omega: f64) -> Self {
        let columns = self.columns(omega);
        for column in columns.column_iter() {
            let norm = column.norm();
            let mut left = column.clone_owned();
            // Twice: what rounding leaves of the first projection.
            for _ in 0..2 {
                let on_basis = self.basis.tr_mul(&left);
                left -= &self.basis * on_basis;
            }
            if left.norm() <= SURVIVAL * norm {
                continue;
            }
            left.unscale_mut(left.norm());
            let size = left.dot(&self.residual_mm);
            self.residual_mm.axpy(-size, &left, 1.0);
            let last = self.basis.ncols();
            self.basis = self.basis.insert_column(last, 0.0);
            self.basis.set_column(last, &left);
        }
        Self::new(self.position, self.carriers, self.basis, self.residual_mm)
    }

    /// Amplitudes (cos, sin) of each carrier at a frequency, mm or rad; least squares next to the model.
    pub fn amplitudes(&self, omega: f64) -> Vec<(f64, f64)> {
        let columns = self.columns(omega);
        let left = off(&columns, &self.basis);
        let scale = left.amax();
        let values = left
            .svd(true, true)
            .solve(&self.residual_mm, SURVIVAL * scale)
            .expect("both factors were asked for");
        (0..self.carriers.ncols()).map(|k| (values[2 * k], values[2 * k + 1])).collect()
    }
}

/// Pivoted elimination of the inner products off the model.
fn explained(inner: Inner) -> Explained {
    let raw = inner.gram;
    let mut gram = &raw - &inner.on_basis * inner.on_basis.transpose();
    let mut right = inner.on_residual;
    let mut open: Vec<usize> = (0..right.len()).collect();
    let mut explained = Explained::default();
    let share = |gram: &DMatrix<f64>, j: usize| gram[(j, j)] / raw[(j, j)].max(f64::MIN_POSITIVE);
    while let Some(at) =
        (0..open.len()).max_by(|&a, &b| share(&gram, open[a]).total_cmp(&share(&gram, open[b])))
    {
        let pivot = open.swap_remove(at);
        if share(&gram, pivot) <= SURVIVAL * SURVIVAL {
            break;
        }
        let diagonal = gram[(pivot, pivot)];
        explained.sum += right[pivot] * right[pivot] / diagonal;
        explained.directions += 1;
        for &i in &open {
            let factor = gram[(i, pivot)] / diagonal;
            right[i] -= factor * right[pivot];
            for &j in &open {
                gram[(i, j)] -= factor * gram[(pivot, j)];
            }
        }
    }
    explained
}
