//! Runs for the tests: points files of the outside data, and the A-C path of the nine single-error tables.

use nalgebra::{Point3, Vector3};
use std::collections::HashMap;
use std::path::PathBuf;
use trunnion_machine::{Machine, State, shipped};
use trunnion_measurement::setup::parse_setup_file;
use trunnion_measurement::{InstrumentKind, NestSide, Point, Run, RunKind, Setup};
use trunnion_units::AxisLetter::{A, B, C};
use trunnion_units::{AxisLetter, AxisValues};

/// A file of the outside data: committed under tests/data, else beside the workspace; `None` when in neither place.
pub fn outside(name: &str) -> Option<String> {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    ["tests/data", "../shared/data"]
        .into_iter()
        .find_map(|folder| std::fs::read_to_string(workspace.join(folder).join(name)).ok())
}

/// A committed points folder on table-bc.
pub fn points_run(folder: &str) -> Run {
    let setup = outside(&format!("{folder}/setup.toml")).expect("committed data");
    let setups = parse_setup_file("setup.toml", &setup).expect("a good setup file").setups;
    let text = outside(&format!("{folder}/points.csv")).expect("committed data");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let points = lines
        .map(|line| {
            let row: HashMap<&str, &str> = header.iter().copied().zip(line.split(',')).collect();
            let number = |name: &str| row[name].parse::<f64>().expect("a number");
            let mut state = State {
                time_s: Some(number("time_s")),
                setup: setups.iter().position(|s| s.name == row["setup"]).expect("a known setup"),
                ..State::default()
            };
            for letter in AxisLetter::LINEAR {
                state.position[letter] = number(&format!("{}_mm", letter.lower()));
            }
            for letter in [B, C] {
                state.position[letter] = number(&format!("{}_deg", letter.lower())).to_radians();
                state.direction[letter] = number(&format!("direction_{}", letter.lower()));
            }
            let reading_mm = ["dx_um", "dy_um", "dz_um"].map(|name| number(name) / 1000.0);
            point(state, reading_mm)
        })
        .collect();
    let machine = shipped::machine("table-bc").expect("shipped");
    run(folder, machine, setups, points)
}

pub fn point(state: State, reading_mm: [f64; 3]) -> Point {
    Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Default::default() }
}

pub fn run(name: &str, machine: Machine, setups: Vec<Setup>, points: Vec<Point>) -> Run {
    Run { name: name.into(), machine, kind: RunKind::Static, setups, channels: vec![], points }
}

/// The A-C table that turns by −A, −C.
pub fn table_ac_turning_back() -> Machine {
    let (name, text) = shipped::FILES.into_iter().find(|(name, _)| *name == "table-ac").expect("shipped");
    let mut text = text.to_string();
    for letter in ["A", "C"] {
        let start = text.find(&format!("[axis.{letter}]")).expect("its table");
        let sense = start + text[start..].find("sense = 1").expect("its sense");
        text.replace_range(sense..sense + "sense = 1".len(), "sense = -1");
    }
    Machine::parse(name, "table-ac.toml", &text).expect("a good machine file")
}

/// A static R-test with the nest in the spindle on the A-C table.
pub fn run_ac(name: &str, ball_in_table_mm: Vector3<f64>, rows: &[([f64; 2], [f64; 3])]) -> Run {
    let machine = table_ac_turning_back();
    let ball = Point3::from(ball_in_table_mm);
    let setup = Setup::new("ball", InstrumentKind::RTest, NestSide::Spindle, ball);
    let points = rows
        .iter()
        .map(|&([a_deg, c_deg], reading_mm)| {
            let mut position = AxisValues::default();
            position[A] = a_deg.to_radians();
            position[C] = c_deg.to_radians();
            let position = machine.follow(&position, &ball).expect("three linear axes");
            point(State { position, ..State::default() }, reading_mm)
        })
        .collect();
    run(name, machine, vec![setup], points)
}
