//! Gross mistakes between the readings of rows: late, lost, relative, without signs, of another day.

use super::probes::{GRAVITY, NOTHING, ProbeMistake, turned};
use super::{Files, READINGS};

/// Everything that says where the axes stood and whence they came.
const POSITIONS: [&str; 7] = ["x_mm", "y_mm", "z_mm", "b_deg", "c_deg", "direction_b", "direction_c"];

/// Which rows of a table are sorted.
#[derive(Clone, Copy, PartialEq)]
enum Rows {
    OfEachSetup,
    All,
}

impl Files {
    /// Some columns sorted by some, as a spreadsheet does it: rows that are equal keep their order.
    fn sorted(&mut self, columns: &[&str], by: &[&str], which: Rows) {
        let key = |row: usize| by.iter().map(|name| self.number(row, name)).collect::<Vec<f64>>();
        let keys: Vec<Vec<f64>> = (0..self.rows.len()).map(key).collect();
        let setup = |row: usize| if which == Rows::All { 0 } else { row / (self.rows.len() / 2) };
        let mut order: Vec<usize> = (0..self.rows.len()).collect();
        order.sort_by(|&a, &b| setup(a).cmp(&setup(b)).then(keys[a].partial_cmp(&keys[b]).unwrap()));
        let given = self.rows.clone();
        for name in columns {
            let column = self.column(name);
            self.rows
                .iter_mut()
                .zip(&order)
                .for_each(|(row, &from)| row[column].clone_from(&given[from][column]));
        }
    }

    /// From a row on, the readings of a row some rows before.
    fn late_from(&mut self, from: usize, by: usize) {
        for name in READINGS {
            let column = self.column(name);
            let given: Vec<String> = self.rows.iter().map(|row| row[column].clone()).collect();
            self.rows[from..]
                .iter_mut()
                .zip(&given[from - by..])
                .for_each(|(row, old)| row[column].clone_from(old));
        }
    }

    fn turned_with_c(&mut self) {
        for row in 0..self.rows.len() {
            let [x, y, z] = READINGS.map(|name| self.number(row, name));
            let new = turned(-self.number(row, "c_deg"))([x, y, z]);
            READINGS.iter().zip(new).for_each(|(name, value)| self.set(row, name, value, 2));
        }
    }

    fn relative_to_the_row_before(&mut self) {
        let of_setup = self.rows.len() / 2;
        for row in (0..self.rows.len()).rev().filter(|row| row % of_setup > 0) {
            for name in READINGS {
                self.set(row, name, self.number(row, name) - self.number(row - 1, name), 2);
            }
        }
    }

    /// The second setup of another machine.
    fn rows_of_another_day(&mut self) {
        let rows = self.second();
        self.rows[rows.clone()].clone_from_slice(&Self::committed(NOTHING).rows[rows]);
    }

    /// Each reading of a setup keeps a share of the one before.
    fn settling(&mut self, share: f64) {
        let of_setup = self.rows.len() / 2;
        for row in (0..self.rows.len()).filter(|row| row % of_setup > 0) {
            for name in READINGS {
                let value = share * self.number(row - 1, name) + (1.0 - share) * self.number(row, name);
                self.set(row, name, value, 2);
            }
        }
    }
}

pub const ROWS: [ProbeMistake; 18] = [
    (
        "positions sorted by C and B, readings not",
        GRAVITY,
        |f| f.sorted(&POSITIONS, &["c_deg", "b_deg"], Rows::OfEachSetup),
        &[
            "in passes B rising, within it C rising, every second pass backwards",
            "positions sorted without their readings",
        ],
    ),
    (
        "positions sorted by C alone, readings not",
        NOTHING,
        |f| f.sorted(&POSITIONS, &["c_deg"], Rows::OfEachSetup),
        &["in passes B rising, within it C rising, every second pass backwards"],
    ),
    (
        "setups and positions sorted by X, readings not",
        NOTHING,
        |f| f.sorted(&[&["setup"], &POSITIONS[..]].concat(), &["x_mm"], Rows::All),
        &["in passes B rising, within it C rising, every second pass backwards"],
    ),
    (
        "readings sorted by C, positions not",
        GRAVITY,
        |f| f.sorted(&READINGS, &["c_deg"], Rows::OfEachSetup),
        &["in the order C rising (", "readings without their positions"],
    ),
    (
        "readings sorted by one of them",
        NOTHING,
        |f| f.sorted(&READINGS, &["dx_um"], Rows::OfEachSetup),
        &["the probe dx rises from row to row through all 168 points", "sorted without their positions"],
    ),
    (
        "one column of readings sorted by itself",
        GRAVITY,
        |f| f.sorted(&["dy_um"], &["dy_um"], Rows::OfEachSetup),
        &["the probe dy rises from row to row", "sorted without their positions"],
    ),
    (
        "readings of one pass in reversed order",
        NOTHING,
        |f| {
            let (of_setup, of_pass) = (f.rows.len() / 2, f.rows.len() / 4);
            f.rows = [&f.rows[..of_pass], &f.rows[of_setup..of_setup + of_pass]].concat();
            let given = f.rows.clone();
            for (row, from) in given.iter().rev().enumerate() {
                READINGS.iter().for_each(|name| {
                    let column = f.column(name);
                    f.rows[row][column].clone_from(&from[column]);
                });
            }
        },
        &["the readings in reversed order"],
    ),
    (
        "read before the probes had settled",
        NOTHING,
        |f| f.settling(0.4),
        &["40 % of the reading before", "before they had settled"],
    ),
    ("readings five poses late", GRAVITY, |f| f.late_from(5, 5), &["shifted 5 rows earlier", "5 poses late"]),
    (
        "a reading written twice in the middle",
        GRAVITY,
        |f| f.late_from(201, 1),
        &["shifted one row earlier", "from 60 % of the points on"],
    ),
    (
        "readings in axes that do not turn with C",
        NOTHING,
        |f| f.turned_with_c(),
        &["readings turned by −C", "turn otherwise with C than the nest"],
    ),
    (
        "readings relative to the row before",
        NOTHING,
        |f| f.relative_to_the_row_before(),
        &["added up from row to row", "relative to the one before"],
    ),
    (
        "missing readings written as 0",
        GRAVITY,
        |f| {
            (4..f.rows.len())
                .step_by(9)
                .for_each(|row| READINGS.iter().for_each(|name| f.set(row, name, 0.0, 2)))
        },
        &["19 of 168 points", "exactly 0", "written as 0"],
    ),
    (
        "a setup of another day",
        GRAVITY,
        |f| f.rows_of_another_day(),
        &[
            "other location errors from 50 %",
            "another day or another machine",
            "import them as a run of their own",
        ],
    ),
    (
        "a second file behind the first",
        GRAVITY,
        |f| {
            let other = Files::committed(NOTHING);
            f.rows.extend(other.rows);
        },
        &[
            "other location errors from 50 %",
            "another day or another machine",
            "import them as a run of their own",
        ],
    ),
    (
        "absolute values of every probe",
        GRAVITY,
        |f| f.readings(|reading| reading.map(f64::abs)),
        &["signs given to the readings dx, dy, dz", "absolute values"],
    ),
    (
        "absolute values of every probe of another machine",
        NOTHING,
        |f| f.readings(|reading| reading.map(f64::abs)),
        &["signs given to the readings dx, dy, dz", "absolute values"],
    ),
    (
        "absolute values of one probe",
        GRAVITY,
        |f| f.readings(|[x, y, z]| [x.abs(), y, z]),
        &["signs given to the readings dx", "absolute values"],
    ),
];
