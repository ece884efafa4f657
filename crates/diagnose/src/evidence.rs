//! Evidence of one group of columns against nothing, averaged over the noise bank.
//!
//! ln BF = ½(ν − k) ln(1 + g) − ½ ν ln(1 + g(1 − R²)),   g = number of readings (unit information)   [DIAGNOSIS §2]
//!
//! R²: share of the whitened, projected residual that the k surviving columns explain. Everything that is already in the
//! model is projected out first, so that what the model can imitate scores nothing. Each member of the noise bank weighs in
//! with its marginal likelihood −½ ln det − ½ ν ln rss.
//!
//! Besides the kernels of [`crate::noise`], a machine has small repeatable error motions of its axes that nobody
//! would call a missing effect. They enter as random columns U with variance ρ: Σ + ρ U Uᵀ, which is a soft projection onto the
//! eigenvectors f_j of Uᵀ Σ⁻¹ U with weight ρ d_j / (1 + ρ d_j).

use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_identify::machine_noise::{Noise, Order, Whitener};

/// Directions that keep less than this share of their norm are taken as imitated by the model.
pub const SURVIVAL: f64 = 0.03;
/// Variances of the repeatable error motions in the bank, relative to the white noise.
const MOTIONS: [f64; 2] = [0.0, 0.4];
/// Threads used for the bank.
const WORKERS: usize = 2;
/// Repeatable motions of a rotary axis are natural up to this share of the noise variance: every bearing has some.
const NATURAL_SHARE: f64 = 0.5;

/// Columns that compete: groups of alternatives (one per shape), each a few columns.
#[derive(Clone, Debug)]
pub struct Library {
    /// Column × row, each of norm 1.
    pub columns: DMatrix<f64>,
    /// Groups.
    pub groups: Vec<Group>,
}

/// One competitor.
#[derive(Clone, Debug)]
pub struct Group {
    /// Its columns for each shape.
    pub parts: Vec<Range<usize>>,
    /// ln of its prior odds, not positive.
    pub prior_ln: f64,
    /// True for repeatable motions of a rotary axis, which must exceed what is natural.
    pub natural: bool,
}

/// A group before its columns are stacked.
pub struct Entry {
    /// Columns of each shape, rows × columns.
    pub parts: Vec<DMatrix<f64>>,
    /// See [`Group::prior_ln`].
    pub prior_ln: f64,
    /// See [`Group::natural`].
    pub natural: bool,
}

impl Library {
    /// Stacks groups; scales each column to norm 1.
    pub fn new(rows: usize, groups: Vec<Entry>) -> Self {
        let width = groups.iter().flat_map(|entry| &entry.parts).map(DMatrix::ncols).sum();
        let mut columns = DMatrix::zeros(width, rows);
        let (mut next, mut listed) = (0, Vec::with_capacity(groups.len()));
        for Entry { parts, prior_ln, natural } in groups {
            let mut ranges = Vec::with_capacity(parts.len());
            for part in parts {
                for j in 0..part.ncols() {
                    let norm = part.column(j).norm();
                    let scale = if norm > 0.0 && norm.is_finite() { 1.0 / norm } else { 0.0 };
                    columns.row_mut(next + j).tr_copy_from(&(part.column(j) * scale));
                }
                ranges.push(next..next + part.ncols());
                next += part.ncols();
            }
            listed.push(Group { parts: ranges, prior_ln, natural });
        }
        Self { columns, groups: listed }
    }

    /// A library of some of the groups.
    pub fn subset(&self, chosen: &[usize]) -> Self {
        let part = |range: &Range<usize>| self.columns.rows(range.start, range.len()).transpose();
        let groups = chosen.iter().map(|&g| {
            let group = &self.groups[g];
            let parts = group.parts.iter().map(part).collect();
            Entry { parts, prior_ln: group.prior_ln, natural: group.natural }
        });
        Self::new(self.columns.ncols(), groups.collect())
    }

    /// Columns of one part, rows × columns.
    pub fn part(&self, group: usize, part: usize) -> DMatrix<f64> {
        let range = &self.groups[group].parts[part];
        self.columns.rows(range.start, range.len()).transpose()
    }
}

/// One noise model with the base model projected out.
pub struct Prepared {
    whitener: Whitener,
    /// Orthonormal basis of the whitened base columns.
    basis: DMatrix<f64>,
    /// Eigenvectors of the repeatable motions, orthogonal to `basis`.
    motion: DMatrix<f64>,
    motion_eigenvalues: DVector<f64>,
    /// ln det Σ + ln det XᵀΣ⁻¹X.
    log_det: f64,
}

