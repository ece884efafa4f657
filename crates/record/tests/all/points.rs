//! The points file of docs/design/contracts.md §2: golden import, every problem at once, round trip.

use trunnion_core::{Joint, Problems};
use trunnion_cycles::Run;
use trunnion_machine::{Machine, shipped};
use trunnion_record::{export, points_csv};

const POINTS: &str = include_str!("../../../../tests/data/points-gravity/points.csv");
const SETUP: &str = include_str!("../../../../tests/data/points-gravity/setup.toml");

fn import(points: &str, setup: &str) -> Result<Run, Problems> {
    let machine = |name: &str| -> Option<Machine> { shipped::machine(name) };
    points_csv::import_files("run", ("points.csv", points), ("setup.toml", setup), &machine)
}

#[test]
fn the_outside_data_set_is_imported_as_its_description_says() {
    let run = import(POINTS, SETUP).unwrap();
    // README of the data: B −90…90° step 30°, C 0…330° step 30°, two heights, both directions
    assert_eq!(
        (run.points.len(), run.setups.len(), run.channels.as_slice()),
        (2 * 2 * 7 * 12, 2, &["ambient".to_string()][..])
    );
    let first = &run.points[0];
    assert_eq!(first.state.position[Joint::X], -60.0);
    assert_eq!(first.state.position[Joint::B], -std::f64::consts::FRAC_PI_2);
    assert_eq!(first.reading_mm, [-21.40 / 1e3, 15.10 / 1e3, 17.50 / 1e3]);
    assert_eq!((first.state.time_s, first.state.temperature_degc.as_slice()), (Some(0.0), &[19.44][..]));
    // second pose: X stays, Y and Z moved up and down
    let second = &run.points[1].state;
    assert_eq!((second.direction[Joint::Y], second.direction[Joint::Z]), (1.0, -1.0));
    assert_eq!((second.direction[Joint::B], second.direction[Joint::C]), (1.0, 1.0));
    assert_eq!(run.points[335].state.setup, 1);
}

#[test]
fn export_and_import_round_trip_in_any_order_of_columns_and_without_time() {
    let run = import(POINTS, SETUP).unwrap();
    let text = export::points_csv(&run);
    let again = import(&text, SETUP).unwrap();
    assert_eq!(again, run);
    assert_eq!(export::points_csv(&again), text);

    let reversed: String = POINTS
        .lines()
        .map(|line| {
            line.split(',').rev().map(|cell| format!(" {cell}")).collect::<Vec<_>>().join(",") + "\r\n"
        })
        .collect();
    assert_eq!(import(&reversed, SETUP).unwrap(), run);

    let untimed: String = POINTS
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            [&cells[..1], &cells[2..]].concat().join(",") + "\n"
        })
        .collect();
    assert!(import(&untimed, SETUP).unwrap().points.iter().all(|point| point.state.time_s.is_none()));
}

