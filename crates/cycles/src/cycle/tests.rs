mod plate;

use super::course::CourseRules;
use super::visit::Pace;
use super::*;
use nalgebra::Unit;
use proptest::prelude::*;
use trunnion_core::convert::{deg_from_rad, rad_from_deg};
use trunnion_core::{Artefact, InstrumentKind, Target};
use trunnion_machine::shipped;

const STATIC: &str = include_str!("../../../../config/cycles/r-test-static.toml");
const SWEEP: &str = include_str!("../../../../config/cycles/r-test-sweep-c.toml");

fn table_bc() -> Machine {
    shipped::machine("table-bc").unwrap()
}

#[test]
fn the_shipped_static_cycle_visits_the_grid_of_oyama_at_two_heights_both_ways() {
    let cycle = Cycle::parse("s1.toml", STATIC).unwrap();
    let poses = cycle.poses(&table_bc()).unwrap();
    assert_eq!(poses.len(), 2 * 2 * 84);
    // first pose of the outside data set: B −90, C 0, ball (150, 0, 60) → X −60, Y 0, Z 150
    let p = poses[0].position;
    assert!((p[Joint::X] + 60.0).abs() < 1e-9 && (p[Joint::Z] - 150.0).abs() < 1e-9);
    assert_eq!(poses[84].direction[Joint::C], -1.0);
}

#[test]
fn a_broken_cycle_names_line_found_and_allowed() {
    let check = |from: &str, to: &str, expected: &str| {
        let text = STATIC.replace(from, to);
        let shown = Cycle::parse("c.toml", &text).unwrap_err().to_string();
        assert!(shown.contains(expected), "{shown}");
    };
    check("step_deg = 30", "step_deg = 0", "step_deg = 0; allowed: 0.001..=1000");
    check("[settle]", "[rounds]\ncount = 0\n[settle]", "rounds.count = 0; allowed: 1..=1000");
    check("[settle]", "[bar]\ndirection = [0, 0, 0]\n[settle]", "bar.direction has no length");
    let finer = STATIC.replace("step_deg = 30", "step_deg = 0.1");
    let shown = Cycle::parse("c.toml", &finer).unwrap_err().to_string();
    assert!(shown.contains("poses in 4 passes; allowed: at most 1000000 in the whole cycle"), "{shown}");
    check("passes = [\"+\", \"-\"]", "passes = [\"up\"]", "\"+\" (as written) and \"-\" (backwards)");
}

#[test]
fn a_cycle_refuses_joints_it_cannot_move() {
    let with = |axis: &str| STATIC.replacen("axis = \"B\"", &format!("axis = \"{axis}\""), 1);
    for (axis, why) in [("U", "move no other joint"), ("1j", "is not a name for a joint")] {
        let shown = Cycle::parse("c.toml", &with(axis)).unwrap_err().to_string();
        assert!(shown.contains(&format!("= \"{axis}\"")) && shown.contains(why), "{shown}");
    }
    let sweep = SWEEP.replacen("axis = \"C\"", "axis = \"C1\"", 1);
    let shown = Cycle::parse("c.toml", &sweep).unwrap_err().to_string();
    assert!(shown.contains("= \"C1\"") && shown.contains("move no other joint"), "{shown}");
    // Which other names there are is known to the machine.
    let table = shipped::machine("table-bc").unwrap();
    let unknown = Cycle::parse("c.toml", &with("C1")).unwrap();
    let shown = unknown.visits(&table, &Pace::default()).unwrap_err().to_string();
    assert!(shown.contains("moves axis C1, which machine table-bc does not have"), "{shown}");
    assert_eq!(unknown.poses(&table), None);

    let robot = include_str!("../../../../config/robots/ur5.toml");
    let robot = Machine::parse("robot", "robot.toml", robot).unwrap();
    let cycle = Cycle::parse("s1.toml", STATIC).unwrap();
    let visits = cycle.visits(&robot, &Pace::default()).unwrap_err().to_string();
    assert!(
        visits.contains("which machine robot does not have; its axes: j1, j2, j3, j4, j5, j6"),
        "{visits}"
    );
    let program =
        crate::nc::Program::of_cycle(&cycle, &robot, &CourseRules::default()).unwrap_err().to_string();
    assert_eq!(program, visits);
}

#[test]
fn interleaved_setups_take_turns_pass_by_pass() {
    let text = STATIC.replace("[settle]", "[rounds]\ncount = 2\nwait_s = 60\ninterleave = true\n[settle]");
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let poses = cycle.poses(&table_bc()).unwrap();
    let turns: Vec<(usize, f64)> =
        poses.chunks(84).map(|leg| (leg[0].setup, leg[0].direction[Joint::C])).collect();
    let round = [(0, 1.0), (1, 1.0), (0, -1.0), (1, -1.0)];
    assert_eq!(turns, [round, round].concat());
}

