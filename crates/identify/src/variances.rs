//! Variances of the parts of a machine's noise, as the residual of a fit shows them.
//!
//! Posterior means under Σ = σ² (I + Σ_k θ_k Z_k Z_kᵀ + c L Lᵀ). Likelihood: that of the residual alone (REML), σ integrated out:
//!
//! ln p(y | θ, c) = −½ ln det Σ/σ² − ½ ln det AᵀΣ⁻¹A σ² − ½ ν ln rss(θ, c),   E[σ² | θ, c] = rss / (ν − 2)
//!
//! With M the projection off the columns A of the fit (after the scatter c has been whitened away) and D = diag θ:
//! ln det of both = ln det(I + D^½ Zᵀ M Z D^½) + const, rss = yᵀMy − bᵀ(I + D^½ Zᵀ M Z D^½)⁻¹ b, b = D^½ Zᵀ M y [Woodbury]: readings
//! appear only in inner products, formed once.
//!
//! Prior of every θ and c, independent: a machine has the part or has it not (one to one); if it has, the ratio √θ of its
//! standard deviation to that of the white noise is half-Cauchy of scale 1 [Gelman, Bayesian Analysis 1 (2006) 515]. Without "has it
//! not", parts too small to be seen would widen every interval of a machine that lacks them.
//! Mean over a grid of half decades in θ: from the best member to all whose weight is not negligible.

use crate::random_columns::{Kind, Levers};
use nalgebra::{Cholesky, DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet, btree_map::Entry};
use std::f64::consts::FRAC_2_PI;

/// Smallest and largest θ of the grid, and steps a decade.
const DECADES: [i32; 2] = [-3, 3];
const PER_DECADE: i32 = 2;
/// Prior probability that a machine has a part.
const HAS_IT: f64 = 0.5;
/// Members lighter than this share of the heaviest are not followed further.
const LIGHT: f64 = 0.1;
/// A scan along one variance ends where the logarithm has fallen by this.
const HOPELESS: f64 = 15.0;
/// Rounds of climbing along one variance after the other.
const MOST_CLIMBS: usize = 4;
/// A part of which the readings show fewer directions than this, after the fit took its share, cannot be sized.
const FEWEST_DIRECTIONS: usize = 3;
/// Share of the largest eigenvalue of a part that counts as a direction seen.
const SEEN: f64 = 0.05;

/// What the variances are estimated from. Rows of readings not used are zero in all.
pub(crate) struct Residual<'a> {
    /// Columns of the fit, weighted.
    pub fitted: &'a DMatrix<f64>,
    /// Weighted residual, mm.
    pub residual_mm: &'a DVector<f64>,
    /// Random columns.
    pub kinds: &'a [Kind],
    /// Scatter of the fast axis.
    pub levers: &'a Levers,
    /// Readings used minus parameters determined, more than 2.
    pub degrees_of_freedom: usize,
}

/// Posterior means of the variances per reading, mm².
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variances {
    pub white: f64,
    /// One for each kind.
    pub kinds: Vec<f64>,
    pub levers: f64,
}

/// Variances that explain the residual.
pub(crate) fn variances(residual: &Residual<'_>) -> Variances {
    let mut bank = Bank::new(Products::new(residual));
    bank.climb();
    bank.spread();
    bank.mean()
}

/// One value of θ in the grid.
struct Level {
    theta: f64,
    prior_ln: f64,
}

fn levels() -> Vec<Level> {
    let count = (DECADES[1] - DECADES[0]) * PER_DECADE;
    let theta = |step: f64| 10f64.powf(f64::from(DECADES[0]) + step / f64::from(PER_DECADE));
    let below = |step: f64| FRAC_2_PI * theta(step).sqrt().atan();
    let mut levels = vec![Level { theta: 0.0, prior_ln: (1.0 - HAS_IT).ln() }];
    for step in 0..=count {
        let from = if step == 0 { 0.0 } else { below(f64::from(step) - 0.5) };
        let to = if step == count { 1.0 } else { below(f64::from(step) + 0.5) };
        levels.push(Level { theta: theta(f64::from(step)), prior_ln: (HAS_IT * (to - from)).ln() });
    }
    levels
}

/// Level of every kind that can be sized, then of the levers if there are any.
type Place = Vec<usize>;

struct Member {
    ln: f64,
    white: f64,
}

struct Bank {
    products: Products,
    levels: Vec<Level>,
    members: BTreeMap<Place, Member>,
    best: Place,
    best_ln: f64,
    /// Projected products at each level of the levers.
    projected: BTreeMap<usize, Projected>,
}

