//! What differs between runs: the standard deviation of each parameter from run to run, from fits of each run alone.
//!
//! x_r ~ N(x, C_r + λ C̄), r = 1…k,  C̄ = k (Σ C_r⁻¹)⁻¹     one-way random effects, as in consensus values of laboratories [Paule 1982]
//! ln p(λ | x_r) = −½ Σ ln|C_r + λ C̄| − ½ ln|Σ W_r| − ½ Σ (x_r − x̄)ᵀ W_r (x_r − x̄) + ln p(λ),   W_r = (C_r + λ C̄)⁻¹   (REML)
//! p(√λ): half-Cauchy of scale 1 [Gelman 2006]. With few runs λ itself is uncertain, so what one more run shows is a mixture over λ; given
//! is the λ whose normal distribution has the same 95 % interval. A parameter alone has its own λ, s² = λ C̄. Those of one effect
//! that the others nearly determine (variance inflation above 10) share one, and s ∝ u: what differs between runs in collinear
//! coefficients is large and opposite like their errors, and their sum, which the readings show, stays as certain as it is.
//! Runs count by information: u²(mean) = u² + v s²,  u²(one more run) = u²(mean) + s²,  v = Σ tr((C̄ C_r⁻¹/k)²)/m for m parameters.
//! Limits: normal differences. Two runs say little: 95 % intervals of one parameter then hold 80 to 100 % of further runs, with five
//! 89 to 100 %.

use crate::fit::identification::Identification;
use crate::fit::mixture::half_width;
use crate::solve::logarithms::shares_of;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use trunnion_core::statistics::COVERAGE_95;

/// Grid of λ: sixths of a decade, a fifth in s. Its ends hardly matter: an s below does not show, an s above is a rare guess with two runs.
const DECADES: [i32; 2] = [-3, 5];
const PER_DECADE: i32 = 6;
/// Variance inflation, the diagonal of the inverse correlation, above which the others nearly determine a parameter [Belsley 1980 §3.2].
const INFLATION: f64 = 10.0;

/// How one parameter differs between runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetweenRuns {
    /// Runs that determine it alone.
    pub runs: usize,
    /// s: standard deviation from run to run, inside units.
    pub sd: f64,
    /// v: the share of s² that the mean of the runs keeps.
    pub share_of_mean: f64,
}

impl BetweenRuns {
    /// u of the mean of the runs, from the u of their fit together.
    pub fn u_of_mean(&self, u: f64) -> f64 {
        (u * u + self.sd * self.sd * self.share_of_mean).sqrt()
    }
}

/// For each parameter of a fit of several runs what differs between them; `None` where fewer than two of the fits of runs
/// `alone` determine the same thing.
pub fn between_runs(together: &Identification, alone: &[Identification]) -> Vec<Option<BetweenRuns>> {
    let mut found = vec![None; together.parameters.len()];
    for group in groups(together) {
        // A parameter that stands for others does so in every run, or it is not the same thing.
        let place = |fit: &Identification, j: usize| {
            let wanted = &together.parameters[j];
            fit.parameters.iter().position(|p| {
                (&p.effect, &p.name, &p.note) == (&wanted.effect, &wanted.name, &wanted.note)
                    && p.u.is_some_and(|u| u > 0.0)
            })
        };
        let of_run = |fit: &Identification| {
            let places: Vec<usize> = group.iter().map(|&j| place(fit, j)).collect::<Option<_>>()?;
            let covariance = fit.covariance.select_rows(&places).select_columns(&places);
            Some(Estimate { value: fit.solution.select_rows(&places), covariance })
        };
        let Some(between) = differences(&alone.iter().filter_map(of_run).collect::<Vec<_>>()) else {
            continue;
        };
        let u: Vec<f64> = group.iter().filter_map(|&j| together.parameters[j].u).collect();
        let ratios = between.variances.iter().zip(&u).map(|(variance, u)| variance / (u * u));
        let ratio = ratios.sum::<f64>() / u.len() as f64;
        for (&j, u) in group.iter().zip(&u) {
            let (runs, share_of_mean) = (between.runs, between.share_of_mean);
            found[j] = Some(BetweenRuns { runs, sd: ratio.sqrt() * u, share_of_mean });
        }
    }
    found
}

