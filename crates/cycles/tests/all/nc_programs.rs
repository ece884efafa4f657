//! NC programs read back by small interpreters that know nothing of the writers.

use crate::clear::keeps_clear;
use crate::interpreter::{Event, interpret, run};
use crate::section::{is_writing, write_or_compare};
use crate::visited::visited;
use proptest::prelude::*;
use trunnion_core::{AxisValues, InstrumentKind, Joint, Setup, convert};
use trunnion_cycles::Cycle;
use trunnion_cycles::nc::{Block, DIALECTS, Program};
use trunnion_cycles::{CourseRules, Step};
use trunnion_machine::{JointErrors, Machine, shipped};

pub const STATIC: &str = r#"
format = "trunnion-cycle/1"
name = "small-static"
machine = "table-bc"
kind = "static"
passes = ["+", "-"]
[[setup]]
name = "low"
instrument = "r-test"
ball_in_table_mm = [150.0, 0.0, 60.0]
[[grid]]
axis = "B"
stations_deg = [0, 5]
[[grid]]
axis = "C"
stations_deg = [0, 5]
[settle]
window_s = 0.5
drift_um = 0.5
noise_um = 2.0
standstill_um = 2.0
standstill_deg = 0.001
timeout_s = 10.0
"#;

const SWEEP: &str = r#"
format = "trunnion-cycle/1"
name = "small-sweep"
machine = "table-bc"
kind = "on-the-fly"
[[setup]]
name = "low"
instrument = "ball-bar"
bar_length_mm = 100
ball_in_table_mm = [0.0, 0.0, 60.0]
[sweep]
axis = "C"
from_deg = 0
to_deg = 360
feeds_deg_per_min = [1800]
[bar]
direction = [0, 1, 0]
"#;

pub fn machine(cycle: &Cycle) -> Machine {
    shipped::machine(&cycle.machine).unwrap()
}

/// Coarse pieces keep the snapshots short.
pub fn coarse() -> CourseRules {
    CourseRules { transfer_chord_mm: 1.0, chord_mm: 0.5, ..CourseRules::default() }
}

#[test]
fn the_registry_holds_every_dialect_file_and_nothing_else() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/nc");
    let machinery = ["compose", "dialect", "program", "tool_point", "words"];
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|stem| !machinery.contains(&stem.as_str()))
        .collect();
    files.sort();
    let registered: Vec<&str> = DIALECTS.iter().map(|dialect| dialect.name).collect();
    assert_eq!(
        registered, files,
        "left: names of DIALECTS in crates/cycles/src/nc.rs, in their order; right: the files of its folder"
    );
    for dialect in DIALECTS {
        let tool_point = dialect.tool_point.as_ref().map_or("none of its own", |own| own.source);
        for (what, text) in [
            ("controllers", dialect.controllers),
            ("source", dialect.source),
            ("tool centre point control", tool_point),
        ] {
            assert!(text.len() > 5, "{} says nothing of its {what}", dialect.name);
        }
        assert!((2..=9).contains(&dialect.decimals), "{}", dialect.name);
    }
}

#[test]
fn the_guide_lists_the_dialects() {
    let mut table = String::from(
        "| dialect | controllers | duration of a block | dwell | stop with a word | positions | `--tcp` |\n|---|---|---|---|---|---|---|\n",
    );
    for dialect in DIALECTS {
        table += &format!(
            "| `{}` | {} | {} | {} | {} | {} decimals | {} |\n",
            dialect.name,
            dialect.controllers,
            dialect.duration,
            dialect.dwell,
            dialect.stop,
            dialect.decimals,
            dialect.tool_point.as_ref().map_or("–", |own| own.name)
        );
    }
    write_or_compare("docs/use/nc-programs.md", "dialects", &table);
}

#[test]
fn every_dialect_writes_the_small_cycles_as_before() {
    for (name, text) in [("static", STATIC), ("sweep", SWEEP)] {
        let cycle = Cycle::parse("small.toml", text).unwrap();
        let program = Program::of_cycle(&cycle, &machine(&cycle), &coarse()).unwrap();
        for dialect in DIALECTS {
            let written = (dialect.write)(&program, dialect.decimals);
            let path = format!(
                "{}/tests/all/nc/{name}.{}.{}",
                env!("CARGO_MANIFEST_DIR"),
                dialect.name,
                dialect.ending
            );
            if is_writing() {
                std::fs::write(&path, &written).unwrap();
            }
            let expected = std::fs::read_to_string(&path).unwrap_or_default();
            assert_eq!(
                written, expected,
                "{path} is old: run this test with TRUNNION_WRITE_DOCS=1, then read what it wrote"
            );
            assert!(written.is_ascii() && written.lines().all(|line| line.len() < 128), "{path}");
        }
    }
}

