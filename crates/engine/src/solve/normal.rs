//! The normal distribution.

/// Probability of |z| within this many standard deviations: erf(z/√2) by [Abramowitz 1964 §7.1.26], error below 1.5·10⁻⁷.
pub(crate) fn within(z: f64) -> f64 {
    const A: [f64; 5] = [0.254_829_592, -0.284_496_736, 1.421_413_741, -1.453_152_027, 1.061_405_429];
    let x = z / std::f64::consts::SQRT_2;
    let t = (1.0 + 0.327_591_1 * x).recip();
    let polynomial = A.iter().rev().fold(0.0, |sum, a| (sum + a) * t);
    1.0 - polynomial * (-x * x).exp()
}

/// No deviate is further out than 10⁻⁹ of all.
const FURTHEST: f64 = 1e-9;

/// Probability of no more than this deviate, Φ.
pub(crate) fn below(z: f64) -> f64 {
    0.5 + 0.5 * within(z.abs()).copysign(z)
}

/// The deviate that is not exceeded with this probability, Φ⁻¹: by [Abramowitz 1964 §26.2.23], error below 4.5·10⁻⁴.
pub(crate) fn deviate(probability: f64) -> f64 {
    let beyond = probability.min(1.0 - probability).max(FURTHEST);
    let t = (-2.0 * beyond.ln()).sqrt();
    let above = (0.010_328 * t + 0.802_853) * t + 2.515_517;
    let under = ((0.001_308 * t + 0.189_269) * t + 1.432_788) * t + 1.0;
    (t - above / under).copysign(probability - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_the_normal_distribution_are_those_of_the_tables() {
        // GUM, table G.1.
        for (z, share) in [(0.0, 0.0), (1.0, 0.6827), (1.96, 0.95), (2.576, 0.99), (3.0, 0.9973)] {
            assert!((within(z) - share).abs() < 1e-4, "{z}: {}", within(z));
        }
    }

    #[test]
    fn a_deviate_and_its_probability_belong_together() {
        for (z, probability) in [(-1.96, 0.025), (-1.0, 0.158_66), (0.674_49, 0.75), (2.326_35, 0.99)] {
            assert!((below(z) - probability).abs() < 1e-4, "{z}: {}", below(z));
            assert!((deviate(probability) - z).abs() < 1e-3, "{probability}: {}", deviate(probability));
        }
    }
}