#[test]
fn every_problem_of_both_files_is_reported_at_once() {
    let points = "setup,x_mm,y_mm,z_mm,b_rad,c_deg,direction_c,dx_um,dy_um,dz_um,dx_um\n\
                  low,0,0,0,0,0,1,1,2,nan,0\n\
                  middle,0,zero,0,0,0,2,1,2,3,0\n\
                  low,0,0,0\n";
    let setup = SETUP.replace("nest = \"table\"", "nest = \"tabel\"");
    let shown = import(points, &setup).unwrap_err().to_string();
    for expected in [
        "setup.toml:7:8: setup[0].nest = \"tabel\"; allowed: table, spindle",
        "points.csv:1:22: column \"b_rad\"; allowed: setup, ",
        "points.csv:1:64: column \"dx_um\" appears twice",
        "points.csv:2:21: dz_um = \"nan\"; allowed: a finite number",
        "points.csv:3:10: y_mm = \"zero\"; allowed: a finite number",
        "points.csv:3:21: direction_c = 2; allowed: -1, 0, 1",
        "points.csv:4:1: 4 cells; allowed: 11, as in the header",
    ] {
        assert!(shown.contains(expected), "{expected} not in\n{shown}");
    }

    let shown = import(points, SETUP).unwrap_err().to_string();
    assert!(shown.contains("points.csv:3:1: setup \"middle\"; allowed: low, high"), "{shown}");
    assert!(shown.contains("points.csv:1:1: column b_deg is missing"), "{shown}");

    let shown = import(POINTS, &SETUP.replace("table-bc", "table-cb")).unwrap_err().to_string();
    assert!(shown.contains("setup.toml:2:1: machine = \"table-cb\" is not known"), "{shown}");
    assert!(shown.contains("table-bc-y") && shown.contains("(did you mean table-bc?)"), "{shown}");

    let two = SETUP.replace("table-bc", "table-cb").replacen("r-test", "r-tset", 1);
    let shown = import(POINTS, &two).unwrap_err().to_string();
    assert!(shown.contains("table-cb") && shown.contains("r-tset"), "both at once: {shown}");

    // x_mm is as near, but it is there already.
    let shown = import(&POINTS.replacen("dx_um", "dx_mm", 1), SETUP).unwrap_err().to_string();
    assert!(shown.contains("Did you mean dx_um?"), "{shown}");
    assert!(import("", SETUP).unwrap_err().to_string().contains("points.csv: the file is empty"));
}

/// Cells of other programs: what to change stands next to what is wrong.
#[test]
fn a_cell_that_is_no_number_says_what_to_change() {
    let with = |name: &str, cell: &str| {
        let mut lines = POINTS.lines();
        let header = lines.next().unwrap();
        let at = header.split(',').position(|column| column == name).unwrap();
        let first = lines.next().unwrap();
        let cells: Vec<&str> =
            first.split(',').enumerate().map(|(k, own)| if k == at { cell } else { own }).collect();
        import(&format!("{header}\n{}\n", cells.join(",")), SETUP).unwrap_err().to_string()
    };
    for cell in ["\"1,464.19\"", "1'464.19", "1 464.19"] {
        assert!(with("dx_um", cell).contains("without marks between thousands"), "{}", with("dx_um", cell));
    }
    for cell in ["-35.81 um", "12.5µm", "3 °"] {
        assert!(with("dx_um", cell).contains("Leave the unit out of the cells"), "{}", with("dx_um", cell));
    }
    for cell in ["", "NaN", "n/a"] {
        assert!(with("dx_um", cell).contains("Leave out rows"), "{}", with("dx_um", cell));
    }
    for cell in ["+", "up", ""] {
        let shown = with("direction_b", cell);
        assert!(
            shown.contains("allowed: -1, 0, 1") && shown.contains("1 where the axis came from below"),
            "{shown}"
        );
    }
    let word = with("dx_um", "zero");
    assert!(word.trim_end().ends_with("allowed: a finite number"), "{word}");
}

#[test]
fn a_second_table_in_the_file_is_one_problem() {
    let shown = import(&format!("{POINTS}\n{POINTS}"), SETUP).unwrap_err().to_string();
    assert!(shown.contains("this row is the header again") && shown.contains("a file of its own"), "{shown}");
    assert!(!shown.contains("finite number") && !shown.contains("[[setup]]"), "{shown}");
    let one_column = import(&POINTS.replace(',', " "), SETUP).unwrap_err().to_string();
    assert!(one_column.contains("separate cells by commas, semicolons or tabs"), "{one_column}");
}

#[test]
fn one_problem_in_every_row_is_said_once_with_its_count() {
    let wrong = POINTS.replace("low,", "lwo,").replace("high,", "lwo,");
    let text = import(&wrong, SETUP).unwrap_err().to_string();
    assert!(text.contains("The same 335 more times, the last in line 337."), "{text}");
    assert!(text.lines().count() < 10 && !text.contains("not listed"), "{text}");
    let twice = import(&POINTS.replacen("\nlow,", "\nlwo,", 2), SETUP).unwrap_err().to_string();
    assert!(twice.contains("The same once more, in line 3."), "{twice}");
}

