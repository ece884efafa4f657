//! Inner products of waves with a model, for many frequencies at once.
//!
//! Rows at one position of the axis wave alike, so their products are summed once; a frequency then costs a cosine and a
//! sine for each position instead of a product of the size of the readings. Many frequencies cost hardly more than their logarithm:
//! positions that do not come back (a circle, several laps of it) have as many as there are rows.

use super::transform::{Transform, together};
use nalgebra::{Complex, DMatrix, DVector};

/// Up to as many frequencies are a matrix product of all positions: a transform spreads each position over a quarter as many nodes.
const FEW: usize = 64;

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
        let size = if count <= FEW { count } else { together(count) };
        let fast =
            (count > FEW).then(|| [step, 2.0 * step].map(|step| Transform::new(&self.positions, step, size)));
        (0..count).step_by(size.max(1)).flat_map(move |from| {
            let low = low + step * from as f64;
            let (products, pairs) = match &fast {
                Some(fast) => self.transformed(low, step, fast),
                None => self.multiplied(low, step, size),
            };
            let inner = move |f: usize| self.inner(&products, &pairs, f, size);
            (0..size.min(count - from)).map(inner)
        })
    }

    /// Columns: cosines of all frequencies, then sines; of the pairs cos², cos·sin and sin².
    fn multiplied(&self, low: f64, step: f64, count: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let places = self.positions.len();
        let (mut waves, mut squares) = (DMatrix::zeros(places, 2 * count), DMatrix::zeros(places, 3 * count));
        for f in 0..count {
            for (i, q) in self.positions.iter().enumerate() {
                let (sin, cos) = ((low + step * f as f64) * q).sin_cos();
                (waves[(i, f)], waves[(i, count + f)]) = (cos, sin);
                squares[(i, f)] = cos * cos;
                squares[(i, count + f)] = cos * sin;
                squares[(i, 2 * count + f)] = sin * sin;
            }
        }
        (&self.products * &waves, &self.pairs * &squares)
    }

    /// The same for many frequencies: cos² = ½ (1 + cos 2ωq), cos·sin = ½ sin 2ωq, sin² = ½ (1 − cos 2ωq).
    fn transformed(
        &self,
        low: f64,
        step: f64,
        [of_waves, of_squares]: &[Transform; 2],
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let count = of_waves.count();
        let middle = low + step * of_waves.middle() as f64;
        let turned: Vec<Complex<f64>> =
            self.positions.iter().map(|q| Complex::from_polar(1.0, middle * q)).collect();
        let (mut products, mut pairs) =
            (DMatrix::zeros(self.products.nrows(), 2 * count), DMatrix::zeros(self.pairs.nrows(), 3 * count));
        for (at, row) in self.products.row_iter().enumerate() {
            let sums = of_waves.of(row.iter().zip(&turned).map(|(product, turned)| turned * *product));
            for (f, sum) in sums.iter().enumerate() {
                (products[(at, f)], products[(at, count + f)]) = (sum.re, sum.im);
            }
        }
        for (at, row) in self.pairs.row_iter().enumerate() {
            let sums = of_squares.of(row.iter().zip(&turned).map(|(pair, turned)| turned * turned * *pair));
            let all = row.sum();
            for (f, sum) in sums.iter().enumerate() {
                pairs[(at, f)] = 0.5 * (all + sum.re);
                pairs[(at, count + f)] = 0.5 * sum.im;
                pairs[(at, 2 * count + f)] = 0.5 * (all - sum.re);
            }
        }
        (products, pairs)
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

    /// Few frequencies and many, of positions that come back and of some that do not.
    #[test]
    fn the_products_are_those_of_the_columns_row_by_row() {
        let rows = 40;
        let noise =
            |seed: f64| move |row: usize, column: usize| ((row * 7 + column * 13) as f64 + seed).sin();
        let carriers = DMatrix::from_fn(rows, 2, noise(0.1));
        let basis = DMatrix::from_fn(rows, 3, noise(0.5));
        let residual = DVector::from_fn(rows, noise(0.9));
        let (low, step) = (0.4, 0.03);
        for places in [rows / 4, rows] {
            let position: Vec<f64> = (0..rows).map(|row| (row % places) as f64 * 0.37).collect();
            let moments = Moments::new(&position, &carriers, &basis, &residual);
            for (count, at) in [(1, 0), (FEW, FEW - 1), (FEW + 1, 3), (4096, 4095), (9000, 4200)] {
                let inner = moments.at_steps(low, step, count).nth(at).unwrap();
                let columns = DMatrix::from_fn(rows, 4, |row, j| {
                    let (sin, cos) = ((low + step * at as f64) * position[row]).sin_cos();
                    carriers[(row, j / 2)] * if j % 2 == 0 { cos } else { sin }
                });
                assert!((inner.gram - columns.tr_mul(&columns)).amax() < 1e-10, "{at} of {count}");
                assert!((inner.on_basis - columns.tr_mul(&basis)).amax() < 1e-10, "{at} of {count}");
                assert!((inner.on_residual - columns.tr_mul(&residual)).amax() < 1e-10, "{at} of {count}");
                assert_eq!(moments.at_steps(low, step, count).count(), count);
            }
        }
    }
}
