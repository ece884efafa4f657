//! Places that fill a cube of many dimensions evenly.
//!
//! ((m aᵏ mod n + ½)/n + φ (k + 1 + r d)) mod 1,   m = 0 … n − 1,   k = 0 … d − 1
//!
//! The lattice of Korobov [Munger 2016], moved [Cranley 1976]: without the second term its first place is a corner, where all
//! coordinates are extreme together. A hundred places on a line of irrational slope do not fill it: with some twenty coordinates two of
//! them go together.

/// Places, a prime. Every one of their coordinates takes 1021 values evenly, so a mean errs by what is left of several together.
const PLACES: u64 = 1021;
/// A primitive root of [`PLACES`]: its powers, one for each coordinate, are all different.
const GENERATOR: u64 = 76;
/// φ: how far each coordinate is moved against the one before it, the golden section.
const MOVED: f64 = 0.618_033_988_749_895;

/// Of the unit cube of this dimension. Those of each round are moved otherwise.
pub(super) fn places(dimension: usize, round: usize) -> impl Iterator<Item = Vec<f64>> {
    lattice(PLACES, GENERATOR, dimension, round)
}

fn lattice(places: u64, generator: u64, dimension: usize, round: usize) -> impl Iterator<Item = Vec<f64>> {
    let next = move |power: &u64| Some(power * generator % places);
    let powers: Vec<(u64, f64)> = std::iter::successors(Some(1), next)
        .zip(1 + round * dimension..)
        .map(|(power, k)| (power, MOVED * k as f64))
        .take(dimension)
        .collect();
    let place = move |m: u64, (power, moved): &(u64, f64)| {
        (((m * power % places) as f64 + 0.5) / places as f64 + moved).fract()
    };
    (0..places).map(move |m| powers.iter().map(|of_coordinate| place(m, of_coordinate)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variance of a sum of parts whose logarithms have a standard deviation of 1.8, of which a few matter.
    fn variance(place: &[f64]) -> f64 {
        let part = |(k, place): (usize, &f64)| 0.7_f64.powi(k as i32) * place / (1.0 - place);
        1.0 + place.iter().enumerate().map(part).sum::<f64>()
    }

    #[test]
    fn quantiles_are_those_of_many_more_places_of_another_lattice() {
        for dimension in [1, 5, 18, 25, 30] {
            let of = |places: &mut dyn Iterator<Item = Vec<f64>>| {
                let mut found: Vec<f64> = places.map(|place| variance(&place).sqrt()).collect();
                found.sort_unstable_by(f64::total_cmp);
                [0.3, 0.6, 0.9].map(|share| found[(share * found.len() as f64) as usize])
            };
            let (few, many) = (of(&mut places(dimension, 0)), of(&mut lattice(65_521, 17, dimension, 0)));
            for (few, many) in few.into_iter().zip(many) {
                assert!((few / many - 1.0).abs() < 0.03, "{dimension}: {few} instead of {many}");
            }
        }
    }
}
