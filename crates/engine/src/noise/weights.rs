//! What a reading is worth against the others.
//!
//! σ_i² = κ_g (f_g² l_i + e_i²).  e_i: standard error of the mean of its samples (0 when unknown), averages down with their number. f_g: floor of
//! its group g (run × instrument): drift, positioning, what the model lacks; it does not average down. f_g by the median:
//! med(r²/(f² l + e²)) over the group = 0.455, the median of χ² with one degree of freedom, so that outliers do not count. l_i: usual
//! length of a block of its pass over its own, at least 1; 1 for points at rest. What does not average down is alike along the path, so a
//! short block (next to a reversal) counts by its length: how finely a path was cut changes no result.
//! κ_g ≥ 1: on the fly 1 + 2 Σ ρ_k, ρ_k the autocorrelation of the residual from block to block within a pass up to where it dies
//! out, so that 100 blocks that err alike do not count as 100 against another run.
//! Rows are scaled by ω_i = σ_ref/σ_i with mean ω² = 1. Where all ω are nearly alike they are exactly 1.
//! Limits: no group counts as more than ten times as exact as all together; correlation between rows is the business of the clusters
//! in `uncertainty`.

use crate::Experiment;
use crate::fit::identification::GroupNoise;
use crate::problem::passes::passes;
use nalgebra::DVector;
use trunnion_core::InstrumentKind;
use trunnion_core::statistics::upper_median;
use trunnion_cycles::RunKind;

const MEDIAN_OF_CHI_SQUARE: f64 = 0.4549;
const FINEST_MM: f64 = 1e-6;
/// ω that differ by less than this are one.
const SAME_WITHIN: f64 = 0.05;
const MOST_EXACT: f64 = 10.0;
const BISECTIONS: usize = 50;
/// Autocorrelation that counts as none, and the longest lag looked at.
const DEAD: f64 = 0.05;
const MOST_LAGS: usize = 200;

/// ω of every row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Weights {
    pub root: DVector<f64>,
    /// True when every ω is 1.
    pub even: bool,
    /// σ_ref, mm; 0 for points at rest that all count alike: the residual is then its own measure.
    pub reference_mm: f64,
}

impl Weights {
    pub fn even(experiment: &Experiment) -> Self {
        Self { root: DVector::from_element(experiment.rows(), 1.0), even: true, reference_mm: 0.0 }
    }

    /// True when a fit with one is as good as a fit with the other.
    pub fn like(&self, other: &Self) -> bool {
        self.root.iter().zip(&other.root).all(|(a, b)| (a / b - 1.0).abs() < SAME_WITHIN)
    }
}

/// Noise of each group by a residual, and the weights that follow from it.
pub(crate) fn weights_of(
    experiment: &Experiment,
    residual_mm: &DVector<f64>,
    used: &[bool],
    determined: usize,
) -> (Weights, Vec<GroupNoise>) {
    let group_of_point = groups(experiment);
    let groups = group_of_point.iter().max().map_or(0, |last| last + 1);
    let mut rows: Vec<Vec<usize>> = vec![Vec::new(); groups];
    for i in (0..used.len()).filter(|&i| used[i]) {
        rows[group_of_point[i]].extend(experiment.rows_of(i));
    }
    let e = experiment.standard_errors_mm();
    let all: Vec<usize> = rows.iter().flatten().copied().collect();
    // A fit shrinks the residual: by the share of the degrees of freedom that it took.
    let shrunk = all.len() as f64 / all.len().saturating_sub(determined).max(1) as f64;
    let short = shortness(experiment);
    let floor = |rows: &[usize]| {
        let row = |&row: &usize| (residual_mm[row].powi(2) * shrunk, short[row], e[row].powi(2));
        floor_mm(&rows.iter().map(row).collect::<Vec<_>>())
    };
    let least = (floor(&all) / MOST_EXACT).max(FINEST_MM);
    let floors: Vec<f64> = rows.iter().map(|rows| floor(rows).max(least)).collect();
    let inflation = inflations(experiment, residual_mm, used, &group_of_point, groups);
    let mut root = DVector::zeros(experiment.rows());
    let mut of_group = Vec::with_capacity(groups);
    for i in 0..used.len() {
        for row in experiment.rows_of(i) {
            let g = group_of_point[i];
            let sigma = (floors[g] * short[row].sqrt()).hypot(e[row]) * inflation[g].sqrt();
            root[row] = sigma.recip();
        }
    }
    for (g, rows) in rows.iter().enumerate() {
        let Some(i) = group_of_point.iter().position(|group| *group == g) else { continue };
        let mean = |value: &dyn Fn(usize) -> f64| {
            (rows.iter().map(|&row| value(row)).sum::<f64>() / rows.len().max(1) as f64).sqrt()
        };
        of_group.push(GroupNoise {
            run: experiment.runs[experiment.run_of_point[i]].clone(),
            instrument: experiment.setups[experiment.points[i].state.setup].instrument,
            readings: rows.len(),
            rms_mm: mean(&|row| residual_mm[row].powi(2)),
            floor_mm: floors[g],
            samples_mm: mean(&|row| e[row].powi(2)),
        });
    }
    let mean_square = all.iter().map(|&row| root[row].powi(2)).sum::<f64>() / all.len().max(1) as f64;
    root /= mean_square.sqrt();
    let mut weights = Weights { root, even: false, reference_mm: mean_square.sqrt().recip() };
    let even = Weights::even(experiment);
    if weights.like(&even) {
        let correlated = inflation.iter().any(|kappa| *kappa > 1.0);
        let reference_mm = if correlated { weights.reference_mm } else { 0.0 };
        weights = Weights { reference_mm, ..even };
    }
    (weights, of_group)
}