/// Parameters with a standard uncertainty: those of one effect that the others nearly determine together, every other one alone.
fn groups(fit: &Identification) -> Vec<Vec<usize>> {
    let mut groups = Vec::new();
    for effect in &fit.effects {
        let known: Vec<usize> = (0..fit.parameters.len())
            .filter(|&j| {
                fit.parameters[j].effect == effect.id && fit.parameters[j].u.is_some_and(|u| u > 0.0)
            })
            .collect();
        let sd: Vec<f64> = known.iter().map(|&j| fit.covariance[(j, j)].sqrt()).collect();
        let correlation = DMatrix::from_fn(known.len(), known.len(), |a, b| {
            fit.covariance[(known[a], known[b])] / (sd[a] * sd[b])
        });
        let inflation = correlation.cholesky().map(|cholesky| cholesky.inverse().diagonal());
        // A correlation that cannot be inverted is of parameters that determine each other.
        let inflated = |a: usize| inflation.as_ref().is_none_or(|inflation| inflation[a] > INFLATION);
        let (together, apart): (Vec<usize>, Vec<usize>) = (0..known.len()).partition(|&a| inflated(a));
        groups.extend(apart.into_iter().map(|a| vec![known[a]]));
        groups.extend((!together.is_empty()).then(|| together.into_iter().map(|a| known[a]).collect()));
    }
    groups
}

