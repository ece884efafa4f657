//! Gross mistakes between probes, setups and positions: wiring, units, parts of a file that belong elsewhere.

use super::{Files, READINGS};

/// What is spoilt in which set, and what must be said of it.
pub type ProbeMistake = (&'static str, &'static str, fn(&mut Files), &'static [&'static str]);

pub const GRAVITY: &str = "points-gravity";
pub const NOTHING: &str = "points-nothing-hidden";

impl Files {
    pub fn number(&self, row: usize, name: &str) -> f64 {
        self.rows[row][self.column(name)].parse().unwrap()
    }

    pub fn set(&mut self, row: usize, name: &str, value: f64, digits: usize) {
        let column = self.column(name);
        self.rows[row][column] = format!("{value:.digits$}");
    }

    /// Each row's readings from those of the row.
    pub fn readings(&mut self, change: impl Fn([f64; 3]) -> [f64; 3]) {
        for row in 0..self.rows.len() {
            let new = change(READINGS.map(|name| self.number(row, name)));
            READINGS.iter().zip(new).for_each(|(name, value)| self.set(row, name, value, 2));
        }
    }

    /// A further temperature, from 20 °C on, as a display in steps of 0.01 K shows it.
    pub fn warm(&mut self, name: &str, warmed_k: impl Fn(usize) -> f64) {
        self.header.push(name.into());
        for (row, cells) in self.rows.iter_mut().enumerate() {
            cells.push(format!("{:.2}", 20.0 + warmed_k(row)));
        }
    }

    /// Rows of the second setup.
    pub fn second(&self) -> std::ops::Range<usize> {
        self.rows.len() / 2..self.rows.len()
    }

    fn rounded(&mut self, digits: usize) {
        for row in 0..self.rows.len() {
            for name in ["x_mm", "y_mm", "z_mm"] {
                self.set(row, name, self.number(row, name), digits);
            }
        }
    }

    /// A column, from the second setup on, is one row late.
    fn late(&mut self, names: &[&str]) {
        let rows = self.second();
        for name in names {
            let column = self.column(name);
            for row in rows.clone().skip(1).rev() {
                self.rows[row][column] = self.rows[row - 1][column].clone();
            }
        }
    }
}

/// A bed that warms by 3 K with a time constant of 100 rows.
pub fn warmed_k(row: usize) -> f64 {
    3.0 * (1.0 - (-(row as f64) / 100.0).exp())
}

pub fn turned(deg: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    let (sin, cos) = deg.to_radians().sin_cos();
    move |[x, y, z]| [cos * x + sin * y, cos * y - sin * x, z]
}

