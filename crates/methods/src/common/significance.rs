//! When a quantity is significant among all that one answer judges.
//!
//! |x| > t u with exp(−t²/2) < 5 %/N for N quantities: the two tails of a normal distribution beyond t are below exp(−t²/2) [Bonferroni].

/// Chance that noise alone makes any of the quantities of an answer significant.
pub(crate) const BY_CHANCE: f64 = 0.05;

/// Of a value with its standard uncertainty, among so many quantities.
pub(crate) fn is_significant(value: f64, u: f64, quantities: usize) -> bool {
    let t = value / u.max(f64::MIN_POSITIVE);
    (-0.5 * t * t).exp() < BY_CHANCE / quantities.max(1) as f64
}
