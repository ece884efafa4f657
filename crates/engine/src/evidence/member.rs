//! One noise model with the model's columns projected out.

use super::SURVIVAL;
use super::algebra::{orthonormal, surviving_basis};
use super::context::{Blocks, Chosen, Context, Soft};
use super::library::Library;
use super::part::{PartScore, Scratch};
use crate::noise::machine_noise::{Noise, Order, Whitener};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Variances of the repeatable error motions in the bank, relative to the white noise of points at rest and of blocks on the fly.
const MOTIONS: [f64; 3] = [0.0, 0.1, 0.4];
const MOTIONS_ON_THE_FLY: [f64; 3] = [0.0, 1.0, 10.0];
/// Variance of a part of the noise, relative to the white noise, at which its prior has halved.
const USUAL_VARIANCE: f64 = 0.25;
/// Columns whitened at a time: they stay in the cache, and the whole library is never held twice.
const CHUNK: usize = 256;
/// Repeatable motions weaker than this share of the strongest are none.
const WEAKEST_MOTION: f64 = 0.01;

/// One member of the bank.
pub struct Prepared {
    whitener: Whitener,
    /// Orthonormal basis of the whitened base columns.
    basis: DMatrix<f64>,
    /// Eigenvectors of the repeatable motions, orthogonal to `basis`.
    motion: DMatrix<f64>,
    motion_eigenvalues: DVector<f64>,
    /// ln det Σ + ln det XᵀΣ⁻¹X.
    log_det: f64,
    motions: [f64; 3],
    prior_ln: f64,
}

/// Orthonormal directions of random columns and their strengths; none when no rotary axis moves.
fn principal(random: DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    if random.ncols() == 0 {
        return (random, DVector::zeros(0));
    }
    let eigen = (random.transpose() * &random).symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max).max(1e-9);
    let strong = |&j: &usize| eigen.eigenvalues[j] > WEAKEST_MOTION * largest;
    let keep: Vec<usize> = (0..eigen.eigenvalues.len()).filter(strong).collect();
    let mut turn = eigen.eigenvectors.select_columns(&keep);
    let eigenvalues = DVector::from_fn(keep.len(), |k, _| eigen.eigenvalues[keep[k]]);
    for (mut column, eigenvalue) in turn.column_iter_mut().zip(eigenvalues.iter()) {
        column /= eigenvalue.sqrt();
    }
    (random * turn, eigenvalues)
}

impl Prepared {
    /// Whitens and projects the base columns (column × row); `motions` are the random columns.
    pub fn new(order: &Order, noise: Noise, base: &DMatrix<f64>, motions: &DMatrix<f64>) -> Self {
        let whitener = Whitener::new(order, &noise);
        let mut whitened = base.clone();
        for mut column in whitened.row_iter_mut() {
            let norm = column.norm().max(1e-300);
            column /= norm;
        }
        whitener.whiten(&mut whitened);
        let (basis, log_det_base) = orthonormal(&whitened.transpose());
        let mut random = motions.clone();
        whitener.whiten(&mut random);
        let mut random = random.transpose();
        random -= &basis * (basis.transpose() * &random);
        let (motion, motion_eigenvalues) = principal(random);
        let log_det = whitener.log_det + log_det_base;
        let motions = if order.on_the_fly { MOTIONS_ON_THE_FLY } else { MOTIONS };
        let prior_ln = [noise.pass, noise.axis, noise.drift]
            .map(|part| less_likely_ln(part, order.on_the_fly))
            .iter()
            .sum();
        Self { whitener, basis, motion, motion_eigenvalues, log_det, motions, prior_ln }
    }

    /// Parameters of the base model that can be seen.
    pub fn base_rank(&self) -> usize {
        self.basis.ncols()
    }

