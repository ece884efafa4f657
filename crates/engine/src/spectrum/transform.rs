//! Sums Σ_j c_j e^(iωq_j) at evenly spaced frequencies ω, of positions q at any distance: a fast Fourier transform of what is spread over a grid.
//!
//! Every c_j is spread over the 2M nodes next to its phase, F(k) = Σ_l b_l e^(2πikl/n) / φ̂(k), with Kaiser's window and its transform
//!
//! φ(t) = I₀(β √(1 − (t/M)²)),   φ̂(k) = 2M sinh(r)/r,   r² = β² − (2πMk/n)²,   β = 2πM (1 − 1/4)
//!
//! on a grid twice as fine as the frequencies ask for [Potts 2001]. What comes back from beyond the grid is 10⁻¹³ of Σ|c|.

use nalgebra::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// M, nodes to either side: 4π(√M + M)·2^(−¼)·e^(−√2 πM) is 10⁻¹³ [Potts 2001].
const HALF_WIDTH: usize = 8;
/// Nodes for each frequency.
const FINER: usize = 2;

/// Frequencies that are transformed together: as much work for the grid as for the positions of a spectrum, and they fit a cache.
const MOST: usize = 4096;

/// How many frequencies each of the fewest transforms has that hold `count`.
pub(super) fn together(count: usize) -> usize {
    count.div_ceil(count.div_ceil(MOST).max(1))
}

/// |Σ_j e^(iωq_j)| at `count` frequencies from `low` on, `step` apart.
pub(super) fn heights(positions: &[f64], low: f64, step: f64, count: usize) -> Vec<f64> {
    let size = together(count).max(1);
    let transform = Transform::new(positions, step, size);
    let of_block = |from: usize| {
        let middle = low + step * (from + transform.middle()) as f64;
        let turned = positions.iter().map(move |q| Complex::from_polar(1.0, middle * q));
        transform.of(turned).into_iter().map(Complex::norm)
    };
    (0..count).step_by(size).flat_map(of_block).take(count).collect()
}

/// Where the positions of a transform lie on its grid.
pub(super) struct Transform {
    /// How many frequencies.
    count: usize,
    nodes: usize,
    /// Of every position: the first node, and the window at that and the next ones.
    spread: Vec<(usize, [f64; 2 * HALF_WIDTH])>,
    /// 1/φ̂ of every frequency.
    window: Vec<f64>,
    /// Σ_l a_l e^(2πikl/n).
    of_grid: Arc<dyn Fft<f64>>,
}

impl Transform {
    /// `step`: between frequencies.
    pub fn new(positions: &[f64], step: f64, count: usize) -> Self {
        let nodes = (FINER * count).next_power_of_two().max(4 * HALF_WIDTH);
        let beta = TAU * HALF_WIDTH as f64 * (1.0 - 0.5 / FINER as f64);
        let half = HALF_WIDTH as f64;
        let spread = |q: &f64| {
            let at = (step * q / TAU).rem_euclid(1.0) * nodes as f64;
            let first = at.floor() - half + 1.0;
            let mut window = [0.0; 2 * HALF_WIDTH];
            for (l, window) in window.iter_mut().enumerate() {
                let off = (first + l as f64 - at) / half;
                *window = bessel_i0(beta * (1.0 - off * off).max(0.0).sqrt());
            }
            ((first.rem_euclid(nodes as f64)) as usize % nodes, window)
        };
        let transformed = |k: usize| {
            let off = TAU * half * (k as f64 - middle(count) as f64) / nodes as f64;
            let r = (beta * beta - off * off).sqrt();
            r / (2.0 * half * r.sinh())
        };
        Self {
            count,
            nodes,
            spread: positions.iter().map(spread).collect(),
            window: (0..count).map(transformed).collect(),
            of_grid: FftPlanner::new().plan_fft_inverse(nodes),
        }
    }

    pub fn count(&self) -> usize {
        self.count
    }

    /// The frequency, of those from 0 on, that the phases of the coefficients stand for.
    pub fn middle(&self) -> usize {
        middle(self.count)
    }