#[test]
fn the_shipped_cycles_visit_their_poses_in_every_dialect() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let cycle = Cycle::parse("c.toml", &std::fs::read_to_string(&path).unwrap()).unwrap();
        // Controllers of machines with legs take no strokes; the command refuses.
        let legs = machine(&cycle).tripod.is_some();
        // What touches belongs to the probing cycles of the controller (tested below).
        // Nor does a program turn a joint that is no letter (tested with the cycle).
        if !legs && !cycle.touches() && cycle.named_joint().is_none() {
            check(&cycle, &CourseRules::default());
            count += 1;
        }
    }
    assert!(count >= 7);
}

#[test]
fn under_tool_centre_point_control_the_same_poses_are_visited() {
    let rules = CourseRules { tool_point: true, ..CourseRules::default() };
    let mut count = 0;
    for name in [
        "r-test-static",
        "r-test-interleaved",
        "r-test-sweep-b",
        "r-test-head-bc",
        "r-test-head-a-table-c",
        "s4-b",
        "bk4-cone",
    ] {
        let path = format!("{}/../../config/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let cycle = Cycle::parse("c.toml", &std::fs::read_to_string(path).unwrap()).unwrap();
        let machine = machine(&cycle);
        let program = Program::of_cycle(&cycle, &machine, &rules).unwrap();
        for dialect in DIALECTS.iter().filter(|dialect| dialect.tool_point.is_some()) {
            let text = (dialect.write)(&program, 6);
            let named = |i: usize| format!("{name} as {}, point {i}", dialect.name);
            let events = moved_by_the_control(&run(dialect.name, &text), &machine, &named(0));
            visited(&events, &cycle, &machine, &rules, 5, &named);
            // Over a cone it turns with the table, at the height of the place where the curve begins.
            if name != "bk4-cone" {
                keeps_clear(&events, &cycle, &machine, &rules, &named(0));
            }
            count += 1;
        }
    }
    assert_eq!(count, 21);
    // The ball stays at the nest, so nothing but the rotary axes is written.
    let cycle = Cycle::parse("c.toml", STATIC).unwrap();
    let program = Program::of_cycle(&cycle, &machine(&cycle), &rules).unwrap();
    let dialect = trunnion_cycles::nc::dialect("siemens").unwrap();
    let text = (dialect.write)(&program, 4);
    let measures = text.split("M0\n").nth(2).unwrap();
    assert!(measures.contains(" B5.0000") && !measures.split("M30").next().unwrap().contains("X1"), "{text}");
    let flat = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles/linear-x.toml");
    let flat = Cycle::parse("c.toml", &std::fs::read_to_string(flat).unwrap()).unwrap();
    let error = Program::of_cycle(&flat, &machine(&flat), &rules).unwrap_err().to_string();
    assert!(error.contains("its machine has no rotary axis"), "{error}");
}

/// What the linear axes do under tool centre point control: they keep the tool point over the table where the program has it, its positions
/// those of the linear axes with the rotary axes at zero.
fn moved_by_the_control(events: &[(Event, bool)], machine: &Machine, named: &str) -> Vec<Event> {
    let none = JointErrors::default();
    let mut was_on = false;
    let mut rotary_at_zero = true;
    let moved = |(event, keeps): &(Event, bool)| {
        let Event::Move { to, seconds } = event else { return event.clone() };
        let turned = Joint::ROTARY.iter().any(|letter| to[*letter] != 0.0);
        assert!(was_on || !keeps || rotary_at_zero, "{named}: switched on with the rotary axes at {to:?}");
        (was_on, rotary_at_zero) = (*keeps, !turned);
        if !keeps {
            return event.clone();
        }
        let letters: Vec<(Joint, f64)> = Joint::ALL.iter().map(|&letter| (letter, to[letter])).collect();
        let asked = inside(&letters);
        let mut upright = asked;
        Joint::ROTARY.iter().for_each(|&letter| upright[letter] = 0.0);
        let tool = machine.machine_from_tool(&upright, &none) * nalgebra::Point3::origin();
        let place = machine.machine_from_table(&upright, &none).inverse() * tool;
        let mut at = machine.follow(&asked, &place).unwrap();
        Joint::ROTARY.iter().for_each(|&letter| at[letter] = to[letter]);
        Event::Move { to: at, seconds: *seconds }
    };
    events.iter().map(moved).collect()
}

#[test]
fn circles_cones_diagonals_and_grids_of_linear_axes_are_visited_too() {
    let circle = SWEEP
        .replace("[sweep]\naxis = \"C\"", "[circle]\nplane = \"ZX\"")
        .replace("feeds_deg_per_min = [1800]", "feeds_mm_per_min = [1000, 3000]")
        .replace("[0.0, 0.0, 60.0]", "[40.0, -30.0, 160.0]")
        .replace("from_deg = 0", "from_deg = -45")
        .replace("to_deg = 360", "to_deg = 135")
        .replace("\n[bar]\ndirection = [0, 1, 0]", "");
    let cone = SWEEP
        .replace("[sweep]\naxis = \"C\"", "[cone]\nhalf_angle_deg = 15\ntilt_deg = 30")
        .replace("feeds_deg_per_min = [1800]", "feeds_mm_per_min = [1000]")
        .replace("\n[bar]\ndirection = [0, 1, 0]", "");
    let grids = &STATIC[STATIC.find("[[grid]]").unwrap()..STATIC.find("[settle]").unwrap()];
    let setup = "instrument = \"r-test\"\nball_in_table_mm = [150.0, 0.0, 60.0]";
    let line = "[line]\nlength_mm = 600\nsteps = 5\nin_turn = true\n";
    let diagonal = STATIC.replace(grids, line).replace(
        setup,
        "instrument = \"step-diagonal\"\ndirection = [1, 1, 1]\nball_in_table_mm = [-200, -200, -200]",
    );
    let axis = |letter: &str| format!("[[grid]]\naxis = \"{letter}\"\nstations_mm = [-100, 0, 150]\n");
    let volume = STATIC
        .replace(grids, &["X", "Y", "Z"].map(axis).concat())
        .replace(setup, "instrument = \"tracker\"\nball_in_table_mm = [300.0, 300.0, 0.0]");
    for (name, text) in [("circle", circle), ("cone", cone), ("diagonal", diagonal), ("volume", volume)] {
        let cycle = Cycle::parse(name, &text).unwrap_or_else(|problems| panic!("{name}: {problems}\n{text}"));
        check(&cycle, &CourseRules::default());
    }
}

/// The joints of an arm turn in one plane, and between its ends there is no room to go below it.
#[test]
fn an_axis_with_one_station_stays_there_while_the_arm_is_in() {
    let text = include_str!("../../../../config/cycles/passive-arm.toml");
    let cycle = Cycle::parse("passive-arm.toml", text).unwrap();
    let steps = cycle.course(&machine(&cycle), &CourseRules::default()).unwrap();
    let pieces = |step| if let Step::Transfer { pieces } = step { pieces } else { Vec::new() };
    let heights: Vec<f64> = steps.into_iter().flat_map(pieces).map(|(end, _)| end[Joint::Z]).collect();
    assert!(heights.len() > 160 && heights.iter().all(|height| *height == 0.0), "{heights:?}");
    // Approached from above where it came down: not from the side of the pass.
    let poses = cycle.poses(&machine(&cycle)).unwrap();
    assert!(poses.iter().all(|pose| pose.direction[Joint::Z] == 0.0 && pose.direction[Joint::X] == 1.0));
}

#[test]
fn what_touches_is_left_to_the_probing_cycles_of_the_controller() {
    let text = STATIC.replace("r-test", "touch-probe");
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let error = Program::of_cycle(&cycle, &machine(&cycle), &CourseRules::default()).unwrap_err().to_string();
    assert!(error.contains("use the probing cycles of the controller"), "{error}");
}

#[test]
fn a_retracted_spindle_beyond_the_travel_is_refused_with_the_axis() {
    let cycle = Cycle::parse("c.toml", STATIC).unwrap();
    let rules = CourseRules { clearance_mm: 500.0, ..CourseRules::default() };
    let error = Program::of_cycle(&cycle, &machine(&cycle), &rules).unwrap_err().to_string();
    assert!(error.contains("needs Z at 560, its travel is -400..=400"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn any_cycle_is_visited_as_expanded(
        ball in [-180.0..180.0f64, -180.0..180.0, 20.0..150.0],
        b in prop::collection::vec(-80.0..80.0f64, 1..4),
        c in prop::collection::vec(-300.0..300.0f64, 1..5),
        both in any::<bool>(),
        interleave in any::<bool>(),
    ) {
        let second = "[[setup]]\nname = \"high\"\ninstrument = \"r-test\"\nball_in_table_mm = [40, 20, 180]\n[[grid]]\naxis = \"B\"";
        let text = STATIC
            .replace("[150.0, 0.0, 60.0]", &format!("{ball:?}"))
            .replacen("stations_deg = [0, 5]", &format!("stations_deg = {:?}", rising(b)), 1)
            .replacen("stations_deg = [0, 5]", &format!("stations_deg = {:?}", rising(c)), 1)
            .replacen("[[grid]]\naxis = \"B\"", second, 1)
            .replace("[\"+\", \"-\"]", if both { "[\"+\", \"-\"]" } else { "[\"-\"]" })
            .replace("[settle]", &format!("[rounds]\ncount = 2\nwait_s = 30\ninterleave = {interleave}\n[settle]"));
        check(&Cycle::parse("c.toml", &text).unwrap(), &CourseRules::default());
    }

    #[test]
    fn any_sweep_runs_at_its_feed_along_its_path(
        ball in [-150.0..150.0f64, -150.0..150.0, 20.0..150.0],
        axis in prop::sample::select(vec!["B", "C"]),
        span in 30.0..150.0f64,
        feed in 300.0..4000.0f64,
    ) {
        let text = SWEEP
            .replace("[0.0, 0.0, 60.0]", &format!("{ball:?}"))
            .replace("axis = \"C\"", &format!("axis = \"{axis}\""))
            .replace("from_deg = 0", &format!("from_deg = {}", -span / 2.0))
            .replace("to_deg = 360", &format!("to_deg = {}", span / 2.0))
            .replace("[1800]", &format!("[{feed}, 500]"));
        check(&Cycle::parse("c.toml", &text).unwrap(), &CourseRules::default());
    }
}

fn rising(mut angles: Vec<f64>) -> Vec<f64> {
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|a, b| (*a - *b).abs() < 1.0);
    angles
}

/// The program stays together with its instrument and visits what the cycle expands to, in every dialect.
fn check(cycle: &Cycle, rules: &CourseRules) {
    let machine = machine(cycle);
    let program = Program::of_cycle(cycle, &machine, rules).unwrap();
    stays_together(&program, cycle, &machine, rules);
    for dialect in DIALECTS {
        for decimals in [dialect.decimals, 6] {
            let events = interpret(dialect.name, &(dialect.write)(&program, decimals));
            let named =
                |i: usize| format!("{} as {} with {decimals} decimals, point {i}", cycle.name, dialect.name);
            visited(&events, cycle, &machine, rules, decimals, &named);
            keeps_clear(&events, cycle, &machine, rules, &named(0));
            let seconds = |event: &Event| match event {
                Event::Move { seconds, .. } | Event::Dwell { seconds } => *seconds,
                Event::Stop(_) => 0.0,
            };
            let runs_s: f64 = events.iter().map(seconds).sum();
            let off = runs_s / program.duration_s - 1.0;
            assert!(off.abs() < 1e-3, "{}: {runs_s} s, header {} s", named(0), program.duration_s);
        }
    }
}

/// Between joining and parting, ball and nest (or a bar's balls and its length) never part by more than the pieces and the
/// synchronisation move allow. Where the cycle names the linear axes nothing is joined.
fn stays_together(program: &Program, cycle: &Cycle, machine: &Machine, rules: &CourseRules) {
    let mut from: Option<AxisValues<f64>> = None;
    let allowed_mm = rules.transfer_chord_mm + rules.stroke_mm + 1e-9;
    for block in &program.blocks {
        match block {
            Block::Timed { to, seconds } => {
                assert!(*seconds > 0.0);
                let to = inside(to);
                if let Some(from) = from {
                    let middle = AxisValues::from_fn(|letter| 0.5 * (from[letter] + to[letter]));
                    let off_mm = |setup: &Setup| parted_mm(machine, setup, &middle);
                    let least = cycle.setups.iter().map(off_mm).fold(f64::INFINITY, f64::min);
                    assert!(least <= allowed_mm, "{} parts by {least} mm at {middle:?}", cycle.name);
                }
                from = Some(to);
            }
            Block::Feed { .. } => from = None,
            Block::Remark(_) | Block::Stop(_) | Block::Dwell { .. } | Block::ToolPoint(_) => {}
        }
    }
}

/// How far what is joined has parted, mm.
fn parted_mm(machine: &Machine, setup: &Setup, at: &AxisValues<f64>) -> f64 {
    let none = JointErrors::default();
    let ball = machine.machine_from_table(at, &none) * setup.ball_in_table_mm;
    let apart_mm = (machine.machine_from_tool(at, &none) * setup.ball_in_tool_mm - ball).norm();
    match setup.instrument {
        InstrumentKind::RTest => apart_mm,
        InstrumentKind::BallBar => (apart_mm - setup.bar_length_mm.unwrap()).abs(),
        _ => 0.0,
    }
}

fn inside(target: &[(Joint, f64)]) -> AxisValues<f64> {
    let mut position = AxisValues::default();
    for &(letter, value) in target {
        position[letter] = if letter.is_rotary() { convert::rad_from_deg(value) } else { value };
    }
    position
}
