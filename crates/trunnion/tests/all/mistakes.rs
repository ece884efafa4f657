//! Gross mistakes that people make with points and their files, and what becomes of each (docs/measured/mistakes.md).

mod bars;
mod blocks;
mod files;
mod likenesses;
mod probes;
mod rows;

use crate::section::write_or_compare;
use bars::{BARS, bar};
use blocks::BLOCKS;
use files::{Becomes, FILES};
use likenesses::LIKENESSES;
use probes::PROBES;
pub use probes::warmed_k;
use rows::ROWS;
use std::path::PathBuf;

pub const READINGS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];

/// A points file with its setup, as text.
pub struct Files {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
    pub setup: String,
}

impl Files {
    pub fn committed(set: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(set);
        let text = std::fs::read_to_string(folder.join("points.csv")).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let setup = std::fs::read_to_string(folder.join("setup.toml")).unwrap();
        Self { header, rows: lines.collect(), setup }
    }

    pub fn column(&self, name: &str) -> usize {
        self.header.iter().position(|column| column == name).unwrap()
    }

    pub fn change(&mut self, name: &str, change: impl Fn(f64) -> f64) {
        let column = self.column(name);
        for row in &mut self.rows {
            row[column] = format!("{:.7}", change(row[column].parse().unwrap()));
        }
    }

    pub fn exchange(&mut self, a: &str, b: &str) {
        let (a, b) = (self.column(a), self.column(b));
        self.rows.iter_mut().for_each(|row| row.swap(a, b));
    }

    /// From one row to before another a column keeps its value.
    pub fn hold(&mut self, name: &str, first: usize, end: usize) {
        let column = self.column(name);
        let held = self.rows[first][column].clone();
        self.rows[first..end].iter_mut().for_each(|row| row[column].clone_from(&held));
    }

    /// Rows in an order that is the same in every run of the test.
    pub fn shuffle(&mut self, seed: u64) {
        let mut state = seed;
        for k in (1..self.rows.len()).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            self.rows.swap(k, (state >> 33) as usize % (k + 1));
        }
    }

    pub fn replace(&mut self, from: &str, to: &str) {
        assert!(self.setup.contains(from), "{from}");
        self.setup = self.setup.replace(from, to);
    }

    pub fn open(&self) -> trunnion::Experiment {
        self.read(self.text().as_bytes()).unwrap()
    }

    pub fn text(&self) -> String {
        let rows: Vec<String> = self.rows.iter().map(|row| row.join(",")).collect();
        format!("{}\n{}\n", self.header.join(","), rows.join("\n"))
    }

    /// A points file of these bytes with this setup; the reason names it without its folder.
    fn read(&self, points: &[u8]) -> Result<trunnion::Experiment, String> {
        let folder = tempfile::tempdir().unwrap();
        // The run is called after its folder.
        let own = folder.path().join("run");
        std::fs::create_dir(&own).unwrap();
        let path = own.join("points.csv");
        std::fs::write(&path, points).unwrap();
        std::fs::write(own.join("setup.toml"), &self.setup).unwrap();
        let within = format!("{}/", own.display());
        trunnion::open(&path).map_err(|error| trunnion::chain(&error).replace(&within, ""))
    }
}