#[test]
fn a_ball_bar_run_has_one_reading_a_point_and_none_of_the_other_instrument() {
    let setup = SETUP.to_string()
        + "\n[[setup]]\nname = \"bar\"\ninstrument = \"ball-bar\"\nball_in_table_mm = [0, 0, 0]\nbar_length_mm = 100\n";
    let points = "setup,x_mm,y_mm,z_mm,b_deg,c_deg,dx_um,dy_um,dz_um,dr_um\n\
                  low,1,2,3,0,30,1.5,2,3,\nbar,1,2,3,0,0,,,,-4.25\n";
    let run = import(points, &setup).unwrap();
    assert_eq!(run.points[1].reading_mm, [-4.25e-3, 0.0, 0.0]);
    assert_eq!(run.points[1].state.direction[Joint::C], -1.0);
    assert_eq!(
        import(&export::points_csv(&run), &setup).unwrap().points[1].reading_mm,
        run.points[1].reading_mm
    );
    let both = points.replace(",,,,-4.25", ",1,,,-4.25");
    let shown = import(&both, &setup).unwrap_err().to_string();
    assert!(shown.contains("points.csv:3:15: dx_um = 1; allowed: an empty cell"), "{shown}");
}

const ROBOT: &str = include_str!("../../../../config/robots/ur5.toml");
const ROBOT_SETUP: &str = r#"
format = "trunnion-points/1"
machine = "robot"
[[setup]]
name = "a"
instrument = "tracker"
nest = "table"
ball_in_table_mm = [1000, 0, 0]
bar_length_mm = 0
"#;
const ROBOT_POINTS: &str = "setup,j1_deg,j2_deg,j3_deg,j4_deg,j5_deg,j6_deg,direction_j1,l_mm
a,10,-20,30,-40,50,-60,1,1200.5
a,12,-21,31,-41,51,-61,-1,1201.5
";

fn import_of(machine_text: &'static str, points: &str, setup: &str) -> Result<Run, Problems> {
    let machine = |name: &str| Machine::parse(name, "machine.toml", machine_text).ok();
    points_csv::import_files("run", ("points.csv", points), ("setup.toml", setup), &machine)
}

#[test]
fn joints_of_a_robot_are_columns() {
    let run = import_of(ROBOT, ROBOT_POINTS, ROBOT_SETUP).unwrap();
    let [j1, .., j6] = run.machine.joints()[..] else { panic!("six joints") };
    let second = &run.points[1].state;
    assert_eq!((second.position[j1], second.position[j6]), (12f64.to_radians(), (-61f64).to_radians()));
    assert_eq!((second.direction[j1], second.direction[j6]), (-1.0, -1.0));
    let text = export::points_csv(&run);
    assert!(text.starts_with("setup,j1_deg,j2_deg,j3_deg,j4_deg,j5_deg,j6_deg,direction_j1,"), "{text}");
    assert_eq!(import_of(ROBOT, &text, ROBOT_SETUP).unwrap(), run);
}

#[test]
fn second_linear_axes_and_a_spindle_are_columns() {
    let machine = include_str!("../../../machine/tests/data/two-carriages.toml");
    let points = "setup,x_mm,y_mm,z_mm,u_mm,v_mm,w_mm,c_deg,spindle_deg,l_mm\na,1,2,3,4,5,6,7,8,900\n";
    let run = import_of(machine, points, &ROBOT_SETUP.replace("robot", "two-carriages")).unwrap();
    let state = &run.points[0].state;
    assert_eq!((state.position[Joint::U], state.position[Joint::W]), (4.0, 6.0));
    let spindle = run.machine.joint("spindle").unwrap();
    assert_eq!(state.position[spindle], 8f64.to_radians());
    assert!(export::points_csv(&run).contains(",spindle_deg,"));
}

