//! Probabilities that are known by their logarithms, which as numbers would be too large or too small.

/// ln of the mean of exp; −∞ of nothing.
pub(crate) fn log_mean_exp(terms: &[f64]) -> f64 {
    let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + (terms.iter().map(|x| (x - largest).exp()).sum::<f64>() / terms.len() as f64).ln()
}

/// Shares that add up to 1.
pub(crate) fn shares_of(ln: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let most = ln.clone().fold(f64::NEG_INFINITY, f64::max);
    let mut shares: Vec<f64> = ln.map(|ln| (ln - most).exp()).collect();
    let sum: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|share| *share /= sum);
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_number_holds_has_its_mean_and_its_shares() {
        let ln = [-2000.0, -2000.0 + 3f64.ln()];
        assert!((log_mean_exp(&ln) - (-2000.0 + 2f64.ln())).abs() < 1e-9);
        assert!((shares_of(ln.into_iter())[1] - 0.75).abs() < 1e-12);
        assert_eq!(log_mean_exp(&[]), f64::NEG_INFINITY);
    }
}
