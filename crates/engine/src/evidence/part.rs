//! Score of one group of columns under one noise model.

use super::SURVIVAL;
use super::context::{Blocks, Soft};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Information of less than so many readings is not taken as prior: the odds would hang on single points.
const LEAST_INFORMATION: f64 = 5.0;

/// Score of one shape under one noise.
#[derive(Clone, Copy, Default)]
pub struct PartScore {
    pub ln_bf: f64,
    /// Directions that survive the projection.
    pub surviving: usize,
    /// −½ ν ln(1 − R²).
    pub gain_ln: f64,
    /// Mean square explained in a whitened reading.
    pub explained: f64,
    /// Variance of the white part of the noise next to it.
    pub noise: f64,
}

/// Small work space for one group: Gram matrix and right side, both scaled by the raw column norms.
#[derive(Default)]
pub struct Scratch {
    gram: Vec<f64>,
    right: Vec<f64>,
    open: Vec<usize>,
    size: usize,
}

impl Scratch {
    /// Loads the columns `range` of a library as they are next to the chosen columns of `soft`.
    pub fn load(
        &mut self,
        range: &Range<usize>,
        gram: &[f64],
        blocks: &Blocks,
        soft: &Soft,
        on_chosen: &DMatrix<f64>,
        residual: &DVector<f64>,
    ) {
        let weights = &soft.weights;
        let height = weights.len();
        let motion = |column: usize| &blocks.on_motion.as_slice()[column * height..(column + 1) * height];
        let size = range.len();
        self.size = size;
        self.gram.clear();
        self.gram.resize(size * size, 0.0);
        self.right.clear();
        for i in 0..size {
            let a = range.start + i;
            let scale_a = 1.0 / blocks.norm_squared[a].sqrt().max(1e-150);
            self.right.push(residual[a] * scale_a);
            for j in 0..=i {
                let b = range.start + j;
                let mut value = gram[i * size + j];
                if soft.rho > 0.0 {
                    let (on_a, on_b) = (motion(a), motion(b));
                    for m in 0..height {
                        value -= weights[m] * on_a[m] * on_b[m];
                    }
                }
                for c in 0..on_chosen.ncols() {
                    value -= on_chosen[(a, c)] * on_chosen[(b, c)];
                }
                value *= scale_a / blocks.norm_squared[b].sqrt().max(1e-150);
                self.gram[i * size + j] = value;
                self.gram[j * size + i] = value;
            }
        }
    }

    /// The score by pivoted elimination of the directions that survive; `readings` in all.
    pub fn score(&mut self, soft: &Soft, readings: f64) -> PartScore {
        let n = self.size;
        let (mut explained, mut surviving, mut ln_pivots) = (0.0, 0, 0.0);
        self.open.clear();
        self.open.extend(0..n);
        while let Some(position) = (0..self.open.len())
            .max_by(|&p, &q| self.gram[self.open[p] * (n + 1)].total_cmp(&self.gram[self.open[q] * (n + 1)]))
        {
            let pivot = self.open.swap_remove(position);
            let diagonal = self.gram[pivot * (n + 1)];
            if diagonal.is_nan() || diagonal <= SURVIVAL * SURVIVAL {
                break;
            }
            surviving += 1;
            ln_pivots += diagonal.ln();
            explained += self.right[pivot] * self.right[pivot] / diagonal;
            for &i in &self.open {
                let factor = self.gram[i * n + pivot] / diagonal;
                self.right[i] -= factor * self.right[pivot];
                for &j in &self.open {
                    self.gram[i * n + j] -= factor * self.gram[pivot * n + j];
                }
            }
        }
        if surviving == 0 {
            return PartScore::default();
        }
        let k = surviving as f64;
        let g = (readings * (ln_pivots / k).exp()).max(LEAST_INFORMATION);
        let left = (1.0 - explained / soft.rss).clamp(1e-12, 1.0);
        let ln_bf = 0.5 * (soft.freedom - k) * g.ln_1p() - 0.5 * soft.freedom * (g * left).ln_1p();
        PartScore {
            ln_bf,
            surviving,
            gain_ln: -0.5 * soft.freedom * left.ln(),
            explained: (1.0 - left) * soft.rss / readings,
            noise: left * soft.rss / soft.freedom,
        }
    }
}
