//! Chart of individual values against a machine's own earlier runs.
//! |x − x̄| > t √(s² (1 + 1/n) + max(0, u² − ū²)),   t = t(1 − p/2; n − 1),   p = 1/(365 m)       [ISO 16269-8; Abramowitz 1964 §26.7]
//! s² = Σ (xᵢ − x̄)² / ((n − 1) κ),   κ = 1 − 2 c φ(c) / (1 − p),   c = t(1 − p/2; ∞)
//! x value of the run that is judged, x̄ and s mean and standard deviation of the n runs before it, m number of values that are
//! watched, u standard uncertainty of x, ū root mean square of those of the runs before. s and not the moving range: then the
//! limits are a prediction interval for one more run, for every n ≥ 2, however few runs there are. One in 365 m for each value
//! gives at most one false alarm in 365 runs over all of them (Bonferroni), whether they are correlated or not.
//! A value that was alarmed about joins no mean, so the tails of an unchanged machine are missing from s; κ is the variance of a normal
//! distribution without them. u enters where a run is less certain than those before: a shorter cycle is no change.
//! Limits: normal differences from run to run, independent of one another. Seasons are neither.

use std::f64::consts::{FRAC_PI_2, TAU};

/// Runs in which one false alarm is allowed, over all values: a year of daily runs.
pub const RUNS_PER_FALSE_ALARM: f64 = 365.0;
/// Doublings and halvings that bring t to the last digits of a double.
const STEPS: usize = 80;
/// Degrees of freedom that are as good as ∞.
const MANY: usize = 1000;

/// Values of earlier runs that count as those of an unchanged machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Baseline {
    count: usize,
    mean: f64,
    squares: f64,
    squared_u: f64,
}

/// Limits for one more run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// x̄.
    pub mean: f64,
    /// Half the distance of the limits.
    pub half_width: f64,
}

impl Baseline {
    /// Takes a value with its standard uncertainty.
    pub fn take(&mut self, value: f64, u: f64) {
        self.count += 1;
        let off = value - self.mean;
        self.mean += off / self.count as f64;
        self.squares += off * (value - self.mean);
        self.squared_u += u * u;
    }

    /// n.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Limits for a run of standard uncertainty `u`, where `watched` values are watched; `None` before the third run.
    pub fn limits(&self, u: f64, watched: usize) -> Option<Limits> {
        if self.count < 2 || watched == 0 {
            return None;
        }
        let rule = Rule::of(watched);
        let t = t_beyond(rule.share, self.count - 1);
        Some(Limits { mean: self.mean, half_width: self.half_width(u, t, rule.kept) })
    }

    fn half_width(&self, u: f64, t: f64, kept: f64) -> f64 {
        let n = self.count as f64;
        let variance = self.squares / ((n - 1.0) * kept) * (1.0 + 1.0 / n);
        let less_certain = (u * u - self.squared_u / n).max(0.0);
        t * (variance + less_certain).sqrt()
    }
}

/// How often a value may be alarmed about.
struct Rule {
    /// p.
    share: f64,
    /// κ.
    kept: f64,
}

impl Rule {
    fn of(watched: usize) -> Self {
        let share = 1.0 / (RUNS_PER_FALSE_ALARM * watched as f64);
        let c = t_beyond(share, MANY);
        let density = (-0.5 * c * c).exp() / TAU.sqrt();
        Self { share, kept: 1.0 - 2.0 * c * density / (1.0 - share) }
    }
}

impl Limits {
    /// True where a value lies outside.
    pub fn alarm(&self, value: f64) -> bool {
        (value - self.mean).abs() > self.half_width
    }
}

/// The t that |t| exceeds with probability `share`, for `freedom` degrees of freedom.
pub fn t_beyond(share: f64, freedom: usize) -> f64 {
    // As an angle θ = atan(t/√ν) the whole range is finite.
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        (low, high) = if 1.0 - within(middle, freedom) > share { (middle, high) } else { (low, middle) };
    }
    (0.5 * (low + high)).tan() * (freedom as f64).sqrt()
}