#[test]
fn a_sweep_moves_at_its_feeds_and_the_ball_keeps_its_place_under_the_probes() {
    let (machine, cycle) = (table_bc(), Cycle::parse("c.toml", SWEEP).unwrap());
    let visits = cycle.visits(&machine, &Pace::default()).unwrap();
    let c = Joint::C;
    let legs = [30.0, -30.0, 60.0, -60.0].map(|deg_per_s: f64| {
        let feed = rad_from_deg(deg_per_s);
        visits.states.iter().filter(|s| (s.velocity[c] - feed).abs() < 1e-9).count()
    });
    // a turn at 30°/s and at 60°/s, ten points a second
    assert_eq!(legs, [120, 120, 60, 60]);
    for pair in visits.states.windows(2) {
        let dt = pair[1].time_s.unwrap() - pair[0].time_s.unwrap();
        assert!(dt > 0.0);
        if pair[0].velocity[c] == pair[1].velocity[c] && dt < 0.2 {
            // Velocities are the derivative of the positions, also of the linear axes that follow.
            let mean = 0.5 * (pair[0].velocity[Joint::X] + pair[1].velocity[Joint::X]);
            let moved = pair[1].position[Joint::X] - pair[0].position[Joint::X];
            assert!((moved - mean * dt).abs() < 0.02, "{moved} {}", mean * dt);
        }
    }
    let last = visits.states.last().unwrap();
    assert_eq!(last.direction[c], -1.0);
    assert!(last.since_reversal[c] > rad_from_deg(355.0));
    assert!((40.0..60.0).contains(&(visits.duration_s - 300.0)), "{}", visits.duration_s);
}

#[test]
fn one_direction_on_the_fly_never_reads_the_way_back() {
    let text = SWEEP.replace("kind =", "passes = [\"+\"]\nkind =");
    let visits = Cycle::parse("c.toml", &text).unwrap().visits(&table_bc(), &Pace::default()).unwrap();
    assert!(visits.states.iter().all(|state| state.direction[Joint::C] == 1.0));
}

#[test]
fn a_ball_bar_is_as_long_as_it_is_wherever_it_points() {
    for frame in ["machine", "table"] {
        let text = SWEEP
            .replace("r-test\"\nnest = \"table\"", "ball-bar\"\nbar_length_mm = 100")
            .replace("b_deg = 0", "b_deg = 20")
            + &format!("\n[bar]\ndirection = [0.6, 0.8, 0]\nframe = \"{frame}\"\n");
        let (machine, cycle) = (table_bc(), Cycle::parse("c.toml", &text).unwrap());
        for state in cycle.visits(&machine, &Pace::default()).unwrap().states {
            let none = JointErrors::default();
            let table = machine.machine_from_table(&state.position, &none) * cycle.setups[0].ball_in_table_mm;
            let tool = machine.machine_from_tool(&state.position, &none) * Point3::origin();
            assert!(((tool - table).norm() - 100.0).abs() < 1e-9);
            if frame == "machine" {
                assert!(((tool - table) / 100.0 - Vector3::new(0.6, 0.8, 0.0)).norm() < 1e-9);
            }
        }
    }
}

#[test]
fn beyond_the_travel_of_an_axis_is_refused_by_name() {
    let text = STATIC.replace("from_deg = -90\nto_deg = 90", "from_deg = -120\nto_deg = 90");
    let error = Cycle::parse("c.toml", &text).unwrap().visits(&table_bc(), &Pace::default()).unwrap_err();
    assert!(error.to_string().contains("B at -120"), "{error}");
}

prop_compose! {
    fn any_grid_axis()(
        letter in prop::sample::select(Joint::ROTARY.to_vec()),
        from in -180i32..180, step in 1u32..120, count in 1usize..20, shift in prop::bool::ANY,
    ) -> GridAxis {
        let mut stations: Vec<f64> = (0..count)
            .map(|i| rad_from_deg(f64::from(from) + f64::from(step) * 0.25 * i as f64)).collect();
        if shift {
            stations[0] -= 0.013;
        }
        GridAxis { letter, stations }
    }
}