pub const PROBES: [ProbeMistake; 39] = [
    (
        "every probe at the input of the next",
        GRAVITY,
        |f| f.readings(|[x, y, z]| [y, z, x]),
        &["dx, dy, dz read as dz, dx, dy", "probe inputs"],
    ),
    (
        "signs of two probes",
        NOTHING,
        |f| f.readings(|[x, y, z]| [-x, y, -z]),
        &["sign of the readings dy reversed, or those of dx and dz"],
    ),
    (
        "nest mounted turned by 90°",
        GRAVITY,
        |f| f.readings(|[x, y, z]| [y, -x, z]),
        &["dx, dy, dz read as −dy, dx, dz", "nest mounted turned"],
    ),
    (
        "nest mounted turned by 45°",
        GRAVITY,
        |f| f.readings(turned(45.0)),
        &["nest mounted turned by +45° about its z axis"],
    ),
    (
        "two inputs on one probe",
        GRAVITY,
        |f| f.readings(|[_, y, z]| [y, y, z]),
        &["the probe dx and the probe dy read the same value in 168 of 168 points"],
    ),
    (
        "a probe at the end of its range",
        GRAVITY,
        |f| f.readings(|[x, y, z]| [x.max(-15.0), y, z]),
        &["the probe dx reads exactly −15.00 µm in", "range ends there"],
    ),
    (
        "a loose probe",
        NOTHING,
        |f| {
            let mut state = 7_u64;
            for row in 0..f.rows.len() {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let shaken = (state >> 40) as f64 / f64::from(1 << 24) * 40.0 - 20.0;
                f.set(row, "dy_um", f.number(row, "dy_um") + shaken, 2);
            }
        },
        &["the probe dy at one pose repeat within", "loose"],
    ),
    (
        "one setup pasted under two names",
        GRAVITY,
        |f| {
            for row in f.second() {
                let from = row - f.second().start;
                READINGS.iter().for_each(|name| f.set(row, name, f.number(from, name), 2));
            }
        },
        &["the readings of setup high are those of setup low in 168 of 168 points"],
    ),
    (
        "readings of two setups exchanged",
        NOTHING,
        |f| {
            for (a, b) in f.second().enumerate() {
                for name in READINGS {
                    let [of_a, of_b] = [a, b].map(|row| f.number(row, name));
                    f.set(a, name, of_b, 2);
                    f.set(b, name, of_a, 2);
                }
            }
        },
        &["readings of the setups low and high exchanged"],
    ),
    ("one pose late in one setup", GRAVITY, |f| f.late(&READINGS), &["one pose late (setup high alone)"]),
    (
        "one probe one pose late",
        NOTHING,
        |f| {
            let column = f.column("dz_um");
            for row in (1..f.rows.len()).rev() {
                f.rows[row][column] = f.rows[row - 1][column].clone();
            }
        },
        &["the readings dz shifted one row earlier: they are one pose late"],
    ),
    (
        "rows of one setup under the name of the other",
        GRAVITY,
        |f| {
            let column = f.column("setup");
            f.rows[100..168].iter_mut().for_each(|row| row[column] = "high".into());
        },
        &["in rows 101 to 168 the axes do not follow the ball", "they are of setup low"],
    ),
    (
        "readings that hold the positions",
        GRAVITY,
        |f| {
            for row in 0..f.rows.len() {
                for (reading, position) in READINGS.iter().zip(["x_mm", "y_mm", "z_mm"]) {
                    f.set(row, reading, f.number(row, reading) + 1e3 * f.number(row, position), 2);
                }
            }
        },
        &["positions of X, Y and Z taken off the readings"],
    ),
    (
        "one probe in millimetres",
        NOTHING,
        |f| f.readings(|[x, y, z]| [x, y, z * 1e-3]),
        &["the readings dz multiplied by 1000 (given in mm, not in µm?)"],
    ),
    (
        "one probe with a tenth of its gain",
        GRAVITY,
        |f| f.readings(|[x, y, z]| [x, y * 0.1, z]),
        &["the readings dy multiplied by 10 (a decimal point, a gain of the amplifier?)"],
    ),
    (
        "one setup in tenths of a µm",
        NOTHING,
        |f| {
            for row in f.second() {
                READINGS.iter().for_each(|name| f.set(row, name, 10.0 * f.number(row, name), 2));
            }
        },
        &["the readings divided by 10 (tenths of a µm", "(setup high alone)"],
    ),
    (
        "two inputs exchanged in the middle of the run",
        NOTHING,
        |f| {
            for row in 202..f.rows.len() {
                let [x, y] = ["dx_um", "dy_um"].map(|name| f.number(row, name));
                f.set(row, "dx_um", y, 2);
                f.set(row, "dy_um", x, 2);
            }
        },
        &["the readings dx and dy exchanged (probe inputs) from 60 % of the points on"],
    ),
    (
        "sign of a probe from the middle of the run",
        GRAVITY,
        |f| (252..f.rows.len()).for_each(|row| f.set(row, "dz_um", -f.number(row, "dz_um"), 2)),
        &["the sign of the readings dz reversed from 75 % of the points on"],
    ),
    (
        "nest of one setup on the other side",
        NOTHING,
        |f| {
            let of_high = f.setup.rfind("\"table\"").unwrap();
            f.setup.replace_range(of_high.., &f.setup[of_high..].replacen("table", "spindle", 1));
        },
        &["the nest on the table, not on the other side (setup high alone)"],
    ),
    (
        "nanometres under µm",
        GRAVITY,
        |f| f.readings(|values| values.map(|v| v * 1e3)),
        &["repeat within 295 µm", "too large", "In nm instead of µm"],
    ),
    (
        "positions with two decimals",
        GRAVITY,
        |f| f.rounded(2),
        &["in steps of 0.01 mm", "rounded when they were written", "four decimals"],
    ),
    (
        "positions in whole millimetres",
        GRAVITY,
        |f| f.rounded(0),
        &["in steps of 1 mm", "rounded when they were written"],
    ),
    (
        "another work offset from row 151 on",
        GRAVITY,
        |f| (150..336).for_each(|row| f.set(row, "x_mm", f.number(row, "x_mm") + 0.2, 4)),
        &["up to 200 µm apart (most in rows 151 to 336)", "work offset"],
    ),
    (
        "a wrong digit in one position",
        GRAVITY,
        |f| f.set(200, "x_mm", f.number(200, "x_mm") + 10.0, 4),
        &["in row 201 the axes do not follow the ball", "Read the positions of row 201 again"],
    ),
    (
        "sense of B in one setup",
        GRAVITY,
        |f| f.second().for_each(|row| f.set(row, "b_deg", -f.number(row, "b_deg"), 4)),
        &["sense of B reversed (sign −1) (setup high alone)"],
    ),
    (
        "C one row late in one setup",
        GRAVITY,
        |f| f.late(&["c_deg"]),
        &["the positions of C, which are one row late, moved up (setup high alone)"],
    ),
    (
        "directions never filled in, and play",
        "points-backlash-and-drift",
        |f| ["direction_b", "direction_c"].into_iter().for_each(|c| f.change(c, |_| 1.0)),
        &["direction_c is always +1", "the readings know the way"],
    ),
    (
        "directions reversed",
        GRAVITY,
        |f| {
            for row in 0..f.rows.len() {
                ["direction_b", "direction_c"]
                    .iter()
                    .for_each(|name| f.set(row, name, -f.number(row, name), 0));
            }
        },
        &["direction_b is opposite to the motion of B", "backlash would have the wrong sign"],
    ),
    (
        "minutes",
        GRAVITY,
        |f| f.change("time_s", |v| v / 60.0),
        &["0.067 s apart", "In minutes instead of seconds"],
    ),
    (
        "days, as a spreadsheet has them",
        GRAVITY,
        |f| f.change("time_s", |v| v / 86_400.0),
        &["In days instead of seconds (factor 86400)"],
    ),
    (
        "degrees Fahrenheit",
        GRAVITY,
        |f| f.change("ambient_degc", |v| v * 1.8 + 32.0),
        &["too hot for air", "in °F 19.4 °C", "1.8 times too small"],
    ),
    (
        "tenths of °C",
        GRAVITY,
        |f| f.change("ambient_degc", |v| 10.0 * v),
        &[
            "never below 194.1 °C",
            "It would be in tenths of °C 19.4 °C, which is plausible",
            "10 times too small",
        ],
    ),
    (
        "kelvin",
        GRAVITY,
        |f| f.change("ambient_degc", |v| v + 273.15),
        &["never below 292.6 °C", "in K 19.4 °C", "273 K off"],
    ),
    (
        "a temperature of zero for a while",
        GRAVITY,
        |f| (100..150).for_each(|row| f.set(row, "ambient_degc", 0.0, 2)),
        &["ambient is exactly 0 °C in 50 of 336 points (rows 101 to 150)", "sensor was not read"],
    ),
    (
        "a temperature that stops",
        GRAVITY,
        |f| f.warm("bed_degc", |row| if row < 60 { warmed_k(row) } else { warmed_k(60) }),
        &[
            "from row 61 to the end (276 readings) the temperature bed is 21.35 °C in every digit, while others go on (ambient)",
            "its plug or its logger stopped",
        ],
    ),
    (
        "a temperature that jumps",
        GRAVITY,
        |f| f.warm("bed_degc", |row| if row < 150 { warmed_k(row) } else { warmed_k(row) + 2.0 }),
        &["from row 150 to row 151 the temperature bed jumps by +2.0 K", "plugged in elsewhere"],
    ),
    (
        "a clock set back by five minutes",
        GRAVITY,
        |f| (112..f.rows.len()).for_each(|row| f.set(row, "time_s", f.number(row, "time_s") - 300.0, 3)),
        &["from row 112 to row 113 time runs back by 296 s, from 498.0 to 202.0 s", "clock was set"],
    ),
    (
        "every fourth row with the readings of the row before",
        NOTHING,
        |f| {
            for row in (1..f.rows.len()).step_by(4) {
                READINGS.iter().for_each(|name| f.set(row, name, f.number(row - 1, name), 2));
            }
        },
        &[
            "42 of 166 rows of setup low all readings are those of the row before",
            "(rows 2, 6, 10, 14, …)",
            "not new",
        ],
    ),
    (
        "9999 where a reading is missing",
        GRAVITY,
        |f| (0..f.rows.len()).step_by(40).for_each(|row| f.set(row, "dy_um", 9999.0, 0)),
        &[
            "the probe dy reads exactly +9999.00 µm in 5 of 168 points of setup low",
            "stands for a missing reading",
        ],
    ),
];