/// What a library looks like under one noise model.
pub struct Blocks {
    /// Motion × column.
    on_motion: DMatrix<f64>,
    grams: Vec<DMatrix<f64>>,
    norm_squared: Vec<f64>,
}

/// The bank, ready for scans.
pub struct Bank {
    /// Its members.
    pub members: Vec<Prepared>,
    rows: usize,
}

/// Result of a scan.
#[derive(Clone, Debug)]
pub struct Scan {
    /// One score per group.
    pub scores: Vec<Score>,
    /// ln marginal likelihood of "nothing more" for each bank member (best motion variance).
    pub nothing: Vec<f64>,
    /// Member that explains best with nothing added.
    pub best_member: usize,
}

/// Score of one group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// ln Bayes factor after its prior, averaged over noise and shapes.
    pub ln_odds: f64,
    /// Best shape.
    pub part: usize,
    /// Bank member under which it is best.
    pub member: usize,
    /// Columns that survive the projection, best shape.
    pub surviving: usize,
    /// ln marginal likelihood of the best member and shape.
    pub log_likelihood: f64,
    /// The same without the price of its columns: how well it fits.
    pub fit_ln: f64,
    /// Mean square that it explains, relative to the noise, in whitened readings.
    pub share: f64,
}

impl Score {
    /// Orders groups of a library under a part of the bank, where ln odds are not defined.
    pub fn log_likelihood_with_prior(&self, prior_ln: f64) -> f64 {
        if self.surviving == 0 { f64::NEG_INFINITY } else { self.log_likelihood + prior_ln }
    }
}

impl Bank {
    /// Whitens and projects the base columns (column × row) under every member. `motions` are the random columns.
    pub fn new(order: &Order, base: &DMatrix<f64>, motions: &DMatrix<f64>) -> Self {
        let noises = order.bank();
        let members = parallel(noises.len(), |i| Prepared::new(order, noises[i], base, motions));
        Self { members, rows: base.ncols() }
    }

    /// Parameters of the base model that can be seen.
    pub fn base_rank(&self) -> usize {
        self.members[0].basis.ncols()
    }

    /// Blocks of a library under the members listed.
    pub fn blocks(&self, library: &Library, members: &[usize]) -> Vec<Blocks> {
        parallel(members.len(), |i| self.members[members[i]].blocks(library))
    }

    /// Scores every group of `library` for the readings `y` with the columns `chosen` (column × row) in the model.
    pub fn scan(
        &self,
        library: &Library,
        members: &[usize],
        blocks: &[&Blocks],
        y: &DVector<f64>,
        chosen: &DMatrix<f64>,
    ) -> Scan {
        let per_member = parallel(self.members.len(), |m| {
            let prepared = &self.members[m];
            let context = prepared.context(y, chosen);
            let scored = members.iter().position(|&x| x == m);
            let products = match scored {
                Some(_) => prepared.products(library, &context),
                None => DMatrix::zeros(0, 0),
            };
            MOTIONS
                .iter()
                .map(|&rho| {
                    let blocks = scored.map(|i| blocks[i]);
                    prepared.scan(library, blocks, &context, &products, rho, self.rows)
                })
                .collect::<Vec<_>>()
        });
        combine(library, &per_member)
    }
}

/// Everything of one member that a scan needs for one set of readings and chosen columns.
struct Context {
    /// Whitened, projected: readings first, then the chosen columns; vector × row.
    vectors: DMatrix<f64>,
    /// Inner products with the motions.
    on_motion: DMatrix<f64>,
}

