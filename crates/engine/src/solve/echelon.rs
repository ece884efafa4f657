//! Reduced row echelon form of null vectors: each direction is named by one parameter, its pivot, and the fewest others.

use nalgebra::{DMatrix, RowDVector};

/// Share of the largest entry from which another may be the pivot: threshold pivoting, with its usual 1/10 [Duff 1986].
const PIVOT_SHARE: f64 = 0.1;

/// One direction.
pub(crate) struct Row {
    pub pivot: usize,
    /// Entries of those that take part, 1 at the pivot.
    pub part: Vec<f64>,
    /// Entries of those that take no part.
    pub rest: Vec<f64>,
}

impl Row {
    /// Those that take part next to the pivot.
    pub fn others(&self) -> Vec<usize> {
        (0..self.part.len()).filter(|&k| k != self.pivot && self.part[k] != 0.0).collect()
    }

    /// Those of them for which `little` holds take no part; their indices.
    pub fn leave_out(&mut self, little: impl Fn(usize, f64) -> bool) -> Vec<usize> {
        let left_out: Vec<usize> = self.others().into_iter().filter(|&k| little(k, self.part[k])).collect();
        left_out.iter().for_each(|&k| self.rest[k] = std::mem::take(&mut self.part[k]));
        left_out
    }
}

/// Columns from which pivots are taken first.
pub(crate) struct Preferred<'a> {
    /// In this order.
    pub columns: &'a [usize],
    /// An entry at 1 as a part of its usual size, of every column.
    pub of_usual: &'a [f64],
    /// A column whose zero asks more of another one than so many times its usual size comes after those of which none does.
    pub most: f64,
}

impl Preferred<'_> {
    pub const NONE: Self = Self { columns: &[], of_usual: &[], most: 1.0 };

    /// The most that the zero of a pivot asks of another that takes part, times its usual size for each of the pivot's.
    fn asks(&self, row: &Row) -> f64 {
        let asked = row.others().into_iter().map(|k| row.part[k].abs() * self.of_usual[k]);
        asked.fold(0.0, f64::max) / self.of_usual[row.pivot]
    }
}

/// Reduced row echelon form of orthonormal rows; pivots from `preferred` in this order while they take part, then the largest entries
/// of the columns `first` while they take part, then of all those that are large the one that counts most. `least`: the shares of a row
/// of length 1 from which each column takes part in it; an entry below is zero.
///
/// What a zero asks of others is read from the reduced rows, which depend on the pivots alone: rows that are not reduced are any basis of the null
/// space. The one that asks most comes last, and all is reduced again, until none asks too much or all of those that do came last.
pub(crate) fn echelon(
    rows: DMatrix<f64>,
    preferred: &Preferred<'_>,
    first: &[usize],
    counts: &[f64],
    least: &dyn Fn(&RowDVector<f64>) -> Vec<f64>,
) -> Vec<Row> {
    let (mut before, mut last) = (preferred.columns.to_vec(), Vec::new());
    loop {
        let columns = [before.as_slice(), last.as_slice()].concat();
        let reduced = reduced(rows.clone(), &columns, first, counts, least);
        let asking = reduced.iter().filter(|row| before.contains(&row.pivot));
        let most = asking.max_by(|a, b| preferred.asks(a).total_cmp(&preferred.asks(b)));
        let Some(most) = most.filter(|row| preferred.asks(row) > preferred.most) else { return reduced };
        before.retain(|column| *column != most.pivot);
        last.push(most.pivot);
    }
}

fn reduced(
    mut rows: DMatrix<f64>,
    preferred: &[usize],
    first: &[usize],
    counts: &[f64],
    least: &dyn Fn(&RowDVector<f64>) -> Vec<f64>,
) -> Vec<Row> {
    let mut pivots = Vec::new();
    let mut waiting: Vec<usize> = preferred.to_vec();
    while pivots.len() < rows.nrows() {
        let below = pivots.len();
        let part = taking_part(&rows.rows(below, rows.nrows() - below).into_owned(), least);
        let takes_part = |&(i, j): &(usize, usize)| part[(i - below, j)] != 0.0;
        let size = |cell: &(usize, usize)| rows[*cell].abs();
        // The largest entry of a column of those that take part.
        let largest_in = |column: usize| {
            let cells = (below..rows.nrows()).map(|i| (i, column)).filter(takes_part);
            cells.max_by(|a, b| size(a).total_cmp(&size(b)))
        };
        let chosen = waiting.iter().find_map(|&column| largest_in(column));
        waiting.retain(|&column| chosen.is_none_or(|(_, chosen)| chosen != column));
        let among_first = || {
            let cells = first.iter().filter_map(|&column| largest_in(column));
            cells.max_by(|a, b| size(a).total_cmp(&size(b)))
        };
        let (row, column) = chosen.or_else(among_first).unwrap_or_else(|| {
            let largest = rows.rows(below, rows.nrows() - below).amax();
            let cells = (0..rows.ncols()).flat_map(|j| (below..rows.nrows()).map(move |i| (i, j)));
            let large = cells.filter(|cell| size(cell) >= PIVOT_SHARE * largest);
            let counted = |cell: &(usize, usize)| match takes_part(cell) {
                true => size(cell) * counts[cell.1],
                false => 0.0,
            };
            // The first of several alike.
            large.rev().max_by(|a, b| counted(a).total_cmp(&counted(b))).unwrap_or((below, 0))
        });
        rows.swap_rows(below, row);
        let pivot = rows[(below, column)];
        rows.row_mut(below).scale_mut(pivot.recip());
        let pivot_row = rows.row(below).into_owned();
        for i in (0..rows.nrows()).filter(|&i| i != below) {
            let factor = rows[(i, column)];
            rows.row_mut(i).zip_apply(&pivot_row, |x, p| *x -= factor * p);
        }
        pivots.push(column);
    }
    let mut kept = taking_part(&rows, least);
    pivots.iter().enumerate().for_each(|(i, &pivot)| kept[(i, pivot)] = 1.0);
    let of_row = |(i, pivot): (usize, usize)| Row {
        pivot,
        part: kept.row(i).iter().copied().collect(),
        rest: (0..kept.ncols()).map(|j| if kept[(i, j)] == 0.0 { rows[(i, j)] } else { 0.0 }).collect(),
    };
    pivots.into_iter().enumerate().map(of_row).collect()
}

