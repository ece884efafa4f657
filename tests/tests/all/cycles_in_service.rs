//! Cycles through the service: three probes on serial lines, or the encoder of a ball bar (CiA 406) behind a serial CAN adapter, the program in
//! an MTConnect controller, and what comes out against the virtual machine. docs/measured/live-cycles.md is written from these runs.

use crate::cycle_program::CycleProgram;
use crate::service::measured;
use std::path::Path;
use std::sync::Arc;
use trunnion_core::{Point, State};
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::mtconnect::Shown;
use trunnion_hil_sim::devices::{Later, SimulatedCell};
use trunnion_hil_sim::{Truth, VirtualMachine};
use trunnion_machine::{Machine, shipped};
use trunnion_tests::schemes::judged::{Found, found as found_in, injected};
use trunnion_tests::section::{is_writing, write_or_compare};
use trunnion_tests::{mounted, workspace_root};

/// A cycle that ships, at a feed at which a test can wait for it, and what it must tell of the machine.
struct Case {
    cycle: &'static str,
    /// What its file says, and what is measured instead.
    quicker: (&'static str, &'static str),
    identifies: &'static [&'static str],
}

/// At which a test can wait for the cycles that turn one axis.
const TENFOLD: (&str, &str) = ("feeds_deg_per_min = [360]", "feeds_deg_per_min = [3600]");
const FIVEFOLD: (&str, &str) = ("feeds_deg_per_min = [720]", "feeds_deg_per_min = [3600]");
const fn as_shipped(line: &'static str) -> (&'static str, &'static str) {
    (line, line)
}
/// Of a cycle at rest: two windows of half a second each are more than the noise of the probes asks for.
const SHORT_STOPS: (&str, &str) = ("window_s = 0.5", "window_s = 0.1");

const R_TESTS: [Case; 5] = [
    Case {
        cycle: "r-test-static",
        quicker: SHORT_STOPS,
        identifies: &["EX0B", "EZ0B", "EA0B", "EB0B", "EC0B", "EX0C", "EY0C", "EA0C"],
    },
    Case {
        cycle: "r-test-head-a-table-c",
        quicker: SHORT_STOPS,
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C", "EB0A", "EC0A"],
    },
    Case { cycle: "r-test-head-bc", quicker: SHORT_STOPS, identifies: &["EA0C", "EB0C", "EX0B", "EA0B"] },
    Case {
        cycle: "r-test-sweep-c",
        quicker: as_shipped("feeds_deg_per_min = [1800, 3600]"),
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C"],
    },
    Case {
        cycle: "r-test-sweep-b",
        quicker: as_shipped("feeds_deg_per_min = [1200, 2400]"),
        identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"],
    },
];