    /// Whitens and projects vectors held transposed; with their squared norms before projection.
    fn project(&self, vectors: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
        let mut whitened = vectors.clone();
        self.whitener.whiten(&mut whitened);
        let norm_squared = whitened.row_iter().map(|row| row.norm_squared()).collect();
        let on_basis = &whitened * &self.basis;
        (whitened - on_basis * self.basis.transpose(), norm_squared)
    }

    /// Gram matrices of a library's parts after projection.
    pub fn blocks(&self, library: &Library) -> Blocks {
        let width = library.columns.nrows();
        let parts: Vec<Range<usize>> = library.parts().cloned().collect();
        let mut offsets = vec![0];
        for part in &parts {
            offsets.push(offsets[offsets.len() - 1] + part.len() * part.len());
        }
        let mut blocks = Blocks {
            on_motion: DMatrix::zeros(self.motion.ncols(), width),
            grams: vec![0.0; offsets[parts.len()]],
            norm_squared: vec![0.0; width],
        };
        let mut order: Vec<usize> = (0..parts.len()).filter(|&p| !parts[p].is_empty()).collect();
        order.sort_by_key(|&p| parts[p].start);
        let mut rest = order.as_slice();
        while let Some(&first) = rest.first() {
            let begin = parts[first].start;
            let count = rest.iter().position(|&p| parts[p].end - begin > CHUNK).unwrap_or(rest.len()).max(1);
            let (chunk, later) = rest.split_at(count);
            let end = chunk.iter().map(|&p| parts[p].end).max().unwrap_or(begin);
            let chunk: Vec<(Range<usize>, usize)> =
                chunk.iter().map(|&p| (parts[p].clone(), offsets[p])).collect();
            self.chunk(library, begin..end, &chunk, &mut blocks);
            rest = later;
        }
        blocks
    }

    /// Fills in the columns `within` and the parts in them, each with the place of its Gram matrix.
    fn chunk(
        &self,
        library: &Library,
        within: Range<usize>,
        parts: &[(Range<usize>, usize)],
        blocks: &mut Blocks,
    ) {
        let width = within.len();
        let mut whitened = library.columns.rows(within.start, width).clone_owned();
        self.whitener.whiten(&mut whitened);
        let norm_squared = &mut blocks.norm_squared[within.clone()];
        norm_squared.fill(0.0);
        for row in whitened.as_slice().chunks_exact(width) {
            norm_squared.iter_mut().zip(row).for_each(|(sum, value)| *sum += value * value);
        }
        let on_basis = &whitened * &self.basis;
        let on_motion = &whitened * &self.motion;
        blocks.on_motion.columns_mut(within.start, width).tr_copy_from(&on_motion);
        for (vectors, sign) in [(&whitened, 1.0), (&on_basis, -1.0)] {
            for vector in vectors.as_slice().chunks_exact(width) {
                for (part, offset) in parts {
                    let of_part = &vector[part.start - within.start..part.end - within.start];
                    let gram = &mut blocks.grams[*offset..offset + of_part.len() * of_part.len()];
                    for (row, a) in gram.chunks_exact_mut(of_part.len()).zip(of_part) {
                        row.iter_mut().zip(of_part).for_each(|(sum, b)| *sum += sign * a * b);
                    }
                }
            }
        }
    }

    /// Least share, over the columns of each part, of what survives the model that lies in the repeatable motions.
    pub fn like_motions(&self, library: &Library, blocks: &Blocks) -> Vec<f64> {
        let mut first = 0;
        let of_part = library.parts().map(|part| {
            let size = part.len();
            let share = |i: usize| {
                let survives = blocks.grams[first + i * (size + 1)];
                if survives <= SURVIVAL * SURVIVAL * blocks.norm_squared[part.start + i] {
                    return 1.0;
                }
                blocks.on_motion.column(part.start + i).norm_squared() / survives
            };
            let least = (0..size).map(share).fold(1.0, f64::min);
            first += size * size;
            least
        });
        of_part.collect()
    }

