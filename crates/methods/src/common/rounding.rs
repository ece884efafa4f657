//! What is rounding of the arithmetic, and so is zero.

/// A displacement below this is rounding: places of metres are computed to some 10⁻¹² mm, a chain of joints and a fit to a few hundred times that.
/// Nothing reads as little: it is a picometre.
pub(crate) const ROUNDING_MM: f64 = 1e-9;

/// `value`, or zero when it is rounding. What is no number stays so.
pub(crate) fn without(value: f64, rounding: f64) -> f64 {
    if value.abs() < rounding { 0.0 } else { value }
}
