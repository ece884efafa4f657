//! LinuxCNC's own interpreter runs the NC program of every shipped cycle; its canonical motions visit our poses.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::path::Path;
use std::process::Command;
use trunnion_machine::{State, shipped};
use trunnion_measurement::Cycle;
use trunnion_measurement::cycle::CourseRules;
use trunnion_report::nc::{Program, dialect};
use trunnion_tests::workspace_root;
use trunnion_units::{AxisLetter, AxisValues, convert};

/// The interpreter prints positions to four decimals of a millimetre or degree.
const PRINTED: f64 = 0.51e-4;
/// Farthest place from a rotary axis, mm.
const ARM_MM: f64 = 300.0;

/// A canonical command that moves or waits; positions in mm and degrees.
#[derive(Debug)]
enum Canon {
    /// Straight to a position at a feed, mm or degrees/min.
    Feed {
        to: AxisValues<f64>,
        per_min: f64,
    },
    Dwell {
        seconds: f64,
    },
    Stop,
    End,
}

#[test]
fn linuxcnc_runs_every_shipped_cycle_through_its_poses() {
    let mut tested = 0;
    for entry in std::fs::read_dir(workspace_root().join("config/cycles")).unwrap() {
        let path = entry.unwrap().path();
        let cycle = Cycle::parse("c.toml", &std::fs::read_to_string(&path).unwrap()).unwrap();
        if shipped::machine(&cycle.machine).is_some_and(|machine| machine.tripod.is_some()) {
            // No program moves legs one by one.
            continue;
        }
        let (points, stops) = check(&cycle);
        println!("{}: {points} points visited, {stops} stops", cycle.name);
        tested += 1;
    }
    assert!(tested >= 7, "{tested} cycles");
}

#[test]
fn linuxcnc_refuses_what_is_no_program() {
    let folder = tempfile::tempdir().unwrap();
    let (done, _, told) = interpret(folder.path(), "G1 X1 F0\nM2\n");
    assert!(!done && told.contains("zero feed rate"), "{told}");
}

/// Number of points visited and of stops.
fn check(cycle: &Cycle) -> (usize, usize) {
    let machine = shipped::machine(&cycle.machine).expect("shipped cycles are for shipped machines");
    let rules = CourseRules::default();
    let program = Program::of_cycle(cycle, &machine, &rules).unwrap();
    let linuxcnc = dialect("linuxcnc").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (done, printed, told) = interpret(folder.path(), &(linuxcnc.write)(&program, linuxcnc.decimals));
    assert!(done, "{}: {told}", cycle.name);
    let canon: Vec<Canon> = canonical(&printed);
    assert!(matches!(canon.last(), Some(Canon::End)), "{} does not end", cycle.name);
    let states = cycle.visits(&machine, &rules.pace).unwrap().states;
    match cycle.settle() {
        Some(settle) => stands(&canon, &states, rules.pace.settle_s + 2.0 * settle.window_s, &cycle.name),
        None => passes(&canon, &states, rules.chord_mm, &cycle.name),
    }
    (states.len(), canon.iter().filter(|command| matches!(command, Canon::Stop)).count())
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

fn canonical(printed: &str) -> Vec<Canon> {
    let mut per_min = 0.0;
    let mut commands = Vec::new();
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
                let at = numbers();
                commands.push(Canon::Feed { to: AxisValues::from_fn(|letter| at[letter as usize]), per_min });
            }
            "STRAIGHT_TRAVERSE" | "ARC_FEED" => panic!("our programs have no such motion: {line}"),
            "DWELL" => commands.push(Canon::Dwell { seconds: numbers()[0] }),
            "PROGRAM_STOP" => commands.push(Canon::Stop),
            "PROGRAM_END" => commands.push(Canon::End),
            _ => {}
        }
    }
    commands
}

fn stands(canon: &[Canon], states: &[State], dwell_s: f64, name: &str) {
    let mut at = AxisValues::<f64>::default();
    let mut poses = states.iter().enumerate();
    for command in canon {
        match command {
            Canon::Feed { to, .. } => at = *to,
            Canon::Dwell { seconds } if (seconds - dwell_s).abs() < 1e-3 => {
                let (i, state) = poses.next().unwrap_or_else(|| panic!("{name}: more dwells than poses"));
                for letter in AxisLetter::ALL {
                    let off = (at[letter] - edge(state, letter)).abs();
                    assert!(off <= PRINTED, "{name}, pose {i}: {letter} is {off} off");
                }
            }
            Canon::Dwell { .. } | Canon::Stop | Canon::End => {}
        }
    }
    assert_eq!(poses.next(), None, "{name}: a pose without dwell");
}

fn passes(canon: &[Canon], states: &[State], chord_mm: f64, name: &str) {
    let mut at = AxisValues::<f64>::default();
    let mut pieces = Vec::new();
    for command in canon {
        if let Canon::Feed { to, per_min } = command {
            pieces.push((at, *to, seconds(&at, to, *per_min)));
            at = *to;
        }
    }
    let mut next = 0;
    for (i, state) in states.iter().enumerate() {
        let turning = AxisLetter::ROTARY.into_iter().find(|&letter| state.velocity[letter] != 0.0).unwrap();
        let found = (next..pieces.len()).find(|&k| {
            let (from, to, seconds) = &pieces[k];
            let travel = to[turning] - from[turning];
            let u = (edge(state, turning) - from[turning]) / travel;
            let speed = convert::rad_from_deg(travel) / seconds / state.velocity[turning];
            let near_mm = chord_mm + PRINTED * (1.0 + convert::rad_from_deg(ARM_MM));
            let off = |letter: AxisLetter| {
                (from[letter] + (to[letter] - from[letter]) * u - edge(state, letter)).abs()
            };
            (-0.01..=1.01).contains(&u)
                && (speed - 1.0).abs() <= 0.002 + 4.0 * PRINTED / travel.abs()
                && AxisLetter::ALL.into_iter().all(|letter| off(letter) <= near_mm)
        });
        next = found.unwrap_or_else(|| panic!("{name}: point {i} is never passed: {:?}", state.position));
    }
}

/// Canonical feed is along the path of the linear axes, or of the rotary ones when those alone move.
fn seconds(from: &AxisValues<f64>, to: &AxisValues<f64>, per_min: f64) -> f64 {
    let way = |letters: [AxisLetter; 3]| letters.map(|l| to[l] - from[l]).into_iter().fold(0.0, f64::hypot);
    let linear = way(AxisLetter::LINEAR);
    60.0 * if linear > 0.0 { linear } else { way(AxisLetter::ROTARY) } / per_min
}

/// Position in mm or degrees.
fn edge(state: &State, letter: AxisLetter) -> f64 {
    let position = state.position[letter];
    if letter.is_rotary() { convert::deg_from_rad(position) } else { position }
}
