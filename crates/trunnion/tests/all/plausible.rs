//! Gross mistakes of users are named before any physics is blamed, and good runs raise no doubt.

use std::path::PathBuf;
use trunnion::results::{DoubtReason, Verdict};

const SETS: [&str; 4] =
    ["points-gravity", "points-backlash-and-drift", "points-nothing-hidden", "points-unnamed"];

/// A points file with its setup, as text.
struct Files {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    setup: String,
}

impl Files {
    fn committed(set: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(set);
        let text = std::fs::read_to_string(folder.join("points.csv")).unwrap();
        let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let setup = std::fs::read_to_string(folder.join("setup.toml")).unwrap();
        Self { header, rows: lines.collect(), setup }
    }

    fn column(&self, name: &str) -> usize {
        self.header.iter().position(|column| column == name).unwrap()
    }

    fn change(&mut self, name: &str, change: impl Fn(f64) -> f64) {
        let column = self.column(name);
        for row in &mut self.rows {
            row[column] = format!("{:.7}", change(row[column].parse().unwrap()));
        }
    }

    fn exchange(&mut self, a: &str, b: &str) {
        let (a, b) = (self.column(a), self.column(b));
        self.rows.iter_mut().for_each(|row| row.swap(a, b));
    }

    fn replace(&mut self, from: &str, to: &str) {
        assert!(self.setup.contains(from), "{from}");
        self.setup = self.setup.replace(from, to);
    }

    fn open(&self) -> trunnion::Experiment {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let rows: Vec<String> = self.rows.iter().map(|row| row.join(",")).collect();
        std::fs::write(&path, format!("{}\n{}\n", self.header.join(","), rows.join("\n"))).unwrap();
        std::fs::write(folder.path().join("setup.toml"), &self.setup).unwrap();
        trunnion::open(&path).unwrap()
    }
}

type Mistake = (&'static str, fn(&mut Files), &'static [&'static str]);

/// What is spoilt, and what must be said of it.
const MISTAKES: [Mistake; 22] = [
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
        "positions stand still",
        |f| {
            for column in ["b_deg", "c_deg"].map(|name| f.column(name)) {
                let first = f.rows[100][column].clone();
                f.rows[100..150].iter_mut().for_each(|row| row[column].clone_from(&first));
            }
        },
        &["elsewhere they do", "B and C stays the same"],
    ),
    (
        "one pose late",
        |f| {
            let first = f.column("dx_um");
            for k in (1..f.rows.len()).rev() {
                for column in first..first + 3 {
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
        "mm under µm",
        |f| ["dx_um", "dy_um", "dz_um"].into_iter().for_each(|c| f.change(c, |v| v / 1e3)),
        &["too small", "factor 1000"],
    ),
    (
        "nothing but noise",
        |f| {
            let mut state = 1_u64;
            for (k, row) in f.rows.iter_mut().enumerate() {
                for column in 0..3 {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k as u64 | 1);
                    let at = f.header.iter().position(|name| name == "dx_um").unwrap() + column;
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
    (
        "directions never filled in",
        |f| ["direction_b", "direction_c"].into_iter().for_each(|c| f.change(c, |_| 1.0)),
        &["direction_b is always +1", "opposite way"],
    ),
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

#[test]
fn every_gross_mistake_is_named() {
    for (name, spoil, expected) in MISTAKES {
        let mut files = Files::committed("points-gravity");
        spoil(&mut files);
        let found = files.open().check().plausibility;
        let text: String = found.iter().map(|one| format!("{} {} ", one.finding, one.hypothesis)).collect();
        assert!(expected.iter().all(|words| text.contains(words)), "{name}: {expected:?} in: {text}");
    }
}

#[test]
fn good_runs_raise_no_doubt() {
    for set in SETS {
        assert_eq!(Files::committed(set).open().check().plausibility, [], "{set}");
    }
}

#[test]
fn what_is_not_plausible_is_not_judged_and_says_why_on_every_surface() {
    let mut files = Files::committed("points-gravity");
    files.change("c_deg", |angle| -angle);
    let run = files.open();
    let fit = run.fit(&run.base_model()).unwrap();
    let diagnosed = fit.diagnose().unwrap();
    let answer = diagnosed.results();
    assert_eq!((answer.verdict, answer.candidates.len()), (Verdict::NotJudged, 0));
    assert_eq!(diagnosed.best(), None);
    let page = fit.compare().page();
    for surface in [answer.why.as_str(), &diagnosed.summary(), &fit.summary(), &page] {
        let words = surface.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("the sense of C reversed"), "{surface}");
    }
}

#[test]
fn readings_ten_times_too_large_are_doubted_where_they_repeat() {
    let mut files = Files::committed("points-gravity");
    let doubts = |files: &Files| {
        let run = files.open();
        run.fit(&run.base_model()).unwrap().results().doubts
    };
    assert_eq!(doubts(&files), []);
    ["dx_um", "dy_um", "dz_um"].iter().for_each(|column| files.change(column, |value| 10.0 * value));
    let [doubt] = &doubts(&files)[..] else { panic!("one doubt") };
    assert_eq!(doubt.reason, DoubtReason::Scatter);
    assert!(
        doubt.words.contains("2.95 µm") && doubt.words.contains("units of the readings"),
        "{}",
        doubt.words
    );
}

#[test]
fn a_recording_given_twice_is_noticed() {
    let run = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-gravity/points.csv");
    let found = trunnion::open_all([&run, &run]).unwrap().check().plausibility;
    assert!(found.iter().any(|one| one.finding.contains("identical, reading by reading")), "{found:?}");
}
