//! An error motion over a whole turn as harmonics, and its range without the bias of noise.
//!
//! x(θ) = c + Σ aₙ cos nθ + bₙ sin nθ, n = 1 … N and orders asked for, by least squares; amplitude Aₙ = √(aₙ² + bₙ²).
//! s² = residual / ν, ν = m − 2N − 1 of m values; u(A) = s √(2/m) for even steps, in general √((s_a² + s_b²)/2).
//! Under noise alone A²/2u² ~ F(2, ν), so p = (1 + A²/(ν u²))^(−ν/2).
//! Significant: p < 5 %/N (Bonferroni). The range of x as read grows with the noise of its extremes; here it is that of the significant
//! harmonics, each with the amplitude √(A² − 2u²), since noise adds 2u² to A² on average.
//! Where none is significant, an upper bound stands in its place: noise is longer than q with a chance of 5 %, q² = ν u² (0.05^(−2/ν) − 1), so a true
//! amplitude is at most A + q, and the range of any one wave at most 2 (A + q).
//! Of K contours that are judged together: p < 5 %/(N K). The largest range of K contours of one error motion has no u of its own, since it was
//! chosen by its noise: an upper bound for all of them together stands in its place, range + q u(range), with the s² of all K, ν = Σ νₖ and 5 %/K in q.
//! Limits: whole turn; what has more than N waves counts as noise.

use super::significance::BY_CHANCE;
use crate::findings::{Cell, Column, FoundTable, FoundValue};
use nalgebra::{DMatrix, DVector, Vector2};
use std::f64::consts::TAU;
use trunnion_core::convert::deg_from_rad;
use trunnion_effects::Unit;
use trunnion_engine::solve::linear::least_squares;

/// Highest order: more waves than this a turn are rollers and gears, which the joint fit looks for.
const HIGHEST: usize = 12;
/// Values a wave that show an order asked for: more than the two of Nyquist, which may both lie where the wave crosses zero.
const VALUES_A_WAVE: usize = 3;
/// A gap between angles wider than this share of a turn is no whole turn.
const WIDEST_GAP: f64 = 1.0 / 6.0;
/// Less of the largest value is rounding.
const ROUNDING: f64 = 1e-9;

/// One harmonic, in the unit of the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Harmonic {
    /// Waves a turn.
    pub order: usize,
    pub amplitude: f64,
    /// Angle of its first crest, rad.
    pub crest_rad: f64,
    /// Standard uncertainty of the amplitude.
    pub u: f64,
    /// Chance that noise alone makes as much.
    pub p: f64,
    pub significant: bool,
}

/// The harmonics of an error motion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Harmonics {
    /// n = 1 … N.
    pub all: Vec<Harmonic>,
    /// Range of the significant ones together, without the bias of noise; zero when none is.
    pub range: f64,
    /// Standard uncertainty of the range.
    pub u_range: f64,
    /// Range of any one wave at most (95 %), whether significant or not.
    pub most: f64,
    /// ν and s of one value.
    freedom: f64,
    s: f64,
}

/// How a wave differs between two contours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Difference {
    pub order: usize,
    /// Half the amplitude of the difference, and its standard uncertainty.
    pub half: f64,
    pub u: f64,
}

/// Chance that noise alone makes an amplitude so many u long, with ν degrees of freedom.
fn chance(in_u: f64, freedom: f64) -> f64 {
    (1.0 + in_u * in_u / freedom).powf(-0.5 * freedom)
}

/// The length in u that noise exceeds with such a chance, the inverse of [`chance`].
fn longest(chance: f64, freedom: f64) -> f64 {
    (freedom * (chance.powf(-2.0 / freedom) - 1.0)).sqrt()
}

impl Harmonic {
    /// 2 (A + q), where q is the length that noise exceeds with a chance of 5 %.
    fn range_at_most(&self, freedom: f64) -> f64 {
        2.0 * (self.amplitude + longest(BY_CHANCE, freedom) * self.u)
    }

