//! Inner products of waves with a model, for many frequencies at once.
//!
//! Rows at one position of the axis wave alike, so their products are summed once; a frequency then costs a cosine and a
//! sine for each position instead of a product of the size of the readings.

use nalgebra::{DMatrix, DVector};

/// Frequencies that are taken together: enough for the matrix product to be efficient, few enough to fit a cache.
const BLOCK: usize = 64;

/// Sums over the rows at each position, for every carrier k.
#[derive(Clone, Debug)]
pub(super) struct Moments {
    /// Positions that differ, mm or rad.
    positions: Vec<f64>,
    /// Carrier k times column j of the model, the residual last: k (columns + 1) + j × positions, as the product needs it.
    products: DMatrix<f64>,
    /// Carrier k times carrier l, k ≤ l: pairs × positions.
    pairs: DMatrix<f64>,
    carriers: usize,
}

/// Inner products of cos ωq and sin ωq, times every carrier in turn, at one frequency.
pub(super) struct Inner {
    /// Among each other.
    pub gram: DMatrix<f64>,
    /// With the orthonormal columns of the model.
    pub on_basis: DMatrix<f64>,
    /// With the residual, mm.
    pub on_residual: DVector<f64>,
}

impl Moments {
    /// Of rows at `position`; carriers and basis are rows × columns.
    pub fn new(
        position: &[f64],
        carriers: &DMatrix<f64>,
        basis: &DMatrix<f64>,
        residual: &DVector<f64>,
    ) -> Self {
        let mut order: Vec<usize> = (0..position.len()).collect();
        order.sort_by(|&a, &b| position[a].total_cmp(&position[b]));
        let mut positions: Vec<f64> = Vec::new();
        let mut place = vec![0; position.len()];
        for row in order {
            if positions.last() != Some(&position[row]) {
                positions.push(position[row]);
            }
            place[row] = positions.len() - 1;
        }
        let summed = |of_row: &dyn Fn(usize) -> f64, mut sums: nalgebra::DVectorViewMut<'_, f64>| {
            (0..position.len()).for_each(|row| sums[place[row]] += of_row(row));
        };
        let (count, width) = (carriers.ncols(), basis.ncols() + 1);
        let mut products = DMatrix::zeros(positions.len(), count * width);
        let mut pairs = DMatrix::zeros(positions.len(), count * (count + 1) / 2);
        for (k, carrier) in carriers.column_iter().enumerate() {
            for (j, column) in basis.column_iter().enumerate() {
                summed(&|row| carrier[row] * column[row], products.column_mut(k * width + j));
            }
            summed(&|row| carrier[row] * residual[row], products.column_mut((k + 1) * width - 1));
        }
        for (at, (k, l)) in pairs_of(count).enumerate() {
            summed(&|row| carriers[(row, k)] * carriers[(row, l)], pairs.column_mut(at));
        }
        Self { positions, products: products.transpose(), pairs: pairs.transpose(), carriers: count }
    }

    /// At one frequency, rad per mm or per rad.
    pub fn at(&self, omega: f64) -> Option<Inner> {
        self.at_steps(omega, 0.0, 1).next()
    }

    /// At `count` frequencies from `low` on, `step` apart.
    pub fn at_steps(&self, low: f64, step: f64, count: usize) -> impl Iterator<Item = Inner> {
        let of_step: Vec<(f64, f64)> = self.positions.iter().map(|q| (step * q).sin_cos()).collect();
        (0..count)
            .step_by(BLOCK)
            .flat_map(move |from| self.block(low + step * from as f64, BLOCK.min(count - from), &of_step))
    }

    /// `of_step`: sine and cosine of a step at each position. A wave is the one before it, turned by a step: a sine for each position and
    /// frequency would take half of the time, and sixty-four turns cost sixty-four roundings.
    fn block(&self, low: f64, count: usize, of_step: &[(f64, f64)]) -> Vec<Inner> {
        let places = self.positions.len();
        // Columns: cosines of all frequencies, then sines; then cos², cos·sin and sin² for the pairs.
        let (mut waves, mut squares) = (DMatrix::zeros(places, 2 * count), DMatrix::zeros(places, 3 * count));
        let mut at: Vec<(f64, f64)> = self.positions.iter().map(|q| (low * q).sin_cos()).collect();
        for f in 0..count {
            for (i, ((sin, cos), (sin_step, cos_step))) in at.iter_mut().zip(of_step).enumerate() {
                (waves[(i, f)], waves[(i, count + f)]) = (*cos, *sin);
                squares[(i, f)] = *cos * *cos;
                squares[(i, count + f)] = *cos * *sin;
                squares[(i, 2 * count + f)] = *sin * *sin;
                (*sin, *cos) = (*sin * cos_step + *cos * sin_step, *cos * cos_step - *sin * sin_step);
            }
        }
        let products = &self.products * &waves;
        let pairs = &self.pairs * &squares;
        (0..count).map(|f| self.inner(&products, &pairs, f, count)).collect()
    }

    fn inner(&self, products: &DMatrix<f64>, pairs: &DMatrix<f64>, f: usize, count: usize) -> Inner {
        let size = 2 * self.carriers;
        let width = products.nrows() / self.carriers.max(1);
        let product = |wave: usize, j: usize| products[(wave / 2 * width + j, wave % 2 * count + f)];
        let mut gram = DMatrix::zeros(size, size);
        for (at, (k, l)) in pairs_of(self.carriers).enumerate() {
            for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let value = pairs[(at, (a + b) * count + f)];
                gram[(2 * k + a, 2 * l + b)] = value;
                gram[(2 * l + b, 2 * k + a)] = value;
            }
        }
        Inner {
            gram,
            on_basis: DMatrix::from_fn(size, width.max(1) - 1, product),
            on_residual: DVector::from_fn(size, |wave, _| product(wave, width - 1)),
        }
    }
}

/// k ≤ l.
fn pairs_of(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |k| (k..count).map(move |l| (k, l)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_products_are_those_of_the_columns_row_by_row() {
        let rows = 40;
        let position: Vec<f64> = (0..rows).map(|row| f64::from(row / 4) * 0.37).collect();
        let noise =
            |seed: f64| move |row: usize, column: usize| ((row * 7 + column * 13) as f64 + seed).sin();
        let rows = rows as usize;
        let carriers = DMatrix::from_fn(rows, 2, noise(0.1));
        let basis = DMatrix::from_fn(rows, 3, noise(0.5));
        let residual = DVector::from_fn(rows, noise(0.9));
        let moments = Moments::new(&position, &carriers, &basis, &residual);
        // In the second block.
        let at = 1.5 * BLOCK as f64;
        let inner = moments.at_steps(0.4, 0.03, 2 * BLOCK).nth(at as usize).unwrap();
        let columns = DMatrix::from_fn(rows, 4, |row, j| {
            let (sin, cos) = ((0.4 + 0.03 * at) * position[row]).sin_cos();
            carriers[(row, j / 2)] * if j % 2 == 0 { cos } else { sin }
        });
        assert!((inner.gram - columns.tr_mul(&columns)).amax() < 1e-12);
        assert!((inner.on_basis - columns.tr_mul(&basis)).amax() < 1e-12);
        assert!((inner.on_residual - columns.tr_mul(&residual)).amax() < 1e-12);
    }
}