impl Prepared {
    fn new(order: &Order, noise: Noise, base: &DMatrix<f64>, motions: &DMatrix<f64>) -> Self {
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
        let eigen = (random.transpose() * &random).symmetric_eigen();
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max).max(1e-9);
        let keep: Vec<usize> =
            (0..eigen.eigenvalues.len()).filter(|&j| eigen.eigenvalues[j] > 0.01 * largest).collect();
        let mut motion = DMatrix::zeros(random.nrows(), keep.len());
        let mut motion_eigenvalues = DVector::zeros(keep.len());
        for (k, &j) in keep.iter().enumerate() {
            motion_eigenvalues[k] = eigen.eigenvalues[j];
            let direction = &random * eigen.eigenvectors.column(j) / eigen.eigenvalues[j].sqrt();
            motion.set_column(k, &direction);
        }
        let log_det = whitener.log_det + log_det_base;
        Self { whitener, basis, motion, motion_eigenvalues, log_det }
    }

    /// Whitens and projects vectors held transposed.
    fn project(&self, vectors: &DMatrix<f64>) -> DMatrix<f64> {
        let mut whitened = vectors.clone();
        self.whitener.whiten(&mut whitened);
        let on_basis = &whitened * &self.basis;
        whitened - on_basis * self.basis.transpose()
    }

    fn blocks(&self, library: &Library) -> Blocks {
        let mut whitened = library.columns.clone();
        self.whitener.whiten(&mut whitened);
        let norm_squared: Vec<f64> = {
            let mut sums = vec![0.0; whitened.nrows()];
            for row in whitened.column_iter() {
                for (sum, value) in sums.iter_mut().zip(row.iter()) {
                    *sum += value * value;
                }
            }
            sums
        };
        let on_basis = &whitened * &self.basis;
        let on_motion = self.motion.tr_mul(&whitened.transpose());
        let gram = |range: &Range<usize>| {
            let columns = whitened.rows(range.start, range.len());
            let shadow = on_basis.rows(range.start, range.len());
            columns * columns.transpose() - shadow * shadow.transpose()
        };
        let grams = library.groups.iter().flat_map(|group| &group.parts).map(gram).collect();
        Blocks { on_motion, grams, norm_squared }
    }

    fn context(&self, y: &DVector<f64>, chosen: &DMatrix<f64>) -> Context {
        let mut vectors = DMatrix::zeros(1 + chosen.nrows(), y.len());
        vectors.row_mut(0).tr_copy_from(y);
        vectors.rows_mut(1, chosen.nrows()).copy_from(chosen);
        let vectors = self.project(&vectors);
        let on_motion = &vectors * &self.motion;
        Context { vectors, on_motion }
    }

    /// Inner products of the library with readings and chosen columns; column × vector.
    fn products(&self, library: &Library, context: &Context) -> DMatrix<f64> {
        let mut back = context.vectors.clone();
        self.whitener.adjoint(&mut back);
        &library.columns * back.transpose()
    }

    /// (ln marginal likelihood of nothing, per part (ln BF, surviving columns, gain)).
    fn scan(
        &self,
        library: &Library,
        blocks: Option<&Blocks>,
        context: &Context,
        products: &DMatrix<f64>,
        rho: f64,
        rows: usize,
    ) -> (f64, Vec<PartScore>) {
        let weights = self.motion_eigenvalues.map(|d| rho * d / (1.0 + rho * d));
        let softened = |m: &DMatrix<f64>| {
            let mut scaled = m.clone();
            for (j, mut column) in scaled.column_iter_mut().enumerate() {
                column *= weights[j];
            }
            scaled
        };
        let mut inner = &context.vectors * context.vectors.transpose();
        let soft_context = softened(&context.on_motion);
        inner -= &soft_context * context.on_motion.transpose();
        let chosen = Chosen::new(&inner);
        let nu = (rows - self.basis.ncols() - chosen.kept.len()) as f64;
        let log_det = self.log_det
            + self.motion_eigenvalues.iter().map(|d| (rho * d).ln_1p()).sum::<f64>()
            + chosen.log_det;
        let rss = chosen.rss.max(1e-300);
        let nothing = -0.5 * log_det - 0.5 * nu * rss.ln();
        let Some(blocks) = blocks else { return (nothing, Vec::new()) };

        let mut products = products.clone();
        products -= blocks.on_motion.tr_mul(&soft_context.transpose());
        let on_chosen = chosen.orthonormal(&products);
        let residual = products.column(0) - &on_chosen * &chosen.on_readings;
        let mut scored = Vec::with_capacity(blocks.grams.len());
        let parts = library.groups.iter().flat_map(|group| &group.parts);
        let mut scratch = Scratch::default();
        for (range, gram) in parts.zip(&blocks.grams) {
            scratch.load(range, gram, blocks, &weights, rho, &on_chosen, &residual);
            let (explained, surviving) = scratch.explained();
            scored.push(score(explained / rss, surviving, nu, rows as f64));
        }
        (nothing, scored)
    }

    /// Generalised least squares of readings on base and chosen columns under this member:
    /// values and covariance of the chosen coefficients.
    pub fn fit(&self, y: &DVector<f64>, chosen: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let context = self.context(y, chosen);
        let columns = context.vectors.rows(1, chosen.nrows());
        let readings = context.vectors.row(0);
        let scale = column_scales(&columns.into_owned());
        let mut gram = columns * columns.transpose();
        let mut right = columns * readings.transpose();
        for i in 0..scale.len() {
            right[i] /= scale[i];
            for j in 0..scale.len() {
                gram[(i, j)] /= scale[i] * scale[j];
            }
        }
        let inverse = gram.pseudo_inverse(1e-9).unwrap_or_else(|_| DMatrix::zeros(scale.len(), scale.len()));
        let mut values = &inverse * &right;
        let rss = (readings.norm_squared() - values.dot(&right)).max(0.0);
        let freedom = (y.len() - self.basis.ncols() - scale.len().min(y.len())).max(1) as f64;
        let mut covariance = inverse * (rss / freedom);
        for i in 0..scale.len() {
            values[i] /= scale[i];
            for j in 0..scale.len() {
                covariance[(i, j)] /= scale[i] * scale[j];
            }
        }
        (values, covariance)
    }

    /// Whitened residual sum of squares with `chosen` and `extra` (column × row) in the model: for refining shape numbers.
    pub fn rss(&self, y: &DVector<f64>, chosen: &DMatrix<f64>, extra: &DMatrix<f64>) -> f64 {
        let context = self.context(y, &stacked(chosen, extra));
        Chosen::new(&(&context.vectors * context.vectors.transpose())).rss
    }

    /// Cosines of the principal angles between two sets of columns (column × row) after projection of the model.
    pub fn canonical_correlations(
        &self,
        chosen: &DMatrix<f64>,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
    ) -> Vec<f64> {
        let (model, _) = orthonormal(&self.project(chosen).transpose());
        let basis = |columns: &DMatrix<f64>| {
            let projected = self.project(columns).transpose();
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

/// Chosen columns folded into the model by a pivoted Cholesky of their inner products.
struct Chosen {
    kept: Vec<usize>,
    /// Inverse of the lower factor of the kept columns.
    inverse_lower: DMatrix<f64>,
    /// Inner products of the orthonormalised chosen columns with the readings.
    on_readings: DVector<f64>,
    rss: f64,
    log_det: f64,
}

impl Chosen {
    /// `inner`: inner products of readings (first) and chosen columns.
    fn new(inner: &DMatrix<f64>) -> Self {
        let count = inner.nrows() - 1;
        let mut kept: Vec<usize> = Vec::new();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut log_det = 0.0;
        for j in 0..count {
            let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
            for (i, other) in kept.iter().enumerate() {
                let dot: f64 = row.iter().zip(&rows[i]).map(|(a, b)| a * b).sum();
                row.push((inner[(1 + j, 1 + other)] - dot) / rows[i][i]);
            }
            let left = inner[(1 + j, 1 + j)] - row.iter().map(|x| x * x).sum::<f64>();
            if left > 1e-9 * inner[(1 + j, 1 + j)].max(1e-300) && left > 1e-200 {
                log_det += left.ln();
                row.push(left.sqrt());
                kept.push(j);
                rows.push(row);
            }
        }
        let lower = DMatrix::from_fn(kept.len(), kept.len(), |i, j| if j <= i { rows[i][j] } else { 0.0 });
        let inverse_lower = lower.try_inverse().expect("every pivot kept is positive");
        let right = DVector::from_fn(kept.len(), |i, _| inner[(0, 1 + kept[i])]);
        let on_readings = &inverse_lower * right;
        let rss = inner[(0, 0)] - on_readings.norm_squared();
        Self { kept, inverse_lower, on_readings, rss, log_det }
    }

    /// Inner products of the library with the orthonormalised chosen columns, from `products` (readings first).
    fn orthonormal(&self, products: &DMatrix<f64>) -> DMatrix<f64> {
        let mut raw = DMatrix::zeros(products.nrows(), self.kept.len());
        for (i, &j) in self.kept.iter().enumerate() {
            raw.set_column(i, &products.column(1 + j));
        }
        raw * self.inverse_lower.transpose()
    }
}

/// Small work space for one group: Gram matrix and right side, both scaled by the raw column norms.
#[derive(Default)]
struct Scratch {
    gram: Vec<f64>,
    right: Vec<f64>,
    size: usize,
}

impl Scratch {
    #[expect(
        clippy::too_many_arguments,
        reason = "the terms of one formula; a struct would only rename them"
    )]
    fn load(
        &mut self,
        range: &Range<usize>,
        gram: &DMatrix<f64>,
        blocks: &Blocks,
        weights: &DVector<f64>,
        rho: f64,
        on_chosen: &DMatrix<f64>,
        residual: &DVector<f64>,
    ) {
        let height = weights.len();
        let motion = |column: usize| &blocks.on_motion.as_slice()[column * height..(column + 1) * height];
        let size = range.len();
        self.size = size;
        self.gram.clear();
        self.right.clear();
        for i in 0..size {
            let a = range.start + i;
            let scale_a = 1.0 / blocks.norm_squared[a].sqrt().max(1e-150);
            self.right.push(residual[a] * scale_a);
            for j in 0..size {
                let b = range.start + j;
                let mut value = gram[(i, j)];
                if j <= i {
                    if rho > 0.0 {
                        let (on_a, on_b) = (motion(a), motion(b));
                        for m in 0..weights.len() {
                            value -= weights[m] * on_a[m] * on_b[m];
                        }
                    }
                    for c in 0..on_chosen.ncols() {
                        value -= on_chosen[(a, c)] * on_chosen[(b, c)];
                    }
                    value *= scale_a / blocks.norm_squared[b].sqrt().max(1e-150);
                }
                self.gram.push(value);
            }
        }
        for i in 0..size {
            for j in i + 1..size {
                self.gram[i * size + j] = self.gram[j * size + i];
            }
        }
    }

    /// Sum of squares explained by the surviving directions and how many survive (pivoted elimination).
    fn explained(&mut self) -> (f64, usize) {
        let n = self.size;
        let (mut explained, mut surviving) = (0.0, 0);
        let mut open: Vec<usize> = (0..n).collect();
        while let Some(position) = (0..open.len())
            .max_by(|&p, &q| self.gram[open[p] * (n + 1)].total_cmp(&self.gram[open[q] * (n + 1)]))
        {
            let pivot = open.swap_remove(position);
            let diagonal = self.gram[pivot * (n + 1)];
            if diagonal.is_nan() || diagonal <= SURVIVAL * SURVIVAL {
                break;
            }
            surviving += 1;
            explained += self.right[pivot] * self.right[pivot] / diagonal;
            for &i in &open {
                let factor = self.gram[i * n + pivot] / diagonal;
                self.right[i] -= factor * self.right[pivot];
                for &j in &open {
                    self.gram[i * n + j] -= factor * self.gram[pivot * n + j];
                }
            }
        }
        (explained, surviving)
    }
}

