//! Gross mistakes in a part of a table: blocks pasted over others, rows between a lost and a doubled reading, signs lost in one setup, a correction
//! switched on. And mistakes in all rows of a machine that lacks a large effect, which hides them from the base model.

use super::probes::{GRAVITY, NOTHING, ProbeMistake};
use super::{Files, READINGS};
use std::ops::Range;
use trunnion_effects::Instance;

impl Files {
    /// The readings of some rows pasted over those of as many others.
    fn paste(&mut self, from: Range<usize>, over: usize) {
        for name in READINGS {
            let column = self.column(name);
            let given: Vec<String> = self.rows[from.clone()].iter().map(|row| row[column].clone()).collect();
            self.rows[over..].iter_mut().zip(given).for_each(|(row, reading)| row[column] = reading);
        }
    }

    /// A reading is lost before one row, and one is written twice before another.
    fn early_between(&mut self, lost: usize, doubled: usize) {
        self.paste(lost + 1..doubled + 1, lost);
    }

    /// What an effect of one parameter makes of the readings, µm of its largest share.
    fn lacks(&mut self, id: &str, largest_um: f64) {
        let run = self.open();
        let effect = Instance::all(run.machine()).into_iter().find(|effect| effect.id() == id).unwrap();
        let column = run.points().columns(&effect, &[]).column(0).into_owned();
        let scale = largest_um / column.amax();
        for row in 0..self.rows.len() {
            for (k, name) in READINGS.into_iter().enumerate() {
                self.set(row, name, self.number(row, name) + scale * column[3 * row + k], 2);
            }
        }
    }

    fn all_late(&mut self) {
        for name in READINGS {
            let column = self.column(name);
            for row in (1..self.rows.len()).rev() {
                self.rows[row][column] = self.rows[row - 1][column].clone();
            }
        }
    }

    fn negated(&mut self, rows: Range<usize>) {
        for row in rows {
            READINGS.into_iter().for_each(|name| self.set(row, name, -self.number(row, name), 2));
        }
    }

    /// What a correction of everything leaves in some rows.
    fn corrected(&mut self, rows: Range<usize>) {
        for row in rows {
            for name in READINGS {
                self.set(row, name, 0.1 * self.number(row, name), 2);
            }
        }
    }
}

pub const BLOCKS: [ProbeMistake; 10] = [
    (
        "a block of readings pasted over the next",
        GRAVITY,
        |f| f.paste(60..72, 72),
        &["readings of rows 73 to 84 (setup low) are those of rows 61 to 72", "pasted over another one"],
    ),
    (
        "a pass pasted over the way back in the same order",
        NOTHING,
        |f| f.paste(0..84, 84),
        &["readings of rows 85 to 168 (setup low) are those of rows 1 to 84", "pasted over another one"],
    ),
    (
        "a pass of one setup pasted into the other",
        NOTHING,
        |f| f.paste(168..252, 0),
        &["readings of rows 1 to 84 (setup low) are those of rows 169 to 252 (setup high)"],
    ),
    (
        "a reading lost, and a later one doubled",
        NOTHING,
        |f| f.early_between(134, 201),
        &["shifted one row later", "one pose early from 40 % to 60 % of the points", "Change it?"],
    ),
    (
        "every sign of some rows reversed",
        GRAVITY,
        |f| f.negated(100..120),
        &["the signs of all readings reversed from 30 % to 36 % of the points", "Change it?"],
    ),
    (
        "the sign of one probe, on a machine that lacks a scale",
        NOTHING,
        |f| {
            f.lacks("linear-scale:Y", 30.0);
            f.readings(|[x, y, z]| [x, -y, z]);
        },
        &["the sign of the readings dy reversed", "and one more effect of an axis, 0.3 µm are left"],
    ),
    (
        "all readings one pose late, on a machine that lacks two effects",
        NOTHING,
        |f| {
            f.lacks("linear-scale:X", 40.0);
            f.lacks("squareness:ZX", 40.0);
            f.all_late();
        },
        &["shifted one row earlier: they are one pose late", "they repeat within", "Change it?"],
    ),
    (
        "absolute values of one probe of one setup",
        NOTHING,
        |f| {
            for row in f.second() {
                f.set(row, "dy_um", f.number(row, "dy_um").abs(), 2);
            }
        },
        &["signs given to the readings dy: they are absolute values (setup high alone)"],
    ),
    (
        "a correction switched on within a pass",
        NOTHING,
        |f| f.corrected(200..f.rows.len()),
        &[
            "other location errors from 60 % of the points on",
            "a correction was switched on or off",
            "import them as a run of their own",
        ],
    ),
    (
        "a correction on in one pass alone",
        NOTHING,
        |f| f.corrected(168..252),
        &[
            "other location errors from 50 % to 75 % of the points",
            "a correction was switched on or off",
            "import them as a run of their own",
        ],
    ),
];