/// The entries that take part; zero for the others.
fn taking_part(rows: &DMatrix<f64>, least: &dyn Fn(&RowDVector<f64>) -> Vec<f64>) -> DMatrix<f64> {
    let mut part = rows.clone();
    for mut row in part.row_iter_mut() {
        let unit = row.normalize();
        for ((entry, share), least) in row.iter_mut().zip(unit.iter()).zip(least(&unit)) {
            if share.abs() <= least {
                *entry = 0.0;
            }
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shift of a head, 1 µm, looks like 1 mrad of two zeros, 1 mm from each other: were the shift held at zero, 20 µm of it would be 20 mrad.
    #[test]
    fn a_zero_that_asks_much_of_others_waits_for_one_that_asks_little() {
        let row = DMatrix::from_row_slice(1, 3, &[1e-3, 1.0, -1.0]).normalize();
        let pivot = |columns: &[usize], of_usual: [f64; 3]| {
            let preferred = Preferred { columns, of_usual: &of_usual, most: 10.0 };
            echelon(row.clone(), &preferred, &[], &[1.0; 3], &|_| vec![1e-6; 3])[0].pivot
        };
        assert_eq!(pivot(&[0, 2], [1.0; 3]), 2);
        assert_eq!(pivot(&[0, 2], [1e3, 1.0, 1.0]), 0, "in usual sizes it asks no more than there is");
        assert_eq!(pivot(&[0], [1.0; 3]), 0, "the only one by convention");
    }

    /// The zero of a display and the tilt of its plate, 15 mm apart, have the same share; third comes a parameter of a small share.
    #[test]
    fn of_parameters_involved_equally_the_one_that_counts_most_is_the_pivot() {
        let row = DMatrix::from_row_slice(1, 3, &[0.7, -0.71, 0.05]).normalize();
        let pivot = |counts: [f64; 3]| {
            echelon(row.clone(), &Preferred::NONE, &[], &counts, &|_| vec![1e-6; 3])[0].pivot
        };
        assert_eq!(pivot([1.0, 1e3 / 15.0, 1.0]), 1);
        assert_eq!(pivot([1e3 / 15.0, 1.0, 1.0]), 0);
        assert_eq!(pivot([1.0, 1.0, 1e9]), 1, "a small share is no pivot, however much it counts");
    }

    #[test]
    fn who_does_not_take_part_is_zero_and_no_pivot() {
        let row = DMatrix::from_row_slice(1, 3, &[1.0, 1.0, 1e-4]).normalize();
        let third = Preferred { columns: &[2], of_usual: &[1.0; 3], most: f64::INFINITY };
        let Row { pivot, part: entries, rest } =
            echelon(row.clone(), &third, &[], &[1.0; 3], &|_| vec![1e-6, 1e-6, 1e-3]).remove(0);
        assert!(pivot != 2 && entries[2] == 0.0 && rest[2] != 0.0, "{entries:?} {rest:?}");
        let Row { pivot, part: entries, .. } =
            echelon(row, &third, &[], &[1.0; 3], &|_| vec![1e-6; 3]).remove(0);
        assert!(pivot == 2 && entries[0] != 0.0, "{entries:?}");
    }

    #[test]
    fn where_nobody_takes_part_the_pivot_is_still_one() {
        let row = DMatrix::from_row_slice(1, 2, &[0.6, 0.8]);
        let Row { pivot, part: entries, .. } =
            echelon(row, &Preferred::NONE, &[], &[1.0; 2], &|_| vec![2.0; 2]).remove(0);
        assert!(entries[pivot] == 1.0 && entries[1 - pivot] == 0.0, "{entries:?}");
    }
}