/// Score of one shape under one noise.
#[derive(Clone, Copy, Default)]
struct PartScore {
    ln_bf: f64,
    surviving: usize,
    /// −½ ν ln(1 − R²).
    gain_ln: f64,
    share: f64,
}

fn score(r_squared: f64, surviving: usize, nu: f64, g: f64) -> PartScore {
    if surviving == 0 {
        return PartScore::default();
    }
    let left = (1.0 - r_squared).clamp(1e-12, 1.0);
    let k = surviving as f64;
    let ln_bf = 0.5 * (nu - k) * g.ln_1p() - 0.5 * nu * (g * left).ln_1p();
    PartScore { ln_bf, surviving, gain_ln: -0.5 * nu * left.ln(), share: (1.0 - left) / left * nu / g }
}

type MemberScores = Vec<(f64, Vec<PartScore>)>;

fn combine(library: &Library, per_member: &[MemberScores]) -> Scan {
    let nothing: Vec<f64> =
        per_member.iter().map(|scores| log_sum_exp(scores.iter().map(|(nothing, _)| *nothing))).collect();
    let total_nothing = log_sum_exp(nothing.iter().copied());
    let best_member = (0..nothing.len()).max_by(|&a, &b| nothing[a].total_cmp(&nothing[b])).unwrap_or(0);
    let mut first_part = 0;
    let mut scores = Vec::with_capacity(library.groups.len());
    for group in &library.groups {
        let parts = group.parts.len();
        let mut terms = Vec::new();
        let mut best = Score {
            ln_odds: f64::NEG_INFINITY,
            part: 0,
            member: best_member,
            surviving: 0,
            log_likelihood: f64::NEG_INFINITY,
            fit_ln: f64::NEG_INFINITY,
            share: 0.0,
        };
        for (member, by_motion) in per_member.iter().enumerate() {
            for (nothing, scored) in by_motion {
                for (part, &PartScore { ln_bf, surviving, gain_ln, share }) in
                    scored.iter().skip(first_part).take(parts).enumerate()
                {
                    let log_likelihood = nothing + ln_bf;
                    terms.push(log_likelihood);
                    if log_likelihood > best.log_likelihood {
                        let fit_ln = nothing + gain_ln;
                        best = Score { part, member, surviving, log_likelihood, fit_ln, share, ..best };
                    }
                }
            }
        }
        best.ln_odds =
            log_sum_exp(terms.iter().copied()) - (parts.max(1) as f64).ln() - total_nothing + group.prior_ln;
        if best.surviving == 0 || (group.natural && best.share < NATURAL_SHARE) {
            best.ln_odds = f64::NEG_INFINITY;
        }
        scores.push(best);
        first_part += parts;
    }
    Scan { scores, nothing, best_member }
}