/// Values of one run with their covariance.
struct Estimate {
    value: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// What differs between runs in a group of parameters.
struct Differences {
    runs: usize,
    /// λ C̄: variance of each from run to run.
    variances: Vec<f64>,
    share_of_mean: f64,
}

/// From the values in each run; `None` for fewer than two, or covariances that are none.
fn differences(runs: &[Estimate]) -> Option<Differences> {
    if runs.len() < 2 {
        return None;
    }
    let (count, width) = (runs.len() as f64, runs[0].value.len());
    let information: Vec<DMatrix<f64>> =
        runs.iter().map(|run| inverse(&run.covariance)).collect::<Option<_>>()?;
    let typical =
        inverse(&information.iter().fold(DMatrix::zeros(width, width), |sum, one| sum + one))? * count;
    let share = |one: &DMatrix<f64>| {
        let share = &typical * one / count;
        (&share * &share).trace() / width as f64
    };
    let share_of_mean = information.iter().map(share).sum::<f64>();
    let levels = levels();
    let ln: Option<Vec<f64>> = levels
        .iter()
        .map(|(lambda, prior)| Some(prior.ln() + likelihood_ln(runs, &(&typical * *lambda))?))
        .collect();
    let ln = ln?;
    let weights = shares_of(ln.into_iter());
    // In units of C̄: the mean of the runs has 1/k of it.
    let variance_of = |lambda: f64| 1.0 / count + lambda * (1.0 + share_of_mean);
    let member = |((lambda, _), weight): (&(f64, f64), &f64)| (variance_of(*lambda).sqrt(), *weight);
    let half_width = half_width(&levels.iter().zip(&weights).map(member).collect::<Vec<_>>());
    let lambda = ((half_width / COVERAGE_95).powi(2) - 1.0 / count).max(0.0) / (1.0 + share_of_mean);
    let variances = typical.diagonal().iter().map(|variance| lambda * variance).collect();
    Some(Differences { runs: runs.len(), variances, share_of_mean })
}

fn inverse(covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    Some(covariance.clone().cholesky()?.inverse())
}

/// Values of λ with their prior probability.
fn levels() -> Vec<(f64, f64)> {
    let count = (DECADES[1] - DECADES[0]) * PER_DECADE;
    let lambda = |step: f64| 10f64.powf(f64::from(DECADES[0]) + step / f64::from(PER_DECADE));
    let below = |step: f64| lambda(step).sqrt().atan();
    (0..=count)
        .map(|step| {
            let from = if step == 0 { 0.0 } else { below(f64::from(step) - 0.5) };
            (lambda(f64::from(step)), below(f64::from(step) + 0.5) - from)
        })
        .collect()
}

fn likelihood_ln(runs: &[Estimate], between: &DMatrix<f64>) -> Option<f64> {
    let width = between.nrows();
    let of_run = |run: &Estimate| (&run.covariance + between).cholesky();
    let factors: Vec<Cholesky<f64, Dyn>> = runs.iter().map(of_run).collect::<Option<_>>()?;
    let (mut weight, mut weighted) = (DMatrix::zeros(width, width), DVector::zeros(width));
    for (factor, run) in factors.iter().zip(runs) {
        weight += factor.inverse();
        weighted += factor.solve(&run.value);
    }
    let of_mean = weight.cholesky()?;
    let mean = of_mean.solve(&weighted);
    let spread = |(factor, run): (&Cholesky<f64, Dyn>, &Estimate)| {
        let off = &run.value - &mean;
        off.dot(&factor.solve(&off)) + factor.ln_determinant()
    };
    Some(-0.5 * (factors.iter().zip(runs).map(spread).sum::<f64>() + of_mean.ln_determinant()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    fn of_values(values: &[(f64, f64)]) -> Option<BetweenRuns> {
        let one = |(value, u): &(f64, f64)| Estimate {
            value: DVector::from_element(1, *value),
            covariance: DMatrix::from_element(1, 1, u * u),
        };
        let found = differences(&values.iter().map(one).collect::<Vec<_>>())?;
        let Differences { runs, variances, share_of_mean } = found;
        Some(BetweenRuns { runs, sd: variances[0].sqrt(), share_of_mean })
    }

    /// Share of further runs inside the 95 % interval.
    fn share_inside(runs: usize, s: f64) -> f64 {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let trials = 1500;
        let mut draw = |sd: f64| Normal::new(0.0, sd).unwrap().sample(&mut rng);
        let inside = (0..trials).filter(|_| {
            // Runs of unequal uncertainty, around zero.
            let values: Vec<_> =
                (0..runs).map(|r| 0.7 + 0.2 * r as f64).map(|u| (draw(s) + draw(u), u)).collect();
            let found = of_values(&values).unwrap();
            let information: f64 = values.iter().map(|(_, u)| u.powi(-2)).sum();
            let mean = values.iter().map(|(x, u)| x * u.powi(-2)).sum::<f64>() / information;
            let u2 = 1.0 / information + found.sd.powi(2) * (1.0 + found.share_of_mean);
            (mean - draw(s)).abs() <= COVERAGE_95 * u2.sqrt()
        });
        inside.count() as f64 / f64::from(trials)
    }

    #[test]
    fn what_one_more_run_shows_lies_in_its_interval_whether_runs_differ_or_not() {
        for (runs, s, least) in
            [(2, 0.0, 0.95), (2, 10.0, 0.78), (3, 1.0, 0.9), (5, 3.0, 0.87), (8, 10.0, 0.9)]
        {
            let share = share_inside(runs, s);
            assert!(share >= least, "{runs} runs, s {s}: {share}");
        }
    }

    #[test]
    fn many_runs_give_the_difference_that_they_have() {
        let equal: Vec<_> = (0..60).map(|r| (if r % 2 == 0 { 1e-3 } else { -1e-3 }, 1e-3)).collect();
        assert!(of_values(&equal).unwrap().sd < 0.5e-3, "scatter that u explains is no difference");
        let apart: Vec<_> = (0..60).map(|r| (if r % 2 == 0 { 7e-3 } else { -7e-3 }, 1e-3)).collect();
        let found = of_values(&apart).unwrap();
        // √(7² − 1) = 6.93, and a little for its own uncertainty.
        assert!((found.sd - 6.93e-3).abs() < 0.7e-3, "{found:?}");
        assert!((found.share_of_mean - 1.0 / 60.0).abs() < 1e-9);
        assert_eq!(of_values(&[(1.0, 0.1)]), None);
    }

    #[test]
    fn collinear_values_that_scatter_as_they_err_differ_little() {
        // Two coefficients of nearly the same column: their difference errs a hundred times as much as their sum.
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut draw = || Normal::new(0.0, 1.0).unwrap().sample(&mut rng);
        let (of_sum, of_difference) = (0.01, 1.0);
        let covariance = DMatrix::from_row_slice(
            2,
            2,
            &[
                of_sum * of_sum + of_difference * of_difference,
                of_sum * of_sum - of_difference * of_difference,
                of_sum * of_sum - of_difference * of_difference,
                of_sum * of_sum + of_difference * of_difference,
            ],
        );
        let runs: Vec<Estimate> = (0..6)
            .map(|_| {
                let (sum, difference) = (of_sum * draw(), of_difference * draw());
                let value = DVector::from_vec(vec![sum + difference, sum - difference]);
                Estimate { value, covariance: covariance.clone() }
            })
            .collect();
        let found = differences(&runs).unwrap();
        assert!(
            found.variances.iter().all(|variance| variance.sqrt() < 0.9 * of_difference),
            "{:?}",
            found.variances
        );
    }
}
