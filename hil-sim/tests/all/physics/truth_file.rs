//! The sealed truth file.

use super::{RUN_S, low_and_high, setup, table_bc};
use trunnion_hil_sim::physics::{grid, simulate_points};
use trunnion_hil_sim::truth::minimum_set;
use trunnion_hil_sim::{HiddenChoice, Instrument, NestOn, SimSetup, Truth, VirtualMachine};
use trunnion_machine::shipped;

fn drawn() -> Truth {
    let mut setups = low_and_high();
    setups.push(setup("spindle", NestOn::Spindle, [0.0, 0.0, 100.0]));
    setups.push(SimSetup {
        instrument: Instrument::ball_bar(150.0),
        ..setup("bar", NestOn::Table, [0.0, 0.0, 50.0])
    });
    let hidden = ["gravity-sag:B", "squareness:ZX", "cable-drag:B", "thermal-drift"]
        .map(|id| HiddenChoice { id: id.into(), sigma: 1.2 });
    Truth::draw(&table_bc(), &setups, &hidden, RUN_S, u64::MAX - 3).unwrap()
}

#[test]
fn a_truth_written_and_read_gives_the_same_readings() {
    let truth = drawn();
    let read = Truth::parse("truth.toml", &truth.to_toml()).unwrap();
    assert_eq!(read.to_toml(), Truth::parse("truth.toml", &read.to_toml()).unwrap().to_toml());
    let states = grid::standard_bc(&table_bc(), &low_and_high());
    let points = |truth| simulate_points(&VirtualMachine::new(table_bc(), truth).unwrap(), &states);
    for (a, b) in points(truth).as_flattened().iter().zip(points(read).as_flattened()) {
        assert!((a - b).abs() < 1e-12);
    }
}

#[test]
fn a_wrong_truth_names_line_and_allowed_values() {
    let text = drawn().to_toml();
    let wrong = text
        .replace("\"gravity-sag:B\"", "\"gravity-sag:Q\"")
        .replace("nest = \"spindle\"", "nest = \"floor\"");
    let problems = Truth::parse("truth.toml", &wrong).unwrap_err();
    let shown = problems.to_string();
    assert_eq!(problems.0.len(), 2, "{shown}");
    assert!(
        shown.contains("table, spindle")
            && shown.contains("gravity-sag:B")
            && problems.0.iter().all(|p| p.line > 0)
    );
    let misspelt = text.replace("white_um", "whit_um");
    assert!(Truth::parse("truth.toml", &misspelt).unwrap_err().to_string().contains("whit_um"));
}

#[test]
fn location_errors_are_the_minimum_set() {
    let names = |machine: &str| -> Vec<String> {
        let mut names: Vec<_> =
            minimum_set(&shipped::machine(machine).unwrap()).into_iter().map(|error| error.name()).collect();
        names.sort();
        names
    };
    // docs/design/physics.md §2.3: eight for two rotary axes.
    assert_eq!(names("table-bc"), ["EA0B", "EA0C", "EB0B", "EC0B", "EX0B", "EX0C", "EY0C", "EZ0B"]);
    assert_eq!(names("table-ac"), ["EA0A", "EB0A", "EB0C", "EC0A", "EX0C", "EY0A", "EY0C", "EZ0A"]);
}

#[test]
fn a_truth_of_another_machine_is_refused() {
    let other = shipped::machine("table-ac").unwrap();
    let problem = VirtualMachine::new(other, drawn()).unwrap_err().to_string();
    assert!(problem.contains("table-bc") && problem.contains("table-ac"));
}