/// Orthonormal basis of columns of similar size and ln det of their Gram matrix over the directions kept.
fn orthonormal(columns: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
    if columns.ncols() == 0 {
        return (DMatrix::zeros(columns.nrows(), 0), 0.0);
    }
    let svd = columns.clone().svd(true, false);
    let largest = svd.singular_values.max();
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&j| svd.singular_values[j] > 1e-7 * largest).collect();
    let left = svd.u.expect("asked for");
    let basis = DMatrix::from_fn(columns.nrows(), kept.len(), |i, k| left[(i, kept[k])]);
    let log_det = kept.iter().map(|&j| 2.0 * svd.singular_values[j].ln()).sum();
    (basis, log_det)
}

/// Orthonormal basis of what is left of `raw` columns (column × row), dropping directions that hardly survive.
fn surviving_basis(left: &DMatrix<f64>, raw: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = left.clone();
    for (j, scale) in column_scales(raw).into_iter().enumerate() {
        scaled.column_mut(j).unscale_mut(scale);
    }
    let svd = scaled.svd(true, false);
    let left = svd.u.expect("asked for");
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&j| svd.singular_values[j] > SURVIVAL).collect();
    DMatrix::from_fn(left.nrows(), kept.len(), |i, k| left[(i, kept[k])])
}

