//! Ball-bar cycles through the service: the encoder of the bar (CiA 406) behind a serial CAN adapter, the program in an MTConnect
//! controller, and what comes out against the virtual machine. docs/measured/bars.md is written from these runs.

use crate::bar_program::{BarProgram, mounted};
use crate::service::measured;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::mtconnect::Shown;
use trunnion_hil_sim::devices::{Later, SimulatedCell};
use trunnion_hil_sim::truth::minimum_set;
use trunnion_hil_sim::{Truth, VirtualMachine};
use trunnion_machine::{Machine, shipped};
use trunnion_tests::carried::carried;
use trunnion_tests::section::{is_writing, write_or_compare};
use trunnion_tests::workspace_root;

/// A cycle that ships, at a feed at which a test can wait for it, and what it must tell of the machine.
struct Case {
    cycle: &'static str,
    feed: (&'static str, &'static str),
    identifies: &'static [&'static str],
}

/// At which a test can wait for the cycles that turn one axis.
const TENFOLD: (&str, &str) = ("feeds_deg_per_min = [360]", "feeds_deg_per_min = [3600]");
const FIVEFOLD: (&str, &str) = ("feeds_deg_per_min = [720]", "feeds_deg_per_min = [3600]");
const AS_SHIPPED: (&str, &str) = ("feeds_deg_per_min = [1800, 3600]", "feeds_deg_per_min = [1800, 3600]");

