//! What differs between runs: the standard deviation of each parameter from run to run, from fits of each run alone.
//!
//! x_r ~ N(x, u_r² + s²), r = 1…k                       one-way random effects, as in consensus values of laboratories [Paule 1982]
//! ln p(s | x_r) = −½ Σ ln(u_r² + s²) − ½ ln Σ w_r − ½ Σ w_r (x_r − x̄)² + ln p(s),   w_r = 1/(u_r² + s²)   (REML)
//! p(s): half-Cauchy, its scale the harmonic mean of the u_r [Gelman 2006]. With few runs s itself is uncertain, so what one more run
//! shows is a mixture over s; given is the s whose normal distribution has the same 95 % interval. Runs count by 1/u_r²:
//! u²(mean) = u² + s² Σ v_r²,  u²(one more run) = u²(mean) + s²,  v_r = u_r⁻² / Σ u_r⁻².
//! Limits: normal differences, one parameter at a time. Two runs say little: 95 % intervals then hold 80 to 100 % of further runs,
//! with five 89 to 100 %.

use crate::fit::identification::Identification;
use crate::solve::normal::within;

/// Grid of s² in units of the harmonic mean of the u_r²: half decades. Its ends hardly matter: an s below does not show, an s
/// above is a rare guess with two runs.
const DECADES: [i32; 2] = [-3, 5];
const PER_DECADE: i32 = 2;
/// Two-sided 95 % of a normal distribution, in standard uncertainties [GUM, table G.1].
const COVERAGE_95: f64 = 1.96;
/// Halvings of the interval in which the half width of the mixture lies.
const HALVINGS: usize = 60;

/// How one parameter differs between runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetweenRuns {
    /// Runs that determine it alone.
    pub runs: usize,
    /// s: standard deviation from run to run, inside units.
    pub sd: f64,
    /// Σ v_r²: the share of s² that the mean of the runs keeps.
    pub share_of_mean: f64,
}

/// For each parameter of a fit of several runs what differs between them; `None` where fewer than two of the fits of runs
/// `alone` determine the same thing.
pub fn between_runs(together: &Identification, alone: &[Identification]) -> Vec<Option<BetweenRuns>> {
    together
        .parameters
        .iter()
        .map(|parameter| {
            parameter.u?;
            let of_run = |fit: &Identification| {
                // A parameter that stands for others does so in every run, or it is not the same thing.
                let same = fit.parameters.iter().find(|p| {
                    (&p.effect, &p.name, &p.note) == (&parameter.effect, &parameter.name, &parameter.note)
                })?;
                Some((same.value?, same.u.filter(|u| *u > 0.0)?))
            };
            of_values(&alone.iter().filter_map(of_run).collect::<Vec<_>>())
        })
        .collect()
}

/// From the value and the standard uncertainty in each run.
fn of_values(values: &[(f64, f64)]) -> Option<BetweenRuns> {
    if values.len() < 2 {
        return None;
    }
    let information: f64 = values.iter().map(|(_, u)| u.powi(-2)).sum();
    let share_of_mean = values.iter().map(|(_, u)| (u.powi(-2) / information).powi(2)).sum::<f64>();
    let unit = values.len() as f64 / information;
    let levels = levels();
    let ln: Vec<f64> =
        levels.iter().map(|(s2, prior)| prior.ln() + likelihood_ln(values, s2 * unit)).collect();
    let highest = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = ln.iter().map(|ln| (ln - highest).exp()).collect();
    let total: f64 = weights.iter().sum();
    let variance_of = |s2: f64| 1.0 / information + s2 * unit * (1.0 + share_of_mean);
    let held = |half: f64| {
        let member = |((s2, _), weight): (&(f64, f64), &f64)| weight * within(half / variance_of(*s2).sqrt());
        levels.iter().zip(&weights).map(member).sum::<f64>() / total
    };
    let (mut low, mut high) = (0.0, 4.0 * variance_of(10f64.powi(DECADES[1])).sqrt());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        (low, high) = if held(middle) < within(COVERAGE_95) { (middle, high) } else { (low, middle) };
    }
    let variance = (high / COVERAGE_95).powi(2) - 1.0 / information;
    let sd = (variance.max(0.0) / (1.0 + share_of_mean)).sqrt();
    Some(BetweenRuns { runs: values.len(), sd, share_of_mean })
}

/// Values of s² in their unit, with prior probability.
fn levels() -> Vec<(f64, f64)> {
    let count = (DECADES[1] - DECADES[0]) * PER_DECADE;
    let s2 = |step: f64| 10f64.powf(f64::from(DECADES[0]) + step / f64::from(PER_DECADE));
    let below = |step: f64| s2(step).sqrt().atan();
    (0..=count)
        .map(|step| {
            let from = if step == 0 { 0.0 } else { below(f64::from(step) - 0.5) };
            (s2(f64::from(step)), below(f64::from(step) + 0.5) - from)
        })
        .collect()
}

fn likelihood_ln(values: &[(f64, f64)], s2: f64) -> f64 {
    let weight = |u: f64| (u * u + s2).recip();
    let total: f64 = values.iter().map(|(_, u)| weight(*u)).sum();
    let mean = values.iter().map(|(x, u)| weight(*u) * x).sum::<f64>() / total;
    let spread = |(x, u): &(f64, f64)| weight(*u).ln() - weight(*u) * (x - mean).powi(2);
    0.5 * (values.iter().map(spread).sum::<f64>() - total.ln())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

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
        let alike: Vec<_> = (0..60).map(|r| (if r % 2 == 0 { 1e-3 } else { -1e-3 }, 1e-3)).collect();
        assert!(of_values(&alike).unwrap().sd < 0.5e-3, "scatter that u explains is no difference");
        let apart: Vec<_> = (0..60).map(|r| (if r % 2 == 0 { 7e-3 } else { -7e-3 }, 1e-3)).collect();
        let found = of_values(&apart).unwrap();
        // √(7² − 1) = 6.93, and a little for its own uncertainty.
        assert!((found.sd - 6.93e-3).abs() < 0.7e-3, "{found:?}");
        assert!((found.share_of_mean - 1.0 / 60.0).abs() < 1e-9);
        assert_eq!(of_values(&[(1.0, 0.1)]), None);
    }
}
