//! One solution of many that the runs do not distinguish: the one to enter into a control.
//!
//! The fit keeps one: the pivot of every null direction is zero (`Identification::solution`). Where a direction also holds a setting of ball or
//! instrument, what was set by hand must not go into the machine: x is moved along these directions, x − d x_j / d_j, until one
//! machine error j of each is zero and the settings hold its share. The readings stay the same.

use std::collections::BTreeSet;
use trunnion_engine::{Identification, Unobservable};

/// Share of the largest coefficient of a direction (screen units) below which a parameter takes no part.
const TAKES_PART: f64 = 1e-9;

/// Parameters of which the data determine only a combination.
#[derive(Clone, Debug, PartialEq)]
pub struct Confounded {
    /// Those in the tables, which stand for all.
    pub entered: Vec<String>,
    /// Those that are zero in the tables.
    pub zero: Vec<String>,
}

/// The solution to enter, inside units. `settings`: ids of the effects that are set by hand.
pub(super) fn representative(fit: &Identification, settings: &BTreeSet<&str>) -> Vec<f64> {
    let of_setting = |j: usize| settings.contains(fit.parameters[j].effect.as_str());
    let free = |j: usize| !of_setting(j) && fit.parameters[j].value.is_none();
    let mut solution: Vec<f64> = fit.solution.iter().copied().collect();
    let mixed = fit
        .unobservable
        .iter()
        .filter(|d| d.inside.iter().any(|t| of_setting(t.0)) && d.inside.iter().any(|t| free(t.0)));
    let mut rows: Vec<Vec<f64>> = mixed.map(|direction| dense(direction, solution.len())).collect();
    let on_screen = |row: &[f64], j: usize| (row[j] * fit.parameters[j].unit.per_inside).abs();
    for i in 0..rows.len() {
        let largest = |columns: &mut dyn Iterator<Item = usize>, row: &[f64]| {
            columns.map(|j| (j, on_screen(row, j))).max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let most = largest(&mut (0..solution.len()), &rows[i]).map_or(0.0, |(_, size)| size);
        let pivot = largest(&mut (0..solution.len()).filter(|&j| free(j)), &rows[i]);
        let Some((j, _)) = pivot.filter(|(_, size)| *size > TAKES_PART * most) else { continue };
        let row: Vec<f64> = rows[i].iter().map(|c| c / rows[i][j]).collect();
        for other in (0..rows.len()).filter(|&k| k != i) {
            let factor = rows[other][j];
            rows[other].iter_mut().zip(&row).for_each(|(c, d)| *c -= factor * d);
        }
        let share = solution[j];
        solution.iter_mut().zip(&row).for_each(|(x, d)| *x -= share * d);
        // Rounding is no error to enter.
        solution[j] = 0.0;
        rows[i] = row;
    }
    solution
}

fn dense(direction: &Unobservable, width: usize) -> Vec<f64> {
    let mut row = vec![0.0; width];
    direction.inside.iter().for_each(|(j, c)| row[*j] = *c);
    row
}

/// The null directions of which a parameter without a number of its own is in the tables: `held` there.
pub(super) fn confounded(
    fit: &Identification,
    solution: &[f64],
    held: impl Fn(usize) -> bool,
) -> Vec<Confounded> {
    let without_number = |j: usize| held(j) && fit.parameters[j].value.is_none();
    let of_direction = |direction: &Unobservable| {
        let names = |which: &dyn Fn(usize) -> bool| -> Vec<String> {
            let terms = direction.terms.iter().zip(&direction.inside);
            terms.filter(|(_, (j, _))| which(*j)).map(|((name, _), _)| name.clone()).collect()
        };
        let entered = names(&|j| without_number(j) && solution[j] != 0.0);
        let zero = names(&|j| without_number(j) && solution[j] == 0.0);
        (!entered.is_empty()).then_some(Confounded { entered, zero })
    };
    fit.unobservable.iter().filter_map(of_direction).collect()
}