impl Bank {
    fn new(products: Products) -> Self {
        let best = vec![0; products.kinds.len() + usize::from(products.squares.len() > 0)];
        let (members, projected) = (BTreeMap::new(), BTreeMap::new());
        let mut bank = Self {
            products,
            levels: levels(),
            members,
            best: best.clone(),
            best_ln: f64::NEG_INFINITY,
            projected,
        };
        bank.visit(&best);
        bank
    }

    fn visit(&mut self, place: &Place) -> f64 {
        if let Some(member) = self.members.get(place) {
            return member.ln;
        }
        let (products, levels) = (&self.products, &self.levels);
        let of_levers = place.get(products.kinds.len()).copied().unwrap_or(0);
        let projected = match self.projected.entry(of_levers) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(products.project(levels[of_levers].theta)),
        };
        let mut member = projected.member(products, |kind| levels[place[kind]].theta);
        member.ln += place.iter().map(|&level| levels[level].prior_ln).sum::<f64>();
        let ln = member.ln;
        if ln > self.best_ln {
            (self.best_ln, self.best) = (ln, place.clone());
        }
        self.members.insert(place.clone(), member);
        ln
    }

    /// To the best member, along one variance after the other.
    fn climb(&mut self) {
        for _ in 0..MOST_CLIMBS {
            let before = self.best_ln;
            for k in 0..self.best.len() {
                let (mut place, mut highest) = (self.best.clone(), f64::NEG_INFINITY);
                for level in 0..self.levels.len() {
                    place[k] = level;
                    let ln = self.visit(&place);
                    highest = highest.max(ln);
                    if ln < highest - HOPELESS {
                        break;
                    }
                }
            }
            if self.best_ln <= before {
                break;
            }
        }
    }

    /// From the best member to neighbours (a step up, a step down, none at all) as long as they weigh something.
    fn spread(&mut self) {
        let mut open = vec![self.best.clone()];
        let mut done = BTreeSet::new();
        while let Some(place) = open.pop() {
            if !done.insert(place.clone()) {
                continue;
            }
            for k in 0..place.len() {
                for level in [place[k].saturating_sub(1), (place[k] + 1).min(self.levels.len() - 1), 0] {
                    let mut next = place.clone();
                    next[k] = level;
                    if self.visit(&next) - self.best_ln > LIGHT.ln() && !done.contains(&next) {
                        open.push(next);
                    }
                }
            }
        }
    }

    fn mean(&self) -> Variances {
        let products = &self.products;
        let mut total = 0.0;
        let mut mean = Variances { white: 0.0, kinds: vec![0.0; products.given], levers: 0.0 };
        for (place, member) in &self.members {
            let weight = (member.ln - self.best_ln).exp();
            let variance = |level: usize| weight * member.white * self.levels[level].theta;
            total += weight;
            mean.white += weight * member.white;
            for (kind, &level) in products.kinds.iter().zip(place) {
                mean.kinds[kind.given] += variance(level);
            }
            mean.levers += place.get(products.kinds.len()).map_or(0.0, |&level| variance(level));
        }
        mean.white /= total;
        mean.kinds.iter_mut().for_each(|variance| *variance /= total);
        mean.levers /= total;
        mean
    }
}

/// Inner products of X = [Q Z y], Q an orthonormal basis of the fitted columns.
struct Products {
    /// XᵀX.
    gram: DMatrix<f64>,
    /// LᵀX.
    levers: DMatrix<f64>,
    /// Diagonal of LᵀL.
    squares: DVector<f64>,
    fitted: usize,
    kinds: Vec<Sized>,
    /// Kinds asked for, also those that cannot be sized.
    given: usize,
    degrees_of_freedom: f64,
}

/// A kind that these readings can size.
struct Sized {
    /// Its number among those asked for.
    given: usize,
    columns: usize,
}

