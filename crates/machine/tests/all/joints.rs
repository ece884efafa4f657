//! Machines of joints that are not called X Y Z A B C.

use nalgebra::{Point3, Vector3};
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::{JointErrors, Machine};

const ROBOT: &str = include_str!("../../../../config/robots/ur5.toml");
const TWO_CARRIAGES: &str = include_str!("../data/two-carriages.toml");

fn parse(text: &str) -> Machine {
    Machine::parse("m", "m.toml", text).unwrap_or_else(|problems| panic!("{problems}"))
}

fn problems(text: &str) -> String {
    Machine::parse("m", "m.toml", text).expect_err("refused").to_string()
}

#[test]
fn a_robot_has_six_rotary_joints_by_name() {
    let robot = parse(ROBOT);
    let names: Vec<&str> = robot.joints().iter().map(|joint| joint.as_str()).collect();
    assert_eq!(names, ["j1", "j2", "j3", "j4", "j5", "j6"]);
    assert!(robot.axes().all(|axis| axis.is_rotary()));
    assert_eq!(robot.joint("J4"), robot.tool.get(3).map(|axis| axis.letter));
    assert_eq!(robot.joint("B"), None, "a joint in the slot of B is not B");
}

/// The chain from directions and points against the product of Denavit-Hartenberg transforms
/// `Rz(q) Tz(d) Tx(a) Rx(α)` with the table of the UR5.
#[test]
fn the_chain_of_a_robot_is_that_of_its_denavit_hartenberg_table() {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};
    use std::f64::consts::FRAC_PI_2;
    let table = [
        (89.159, 0.0, FRAC_PI_2),
        (0.0, -425.0, 0.0),
        (0.0, -392.25, 0.0),
        (109.15, 0.0, FRAC_PI_2),
        (94.65, 0.0, -FRAC_PI_2),
        (82.3, 0.0, 0.0),
    ];
    let of_table = |q: &[f64; 6]| {
        table.iter().zip(q).fold(Isometry3::identity(), |sum: Isometry3<f64>, ((d, a, alpha), q)| {
            sum * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *q)
                * Translation3::new(*a, 0.0, *d)
                * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), *alpha)
        })
    };
    let robot = parse(ROBOT);
    let flange = Point3::from(of_table(&[0.0; 6]).translation.vector);
    for q in [[0.0; 6], [0.3, -0.8, 1.2, 0.4, -1.1, 2.0], [-2.0, -1.5, 0.7, -0.9, 0.6, -0.2]] {
        let position = AxisValues::of(robot.joints(), |joint| {
            q[robot.tool.iter().position(|axis| axis.letter == joint).unwrap()]
        });
        let found = robot.machine_from_tool(&position, &JointErrors::default()) * flange;
        let wanted = Point3::from(of_table(&q).translation.vector);
        assert!((found - wanted).norm() < 1e-9, "{q:?}: {found} {wanted}");
    }
}

#[test]
fn second_axes_and_a_spindle_are_joints() {
    let machine = parse(TWO_CARRIAGES);
    let spindle = machine.joint("spindle").unwrap();
    assert!(spindle.is_rotary());
    assert_eq!(machine.linear_joints(), [Joint::X, Joint::Y, Joint::Z, Joint::U, Joint::V, Joint::W]);
    let mut position = AxisValues::default();
    (position[Joint::X], position[Joint::U], position[spindle]) = (100.0, 7.0, 0.5);
    let tool = machine.machine_from_tool(&position, &JointErrors::default());
    assert_eq!(tool.translation.vector, Vector3::new(107.0, 0.0, 0.0));
    assert!((tool.rotation.angle() - 0.5).abs() < 1e-12);
}

#[test]
fn the_spindle_is_the_last_joint_of_the_tool() {
    let named =
        |name: &str| TWO_CARRIAGES.replace("\n[axis.C]", &format!("spindle = \"{name}\"\n\n[axis.C]"));
    let machine = parse(&named("spindle"));
    assert_eq!(machine.spindle, machine.joint("spindle"));
    assert_eq!(parse(TWO_CARRIAGES).spindle, None);
    for other in ["C", "W", "S"] {
        let text = problems(&named(other));
        assert!(text.contains("The spindle is the last joint of tool"), "{text}");
    }
}

#[test]
fn a_joint_without_a_table_is_refused_with_the_nearest_name() {
    let text = problems(&ROBOT.replace("[axis.j6]", "[axis.joint6]"));
    assert!(text.contains("j6 is missing"), "{text}");
    let text = problems(&TWO_CARRIAGES.replace("\"spindle\"", "\"spindel\""));
    assert!(text.contains("Did you mean spindle?"), "{text}");
}

#[test]
fn names_that_mean_something_else_are_refused() {
    let text = problems(&ROBOT.replace("j6", "pi"));
    assert!(text.contains("\"pi\" is not a name for a joint"), "{text}");
    let text = problems(&ROBOT.replace("j6", "vj1"));
    assert!(text.contains("vj1 is also a quantity of j1"), "{text}");
    let text = problems(&ROBOT.replace("j6", "dirB"));
    assert!(text.contains("dirB is also a quantity of B"), "{text}");
    let text = problems(&ROBOT.replace("\"j6\"]", "\"J5\"]"));
    assert!(text.contains("names J5 twice"), "{text}");
}

#[test]
fn a_joint_that_nobody_has_is_answered_with_the_nearest() {
    assert_eq!(parse(ROBOT).joints_near("j7"), "j1, j2, j3, j4, j5, j6");
    assert_eq!(
        parse(TWO_CARRIAGES).joints_near("spindel"),
        "X, Y, Z, spindle, C, U, V, W (did you mean spindle?)"
    );
}

#[test]
fn eight_rotary_joints_are_one_too_many() {
    let extra = |name: &str| {
        format!(
            "\n[axis.{name}]\nkind = \"rotary\"\ndirection = [0, 0, 1]\nthrough_mm = [0, 0, 0]\nsense = 1\ntravel_deg = [-90, 90]\n"
        )
    };
    let seven = ROBOT.replace("\"j6\"]", "\"j6\", \"j7\"]") + &extra("j7");
    assert_eq!(parse(&seven).joints().len(), 7);
    let eight = seven.replace("\"j7\"]", "\"j7\", \"j8\"]") + &extra("j8");
    assert!(problems(&eight).contains("at most 7 rotary joints"));
}

#[test]
fn counts_are_whole() {
    for key in ["gear_teeth", "bearing_rollers", "encoder_lines"] {
        let text = ROBOT.replacen("sense = 1", &format!("sense = 1\n{key} = 12.5"), 1);
        assert!(problems(&text).contains(&format!("{key} = 12.5")), "{}", problems(&text));
    }
}

#[test]
fn travel_that_is_missing_is_said_to_be_missing() {
    let travel = "travel_deg = [-360, 360]\n";
    let missing = problems(&ROBOT.replacen(travel, "", 1));
    assert!(missing.contains("travel_deg is missing in [axis.j1]"), "{missing}");
    assert!(!missing.contains("is not a range"), "{missing}");
    let turned = problems(&ROBOT.replacen(travel, "travel_deg = [360, -360]\n", 1));
    assert!(turned.contains("axis.j1.travel_deg is not a range"), "{turned}");
    let text = problems(&ROBOT.replacen(travel, "travel_deg = \"wide\"\n", 1));
    assert_eq!(text.matches("travel_deg").count(), 1, "{text}");
}