type Mistake = (&'static str, fn(&mut Files), &'static [&'static str]);

/// What is spoilt, and what must be said of it.
const MISTAKES: [Mistake; 30] = [
    ("B and C exchanged", |f| f.exchange("b_deg", "c_deg"), &["follow the ball", "B and C exchanged"]),
    ("X and Z exchanged", |f| f.exchange("x_mm", "z_mm"), &["follow the ball", "X and Z exchanged"]),
    ("sense of B", |f| f.change("b_deg", |v| -v), &["follow the ball", "sense of B reversed"]),
    ("sense of C", |f| f.change("c_deg", |v| -v), &["follow the ball", "sense of C reversed"]),
    ("radians", |f| ["b_deg", "c_deg"].into_iter().for_each(|c| f.change(c, f64::to_radians)), &["radians"]),
    ("inches", |f| ["x_mm", "y_mm", "z_mm"].into_iter().for_each(|c| f.change(c, |v| v / 25.4)), &["inches"]),
    ("metres", |f| ["x_mm", "y_mm", "z_mm"].into_iter().for_each(|c| f.change(c, |v| v / 1e3)), &["metres"]),
    ("another machine", |f| f.replace("\"table-bc\"", "\"head-bc\""), &["another machine, table-bc"]),
    ("ball elsewhere", |f| f.replace("[150", "[15"), &["position of the ball of setup low", "[150.0, "]),
    (
        "positions not updated",
        |f| ["b_deg", "c_deg"].into_iter().for_each(|c| f.hold(c, 100, 150)),
        &["elsewhere they do", "B and C stays the same"],
    ),
    (
        "one pose late",
        |f| {
            let columns = READINGS.map(|name| f.column(name));
            for k in (1..f.rows.len()).rev() {
                for column in columns {
                    f.rows[k][column] = f.rows[k - 1][column].clone();
                }
            }
        },
        &["do not fit their positions", "one pose late"],
    ),
    ("sign of a probe", |f| f.change("dy_um", |v| -v), &["sign of the readings dy reversed"]),
    ("probes exchanged", |f| f.exchange("dx_um", "dz_um"), &["dx and dz exchanged"]),
    ("dead probe", |f| f.change("dz_um", |_| 1.5), &["probe dz reads the same value"]),
    (
        "every probe reads 5.00",
        |f| READINGS.into_iter().for_each(|c| f.change(c, |_| 5.0)),
        &["rows 1 to 168 the probe dx and the probe dy and the probe dz each read the same value"],
    ),
    (
        "a probe sticks from row 151 on",
        |f| f.hold("dy_um", 150, 336),
        &["in rows 169 to 336 the probe dy reads the same value in every digit"],
    ),
    (
        "a probe sticks for a while",
        |f| f.hold("dz_um", 100, 130),
        &["in rows 101 to 130 the probe dz reads the same value in every digit"],
    ),
    (
        "thousandths of an inch under µm",
        |f| READINGS.into_iter().for_each(|c| f.change(c, |v| v / 25.4)),
        &["repeat within 0.012 µm", "too small", "25.4"],
    ),
    (
        "a wrong zero of B",
        |f| f.change("b_deg", |v| v + 10.0),
        &["every position of B changed by −10.0°", "constant offset"],
    ),
    (
        "a wrong zero of C",
        |f| f.change("c_deg", |v| v + 90.0),
        &["every position of C changed by −90.0°", "constant offset"],
    ),
    (
        "a wrong zero of X",
        |f| f.change("x_mm", |v| v + 25.0),
        &["every position of X changed by −25.0 mm", "constant offset"],
    ),
    ("rows shuffled", |f| f.shuffle(1), &["in no order of time", "shuffled"]),
    ("rows shuffled otherwise", |f| f.shuffle(2), &["in no order of time", "shuffled"]),
    (
        "mm under µm",
        |f| READINGS.into_iter().for_each(|c| f.change(c, |v| v / 1e3)),
        &["too small", "factor 1000"],
    ),
    (
        "nothing but noise",
        |f| {
            let mut state = 1_u64;
            for (k, row) in f.rows.iter_mut().enumerate() {
                for name in READINGS {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k as u64 | 1);
                    let at = f.header.iter().position(|column| column == name).unwrap();
                    row[at] = format!("{:.2}", (state >> 40) as f64 / f64::from(1 << 24) * 60.0 - 30.0);
                }
            }
        },
        &["nothing but noise", "do not depend on the pose"],
    ),
    (
        "nest on the other side",
        |f| f.replace("nest = \"table\"", "nest = \"spindle\""),
        &["nest on the table"],
    ),
    ("rows reversed in time", |f| f.change("time_s", |v| 1e5 - v), &["time runs backward"]),
    ("milliseconds", |f| f.change("time_s", |v| v * 1e3), &["days, which is too long", "milliseconds"]),
    ("rows twice", |f| f.rows.extend(f.rows.clone()), &["336 of 672 points are copies"]),
    (
        "setups exchanged",
        |f| {
            f.replace("\"low\"", "\"@\"");
            f.replace("\"high\"", "\"low\"");
            f.replace("\"@\"", "\"high\"");
        },
        &["setups high and low exchanged"],
    ),
];

/// What is said of points: finding and what to do.
fn said(run: &trunnion::Experiment) -> String {
    let found = run.check().plausibility;
    found.iter().map(|one| format!("{} {}", one.finding, one.hypothesis)).collect::<Vec<_>>().join(" ")
}

/// A row of the table: named where the mistake that was found is one to be undone.
fn row(mistake: &str, said: &str) -> String {
    let to_do =
        ["Change it?", "change what differs", "import them as a run of their own", "with a longer dwell"];
    let is_named = to_do.iter().any(|words| said.contains(words));
    let becomes = if is_named { "named" } else { "doubted" };
    format!("| {mistake} | {becomes} | {} |\n", said.replace('|', "/").replace('\n', " "))
}

#[test]
fn every_gross_mistake_is_refused_read_named_or_doubted() {
    let mut table = String::from("| mistake | becomes | in the words of the program |\n|---|---|---|\n");
    for (name, spoil, expected) in MISTAKES {
        let mut files = Files::committed("points-gravity");
        spoil(&mut files);
        let text = said(&files.open());
        assert!(expected.iter().all(|words| text.contains(words)), "{name}: {expected:?} in: {text}");
        table += &row(name, &text);
    }
    for (name, set, spoil, expected) in PROBES.into_iter().chain(ROWS).chain(BLOCKS).chain(LIKENESSES) {
        let mut files = Files::committed(set);
        spoil(&mut files);
        let text = said(&files.open());
        assert!(expected.iter().all(|words| text.contains(words)), "{name}: {expected:?} in: {text}");
        table += &row(name, &text);
    }
    for (name, cycle, spoil, expected) in BARS {
        let mut files = bar(cycle);
        assert_eq!(said(&files.open()), "", "{name}");
        // A reading that crosses zero shows it for a while in coarse steps.
        let mut coarse = bar(cycle);
        coarse.change("dr_um", |um| (4.0 * um).round() / 4.0);
        assert_eq!(said(&coarse.open()), "", "{name}, in steps of 0.25 µm");
        spoil(&mut files);
        let text = said(&files.open());
        assert!(expected.iter().all(|words| text.contains(words)), "{name}: {expected:?} in: {text}");
        table += &row(&format!("ball bar: {name}"), &text);
    }
    let good = Files::committed("points-gravity").open();
    for (name, spoil, becomes) in FILES {
        let mut files = Files::committed("points-gravity");
        let bytes = spoil(&mut files);
        match (files.read(&bytes), becomes) {
            (Ok(run), Becomes::Read) => {
                assert_eq!(run.runs()[0].points, good.runs()[0].points, "{name}");
                table += &format!("| {name} | read | |\n");
            }
            (Err(why), Becomes::Refused(expected)) => {
                assert!(expected.iter().all(|words| why.contains(words)), "{name}: {expected:?} in: {why}");
                table += &format!("| {name} | refused | {} |\n", shortened(&why));
            }
            (Ok(_), Becomes::Refused(_)) => panic!("{name} was read"),
            (Err(why), Becomes::Read) => panic!("{name}: {why}"),
        }
    }
    write_or_compare("docs/measured/mistakes.md", "mistakes", &table);
}

/// Positions of the machine's own zero: half a metre off, the fit does not converge.
#[test]
fn a_fit_that_does_not_converge_says_what_is_wrong_with_the_runs() {
    let mut files = Files::committed("points-nothing-hidden");
    for (axis, offset) in [("x_mm", 312.4), ("y_mm", -201.7), ("z_mm", -455.2)] {
        files.change(axis, |mm| mm + offset);
    }
    let run = files.open();
    let why = run.fit(&run.base_model()).err().expect("no fit").to_string();
    assert!(why.contains("the axes do not follow the ball") && why.contains("Change it?"), "{why}");
}

/// The first two lines of a refusal in one cell.
fn shortened(why: &str) -> String {
    let lines: Vec<&str> = why.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let more = if lines.len() > 2 { " …" } else { "" };
    lines.iter().take(2).copied().collect::<Vec<_>>().join(" ").replace('|', "/") + more
}
