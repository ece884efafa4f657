//! Legendre polynomials: orthogonal over −1…1, so that the orders of a smooth error do not imitate each other.

/// P₀ … P₍N₋₁₎ by (n + 1) Pₙ₊₁ = (2n + 1) s Pₙ − n Pₙ₋₁.
pub(crate) fn legendre<const N: usize>(s: f64) -> [f64; N] {
    let mut p = [1.0; N];
    p[1] = s;
    for n in 1..N - 1 {
        let order = n as f64;
        p[n + 1] = ((2.0 * order + 1.0) * s * p[n] - order * p[n - 1]) / (order + 1.0);
    }
    p
}

#[cfg(test)]
mod tests {
    /// Abramowitz and Stegun, table 22.9: P₅(x) = (63 x⁵ − 70 x³ + 15 x)/8.
    #[test]
    fn legendre_polynomials_are_those_of_the_handbook() {
        for x in [-1.0, -0.3, 0.0, 0.5, 1.0f64] {
            let p5 = (63.0 * x.powi(5) - 70.0 * x.powi(3) + 15.0 * x) / 8.0;
            assert!((super::legendre::<6>(x)[5] - p5).abs() < 1e-14);
        }
    }
}