prop_compose! {
    fn any_artefact()(
        places in prop::collection::vec(prop::array::uniform3(-300i32..300), 1..5),
        turned in prop::array::uniform3(-180i32..180), faces in prop::bool::ANY,
    ) -> Artefact {
        let target = |(i, place): (usize, [i32; 3])| Target {
            name: format!("{i}"),
            at_mm: Vector3::from(place.map(|v| f64::from(v) * 0.25)),
            normal: faces.then(|| [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()][i % 3]),
        };
        Artefact {
            name: "plate \"1\"".into(),
            turned_rad: Vector3::from(turned.map(|deg| rad_from_deg(f64::from(deg)))),
            targets: places.into_iter().enumerate().map(target).collect(),
        }
    }
}

prop_compose! {
    fn any_setup(name: &'static str)(
        kind in prop::sample::select(InstrumentKind::NAMES.map(|(_, kind)| kind).to_vec()),
        ball in prop::array::uniform3(-300i32..300), tool in prop::array::uniform3(-30i32..30),
        bar in 50u32..500, arms in prop::array::uniform2(50u32..500),
        artefact in any_artefact(), calibrated in prop::bool::ANY, spindle in prop::bool::ANY,
    ) -> Setup {
        let nest = if spindle { trunnion_core::NestSide::Spindle } else { trunnion_core::NestSide::Table };
        let has_normals = artefact.targets[0].normal.is_some();
        let fits = kind.has_targets() && has_normals == kind.has_normals();
        let kind = if kind.has_targets() && !fits { InstrumentKind::RTest } else { kind };
        Setup {
            bar_length_mm: Some(f64::from(bar)),
            ball_in_tool_mm: Point3::from(tool.map(f64::from)),
            direction: Some(Vector3::y_axis()),
            arms_mm: Some(arms.map(f64::from)),
            calibrated,
            artefact: fits.then_some(artefact),
            ..Setup::new(name, kind, nest, Point3::from(ball.map(|v| f64::from(v) * 0.5)))
        }
    }
}

fn any_motion() -> impl Strategy<Value = Motion> {
    let passes = || prop::collection::vec(prop::sample::select(vec![1.0, -1.0]), 1..4);
    let settle = Settle {
        window_s: 0.5,
        drift_mm: 0.5e-3,
        noise_mm: 2e-3,
        standstill_mm: 2e-3,
        standstill_rad: rad_from_deg(0.001),
        timeout_s: 10.0,
    };
    let at_rest = (prop::collection::vec(any_grid_axis(), 1..3), passes())
        .prop_map(move |(grid, passes)| Motion::Static { grid, passes, settle });
    let sweep = (prop::collection::vec(1u32..20_000, 1..4), passes(), -360i32..360, (-90i32..90, -90i32..90))
        .prop_map(|(feeds, passes, to, (first, last))| {
            let mut others = AxisValues::default();
            others[Joint::B] = (rad_from_deg(f64::from(first)), rad_from_deg(f64::from(last)));
            let feeds_rad_per_s = feeds.into_iter().map(|f| rad_from_deg(f64::from(f)) / 60.0).collect();
            let from_to_rad = (0.0, rad_from_deg(f64::from(to)));
            Motion::OnTheFly { axis: Joint::C, from_to_rad, feeds_rad_per_s, passes, others }
        });
    let line = (1u32..2000, 1usize..50, prop::bool::ANY, passes()).prop_map(
        move |(length, steps, in_turn, passes)| {
            let line = Line { length_mm: f64::from(length), steps, in_turn };
            Motion::Line { line, passes, settle }
        },
    );
    let shapes = [
        Path::Circle { plane: [Joint::Z, Joint::X], radius_mm: None },
        Path::Circle { plane: [Joint::Y, Joint::Z], radius_mm: Some(1.5) },
        Path::Cone { half_angle_rad: rad_from_deg(15.0), tilt_rad: rad_from_deg(10.0) },
    ];
    let curve = (prop::sample::select(shapes.to_vec()), 0i32..720, 1u32..5000, passes()).prop_map(
        |(path, to, feed, passes)| {
            let from_to_rad = (0.0, rad_from_deg(f64::from(to)));
            Motion::Path { path, from_to_rad, feeds_mm_per_s: vec![f64::from(feed) / 60.0], passes }
        },
    );
    prop_oneof![at_rest, sweep, line, curve]
}

