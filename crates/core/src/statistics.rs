//! Statistics of plain numbers.
//!
//! mean = Σx/n; rms = √(Σx²/n); the median of an even count is the mean of the middle two. `None` of nothing: what a caller
//! takes then is its own affair.

/// Two-sided 95 % of a normal distribution, in standard uncertainties [GUM, table G.1].
pub const COVERAGE_95: f64 = 1.96;

/// Median of |x| for a standard normal x, the quartile of that distribution: a median of sizes divided by it estimates σ.
pub const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// Mean.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(sum, count), v| (sum + v, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// Root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    mean(values.into_iter().map(|v| v * v)).map(f64::sqrt)
}

/// Median; the mean of the middle two of an even count.
pub fn median(values: &[f64]) -> Option<f64> {
    let upper = upper_median(values)?;
    if values.len() % 2 == 1 {
        return Some(upper);
    }
    let mut sorted = values.to_vec();
    let lower = *sorted.select_nth_unstable_by(values.len() / 2 - 1, f64::total_cmp).1;
    Some((lower + upper) / 2.0)
}

/// The upper of the middle two of an even count, else the median: one of the values, as sizes of noise take it. Of n values
/// it lies half a step of the sorted values above the median, 1/n of their scatter.
pub fn upper_median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// The value below which a share of the values lies: one of them, the upper of two.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    let at = ((share * sorted.len() as f64) as usize).min(sorted.len().checked_sub(1)?);
    Some(*sorted.select_nth_unstable_by(at, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_medians_of_few_numbers() {
        assert_eq!((mean([]), rms([]), median(&[]), upper_median(&[])), (None, None, None, None));
        assert_eq!((mean([1.0, 5.0]), rms([3.0, -4.0, 0.0, 0.0])), (Some(3.0), Some(2.5)));
        assert_eq!(
            (quantile(&[4.0, 1.0, 3.0, 2.0], 0.9), quantile(&[4.0, 1.0], 1.0)),
            (Some(4.0), Some(4.0))
        );
        assert_eq!((median(&[5.0, 1.0, 3.0]), upper_median(&[5.0, 1.0, 3.0])), (Some(3.0), Some(3.0)));
        assert_eq!(
            (median(&[4.0, 1.0, 9.0, 2.0]), upper_median(&[4.0, 1.0, 9.0, 2.0])),
            (Some(3.0), Some(4.0))
        );
        assert!(mean([f64::NAN]).is_some_and(f64::is_nan), "what is no number stays so");
    }
}