#[test]
fn a_column_of_no_joint_is_refused_with_the_nearest() {
    let points = ROBOT_POINTS.replace("direction_j1", "direction_j7");
    let shown = import_of(ROBOT, &points, ROBOT_SETUP).unwrap_err().to_string();
    assert!(
        shown.contains("column \"direction_j7\"") && shown.contains("Did you mean direction_j1?"),
        "{shown}"
    );
}

/// `j1_deg` is a reading of a passive arm unless the machine has a joint of that name.
#[test]
fn a_passive_arm_on_a_machine_with_joints_of_its_names_is_refused() {
    let setup =
        ROBOT_SETUP.replace("tracker", "passive-arm").replace("bar_length_mm = 0", "arms_mm = [200, 200]");
    let shown = import_of(ROBOT, ROBOT_POINTS, &setup).unwrap_err().to_string();
    assert!(shown.contains("j1_deg is a reading of an instrument and the position of a joint"), "{shown}");
}

/// A table as a program of a laser tracker writes it: targets and differences, joints of its own names.
const FOREIGN: &str = "step,x_t,y_t,z_t,x_dif,y_dif,z_dif,joint_1,joint_2,joint_3,joint_4,joint_5,joint_6
0,-430.5,-6,-98,-2.25,-3.5,0.5,10,-20,30,-40,50,-60
";
const FOREIGN_SETUP: &str = include_str!("../../../../tests/data/robot/setup.toml");

#[test]
fn a_table_of_another_program_is_read_by_the_names_of_its_columns() {
    let run = import_of(ROBOT, FOREIGN, FOREIGN_SETUP).unwrap();
    assert_eq!(run.points[0].reading_mm, [-432.75, -9.5, -97.5]);
    let j6 = run.machine.joint("j6").unwrap();
    assert_eq!(run.points[0].state.position[j6], (-60f64).to_radians());

    // Differences in µm that run from measured to target.
    let setup = FOREIGN_SETUP.replace("\"y_dif\"", "\"-0.001 * y_dif\"");
    let run = import_of(ROBOT, FOREIGN, &setup).unwrap();
    assert!((run.points[0].reading_mm[1] - -5.9965).abs() < 1e-12, "{:?}", run.points[0].reading_mm);
}

#[test]
fn a_column_that_the_table_lacks_and_a_cell_that_is_no_number_are_named_where_they_stand() {
    let setup = FOREIGN_SETUP.replace("\"joint_4\"", "\"joint_44\"");
    let shown = import_of(ROBOT, FOREIGN, &setup).unwrap_err().to_string();
    assert!(shown.contains("points.csv:1:1: column \"joint_44\" of [columns] is missing"), "{shown}");
    let shown = import_of(ROBOT, &FOREIGN.replace("-3.5", "n/a"), FOREIGN_SETUP).unwrap_err().to_string();
    assert!(shown.contains("points.csv:2:23: reflector_y_mm = \"n/a\""), "{shown}");
    let setup = FOREIGN_SETUP.replace("[\"joint_4\"]", "[]");
    let shown = import_of(ROBOT, FOREIGN, &setup).unwrap_err().to_string();
    assert!(shown.contains("setup.toml:7:10: columns.j4_deg = []"), "{shown}");
}

#[test]
fn a_setup_file_that_cannot_be_read_is_the_only_problem_of_good_points() {
    let setup = SETUP.replacen("ball_in_table_mm = [", "ball_in_table_mm = [np.float64(1.0), ", 1);
    assert_ne!(setup, SETUP);
    let found = import(POINTS, &setup).unwrap_err().0;
    assert!(found.iter().all(|problem| problem.file == "setup.toml"), "{found:?}");
}
