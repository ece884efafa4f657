//! Intervals of a mixture of normal distributions, one for each draw of numbers that are themselves uncertain.

use crate::solve::normal::within;
use trunnion_core::statistics::COVERAGE_95;

/// Draws, a prime. Every one of their coordinates takes 1021 places evenly, so a half-width errs by what is left of several together.
const DRAWS: u64 = 1021;
/// A primitive root of [`DRAWS`]: its powers, one for each coordinate, are all different.
const GENERATOR: u64 = 76;
const COVERED: f64 = 0.95;
const BISECTIONS: usize = 30;

/// Places that fill the unit cube of this dimension evenly: (m aᵏ mod n + ½)/n, m = 0 … n − 1, the lattice of Korobov
/// [Munger 2016]. A hundred places on a line of irrational slope do not: with some twenty coordinates two of them go together.
pub(crate) fn places(dimension: usize) -> impl Iterator<Item = Vec<f64>> {
    lattice(DRAWS, GENERATOR, dimension)
}

fn lattice(draws: u64, generator: u64, dimension: usize) -> impl Iterator<Item = Vec<f64>> {
    let next = move |power: &u64| Some(power * generator % draws);
    let powers: Vec<u64> = std::iter::successors(Some(1), next).take(dimension).collect();
    let place = move |m: u64, power: &u64| ((m * power % draws) as f64 + 0.5) / draws as f64;
    (0..draws).map(move |m| powers.iter().map(|power| place(m, power)).collect())
}

/// What 95 % of a mixture of normal distributions of these standard deviations lie within.
pub(crate) fn half_width(u: &[f64]) -> f64 {
    let largest = u.iter().copied().fold(0.0, f64::max);
    let (mut low, mut high) = (0.0, COVERAGE_95 * largest);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let inside = u.iter().map(|u| within(middle / u.max(f64::MIN_POSITIVE))).sum::<f64>();
        if inside < COVERED * u.len() as f64 { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviation of a sum of parts whose logarithms have a standard deviation of 1.8, of which a few matter.
    fn u(place: &[f64]) -> f64 {
        let part = |(k, place): (usize, &f64)| 0.7_f64.powi(k as i32) * place / (1.0 - place);
        (1.0 + place.iter().enumerate().map(part).sum::<f64>()).sqrt()
    }

    #[test]
    fn a_half_width_is_that_of_many_more_draws_of_another_lattice() {
        for dimension in [1, 5, 18, 25, 30] {
            let of = |places: &mut dyn Iterator<Item = Vec<f64>>| {
                half_width(&places.map(|place| u(&place)).collect::<Vec<_>>())
            };
            let (few, many) = (of(&mut places(dimension)), of(&mut lattice(65_521, 17, dimension)));
            assert!((few / many - 1.0).abs() < 0.03, "{dimension}: {few} instead of {many}");
        }
    }

    #[test]
    fn a_mixture_of_one_has_the_interval_of_the_normal_distribution() {
        assert!((half_width(&[2.0; 7]) - 2.0 * COVERAGE_95).abs() < 1e-3);
    }
}
