//! LinuxCNC's own interpreter runs the NC program of every shipped cycle; its canonical motions visit our poses.

use crate::interpreter::Event;
use crate::visited::visited;
use std::path::Path;
use std::process::Command;
use trunnion_core::{AxisValues, Joint};
use trunnion_cycles::CourseRules;
use trunnion_cycles::Cycle;
use trunnion_cycles::nc::{Program, dialect};
use trunnion_machine::shipped;
use trunnion_tests::workspace_root;

/// The interpreter prints positions to four decimals of a millimetre or degree.
const PRINTED_DECIMALS: usize = 4;

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn linuxcnc_runs_every_shipped_cycle_through_its_poses() {
    let mut tested = 0;
    for entry in std::fs::read_dir(workspace_root().join("config/cycles")).unwrap() {
        let path = entry.unwrap().path();
        let cycle = Cycle::parse("c.toml", &std::fs::read_to_string(&path).unwrap()).unwrap();
        if shipped::machine(&cycle.machine).is_some_and(|machine| machine.tripod.is_some()) {
            // No program moves legs one by one.
            continue;
        }
        if cycle.touches() || cycle.named_joint().is_some() {
            // The controller's own probing cycles, and joints that no program turns.
            continue;
        }
        let (points, stops) = check(&cycle);
        println!("{}: {points} points visited, {stops} stops", cycle.name);
        tested += 1;
    }
    assert!(tested >= 7, "{tested} cycles");
}

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn linuxcnc_refuses_what_is_no_program() {
    let folder = tempfile::tempdir().unwrap();
    let (done, _, reported) = interpret(folder.path(), "G1 X1 F0\nM2\n");
    assert!(!done && reported.contains("zero feed rate"), "{reported}");
}

/// Number of points visited and of stops.
fn check(cycle: &Cycle) -> (usize, usize) {
    let machine = shipped::machine(&cycle.machine).expect("shipped cycles are for shipped machines");
    let rules = CourseRules::default();
    let program = Program::of_cycle(cycle, &machine, &rules).unwrap();
    let linuxcnc = dialect("linuxcnc").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (done, printed, reported) = interpret(folder.path(), &(linuxcnc.write)(&program, linuxcnc.decimals));
    assert!(done, "{}: {reported}", cycle.name);
    let events = canonical(&printed);
    visited(&events, cycle, &machine, &rules, PRINTED_DECIMALS, &|i| format!("{}, point {i}", cycle.name));
    let points = cycle.visits(&machine, &rules.pace).unwrap().states.len();
    (points, events.iter().filter(|event| matches!(event, Event::Stop(_))).count())
}

/// Runs the stand-alone interpreter with a tool of no length and an empty parameter file: success, canonical commands, errors.
fn interpret(folder: &Path, program: &str) -> (bool, String, String) {
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let output = Command::new("rs274")
        .arg("-g")
        .arg("-t")
        .arg(file("tool.tbl", "T1 P1 Z0 D0\n"))
        .arg("-v")
        .arg(file("parameters.var", &parameters()))
        .arg(file("program.ngc", program))
        .output()
        .expect("rs274 of linuxcnc-uspace is installed by tests/peers/run");
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.success(), text(output.stdout), text(output.stderr))
}

/// The parameters that RS274/NGC keeps in its file: no offsets at all, first coordinate system.
fn parameters() -> String {
    let systems = (0..9).flat_map(|system| (1..=10).map(move |k| 5220 + 20 * system + k));
    let zeros = (5161..=5169).chain(5181..=5189).chain(5210..=5219).chain(systems);
    let line = |(number, value)| format!("{number} {value}\n");
    let mut numbers: Vec<(u32, u32)> = zeros.map(|number| (number, 0)).chain([(5220, 1)]).collect();
    numbers.sort_unstable();
    numbers.into_iter().map(line).collect()
}

/// What moves or waits in the canonical commands; positions in mm and degrees.
fn canonical(printed: &str) -> Vec<Event> {
    let (mut per_min, mut at) = (0.0, AxisValues::<f64>::default());
    let (mut events, mut ended) = (Vec::new(), false);
    for line in printed.lines() {
        // "   34 N..... STRAIGHT_FEED(0.0000, …)"
        let Some((name, rest)) = line.split_once("N..... ").and_then(|(_, command)| command.split_once('('))
        else {
            panic!("not a canonical command: {line}");
        };
        let numbers = || -> Vec<f64> {
            rest.trim_end_matches(')').split(", ").map(|number| number.parse().unwrap()).collect()
        };
        match name {
            "SET_FEED_RATE" => per_min = numbers()[0],
            "STRAIGHT_FEED" => {
                let place = numbers();
                let to = AxisValues::from_fn(|slot| place.get(slot.index()).copied().unwrap_or(0.0));
                events.push(Event::Move { to, seconds: seconds(&at, &to, per_min) });
                at = to;
            }
            "STRAIGHT_TRAVERSE" | "ARC_FEED" => panic!("our programs have no such motion: {line}"),
            "DWELL" => events.push(Event::Dwell { seconds: numbers()[0] }),
            "PROGRAM_STOP" => events.push(Event::Stop(String::new())),
            "PROGRAM_END" => ended = true,
            _ => {}
        }
    }
    assert!(ended, "the program does not end");
    events
}

/// Canonical feed is along the path of the linear axes, or of the rotary ones when those alone move.
fn seconds(from: &AxisValues<f64>, to: &AxisValues<f64>, per_min: f64) -> f64 {
    let way = |letters: [Joint; 3]| letters.map(|l| to[l] - from[l]).into_iter().fold(0.0, f64::hypot);
    let linear = way(Joint::LINEAR);
    60.0 * if linear > 0.0 { linear } else { way(Joint::ROTARY) } / per_min
}
