//! A smooth path through one axis' positions that spikes do not bend.
//!
//! Cubic B-spline with even knots, least squares by the banded normal equations (de Boor); weights `(1 − (r/6s)²)²` (Tukey,
//! s from the median of |r|), so that what sticks out for a short time has no say.
//! Limits: a path that bends within two knots is smoothed away; its size is (h ω)⁴/384 of a swing of frequency ω.

use trunnion_core::statistics::{MEDIAN_OF_NORMAL, upper_median};

/// Rounds of weighing.
const ROUNDS: usize = 12;
/// Weights vanish at this many standard deviations.
const WIDE: f64 = 6.0;
/// Share of the size of the positions below which residuals are rounding.
const ROUNDING: f64 = 1e-9;
/// Weight of second differences of the coefficients, share of the mean diagonal: where no sample has a say the path goes straight on.
const STRAIGHT: f64 = 1e-10;

/// Splines over one set of times.
pub(super) struct Path {
    /// First of the four coefficients at each sample, and their shares.
    shares: Vec<(usize, [f64; 4])>,
    width: usize,
}

impl Path {
    /// `None` when times do not rise or the distance of knots is no positive number.
    pub fn over(times_s: &[f64], knot_s: f64) -> Option<Self> {
        let (first, last) = (*times_s.first()?, *times_s.last()?);
        if !(knot_s > 0.0 && last > first) {
            return None;
        }
        let intervals = ((last - first) / knot_s).ceil().max(1.0) as usize;
        let step_s = (last - first) / intervals as f64;
        let share = |&time_s: &f64| {
            let at = (time_s - first) / step_s;
            let k = (at.floor().max(0.0) as usize).min(intervals - 1);
            let u = at - k as f64;
            let v = 1.0 - u;
            let cubic = [
                v * v * v,
                3.0 * u * u * u - 6.0 * u * u + 4.0,
                -3.0 * u * u * u + 3.0 * u * u + 3.0 * u + 1.0,
                u * u * u,
            ];
            (k, cubic.map(|c| c / 6.0))
        };
        Some(Self { shares: times_s.iter().map(share).collect(), width: intervals + 3 })
    }

    /// The path at every sample.
    pub fn through(&self, measured: &[f64]) -> Vec<f64> {
        let size = measured.iter().fold(0f64, |a, b| a.max(b.abs()));
        let mut weights = vec![1.0; measured.len()];
        let mut path = self.fit(measured, &weights);
        for _ in 0..ROUNDS {
            let off: Vec<f64> = measured.iter().zip(&path).map(|(m, p)| m - p).collect();
            let sizes: Vec<f64> = off.iter().map(|r| r.abs()).collect();
            let s = upper_median(&sizes).unwrap_or(0.0) / MEDIAN_OF_NORMAL + ROUNDING * size;
            if s == 0.0 {
                break;
            }
            for (weight, r) in weights.iter_mut().zip(&off) {
                let far = r / (WIDE * s);
                *weight = if far.abs() < 1.0 { (1.0 - far * far).powi(2) } else { 0.0 };
            }
            path = self.fit(measured, &weights);
        }
        path
    }

    fn fit(&self, measured: &[f64], weights: &[f64]) -> Vec<f64> {
        // Lower band of the normal equations: band[i][d] = N(i, i − d).
        let mut band = vec![[0.0; 4]; self.width];
        let mut right = vec![0.0; self.width];
        for (((first, share), y), w) in self.shares.iter().zip(measured).zip(weights) {
            for a in 0..4 {
                right[first + a] += w * share[a] * y;
                for b in 0..=a {
                    band[first + a][a - b] += w * share[a] * share[b];
                }
            }
        }
        let straight = STRAIGHT * band.iter().map(|row| row[0]).sum::<f64>() / self.width as f64;
        for i in 2..self.width {
            let second_difference = [1.0, -2.0, 1.0];
            for a in 0..3 {
                for b in 0..=a {
                    band[i - 2 + a][a - b] += straight * second_difference[a] * second_difference[b];
                }
            }
        }
        let coefficients = solve_banded(band, right);
        let value =
            |(first, share): &(usize, [f64; 4])| (0..4).map(|a| share[a] * coefficients[first + a]).sum();
        self.shares.iter().map(value).collect()
    }
}

/// Cholesky of a positive definite matrix with three diagonals below the main one.
fn solve_banded(mut band: Vec<[f64; 4]>, mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len();
    for i in 0..n {
        for d in (0..=3.min(i)).rev() {
            let j = i - d;
            let mut sum = band[i][d];
            for e in d + 1..=3.min(i) {
                if e - d <= 3 {
                    sum -= band[i][e] * band[j][e - d];
                }
            }
            band[i][d] = if d == 0 { sum.max(f64::MIN_POSITIVE).sqrt() } else { sum / band[j][0] };
        }
        for d in 1..=3.min(i) {
            x[i] -= band[i][d] * x[i - d];
        }
        x[i] /= band[i][0];
    }
    for i in (0..n).rev() {
        for d in 1..=3.min(n - 1 - i) {
            x[i] -= band[i + d][d] * x[i + d];
        }
        x[i] /= band[i][0];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_path_and_a_spike_does_not_bend_it() {
        let times: Vec<f64> = (0..800).map(|i| f64::from(i) * 0.01).collect();
        let cubic = |t: f64| 3.0 - 2.0 * t + 0.5 * t * t - 0.04 * t * t * t;
        let path = Path::over(&times, 1.0).expect("rising times");
        let plain: Vec<f64> = times.iter().map(|&t| cubic(t)).collect();
        let spiked: Vec<f64> =
            times.iter().map(|&t| cubic(t) + if (4.0..4.2).contains(&t) { 0.01 } else { 0.0 }).collect();
        for found in [path.through(&plain), path.through(&spiked)] {
            let worst = found.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-7, "{worst}");
        }
        // A straight line stays one to its ends.
        let line: Vec<f64> = times.iter().map(|&t| 6.0 - 1.05 * t).collect();
        let worst = path.through(&line).iter().zip(&line).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{worst}");
    }
}