/// Norm of each column (column × row); infinite for one that moves nothing, so that it scales to zero and
/// never to a number that no decomposition survives.
fn column_scales(columns: &DMatrix<f64>) -> Vec<f64> {
    let norms: Vec<f64> = (0..columns.nrows()).map(|j| columns.row(j).norm()).collect();
    let largest = norms.iter().copied().fold(0.0, f64::max);
    norms.into_iter().map(|norm| if norm > 1e-12 * largest { norm } else { f64::INFINITY }).collect()
}

/// Two sets of columns (column × row) in one.
pub(crate) fn stacked(first: &DMatrix<f64>, second: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(first.nrows() + second.nrows(), first.ncols());
    all.rows_mut(0, first.nrows()).copy_from(first);
    all.rows_mut(first.nrows(), second.nrows()).copy_from(second);
    all
}

/// ln Σ exp.
pub fn log_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + terms.map(|x| (x - largest).exp()).sum::<f64>().ln()
}

/// `f(0..count)` on a few threads, results in order.
pub(crate) fn parallel<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let share = count.div_ceil(WORKERS).max(1);
    let chunks: Vec<Range<usize>> =
        (0..count).step_by(share).map(|from| from..(from + share).min(count)).collect();
    std::thread::scope(|scope| {
        let handles: Vec<_> =
            chunks.into_iter().map(|chunk| scope.spawn(|| chunk.map(&f).collect::<Vec<_>>())).collect();
        handles.into_iter().flat_map(|h| h.join().expect("a worker panics only on a defect")).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forward wobble at one lobe is zero by definition; its scaled Gram matrix once was NaN, and the
    /// decomposition of that never ended.
    #[test]
    fn a_column_that_moves_nothing_scales_to_zero() {
        let columns = DMatrix::from_row_slice(3, 2, &[3.0, 4.0, 0.0, 0.0, 1e-17, 0.0]);
        let scales = column_scales(&columns);
        assert_eq!(scales, [5.0, f64::INFINITY, f64::INFINITY]);
        let basis = surviving_basis(&columns.transpose(), &columns);
        assert_eq!(basis.ncols(), 1);
    }
}