const CASES: [Case; 8] = [
    Case { cycle: "bk1-b", feed: TENFOLD, identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"] },
    Case { cycle: "bk1-a", feed: TENFOLD, identifies: &["EY0A", "EZ0A", "EB0A", "EC0A"] },
    Case { cycle: "bk2-c", feed: TENFOLD, identifies: &["EX0C", "EY0C", "EA0C", "EB0C"] },
    Case { cycle: "bk3-bc", feed: TENFOLD, identifies: &["EX0C", "EA0C", "EA0B", "EC0B"] },
    Case {
        cycle: "bk4-cone",
        feed: ("feeds_mm_per_min = [1000]", "feeds_mm_per_min = [6000]"),
        identifies: &["EX0B", "EX0C"],
    },
    // One direction of a bar of unknown length: the settings of both balls take up every location error of C.
    Case { cycle: "ball-bar-c", feed: AS_SHIPPED, identifies: &[] },
    Case { cycle: "s4-b", feed: FIVEFOLD, identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"] },
    Case { cycle: "s4-c", feed: FIVEFOLD, identifies: &["EX0C", "EY0C", "EA0C", "EB0C"] },
];

/// The floor is on before the program begins, s.
pub const LATER_S: f64 = 3.0;
/// An operator who is quick, s.
pub const OPERATOR_S: f64 = 1.0;
/// White noise of a sample of the bar, mm.
const NOISE_MM: f64 = 0.2e-3;
/// What the bar shows while nobody has put it in, mm.
const FREE_MM: f64 = 1.5;
/// Share of the samples sent that must become points.
const LEAST_USED: f64 = 0.95;
/// Formed readings against those of the machine at their positions (rms), mm. Noise leaves 0.2 µm; 0.1 ms between bar and axes
/// costs less than 0.1 µm here.
const MOST_OFF_MM: f64 = 0.5e-3;
/// As for the schemes that are simulated without ports: [schemes](../../../docs/measured/schemes.md).
const ALLOWED_U: f64 = 4.5;
/// What the linear uncertainty leaves out: errors of second order, in the last printed digit.
const SECOND_ORDER: f64 = 0.01;

/// The cone moves all five axes, and its points are formed along a curve: what the others need it needs too.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_cone_behind_an_slcan_adapter_ends_in_the_values_of_the_machine() {
    let cone = CASES.iter().find(|case| case.cycle == "bk4-cone").unwrap();
    println!("{}", row(cone).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a quarter of an hour: tests/peers/run --long"]
async fn ball_bar_cycles_behind_an_slcan_adapter_end_in_the_values_of_the_machine() {
    let mut table = String::from(
        "| cycle | at | samples sent | used | points | formed − true (rms) | values of the machine | worst |\n|---|---|---|---|---|---|---|---|\n",
    );
    let only = std::env::var("TRUNNION_BAR_CYCLES").unwrap_or_default();
    let chosen: Vec<&Case> = CASES.iter().filter(|case| case.cycle.contains(&only)).collect();
    assert!(!chosen.is_empty(), "TRUNNION_BAR_CYCLES = {only}: no such cycle");
    for case in chosen {
        table += &row(case).await;
    }
    println!("{table}");
    // Figures differ from run to run with what else the computer does; what they must keep is asserted.
    if is_writing() && only.is_empty() {
        write_or_compare("docs/measured/bars.md", "bars in the service", &table);
    }
}

/// The floor of a program: a bar on the bus and no probes, and a controller that stops where the program does.
pub fn floor(folder: &Path, program: &BarProgram, machine: &Machine) -> CellConfig {
    let mut floor = CellConfig { probes: Vec::new(), ..CellConfig::new(folder, 0) };
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
    assert!(shipped_text.contains(case.feed.0), "{}", case.cycle);
    let text = shipped_text.replace(case.feed.0, case.feed.1);
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    let program = BarProgram::of(&cycle, &machine, &quick(), OPERATOR_S);
    let duration_s = program.trajectory.duration_s();
    println!("{}: a program of {duration_s:.0} s", case.cycle);
    let truth = Truth::draw(&machine, &mounted(&cycle), &[], duration_s, 7).unwrap();
    let world = Arc::new(VirtualMachine::new(machine.clone(), truth.clone()).unwrap());
    let shop = |folder: &Path| {
        (
            Later { world: cell(case.cycle, &program, &world), by_s: LATER_S },
            floor(folder, &program, &machine),
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
    let live = trunnion_record::read_run(&paths[0], &|_| Some(machine.clone())).unwrap();
    let lost: u64 = live.gaps.iter().filter_map(|gap| gap.lost_samples).sum();
    let samples = &check.complete.samples[0];
    let (sent, used) = (samples.all + lost, samples.used as f64 / (samples.all + lost) as f64);
    println!("{}: {samples:?}, {lost} lost", case.cycle);
    assert!(used >= LEAST_USED, "{}: {used} of {sent} samples used, {lost} lost: {samples:?}", case.cycle);

    let mut squares = 0.0;
    for setup in 0..cycle.setups.len() {
        let mine = recording.run.points.iter().filter(|point| point.state.setup == setup);
        let off_mm: Vec<f64> =
            mine.map(|p| p.reading_mm[0] - world.ideal_reading_mm(setup, &p.state)[0]).collect();
        assert!(!off_mm.is_empty(), "{}: nothing read of {}", case.cycle, cycle.setups[setup].name);
        // Only changes are measured: each setup has a zero of its own.
        let mean_mm = off_mm.iter().sum::<f64>() / off_mm.len() as f64;
        squares += off_mm.iter().map(|off_mm| (off_mm - mean_mm).powi(2)).sum::<f64>();
    }
    let points = recording.run.points.len();
    let rms_mm = (squares / points as f64).sqrt();
    assert!(rms_mm < MOST_OFF_MM, "{}: {rms_mm} mm", case.cycle);

    let found = std::fs::read_to_string(paths[0].with_extension("identification.json")).unwrap();
    let (values, worst_u) = against_truth(case, &serde_json::from_str(&found).unwrap(), &machine, &truth);
    format!(
        "| `{}` | {} | {sent} | {:.1} % | {points} | {:.2} µm | {values} | {worst_u:.1} u |\n",
        case.cycle,
        feed_in_words(case.feed.1),
        100.0 * used,
        1e3 * rms_mm,
    )
}

/// Nothing can be hit here: the ways between the passes are short and quick, the passes are as the cycle asks.
pub fn quick() -> CourseRules {
    CourseRules {
        transfer_mm_per_s: 500.0,
        transfer_rad_per_s: 6.0,
        clearance_mm: 2.0,
        ..CourseRules::default()
    }
}

/// The feed as the table shows it.
fn feed_in_words(line: &str) -> String {
    let (key, feed) = line.split_once(" = ").unwrap();
    let unit = if key.contains("deg") { "°/min" } else { "mm/min" };
    format!("{} {unit}", feed.trim_matches(['[', ']']))
}

/// The machine under the program, with the bar that is in.
pub fn cell(name: &str, program: &BarProgram, world: &Arc<VirtualMachine>) -> SimulatedCell {
    let (world, along) = (Arc::clone(world), program.trajectory.clone());
    let setup_of_step = program.setup_of_step.clone();
    SimulatedCell {
        program: name.into(),
        bar_mm: Box::new(move |state| {
            let step = along.at(state.time_s.unwrap_or_default()).step;
            setup_of_step[step].map_or(FREE_MM, |setup| world.ideal_reading_mm(setup, state)[0])
        }),
        noise_mm: NOISE_MM,
        seed: 7,
        ..SimulatedCell::along(program.trajectory.clone())
    }
}

/// What was asked for in words, and the farthest of all numbers of the machine from the injected ones in u.
fn against_truth(case: &Case, found: &Value, machine: &Machine, truth: &Truth) -> (String, f64) {
    let injected = minimum_set(machine);
    let true_value = |name: &str| {
        let error = injected.iter().find(|error| error.name() == name);
        error.map_or(0.0, |error| {
            if error.direction.is_rotary() {
                1e6 * error.of(&truth.location)
            } else {
                1e3 * error.of(&truth.location)
            }
        })
    };
    let (mut worst_u, mut values) = (0f64, Vec::new());
    for parameter in found["parameters"].as_array().unwrap() {
        let name = parameter["name"].as_str().unwrap();
        let Some((value, u)) = parameter["value"].as_f64().zip(parameter["u"].as_f64()) else { continue };
        if parameter["effect"] == "ball-setting" {
            continue;
        }
        let expected = true_value(name) + carried(found, name, &true_value);
        let off = (value - expected).abs();
        println!("{}: {name} = {value:.3} ± {u:.3}, injected {expected:.3}", case.cycle);
        assert!(
            off <= ALLOWED_U * u + SECOND_ORDER,
            "{}: {name} = {value} ± {u}, injected {expected}",
            case.cycle
        );
        worst_u = worst_u.max((off - SECOND_ORDER).max(0.0) / u);
        if case.identifies.contains(&name) {
            let unit = if parameter["unit"] == "urad" { "µrad" } else { "µm" };
            values.push(format!("{name} {value:.2} ± {u:.2} {unit} (injected {expected:.2})"));
        }
    }
    assert_eq!(values.len(), case.identifies.len(), "{}: {values:?} of {:?}", case.cycle, case.identifies);
    match values.as_slice() {
        [] => ("none is observable".into(), worst_u),
        values => (values.join(", "), worst_u),
    }
}