    /// (aₙ, bₙ).
    fn phasor(&self) -> Vector2<f64> {
        let (sin, cos) = (self.order as f64 * self.crest_rad).sin_cos();
        Vector2::new(cos, sin) * self.amplitude
    }
}

impl Harmonics {
    /// Of values over an angle (rad), one of so many contours that are judged together; `None` where they do not go around, or are too few.
    pub fn among(points: &[(f64, f64)], contours: usize) -> Option<Self> {
        Self::with(points, &[], contours)
    }

    /// The same with further orders, of those that so many values show.
    pub fn with(points: &[(f64, f64)], further: &[usize], contours: usize) -> Option<Self> {
        let m = points.len();
        // As many degrees of freedom are left to the noise as the harmonics take.
        let highest = (m / 4).min(HIGHEST);
        if highest == 0 || !goes_around(points) {
            return None;
        }
        let shown = |order: &&usize| **order > highest && VALUES_A_WAVE * **order <= m;
        let orders: Vec<usize> = (1..=highest).chain(further.iter().filter(shown).copied()).collect();
        let design = DMatrix::from_fn(m, 2 * orders.len() + 1, |i, k| match k {
            0 => 1.0,
            _ => {
                let (sin, cos) = (orders[(k - 1) / 2] as f64 * points[i].0).sin_cos();
                if k % 2 == 1 { cos } else { sin }
            }
        });
        let values = DVector::from_iterator(m, points.iter().map(|point| point.1));
        let fit = least_squares(&design, &values, 1e-9);
        if fit.rank <= 2 * orders.len() {
            return None;
        }
        let freedom = (m - fit.rank) as f64;
        let s = (values.clone() - &design * &fit.x).norm() / freedom.sqrt();
        let harmonic = |(i, &order): (usize, &usize)| {
            let (k, l) = (2 * i + 1, 2 * i + 2);
            let amplitude = fit.x[k].hypot(fit.x[l]);
            let u = (0.5 * (fit.u[k].powi(2) + fit.u[l].powi(2))).sqrt();
            let p = chance(amplitude / u.max(f64::MIN_POSITIVE), freedom);
            let crest_rad = fit.x[l].atan2(fit.x[k]).rem_euclid(TAU) / order as f64;
            let trials = (orders.len() * contours) as f64;
            let significant = p < BY_CHANCE / trials && amplitude > ROUNDING * values.amax();
            Harmonic { order, amplitude, crest_rad, u, p, significant }
        };
        let all: Vec<Harmonic> = orders.iter().enumerate().map(harmonic).collect();
        let (range, u_range) = range(&all);
        let most = all.iter().map(|h| h.range_at_most(freedom)).fold(0.0, f64::max);
        Some(Self { all, range, u_range, most, freedom, s })
    }

