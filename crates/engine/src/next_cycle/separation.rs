//! How well two effects would be separated: expected ln Bayes factor.
//!
//! If effect A with parameters a is the truth, the best that B can do leaves `aᵀ G a`, `G = (S_AA − S_AB S_BB⁺ S_BA)/σ²`, and
//! the expected ln Bayes factor is half of it (T-optimality; Atkinson & Fedorov 1975). a is known from the present data only
//! within `(a − â)ᵀ Λ (a − â) ≤ r²`, so the least value within that region counts: a difference that rests on the noise of the
//! present fit is none.

use nalgebra::{DMatrix, DVector};

/// r²: 95 % of four parameters.
const REGION: f64 = 9.5;

/// What is known of the parameters of an effect.
#[derive(Clone, Debug)]
pub(super) enum Known {
    /// From a fit: values and their precision Λ.
    Fitted(DVector<f64>, DMatrix<f64>),
    /// Only a typical size of each parameter.
    Typical(DVector<f64>),
}

impl Known {
    /// True when the fit separates the effect from none.
    pub fn is_significant(values: &DVector<f64>, precision: &DMatrix<f64>) -> bool {
        (values.transpose() * precision * values)[(0, 0)] > REGION
    }
}

/// Expected ln Bayes factor for what is left (G, already divided by the noise variance).
pub(super) fn expected_ln(left: &DMatrix<f64>, known: &Known) -> f64 {
    match known {
        Known::Typical(sizes) => {
            // Each parameter alone, on average.
            let one = |j: usize| 0.5 * left[(j, j)].max(0.0) * sizes[j] * sizes[j];
            (0..sizes.len()).map(one).sum::<f64>() / sizes.len().max(1) as f64
        }
        Known::Fitted(values, precision) => 0.5 * least_within(left, values, precision),
    }
}

/// The same when the noise variance has to be found from the data as well: ½ ν ln(1 + 2 ln BF/ν) [docs/design/statistics.md §2 with large g].
pub(super) fn with_unknown_noise(ln: f64, freedom: usize) -> f64 {
    let nu = freedom.max(1) as f64;
    0.5 * nu * (2.0 * ln / nu).ln_1p()
}

/// min aᵀ G a over (a − â)ᵀ Λ (a − â) ≤ r².
fn least_within(g: &DMatrix<f64>, values: &DVector<f64>, precision: &DMatrix<f64>) -> f64 {
    let eigen = precision.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return 0.0;
    }
    let (mut known, mut free) = (Vec::new(), Vec::new());
    for j in 0..values.len() {
        if eigen.eigenvalues[j] > 1e-12 * largest { known.push(j) } else { free.push(j) }
    }
    // z = Λ^½ a in the directions the data know; the others cost nothing.
    let to_z = |js: &[usize], root: bool| {
        DMatrix::from_fn(values.len(), js.len(), |i, k| {
            let scale = if root { 1.0 / eigen.eigenvalues[js[k]].sqrt() } else { 1.0 };
            eigen.eigenvectors[(i, js[k])] * scale
        })
    };
    let (basis, loose) = (to_z(&known, true), to_z(&free, false));
    let mut m = basis.transpose() * g * &basis;
    if loose.ncols() > 0 {
        let across = basis.transpose() * g * &loose;
        let own = loose.transpose() * g * &loose;
        let tolerance = 1e-12 * own.amax().max(1e-300);
        if let Ok(inverse) = own.pseudo_inverse(tolerance) {
            m -= &across * inverse * across.transpose();
        }
    }
    let z_hat = DVector::from_iterator(
        known.len(),
        known.iter().map(|&j| eigen.eigenvectors.column(j).dot(values) * eigen.eigenvalues[j].sqrt()),
    );
    if z_hat.norm_squared() <= REGION {
        return 0.0;
    }
    let m = (&m + m.transpose()) * 0.5;
    let curved = m.symmetric_eigen();
    let d = curved.eigenvalues.map(|v| v.max(0.0));
    let z_hat = curved.eigenvectors.transpose() * z_hat;
    let moved =
        |mu: f64| -> f64 { d.iter().zip(z_hat.iter()).map(|(d, z)| (d * z / (d + mu)).powi(2)).sum() };
    let (mut low, mut high) = (-80f64, 80f64);
    if moved(low.exp()) <= REGION {
        return 0.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if moved(middle.exp()) > REGION { low = middle } else { high = middle }
    }
    let mu = high.exp();
    d.iter().zip(z_hat.iter()).map(|(d, z)| d * (mu * z / (d + mu)).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_value_in_the_region_is_that_of_a_search_around_its_rim() {
        let g = DMatrix::from_row_slice(2, 2, &[3.0, 0.2, 0.2, 0.02]);
        let precision = DMatrix::from_row_slice(2, 2, &[2.0, -0.3, -0.3, 1.0]);
        let values = DVector::from_row_slice(&[4.0, -7.0]);
        let found = least_within(&g, &values, &precision);
        let root = precision.clone().cholesky().unwrap().l().transpose().try_inverse().unwrap();
        let mut least = f64::INFINITY;
        for i in 0..20_000 {
            let angle = f64::from(i) * std::f64::consts::TAU / 20_000.0;
            let a = &values + &root * DVector::from_row_slice(&[angle.cos(), angle.sin()]) * REGION.sqrt();
            least = least.min((a.transpose() * &g * &a)[(0, 0)]);
        }
        assert!((found - least).abs() < 1e-6 * least, "{found} {least}");
    }

    #[test]
    fn a_difference_that_rests_on_the_noise_of_the_fit_separates_nothing() {
        // Two parameters: the first ten sigma, the second one sigma; only the second separates A from B.
        let g = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, 1e6]);
        let known = Known::Fitted(DVector::from_row_slice(&[10.0, 1.0]), DMatrix::identity(2, 2));
        assert!(expected_ln(&g, &known) < 1e-6);
        let seen = Known::Fitted(DVector::from_row_slice(&[10.0, 8.0]), DMatrix::identity(2, 2));
        assert!(expected_ln(&g, &seen) > 1e6);
    }
}
