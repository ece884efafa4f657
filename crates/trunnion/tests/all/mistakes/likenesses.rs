//! Gross mistakes that fit nearly as well as the truth: machines in a mirror, one nest turned, raw readings, copied blocks.

use super::probes::{GRAVITY, NOTHING, ProbeMistake, turned};
use super::{Files, READINGS};

impl Files {
    /// The readings of one setup turned by an angle about z.
    pub fn second_turned(&mut self, deg: f64) {
        for row in self.second() {
            let given = READINGS.map(|name| self.number(row, name));
            READINGS.iter().zip(turned(deg)(given)).for_each(|(name, value)| self.set(row, name, value, 2));
        }
    }

    /// What three probes at right angles to each other read of the ball, each inclined alike to z, the first at an angle about z.
    pub fn raw_of_inclined(&mut self, first_deg: f64) {
        let (along, across) = ((1.0_f64 / 3.0).sqrt(), (2.0_f64 / 3.0).sqrt());
        self.readings(|[x, y, z]| {
            [0.0, 120.0, 240.0].map(|deg| {
                let (sin, cos) = (first_deg + deg).to_radians().sin_cos();
                across * (cos * x + sin * y) + along * z
            })
        });
    }

    /// The block of the second setup copied from the first, and the positions computed from it. The axis of C leans by 70 µrad about machine Y, which
    /// moves the ball that is 100 mm higher by 7 µm more.
    pub fn block_copied(&mut self) {
        let rows = self.second();
        for row in rows.clone() {
            for name in ["x_mm", "y_mm", "z_mm"].into_iter().chain(READINGS) {
                let column = self.column(name);
                self.rows[row][column] = self.rows[row - rows.start][column].clone();
            }
            let (sin, cos) = self.number(row, "c_deg").to_radians().sin_cos();
            for (channel, (name, more)) in READINGS.iter().zip([7.0 * cos, -7.0 * sin, 0.0]).enumerate() {
                let noise = 0.3 * ((row * 3 + channel) as f64 * 12.9898).sin();
                self.set(row, name, self.number(row, name) + more + noise, 2);
            }
        }
        self.replace("160.0]", "60.0]");
    }

    /// The same on a table A-C: machine axes turned by −90° about z, so that Y becomes X, and B about Y becomes A about X.
    pub fn on_a_table_ac(&mut self) {
        self.exchange("x_mm", "y_mm");
        self.change("y_mm", |mm| -mm);
        self.change("c_deg", |deg| deg - 90.0);
        for name in &mut self.header {
            *name = name.replace("b_deg", "a_deg").replace("direction_b", "direction_a");
        }
        self.replace("\"table-bc\"", "\"table-ac\"");
    }

    /// Senses reversed.
    pub fn reverse(&mut self, columns: &[&str]) {
        columns.iter().for_each(|name| self.change(name, |value| -value));
    }
}

pub const LIKENESSES: [ProbeMistake; 7] = [
    (
        "senses of A and C",
        GRAVITY,
        |f| {
            f.on_a_table_ac();
            f.reverse(&["a_deg", "c_deg"]);
        },
        &[
            "the senses of A and C reversed (sign −1), or the sense of Y",
            "cannot distinguish",
            "jog +A, +C and +Y",
        ],
    ),
    (
        "senses of A and C, and then Y reversed",
        NOTHING,
        |f| {
            f.on_a_table_ac();
            f.reverse(&["a_deg", "c_deg", "y_mm"]);
        },
        &[
            "readings dy reversed",
            "or the senses of A and C, and of Y, reversed together",
            "jog +A, +C and +Y",
        ],
    ),
    (
        "positions of the tool tip",
        GRAVITY,
        |f| [("x_mm", 150.0), ("y_mm", 0.0), ("z_mm", 60.0)].iter().for_each(|(c, mm)| f.change(c, |_| *mm)),
        &["position of the tool tip on the workpiece", "Log machine coordinates"],
    ),
    (
        "the nest of one setup turned by 30°",
        NOTHING,
        |f| f.second_turned(30.0),
        &["the nest mounted turned by +30° about its z axis (setup high alone)", "Change it?"],
    ),
    (
        "the nest of one setup turned by 8°",
        NOTHING,
        |f| f.second_turned(8.0),
        &["the nest mounted turned by +8° about its z axis (setup high alone)", "Change it?"],
    ),
    (
        "raw readings of three inclined probes",
        NOTHING,
        |f| f.raw_of_inclined(20.0),
        &["raw readings of three probes at right angles", "inclined by 54.7°", "the first at +20°"],
    ),
    (
        "the block of a setup copied",
        NOTHING,
        Files::block_copied,
        &["setups low and high have the same ball_in_table_mm", "Was the block [[setup]] copied"],
    ),
];