    /// Which of several contours of one error motion may range most, and by how much at most (95 % for all together).
    pub fn largest_at_most(contours: &[Self]) -> Option<(usize, f64)> {
        let freedom: f64 = contours.iter().map(|of| of.freedom).sum();
        let squares: f64 = contours.iter().map(|of| of.freedom * of.s.powi(2)).sum();
        let (s, longest) = ((squares / freedom).sqrt(), longest(BY_CHANCE / contours.len() as f64, freedom));
        let at_most = |of: &Self| {
            let in_u = longest * s / of.s.max(f64::MIN_POSITIVE);
            match of.all.iter().any(|harmonic| harmonic.significant) {
                true => of.range + in_u * of.u_range,
                false => of.all.iter().map(|h| 2.0 * (h.amplitude + in_u * h.u)).fold(0.0, f64::max),
            }
        };
        contours.iter().map(at_most).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The range as a value: that of the significant waves with its u, else an upper bound that says so in its name.
    pub fn range_value(&self, name: &str, unit: Unit) -> FoundValue {
        if self.all.iter().any(|harmonic| harmonic.significant) {
            return FoundValue::new(format!("{name} range"), self.range, unit, Some(self.u_range))
                .note(self.words(unit));
        }
        let note = "no harmonic is significant; upper bound (95 %) of the range of any one wave";
        FoundValue::new(format!("{name} range of one wave at most"), self.most, unit, None).note(note)
    }

    /// The harmonic of this order.
    pub fn order(&self, order: usize) -> Option<&Harmonic> {
        self.all.iter().find(|harmonic| harmonic.order == order)
    }

    /// Waves that differ from those of `other` beyond chance, where so many contours are compared: Δ²/2u² ~ F(2, ν) with u² = u₁² + u₂²
    /// and the effective degrees of freedom ν = u⁴/(u₁⁴/ν₁ + u₂⁴/ν₂) [GUM G.2b, Welch-Satterthwaite].
    pub fn differs(&self, other: &Self, comparisons: usize) -> Vec<Difference> {
        let difference = |one: &Harmonic| {
            let two = other.order(one.order)?;
            let u = one.u.hypot(two.u).max(f64::MIN_POSITIVE);
            let parts = (one.u / u).powi(4) / self.freedom + (two.u / u).powi(4) / other.freedom;
            let freedom = parts.max(f64::MIN_POSITIVE).recip();
            let [one_at, two_at] = [one, two].map(Harmonic::phasor);
            let half = 0.5 * (one_at - two_at).norm();
            let p = chance(2.0 * half / u, freedom);
            Some((Difference { order: one.order, half, u: 0.5 * u }, p))
        };
        let all: Vec<(Difference, f64)> = self.all.iter().filter_map(difference).collect();
        let trials = (all.len() * comparisons) as f64;
        all.iter().filter(|(_, p)| *p < BY_CHANCE / trials).map(|(difference, _)| *difference).collect()
    }

    /// The significant ones, largest first.
    pub fn significant(&self) -> Vec<Harmonic> {
        let mut found: Vec<Harmonic> = self.all.iter().copied().filter(|h| h.significant).collect();
        found.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        found
    }

    /// The significant ones in words, e.g. `2 a turn: 1.20 ± 0.05 µm`.
    pub fn words(&self, unit: Unit) -> String {
        let scale = unit.per_inside;
        let one = |h: &Harmonic| {
            format!("{} a turn: {:.2} ± {:.2} {}", h.order, h.amplitude * scale, h.u * scale, unit.text())
        };
        let found: Vec<String> = self.significant().iter().map(one).collect();
        if found.is_empty() { "no harmonic is significant".into() } else { found.join(", ") }
    }
}

fn goes_around(points: &[(f64, f64)]) -> bool {
    let mut angles: Vec<f64> = points.iter().map(|point| point.0.rem_euclid(TAU)).collect();
    angles.sort_by(f64::total_cmp);
    let across_zero = angles.first().zip(angles.last()).map_or(TAU, |(first, last)| first + TAU - last);
    let widest = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(across_zero, f64::max);
    widest < WIDEST_GAP * TAU
}

/// Range of the significant harmonics, and its uncertainty by those of the amplitudes where the extremes are.
fn range(all: &[Harmonic]) -> (f64, f64) {
    const STEPS: usize = 720;
    let significant: Vec<&Harmonic> = all.iter().filter(|h| h.significant).collect();
    let turn = |h: &Harmonic, angle: f64| h.order as f64 * (angle - h.crest_rad);
    let at = |angle: f64| {
        let unbiased = |h: &&&Harmonic| (h.amplitude.powi(2) - 2.0 * h.u.powi(2)).max(0.0).sqrt();
        significant.iter().map(|h| unbiased(&h) * turn(h, angle).cos()).sum::<f64>()
    };
    let angles = (0..STEPS).map(|k| TAU * k as f64 / STEPS as f64);
    let found = angles.map(|angle| (angle, at(angle)));
    let Some(((low, lowest), (high, highest))) = found.fold(None, |ends, here| {
        let (low, high): ((f64, f64), (f64, f64)) = ends.unwrap_or((here, here));
        Some((if here.1 < low.1 { here } else { low }, if here.1 > high.1 { here } else { high }))
    }) else {
        return (0.0, 0.0);
    };
    let variance = significant.iter().map(|h| {
        let (sin_high, cos_high) = turn(h, high).sin_cos();
        let (sin_low, cos_low) = turn(h, low).sin_cos();
        h.u.powi(2) * ((cos_high - cos_low).powi(2) + (sin_high - sin_low).powi(2))
    });
    (highest - lowest, variance.sum::<f64>().sqrt())
}

/// The harmonics of several error motions, those that are significant and the largest that is not.
pub(crate) fn table(motions: &[(String, Unit, Harmonics)]) -> Option<FoundTable> {
    let columns = [
        "error motion",
        "waves a turn",
        "amplitude",
        "u",
        "unit",
        "crest at, °",
        "probability of noise alone",
    ];
    let mut rows = Vec::new();
    for (name, unit, harmonics) in motions {
        let insignificant = harmonics.all.iter().filter(|h| !h.significant);
        let largest = insignificant.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).copied();
        for harmonic in harmonics.significant().into_iter().chain(largest) {
            let p = harmonic.p;
            let chance = if p < 0.01 { format!("{p:.1e}") } else { format!("{p:.2}") };
            // A small one is no contradiction: the best of many that noise alone made is small too.
            let remark =
                if harmonic.significant { "" } else { ": not significant among all that were tried" };
            let chance = chance + remark;
            rows.push(vec![
                Cell::Text(name.clone()),
                Cell::Text(harmonic.order.to_string()),
                Cell::Number(harmonic.amplitude * unit.per_inside),
                Cell::Number(harmonic.u * unit.per_inside),
                Cell::Text(unit.text()),
                Cell::Number(deg_from_rad(harmonic.crest_rad)),
                Cell::Text(chance),
            ]);
        }
    }
    (!rows.is_empty()).then(|| FoundTable {
        caption: "Error motions as harmonics; of those that are not significant the largest".into(),
        columns: columns.map(Column::plain).to_vec(),
        rows,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    fn of(points: &[(f64, f64)]) -> Option<Harmonics> {
        Harmonics::among(points, 1)
    }

    fn noisy(steps: usize, sigma: f64, seed: u64, motion: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let noise = Normal::new(0.0, sigma).unwrap();
        let angle = |k: usize| TAU * k as f64 / steps as f64;
        (0..steps).map(|k| (angle(k), motion(angle(k)) + noise.sample(&mut rng))).collect()
    }

    #[test]
    fn noise_alone_is_significant_as_seldom_as_promised() {
        let found = |seed: u64| of(&noisy(36, 1.0, seed, |_| 0.0)).unwrap();
        let false_alarms = (0..2000).filter(|&seed| found(seed).range > 0.0).count();
        // 5 % of 2000, ± 3 standard deviations of a binomial.
        assert!((70..=130).contains(&false_alarms), "{false_alarms} of 2000");
    }

    #[test]
    fn contours_that_are_judged_together_share_the_chance() {
        let together = |seed: u64| {
            (0..5).any(|k| Harmonics::among(&noisy(12, 1.0, 5 * seed + k, |_| 0.0), 5).unwrap().range > 0.0)
        };
        let false_alarms = (0..1000).filter(|&seed| together(seed)).count();
        // 5 % of 1000 and 3 standard deviations of a binomial at most; Bonferroni makes it a little less.
        assert!((20..=71).contains(&false_alarms), "{false_alarms} of 1000");
    }

    #[test]
    fn the_largest_of_several_contours_is_below_its_upper_bound() {
        for amplitude in [0.5, 8.0] {
            let at_most = |seed: u64| {
                let of = |k| noisy(12, 1.0, 7 * seed + k, |a| amplitude * (2.0 * a).cos());
                let all: Vec<Harmonics> = (0..7).map(|k| Harmonics::among(&of(k), 35).unwrap()).collect();
                Harmonics::largest_at_most(&all).unwrap().1
            };
            let bounds: Vec<f64> = (0..400).map(at_most).collect();
            let held = bounds.iter().filter(|bound| **bound >= 2.0 * amplitude).count();
            assert!(held >= 380, "{held} of 400 at {amplitude}");
            // No wilder than noise of the readings makes it.
            let mean = bounds.iter().sum::<f64>() / 400.0;
            assert!(mean < 2.0 * amplitude + 6.0, "{mean} at {amplitude}");
        }
    }

    #[test]
    fn contours_that_are_the_same_differ_as_seldom_as_promised() {
        // The second quieter, as noisy, and noisier than the first.
        for sigma in [1.0 / 3.0, 1.0, 3.0, 10.0] {
            let found = |sigma: f64, seed: u64| of(&noisy(12, sigma, seed, |_| 0.0)).unwrap();
            let differ = |seed: &u64| !found(1.0, *seed).differs(&found(sigma, seed + 2000), 1).is_empty();
            let false_alarms = (0..2000).filter(differ).count();
            // 5 % of 2000 and 3 standard deviations of a binomial at most. Fewer, as the freedom is itself estimated [GUM G.4.1].
            assert!((40..=130).contains(&false_alarms), "{false_alarms} of 2000 at {sigma}");
        }
    }

    #[test]
    fn a_wave_that_is_not_significant_is_below_the_upper_bound() {
        for (steps, amplitude) in [(12, 0.6), (36, 0.4)] {
            let drawn = |seed| of(&noisy(steps, 1.0, seed, |a| amplitude * (2.0 * a).cos())).unwrap();
            let all: Vec<Harmonics> = (0..1000).map(drawn).collect();
            let bound = |of: &&Harmonics| of.order(2).unwrap().range_at_most(of.freedom) >= 2.0 * amplitude;
            let held = all.iter().filter(bound).count();
            assert!(held >= 950, "{held} of 1000 at {amplitude}");
            let silent = all.iter().find(|of| of.significant().is_empty()).unwrap();
            let value = silent.range_value("EXC", Unit::UM);
            assert_eq!(
                (value.name.as_str(), value.value, value.u),
                ("EXC range of one wave at most", silent.most, None)
            );
        }
    }

    #[test]
    fn amplitude_and_range_have_no_bias_of_noise() {
        let motion = |angle: f64| 2.0 * (2.0 * angle - 0.7).cos() + (3.0 * angle).sin();
        let exact = of(&noisy(72, 1e-12, 1, motion)).unwrap().range;
        let trials: Vec<Harmonics> =
            (0..400).map(|seed| of(&noisy(72, 0.5, seed, motion)).unwrap()).collect();
        let mean = trials.iter().map(|t| t.range).sum::<f64>() / 400.0;
        let u_mean = trials.iter().map(|t| t.u_range).sum::<f64>() / 400.0;
        let scatter = (trials.iter().map(|t| (t.range - mean).powi(2)).sum::<f64>() / 399.0).sqrt();
        assert!((mean - exact).abs() < 0.02 * exact, "{mean} of {exact}");
        assert!((0.8..1.25).contains(&(scatter / u_mean)), "scatters by {scatter}, u {u_mean}");
        let as_read = |seed: u64| {
            let values: Vec<f64> = noisy(72, 0.5, seed, motion).into_iter().map(|point| point.1).collect();
            values.iter().copied().fold(f64::MIN, f64::max) - values.iter().copied().fold(f64::MAX, f64::min)
        };
        let mean_as_read = (0..400).map(as_read).sum::<f64>() / 400.0;
        assert!(mean_as_read > 1.06 * exact, "as read {mean_as_read}, without noise {exact}");
    }

    #[test]
    fn an_arc_has_no_harmonics() {
        let arc: Vec<(f64, f64)> = (0..60).map(|k| (0.05 * f64::from(k), 1.0)).collect();
        assert_eq!(of(&arc), None);
    }
}
