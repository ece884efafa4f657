//! Runs for the tests: points files of the outside data, and the A-C path of the nine single-error tables.

use nalgebra::{Point3, Vector3};
use std::path::PathBuf;
use trunnion_core::axis::iso::{A, C};
use trunnion_core::{AxisValues, InstrumentKind, NestSide, Point, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_engine::Diagnosis;
use trunnion_machine::{Machine, shipped};
use trunnion_record::points_csv::import_files;

/// A file of the outside data: committed under tests/data, else next to the workspace; `None` when in neither place.
pub fn outside(name: &str) -> Option<String> {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    ["tests/data", "../shared/data"]
        .into_iter()
        .find_map(|folder| std::fs::read_to_string(workspace.join(folder).join(name)).ok())
}

/// A committed points folder.
pub fn points_run(folder: &str) -> Run {
    let text = |file: &str| outside(&format!("{folder}/{file}")).expect("committed data");
    let (points, setup) = (text("points.csv"), text("setup.toml"));
    import_files(folder, ("points.csv", &points), ("setup.toml", &setup), &shipped::machine)
        .expect("good files")
}

/// Effects that together explain what is left.
pub fn set(diagnosis: &Diagnosis) -> Vec<&str> {
    let mut ids: Vec<&str> = diagnosis.set.iter().map(|entry| entry.id.as_str()).collect();
    ids.sort_unstable();
    ids
}

pub fn point(state: State, reading_mm: [f64; 3]) -> Point {
    Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Default::default() }
}

pub fn run(name: &str, machine: Machine, setups: Vec<Setup>, points: Vec<Point>) -> Run {
    Run { name: name.into(), machine, kind: RunKind::Static, setups, channels: vec![], points }
}

/// The A-C table that turns by −A, −C.
pub fn table_ac_turning_back() -> Machine {
    let (name, text) = shipped::FILES.iter().find(|(name, _)| *name == "table-ac").expect("shipped");
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