impl Products {
    fn new(residual: &Residual<'_>) -> Self {
        let q = orthonormal(residual.fitted);
        let (mut kinds, mut random) = (Vec::new(), Vec::new());
        for (given, kind) in residual.kinds.iter().enumerate() {
            if directions_seen(&q, &kind.columns) >= FEWEST_DIRECTIONS {
                kinds.push(Sized { given, columns: kind.columns.ncols() });
                random.push(&kind.columns);
            }
        }
        let width = q.ncols() + random.iter().map(|columns| columns.ncols()).sum::<usize>() + 1;
        let mut x = DMatrix::zeros(q.nrows(), width);
        x.columns_mut(0, q.ncols()).copy_from(&q);
        let mut next = q.ncols();
        for columns in random {
            x.columns_mut(next, columns.ncols()).copy_from(columns);
            next += columns.ncols();
        }
        x.set_column(next, residual.residual_mm);
        Self {
            gram: x.tr_mul(&x),
            levers: residual.levers.seen_by(&x),
            squares: residual.levers.squares(),
            fitted: q.ncols(),
            kinds,
            given: residual.kinds.len(),
            degrees_of_freedom: residual.degrees_of_freedom as f64,
        }
    }

    /// With the scatter c of the fast axis whitened away, (I + c L Lᵀ)⁻¹ = I − L diag(c/(1 + c l²)) Lᵀ, and M applied.
    fn project(&self, c: f64) -> Projected {
        let mut weighted = self.levers.clone();
        let shrink = self.squares.map(|square| c / (1.0 + c * square));
        weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(&shrink));
        let gram = if c > 0.0 { &self.gram - self.levers.tr_mul(&weighted) } else { self.gram.clone() };
        let (q, rest) = (self.fitted, gram.ncols() - self.fitted);
        let of_fit = positive_definite(gram.view((0, 0), (q, q)).into_owned());
        let on_fit = of_fit
            .l_dirty()
            .solve_lower_triangular(&gram.view((0, q), (q, rest)))
            .expect("a positive diagonal");
        let left = gram.view((q, q), (rest, rest)) - on_fit.tr_mul(&on_fit);
        let random = rest - 1;
        Projected {
            gram: left.view((0, 0), (random, random)).into_owned(),
            on_residual: left.view((0, random), (random, 1)).column(0).into_owned(),
            squares: left[(random, random)],
            log_det: log_det(&of_fit) + self.squares.iter().map(|square| (c * square).ln_1p()).sum::<f64>(),
        }
    }
}

/// Products of the random columns and the residual, off the fitted columns.
struct Projected {
    /// ZᵀMZ.
    gram: DMatrix<f64>,
    /// ZᵀMy.
    on_residual: DVector<f64>,
    /// yᵀMy.
    squares: f64,
    log_det: f64,
}

impl Projected {
    fn member(&self, products: &Products, theta_of: impl Fn(usize) -> f64) -> Member {
        let (mut active, mut root, mut next) = (Vec::new(), Vec::new(), 0);
        for (k, kind) in products.kinds.iter().enumerate() {
            let theta = theta_of(k);
            if theta > 0.0 {
                active.extend(next..next + kind.columns);
                root.extend(std::iter::repeat_n(theta.sqrt(), kind.columns));
            }
            next += kind.columns;
        }
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let entry = |i: usize, j: usize| one(i, j) + root[i] * root[j] * self.gram[(active[i], active[j])];
        let cholesky = positive_definite(DMatrix::from_fn(active.len(), active.len(), entry));
        let b = DVector::from_fn(active.len(), |i, _| root[i] * self.on_residual[active[i]]);
        let explained =
            cholesky.l_dirty().solve_lower_triangular(&b).expect("a positive diagonal").norm_squared();
        let rss = (self.squares - explained).max(f64::MIN_POSITIVE);
        let nu = products.degrees_of_freedom;
        let ln = -0.5 * (self.log_det + log_det(&cholesky)) - 0.5 * nu * rss.ln();
        Member { ln, white: rss / (nu - 2.0) }
    }
}

/// How many directions of random columns are left off the fitted ones.
fn directions_seen(q: &DMatrix<f64>, columns: &DMatrix<f64>) -> usize {
    let largest = columns.tr_mul(columns).symmetric_eigenvalues().max();
    let left = columns - q * q.tr_mul(columns);
    left.tr_mul(&left).symmetric_eigenvalues().iter().filter(|lambda| **lambda > SEEN * largest).count()
}

fn orthonormal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = columns.clone();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        column /= if norm > 0.0 { norm } else { 1.0 };
    }
    scaled.qr().q()
}

fn positive_definite(matrix: DMatrix<f64>) -> Cholesky<f64, nalgebra::Dyn> {
    matrix.cholesky().expect("identity plus a Gram matrix is positive definite")
}

fn log_det(cholesky: &Cholesky<f64, nalgebra::Dyn>) -> f64 {
    let l = cholesky.l_dirty();
    2.0 * (0..l.nrows()).map(|k| l[(k, k)].ln()).sum::<f64>()
}