/// f with med(r²/(f² l + e²)) = 0.455, from (r², l, e²); 0 when the samples say it all.
fn floor_mm(rows: &[(f64, f64, f64)]) -> f64 {
    if rows.is_empty() {
        return 0.0;
    }
    let mut ratios = vec![0.0; rows.len()];
    let mut median_ratio = |f_square: f64| {
        let of_row = |(r, l, e): &(f64, f64, f64)| r / (f_square * l + e).max(f64::MIN_POSITIVE);
        ratios.iter_mut().zip(rows).for_each(|(ratio, row)| *ratio = of_row(row));
        let middle = ratios.len() / 2;
        *ratios.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let most = rows.iter().fold(0.0_f64, |most, (r, _, _)| most.max(*r));
    let (mut low, mut high) = (0.0, most / MEDIAN_OF_CHI_SQUARE);
    if median_ratio(low) <= MEDIAN_OF_CHI_SQUARE {
        return 0.0;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if median_ratio(middle) > MEDIAN_OF_CHI_SQUARE { low = middle } else { high = middle }
    }
    high.sqrt()
}

/// κ of every group.
fn inflations(
    experiment: &Experiment,
    residual_mm: &DVector<f64>,
    used: &[bool],
    group_of_point: &[usize],
    groups: usize,
) -> Vec<f64> {
    let mut inflation = vec![1.0; groups];
    if !experiment.kinds.contains(&RunKind::OnTheFly) {
        return inflation;
    }
    let pass = passes(experiment).pass;
    for g in 0..groups {
        let on_the_fly = |&i: &usize| experiment.kinds[experiment.run_of_point[i]] == RunKind::OnTheFly;
        let points: Vec<usize> =
            (0..used.len()).filter(|&i| used[i] && group_of_point[i] == g).filter(on_the_fly).collect();
        let product = |lag: usize| -> f64 {
            let pairs = points.iter().zip(points.iter().skip(lag)).filter(|(i, j)| pass[**i] == pass[**j]);
            let of_pair = |(&i, &j): (&usize, &usize)| -> f64 {
                let rows = experiment.rows_of(i).zip(experiment.rows_of(j));
                rows.map(|(a, b)| residual_mm[a] * residual_mm[b]).sum()
            };
            pairs.map(of_pair).sum()
        };
        let square = product(0);
        if square > 0.0 {
            let correlations = (1..=MOST_LAGS).map(|lag| product(lag) / square);
            inflation[g] += 2.0 * correlations.take_while(|rho| *rho > DEAD).sum::<f64>();
        }
    }
    inflation
}

/// l of every row.
fn shortness(experiment: &Experiment) -> Vec<f64> {
    let mut short = vec![1.0; experiment.rows()];
    if !experiment.kinds.contains(&RunKind::OnTheFly) {
        return short;
    }
    let passes = passes(experiment);
    let mut samples: Vec<Vec<f64>> = vec![Vec::new(); passes.passes];
    for (point, &pass) in experiment.points.iter().zip(&passes.pass) {
        samples[pass].push(f64::from(point.samples.max(1)));
    }
    let usual: Vec<f64> = samples.iter().map(|of_pass| upper_median(of_pass).unwrap_or(0.0)).collect();
    for (i, point) in experiment.points.iter().enumerate() {
        if experiment.kinds[experiment.run_of_point[i]] == RunKind::OnTheFly {
            let length = (usual[passes.pass[i]] / f64::from(point.samples.max(1))).max(1.0);
            short[experiment.rows_of(i)].fill(length);
        }
    }
    short
}

/// Group of each point: run × instrument, numbered in order of appearance.
fn groups(experiment: &Experiment) -> Vec<usize> {
    let mut seen: Vec<(usize, InstrumentKind)> = Vec::new();
    (0..experiment.points.len())
        .map(|i| {
            let instrument = experiment.setups[experiment.points[i].state.setup].instrument;
            let key = (experiment.run_of_point[i], instrument);
            seen.iter().position(|other| *other == key).unwrap_or_else(|| {
                seen.push(key);
                seen.len() - 1
            })
        })
        .collect()
}