    /// Readings and chosen columns (column × row) under this member.
    pub fn context(&self, y: &DVector<f64>, chosen: &DMatrix<f64>) -> Context {
        let mut vectors = DMatrix::zeros(1 + chosen.nrows(), y.len());
        vectors.row_mut(0).tr_copy_from(y);
        vectors.rows_mut(1, chosen.nrows()).copy_from(chosen);
        let (mut back, norm_squared) = self.project(&vectors);
        let on_motion = &back * &self.motion;
        let inner = &back * back.transpose();
        let soft = self.motions.map(|rho| self.soft(rho, &inner, &on_motion, &norm_squared));
        self.whitener.adjoint(&mut back);
        Context { back, soft: soft.into() }
    }

    fn soft(&self, rho: f64, inner: &DMatrix<f64>, on_motion: &DMatrix<f64>, norm_squared: &[f64]) -> Soft {
        let weights = self.motion_eigenvalues.map(|d| rho * d / (1.0 + rho * d));
        let mut softened = on_motion.clone();
        for (j, mut column) in softened.column_iter_mut().enumerate() {
            column *= weights[j];
        }
        let chosen = Chosen::new(&(inner - &softened * on_motion.transpose()), norm_squared);
        let freedom = self.motion.nrows() as f64 - (self.basis.ncols() + chosen.kept.len()) as f64;
        let log_det = self.log_det
            + self.motion_eigenvalues.iter().map(|d| (rho * d).ln_1p()).sum::<f64>()
            + chosen.log_det;
        let rss = chosen.rss.max(1e-300);
        let prior_ln = self.prior_ln + less_likely_ln(rho, self.motions == MOTIONS_ON_THE_FLY);
        let nothing = prior_ln - 0.5 * log_det - 0.5 * freedom * rss.ln();
        Soft { rho, weights, on_motion: softened, chosen, freedom, rss, nothing }
    }

    /// Scores of all parts of a library, for each variance of the repeatable motions.
    pub fn scan(&self, library: &Library, blocks: &Blocks, context: &Context) -> Vec<Vec<PartScore>> {
        // Inner products of the library with readings and chosen columns; column × vector.
        let products = &library.columns * context.back.transpose();
        let mut scratch = Scratch::default();
        let score = |soft: &Soft| {
            let products = &products - blocks.on_motion.tr_mul(&soft.on_motion.transpose());
            let on_chosen = soft.chosen.orthonormal(&products);
            let residual = products.column(0) - &on_chosen * &soft.chosen.on_readings;
            let mut first = 0;
            let scored = library.parts().map(|range| {
                let gram = &blocks.grams[first..first + range.len() * range.len()];
                first += gram.len();
                scratch.load(range, gram, blocks, soft, &on_chosen, &residual);
                scratch.score(soft, library.columns.ncols() as f64)
            });
            scored.collect()
        };
        context.soft.iter().map(score).collect()
    }

    /// Cosines of the principal angles between two sets of columns (column × row) after projection of the model.
    pub fn canonical_correlations(
        &self,
        chosen: &DMatrix<f64>,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
    ) -> Vec<f64> {
        let (model, _) = orthonormal(&self.project(chosen).0.transpose());
        let basis = |columns: &DMatrix<f64>| {
            let projected = self.project(columns).0.transpose();
            let left = &projected - &model * (model.transpose() * &projected);
            surviving_basis(&left, columns)
        };
        let (a, b) = (basis(a), basis(b));
        if a.ncols() == 0 || b.ncols() == 0 {
            return Vec::new();
        }
        (a.transpose() * b).singular_values().iter().copied().collect()
    }
}

/// Half-Cauchy prior on the standard deviation of a part of the noise, next to the white one: small parts are usual, parts larger than
/// the white noise are not. Blocks on the fly have hardly any white noise.
fn less_likely_ln(variance: f64, on_the_fly: bool) -> f64 {
    if on_the_fly { 0.0 } else { -(variance / USUAL_VARIANCE).ln_1p() }
}