proptest! {
    #[test]
    fn what_is_written_reads_back_the_same(
        motion in any_motion(), low in any_setup("low"), high in any_setup("high"),
        count in 1usize..5, wait in 0u32..100, interleave in prop::bool::ANY, table in prop::bool::ANY,
    ) {
        let frame = if table { BarFrame::Table } else { BarFrame::Machine };
        let cycle = Cycle {
            name: "any \"name\"".into(), machine: "table-bc".into(), setups: vec![low, high], motion,
            rounds: Rounds { count, wait_s: f64::from(wait), interleave },
            bar: Bar { direction: Unit::new_normalize(Vector3::new(1.0, 2.0, 0.5)), frame },
        };
        let text = cycle.to_text();
        let read = Cycle::parse("c.toml", &text).unwrap();
        prop_assert_eq!(&read.to_text(), &text);
        prop_assert_eq!((&read.name, &read.setups, read.rounds), (&cycle.name, &cycle.setups, cycle.rounds));
        let numbers = |cycle: &Cycle| match &cycle.motion {
            Motion::Static { grid, passes, settle } => {
                let mut all: Vec<f64> = grid.iter().flat_map(|axis| axis.stations.clone()).collect();
                all.extend(passes.iter().chain(&[settle.drift_mm, settle.standstill_rad, settle.window_s]));
                all
            }
            Motion::Line { line, passes, settle } => {
                let in_turn = f64::from(u8::from(line.in_turn));
                let mut all = vec![line.steps as f64, line.length_mm, in_turn, settle.noise_mm];
                all.extend(passes);
                all
            }
            Motion::Path { path, from_to_rad, feeds_mm_per_s, passes } => {
                let shape = match path {
                    Path::Circle { plane: [first, second], radius_mm } => {
                        [first.index() as f64, second.index() as f64, radius_mm.unwrap_or(-1.0)]
                    }
                    Path::Cone { half_angle_rad, tilt_rad } => [*half_angle_rad, *tilt_rad, 0.0],
                };
                let mut all = vec![from_to_rad.0, from_to_rad.1];
                all.extend(shape.iter().chain(feeds_mm_per_s).chain(passes));
                all
            }
            Motion::OnTheFly { from_to_rad, feeds_rad_per_s, passes, others, .. } => {
                let mut all = vec![from_to_rad.0, from_to_rad.1, others[Joint::B].0, others[Joint::B].1];
                all.extend(feeds_rad_per_s.iter().chain(passes));
                all
            }
        };
        let (before, after) = (numbers(&cycle), numbers(&read));
        prop_assert_eq!(before.len(), after.len());
        for (a, b) in before.iter().zip(&after) {
            prop_assert!((a - b).abs() < 1e-11, "{} {}\n{}", a, b, text);
        }
    }
}

/// On this machine the spindle has the place that A has on others.
#[test]
fn a_grid_turns_the_spindle_of_its_machine_by_name() {
    let text = include_str!("../../../../config/cycles/r-test-head-bc-spindle.toml");
    let (cycle, machine) =
        (Cycle::parse("c.toml", text).unwrap(), shipped::machine("head-bc-spindle").unwrap());
    let spindle = machine.spindle.unwrap();
    assert_eq!((cycle.named_joint().map(Joint::as_str), spindle.as_str()), (Some("C1"), "C1"));
    let poses = cycle.poses(&machine).unwrap();
    let deg = |pose: &Pose| deg_from_rad(pose.position[spindle]).round();
    let first: Vec<f64> = poses.iter().take(5).map(deg).collect();
    assert_eq!(first, [0.0, 90.0, 180.0, 270.0, 0.0]);
    // A ball on the line of the spindle stays where it is.
    assert!((0..3).all(|k| (poses[0].position.0[k] - poses[3].position.0[k]).abs() < 1e-9));
    let course = cycle.course(&machine, &CourseRules::default()).unwrap_err().to_string();
    assert!(course.contains("turns another joint"), "{course}");
}

#[test]
fn every_shipped_cycle_can_be_run_and_reads_back_the_same() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let file = path.display().to_string();
        let cycle = Cycle::parse(&file, &std::fs::read_to_string(&path).unwrap()).unwrap();
        let machine = shipped::machine(&cycle.machine).unwrap();
        let visits = cycle.visits(&machine, &Pace::default()).unwrap();
        assert!(
            visits.states.len() > 50 && visits.duration_s < 4.0 * 3600.0,
            "{file}: {}",
            visits.duration_s
        );
        assert_eq!(Cycle::parse(&file, &cycle.to_text()).unwrap().to_text(), cycle.to_text(), "{file}");
        if let Motion::Static { .. } = cycle.motion {
            let poses = cycle.poses(&machine).unwrap();
            let same = |(pose, state): (&Pose, &trunnion_core::State)| {
                pose.setup == state.setup
                    && pose.position == state.position
                    && pose.direction[Joint::C] == state.direction[Joint::C]
            };
            assert!(poses.iter().zip(&visits.states).all(same), "{file}");
        }
        count += 1;
    }
    assert!(count >= 7);
}
