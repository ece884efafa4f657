//! The normal distribution.

/// Probability of |z| within this many standard deviations: erf(z/√2) by [Abramowitz 1964 §7.1.26], error below 1.5·10⁻⁷.
pub(crate) fn within(z: f64) -> f64 {
    const A: [f64; 5] = [0.254_829_592, -0.284_496_736, 1.421_413_741, -1.453_152_027, 1.061_405_429];
    let x = z / std::f64::consts::SQRT_2;
    let t = (1.0 + 0.327_591_1 * x).recip();
    let polynomial = A.iter().rev().fold(0.0, |sum, a| (sum + a) * t);
    1.0 - polynomial * (-x * x).exp()
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn intervals_of_the_normal_distribution_are_those_of_the_tables() {
        // GUM, table G.1.
        for (z, share) in [(0.0, 0.0), (1.0, 0.6827), (1.96, 0.95), (2.576, 0.99), (3.0, 0.9973)] {
            assert!((within(z) - share).abs() < 1e-4, "{z}: {}", within(z));
        }
    }
}