const BARS: [Case; 11] = [
    Case { cycle: "bk1-b", quicker: TENFOLD, identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"] },
    Case { cycle: "bk1-a", quicker: TENFOLD, identifies: &["EY0A", "EZ0A", "EB0A", "EC0A"] },
    Case { cycle: "bk2-c", quicker: TENFOLD, identifies: &["EX0C", "EY0C", "EA0C", "EB0C"] },
    Case { cycle: "bk3-bc", quicker: TENFOLD, identifies: &["EX0C", "EA0C", "EA0B", "EC0B"] },
    Case {
        cycle: "bk4-cone",
        quicker: ("feeds_mm_per_min = [1000]", "feeds_mm_per_min = [6000]"),
        identifies: &["EX0B", "EX0C"],
    },
    // One direction of a bar of unknown length: the settings of both balls take up every location error of C.
    Case { cycle: "ball-bar-c", quicker: as_shipped("feeds_deg_per_min = [1800, 3600]"), identifies: &[] },
    Case { cycle: "s4-b", quicker: FIVEFOLD, identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"] },
    Case { cycle: "s4-c", quicker: FIVEFOLD, identifies: &["EX0C", "EY0C", "EA0C", "EB0C"] },
    Case { cycle: "head-b", quicker: TENFOLD, identifies: &["EA0B", "EC0B"] },
    Case { cycle: "head-c", quicker: TENFOLD, identifies: &["EA0C", "EB0C"] },
    Case {
        cycle: "circle-xy",
        quicker: ("feeds_mm_per_min = [1000]", "feeds_mm_per_min = [6000]"),
        identifies: &["EC0Y"],
    },
];

/// The floor is on before the program begins, s.
pub const LATER_S: f64 = 3.0;
/// An operator who is quick, s.
pub const OPERATOR_S: f64 = 1.0;
/// White noise of a sample of the bar, mm.
const NOISE_MM: f64 = 0.2e-3;
/// What the bar shows while nobody has put it in, mm.
const FREE_MM: f64 = 1.5;
/// What probes show while the ball is elsewhere: inside their range, so that nothing but the program says that nothing is measured, mm.
const NO_BALL_MM: f64 = 0.5;
/// At a pose, s: two windows, and the time until the probes stand.
const POSE_S: f64 = 0.35;
/// Share of the samples sent, or of the poses planned, that must become points.
const LEAST_USED: f64 = 0.95;
/// Formed readings against those of the machine at their positions (rms), mm. Noise leaves 0.2 µm; 0.1 ms between bar and axes
/// costs less than 0.1 µm here.
const MOST_OFF_MM: f64 = 0.5e-3;
/// Its machine has no motions of its axes: what C of a head does once per turn is, by definition (ISO 230-7), the offset of the spindle from it,
/// which is what this cycle sees of B. With them EY0B is 0.35 µm off the injected one.
const WITHOUT_MOTIONS: &str = "head-c";
/// What a machine without rotary axes has to be found, as a truth file says it.
const SQUARENESS: &str = "[[hidden]]\nid = \"squareness:XY\"\namplitude = 3e-5\nshape = { sign = 1.0 }\n";
/// As for the schemes that are simulated without ports: [schemes](../../../docs/measured/schemes.md).
const ALLOWED_U: f64 = 4.5;
/// What the linear uncertainty leaves out: errors of second order, in the last printed digit.
const SECOND_ORDER: f64 = 0.01;

/// The cone moves all five axes, and its points are formed along a curve: what the others need it needs too.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_cone_behind_an_slcan_adapter_ends_in_the_values_of_the_machine() {
    let cone = BARS.iter().find(|case| case.cycle == "bk4-cone").unwrap();
    println!("{}", row(cone).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a quarter of an hour: tests/peers/run --long"]
async fn ball_bar_cycles_behind_an_slcan_adapter_end_in_the_values_of_the_machine() {
    table("ball bars in the service", &BARS).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a quarter of an hour: tests/peers/run --long"]
async fn r_tests_behind_serial_lines_end_in_the_values_of_the_machine() {
    table("R-tests in the service", &R_TESTS).await;
}

async fn table(section: &str, cases: &[Case]) {
    let mut table = String::from(
        "| cycle | at | samples sent, or poses | used | points | formed − true (rms) | values of the machine | worst |\n|---|---|---|---|---|---|---|---|\n",
    );
    let only = std::env::var("TRUNNION_LIVE_CYCLE").unwrap_or_default();
    let chosen: Vec<&Case> = cases.iter().filter(|case| case.cycle.contains(&only)).collect();
    assert!(!chosen.is_empty(), "TRUNNION_LIVE_CYCLE = {only}: no such cycle");
    for case in chosen {
        table += &row(case).await;
    }
    println!("{table}");
    // Figures differ from run to run with what else the computer does; what they must keep is asserted.
    if is_writing() && only.is_empty() {
        write_or_compare("docs/measured/live-cycles.md", section, &table);
    }
}

/// The floor of a program: a bar on the bus or three probes, and a controller that stops where the program does.
pub fn floor(folder: &Path, cycle: &Cycle, program: &CycleProgram, machine: &Machine) -> CellConfig {
    let mut floor = CellConfig::new(folder, 0);
    if cycle.setups.iter().all(|setup| setup.instrument.keeps_bar_length()) {
        floor.probes.clear();
    } else {
        floor.can = None;
    }
    let (agent, _) = floor.controller.as_mut().unwrap();
    agent.axes = machine.joints();
    let stop = |&(from_s, to_s): &(f64, f64)| Shown {
        from_s: LATER_S + from_s,
        to_s: LATER_S + to_s,
        execution: "PROGRAM_STOPPED",
    };
    agent.shown = program.stops_s.iter().map(stop).collect();
    floor
}

/// Measures a cycle; its line of the table.
async fn row(case: &Case) -> String {
    let path = workspace_root().join(format!("config/cycles/{}.toml", case.cycle));
    let shipped_text = std::fs::read_to_string(path).unwrap();
    assert!(shipped_text.contains(case.quicker.0), "{}", case.cycle);
    let text = shipped_text.replace(case.quicker.0, case.quicker.1);
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    let program = CycleProgram::of(&cycle, &machine, &quick(), OPERATOR_S);
    let duration_s = program.trajectory.duration_s();
    println!("{}: a program of {duration_s:.0} s", case.cycle);
    let mut truth = Truth::draw(&machine, &mounted(&cycle), &[], duration_s, 7).unwrap();
    if machine.rotary().is_empty() {
        truth = Truth::parse("truth.toml", &(truth.to_toml() + SQUARENESS)).unwrap();
    }
    if case.cycle == WITHOUT_MOTIONS {
        truth.noise.natural_motion_mm = 0.0;
    }
    let world = Arc::new(VirtualMachine::new(machine.clone(), truth.clone()).unwrap());
    let shop = |folder: &Path| {
        (
            Later { world: cell(case.cycle, &program, &world), by_s: LATER_S },
            floor(folder, &cycle, &program, &machine),
        )
    };
    let (_folder, paths) = measured(&text, 1, shop).await;

    let recording = trunnion::recording::read(&paths[0], &|_| Some(machine.clone()), None).unwrap();
    let check = trunnion::open(&paths[0]).unwrap().check();
    assert!(check.plausibility.is_empty(), "{check:?}");
    // A pause of the computer too short to spoil the run skips some degrees at this feed. A curve has no planned points.
    if let Some(planned) = check.complete.planned {
        assert!(check.complete.read as f64 >= LEAST_USED * planned as f64, "{check:?}");
    }
    let (sent, used) = match check.complete.samples.as_slice() {
        [samples] => {
            let live = trunnion_record::read_run(&paths[0], &|_| Some(machine.clone())).unwrap();
            let lost: u64 = live.gaps.iter().filter_map(|gap| gap.lost_samples).sum();
            println!("{}: {samples:?}, {lost} lost", case.cycle);
            (samples.all + lost, samples.used)
        }
        _ => (check.complete.planned.unwrap() as u64, check.complete.read as u64),
    };
    let used = used as f64 / sent as f64;
    assert!(used >= LEAST_USED, "{}: {used} of {sent} used: {:?}", case.cycle, check.complete);

    let points = &recording.run.points;
    let rms_mm = off_truth_mm(points, &cycle, &world);
    assert!(rms_mm < MOST_OFF_MM, "{}: {rms_mm} mm", case.cycle);

    let found = std::fs::read_to_string(paths[0].with_extension("identification.json")).unwrap();
    let found = found_in(&serde_json::from_str(&found).unwrap(), &injected(&truth.to_toml(), &[]));
    let (values, worst_u) = against_truth(case, &found);
    format!(
        "| `{}` | {} | {sent} | {:.1} % | {} | {:.2} µm | {values} | {worst_u:.1} u |\n",
        case.cycle,
        in_words(case.quicker.1),
        100.0 * used,
        points.len(),
        1e3 * rms_mm,
    )
}

/// Formed readings against those of the machine at their positions, rms, mm. Only changes are measured: each channel of a setup has a zero of its
/// own.
fn off_truth_mm(points: &[Point], cycle: &Cycle, world: &VirtualMachine) -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for (setup, of) in cycle.setups.iter().enumerate() {
        for channel in 0..of.instrument.components().len() {
            let own = points.iter().filter(|point| point.state.setup == setup);
            let off = |point: &Point| {
                point.reading_mm[channel] - world.ideal_reading_mm(setup, &point.state)[channel]
            };
            let off_mm: Vec<f64> = own.map(off).collect();
            assert!(!off_mm.is_empty(), "{}: nothing read of {}", cycle.name, of.name);
            let mean_mm = off_mm.iter().sum::<f64>() / off_mm.len() as f64;
            squares += off_mm.iter().map(|off_mm| (off_mm - mean_mm).powi(2)).sum::<f64>();
            count += off_mm.len();
        }
    }
    (squares / count as f64).sqrt()
}

/// Nothing can be hit here: the ways between the passes are short and quick, the passes are as the cycle asks.
pub fn quick() -> CourseRules {
    CourseRules {
        transfer_mm_per_s: 500.0,
        transfer_rad_per_s: 6.0,
        clearance_mm: 2.0,
        dwell_s: Some(POSE_S),
        ..CourseRules::default()
    }
}

/// What is measured, as the table shows it.
fn in_words(line: &str) -> String {
    let (key, value) = line.split_once(" = ").unwrap();
    let value = value.trim_matches(['[', ']']);
    match key {
        "feeds_deg_per_min" => format!("{value} °/min"),
        "feeds_mm_per_min" => format!("{value} mm/min"),
        "window_s" => format!("rest, windows of {value} s"),
        _ => panic!("{key}"),
    }
}

/// The machine under the program, with what is mounted.
pub fn cell(name: &str, program: &CycleProgram, world: &Arc<VirtualMachine>) -> SimulatedCell {
    let (along, setup_of_step) = (program.trajectory.clone(), program.setup_of_step.clone());
    let world = Arc::clone(world);
    // Nothing where no setup is mounted.
    let reading_mm = Arc::new(move |state: &State| {
        let step = along.at(state.time_s.unwrap_or_default()).step;
        setup_of_step[step].map(|setup| world.ideal_reading_mm(setup, state))
    });
    let of_bar_mm = Arc::clone(&reading_mm);
    SimulatedCell {
        program: name.into(),
        deflection_mm: Box::new(move |state| reading_mm(state).unwrap_or([NO_BALL_MM; 3])),
        bar_mm: Box::new(move |state| of_bar_mm(state).map_or(FREE_MM, |reading_mm| reading_mm[0])),
        noise_mm: NOISE_MM,
        seed: 7,
        ..SimulatedCell::along(program.trajectory.clone())
    }
}

/// What was asked for in words, and the farthest of all numbers of the machine from the injected ones in u.
fn against_truth(case: &Case, found: &[Found]) -> (String, f64) {
    let mut worst_u = 0f64;
    for one in found {
        let Found { name, value, u, expected, .. } = one;
        println!("{}: {name} = {value:.3} ± {u:.3}, injected {expected:.3}", case.cycle);
        let off = (value - expected).abs();
        assert!(off <= ALLOWED_U * u + SECOND_ORDER, "{}: {one:?}", case.cycle);
        worst_u = worst_u.max((off - SECOND_ORDER).max(0.0) / u);
    }
    let in_words = |Found { name, unit, value, u, expected }: &Found| {
        let unit = if unit == "urad" { "µrad" } else { "µm" };
        format!("{name} {value:.2} ± {u:.2} {unit} (injected {expected:.2})")
    };
    let asked = found.iter().filter(|one| case.identifies.contains(&one.name.as_str()));
    let values: Vec<String> = asked.map(in_words).collect();
    assert_eq!(values.len(), case.identifies.len(), "{}: {values:?} of {:?}", case.cycle, case.identifies);
    match values.as_slice() {
        [] => ("none is observable".into(), worst_u),
        values => (values.join(", "), worst_u),
    }
}
