//! Interval of a mixture of normal distributions, one for each draw of numbers that are themselves uncertain.

use crate::solve::normal::within;
use trunnion_core::statistics::COVERAGE_95;

const COVERED: f64 = 0.95;
/// Halvings of the interval in which it lies: a part in 10⁶ of the widest.
const BISECTIONS: usize = 20;

/// What 95 % lie within; `draws`: standard deviation and weight of each, the weights adding up to 1.
pub(crate) fn half_width(draws: &[(f64, f64)]) -> f64 {
    let largest = draws.iter().map(|(u, _)| *u).fold(0.0, f64::max);
    let (mut low, mut high) = (0.0, COVERAGE_95 * largest);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let of_draw = |(u, weight): &(f64, f64)| weight * within(middle / u.max(f64::MIN_POSITIVE));
        if draws.iter().map(of_draw).sum::<f64>() < COVERED { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_of_one_has_the_interval_of_the_normal_distribution() {
        assert!((half_width(&[(2.0, 0.3), (2.0, 0.7)]) - 2.0 * COVERAGE_95).abs() < 1e-3);
    }

    /// 2 (0.9 (1 − Φ(k)) + 0.1 (1 − Φ(k/3))) = 0.05 at k = 2.594.
    #[test]
    fn what_is_seldom_large_widens_the_interval_by_its_share() {
        let k = half_width(&[(1.0, 0.9), (3.0, 0.1)]);
        assert!((0.9 * within(k) + 0.1 * within(k / 3.0) - COVERED).abs() < 1e-6);
        assert!(k > COVERAGE_95 && k < 3.0, "{k}");
    }
}