/// A(t|ν) at tan θ = t/√ν [Abramowitz 1964 §26.7.3, §26.7.4].
fn within(theta: f64, freedom: usize) -> f64 {
    let (sin, cos) = theta.sin_cos();
    let is_odd = freedom % 2 == 1;
    let (mut term, mut sum) = (if is_odd { cos } else { 1.0 }, 0.0);
    for k in (freedom % 2..freedom.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= cos * cos * (k as f64 + 1.0) / (k as f64 + 2.0);
    }
    if is_odd { (theta + sin * sum) / FRAC_PI_2 } else { sin * sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz 1964, table 26.10, two-sided.
        for (share, freedom, t) in
            [(0.05, 1, 12.706), (0.05, 2, 4.303), (0.05, 5, 2.571), (0.01, 10, 3.169), (0.001, 30, 3.646)]
        {
            assert!(
                (t_beyond(share, freedom) - t).abs() < 1e-3,
                "{share} {freedom}: {}",
                t_beyond(share, freedom)
            );
        }
        // GUM, table G.2, p = 95.45 %, many degrees of freedom.
        assert!((t_beyond(0.0455, 5000) - 2.0).abs() < 2e-3);
    }

    /// False alarms a year of daily runs over all watched values.
    fn alarms_a_year(years: usize, watched: usize, correlation: f64) -> f64 {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let normal = Normal::new(0.0, 1.0).expect("a deviation of one");
        let mut draw = || normal.sample(&mut rng);
        // What limits() computes for each n, once.
        let Rule { share, kept } = Rule::of(watched);
        let t: Vec<f64> = (0..365).map(|freedom| t_beyond(share, freedom)).collect();
        let mut alarms = 0;
        for _ in 0..years {
            let mut charts = vec![Baseline::default(); watched];
            for run in 0..365 {
                let common = draw() * correlation.sqrt();
                for chart in &mut charts {
                    let value = 5.0 + common + draw() * (1.0 - correlation).sqrt();
                    let half_width = match chart.count {
                        0 | 1 => f64::INFINITY,
                        n => chart.half_width(0.0, t[n - 1], kept),
                    };
                    if run == 100 {
                        let limits = chart.limits(0.0, watched).expect("a hundred runs");
                        assert_eq!(limits.half_width, half_width, "the statistic itself");
                    }
                    let limits = Limits { mean: chart.mean, half_width };
                    if limits.alarm(value) { alarms += 1 } else { chart.take(value, 0.0) }
                }
            }
        }
        alarms as f64 / years as f64
    }

    #[test]
    fn an_unchanged_machine_gives_at_most_one_false_alarm_a_year_over_all_values() {
        // 400 years: the rate has a standard deviation of 0.05.
        for (watched, correlation) in [(1, 0.0), (9, 0.0), (9, 0.8)] {
            let rate = alarms_a_year(400, watched, correlation);
            assert!(
                (0.75..=1.1).contains(&rate),
                "{watched} values, correlation {correlation}: {rate} a year"
            );
        }
    }

    #[test]
    fn a_change_is_alarmed_about_and_moves_no_limit() {
        let mut chart = Baseline::default();
        for run in 0..20 {
            chart.take(if run % 2 == 0 { 1.0 } else { -1.0 }, 0.5);
        }
        let limits = chart.limits(0.5, 9).expect("twenty runs");
        assert!(limits.alarm(6.5) && !limits.alarm(3.0), "{limits:?}");
        // A run of four times the uncertainty has wider limits, one of less the same.
        let half_width = |u: f64| chart.limits(u, 9).expect("twenty runs").half_width;
        assert!(half_width(2.0) > 1.5 * half_width(0.5) && half_width(0.1) == half_width(0.5));
        assert_eq!(Baseline::default().limits(0.5, 9), None);
    }
}