    /// F of every frequency. `coefficients`: c_j e^(iωq_j) at the frequency in the middle.
    pub fn of(&self, coefficients: impl Iterator<Item = Complex<f64>>) -> Vec<Complex<f64>> {
        let mut grid = vec![Complex::new(0.0, 0.0); self.nodes];
        for (c, (first, window)) in coefficients.zip(&self.spread) {
            for (l, window) in window.iter().enumerate() {
                grid[(first + l) & (self.nodes - 1)] += c * *window;
            }
        }
        self.of_grid.process(&mut grid);
        let of_frequency = |k: usize| grid[(k + self.nodes - self.middle()) & (self.nodes - 1)];
        self.window.iter().enumerate().map(|(k, window)| of_frequency(k) * *window).collect()
    }
}

fn middle(count: usize) -> usize {
    count / 2
}

/// I₀(x) = Σ (x/2)^2m / m!².
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum, mut m) = (1.0, 1.0, 0.0);
    while term > f64::EPSILON * sum {
        m += 1.0;
        term *= quarter / (m * m);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    proptest! {
        #[test]
        fn the_sums_are_those_of_every_position_by_itself(
            positions in prop::collection::vec(-300.0..300.0_f64, 1..80),
            (low, step) in (-3.0..3.0_f64, 0.001..2.0_f64),
            count in 1_usize..300,
        ) {
            let size = |j: usize| (j as f64 * 0.7).sin();
            let transform = Transform::new(&positions, step, count);
            let middle = low + step * transform.middle() as f64;
            let of = |(j, q): (usize, &f64)| Complex::from_polar(1.0, middle * q) * size(j);
            let found = transform.of(positions.iter().enumerate().map(of));
            let total: f64 = (0..positions.len()).map(|j| size(j).abs()).sum();
            for (k, found) in found.iter().enumerate() {
                let omega = low + step * k as f64;
                let of = |(j, q): (usize, &f64)| Complex::from_polar(1.0, omega * q) * size(j);
                let plain: Complex<f64> = positions.iter().enumerate().map(of).sum();
                prop_assert!((plain - found).norm() < 1e-10 * total.max(1.0), "{k} of {count}: {found} {plain}");
            }
        }
    }

    /// In one transform, in the second of two, and none at all.
    #[test]
    fn heights_are_those_of_every_frequency_by_itself() {
        let positions: Vec<f64> = (0..50).map(|i| (f64::from(i) * 0.618_034).fract() * 30.0).collect();
        for count in [0, 1, 500, MOST + 900] {
            let found = heights(&positions, 0.7, 0.013, count);
            assert_eq!(found.len(), count);
            for k in [0, 1, count / 2, count.saturating_sub(1)].into_iter().filter(|k| *k < count) {
                let omega = 0.7 + 0.013 * k as f64;
                let plain: Complex<f64> = positions.iter().map(|q| Complex::from_polar(1.0, omega * q)).sum();
                assert!(
                    (plain.norm() - found[k]).abs() < 1e-10,
                    "{k} of {count}: {} {}",
                    found[k],
                    plain.norm()
                );
            }
        }
    }

    #[test]
    fn the_window_has_its_transform() {
        let (beta, half) = (1.5 * PI * HALF_WIDTH as f64, HALF_WIDTH as f64);
        let nodes = 4000;
        for xi in [0.0, 0.3, 1.1, 1.5] {
            let at = |l: usize| (l as f64 + 0.5) / nodes as f64 * 2.0 * half - half;
            let of = |t: f64| bessel_i0(beta * (1.0 - (t / half).powi(2)).sqrt()) * (xi * t).cos();
            let sum: f64 = (0..nodes).map(|l| of(at(l))).sum::<f64>() * 2.0 * half / nodes as f64;
            let r = (beta * beta - (xi * half).powi(2)).sqrt();
            let stated = 2.0 * half * r.sinh() / r;
            assert!((sum / stated - 1.0).abs() < 1e-3, "{xi}: {sum} {stated}");
        }
    }
}
