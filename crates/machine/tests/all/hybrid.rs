//! The hybrid machine of S3: closure, Jacobian, inverse kinematics, S3's two checks, and files that are wrong.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use proptest::prelude::*;
use trunnion_core::axis::iso::{A, C, X, Y, Z};
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::{JointErrors, Machine, shipped};

fn hybrid() -> Machine {
    shipped::machine("hybrid-exechon").unwrap()
}

fn strokes(x: f64, y: f64, z: f64) -> AxisValues<f64> {
    let mut q = AxisValues::default();
    (q[X], q[Y], q[Z]) = (x, y, z);
    q
}

fn text() -> String {
    shipped::FILES.iter().find(|(name, _)| *name == "hybrid-exechon").unwrap().1.to_string()
}

#[test]
fn at_zero_the_tool_is_at_the_origin_and_vertical() {
    let (place, direction) = hybrid().tool_in_table(&AxisValues::default());
    assert!(place.coords.norm() < 1e-12 && (direction.into_inner() - Vector3::z()).norm() < 1e-12);
}

/// S3 eq. 4–5 written out for the solved pose: B_i at the length of the leg from A_i, hinges as they must be.
#[test]
fn the_legs_have_their_lengths_and_the_hinges_their_directions() {
    let machine = hybrid();
    let tripod = machine.tripod.as_ref().unwrap();
    let at_zero = tripod.displacement(&AxisValues::default());
    assert!((at_zero.to_homogeneous() - nalgebra::Matrix4::identity()).amax() < 1e-12);
    for place in 0..125 {
        let at = |k: u32| f64::from(place / 5i32.pow(k) % 5 - 2) * 75.0;
        let q = strokes(at(0), at(1), at(2));
        assert!(tripod.closure_mm(&q).unwrap() < 1e-9);
        // The pose gives the strokes back: every joint is at the length of its leg.
        let back = tripod.strokes_mm(&tripod.displacement(&q));
        for letter in [X, Y, Z] {
            assert!((back[letter] - q[letter]).abs() < 1e-9, "{q:?} {back:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// The rate of every axis is the central difference of the exact pose: place and orientation.
    #[test]
    fn the_jacobian_is_the_derivative(q in prop::array::uniform5(-1.0..1.0f64), p in prop::array::uniform3(-300.0..300.0f64)) {
        let machine = hybrid();
        let none = JointErrors::default();
        let mut here = strokes(q[0] * 150.0, q[1] * 150.0, q[2] * 150.0);
        (here[C], here[A]) = (q[3] * 3.0, q[4] * 1.5);
        let p = Point3::from(p);
        let in_machine = machine.machine_from_tool(&here, &none) * p;
        for letter in [X, Y, Z, C, A] {
            let h = if letter.is_rotary() { 1e-5 } else { 1e-2 };
            let pose = |by: f64| {
                let mut moved = here;
                moved[letter] += by;
                machine.machine_from_tool(&moved, &none)
            };
            // Five points: where the legs of the tripod lie flat the third derivative is large, and two points
            // would be wrong by more than the tolerance.
            let (near, far) = ((pose(h), pose(-h)), (pose(2.0 * h), pose(-2.0 * h)));
            let derivative = |near: Vector3<f64>, far: Vector3<f64>| (near * 8.0 - far) / (12.0 * h);
            let difference = derivative(near.0 * p - near.1 * p, far.0 * p - far.1 * p);
            let between = |(after, before): &(Isometry3<f64>, Isometry3<f64>)| (after.rotation * before.rotation.inverse()).scaled_axis();
            let turning = derivative(between(&near), between(&far));
            let frame = machine.joint_frame(letter, &here).unwrap();
            let unit = machine.axis(letter).unwrap().positioning_twist();
            let scale = if letter.is_rotary() { 1e-5 } else { 1e-7 };
            prop_assert!((frame.displacement_mm(&in_machine, &unit) - difference).norm() < scale, "{letter}");
            prop_assert!((frame.turned(&unit).rotation_rad - turning).norm() < 1e-8, "{letter}");
        }
    }

    #[test]
    fn positions_found_for_a_place_and_a_direction_bring_the_tool_there(
        q in prop::array::uniform5(-1.0..1.0f64),
    ) {
        let machine = hybrid();
        let mut there = strokes(q[0] * 80.0, q[1] * 80.0, q[2] * 80.0);
        // Away from the pose in which the tool is along C, where C has no say.
        (there[C], there[A]) = (q[3] * 0.4, q[4] * 0.3);
        let (place, direction) = machine.tool_in_table(&there);
        let found = machine.reach(&AxisValues::default(), &place, &direction).expect("within reach");
        let (reached, along) = machine.tool_in_table(&found);
        prop_assert!((reached - place).norm() < 1e-8 && along.cross(&direction).norm() < 1e-11);
        for letter in [X, Y, Z, C, A] {
            prop_assert!((found[letter] - there[letter]).abs() < 1e-6, "{letter}: {found:?} {there:?}");
        }
    }
}

/// S3 §2.2 and fig. 3: ±20 mm along X and along Y in steps of 5 mm with the tool held vertical.
#[test]
fn linear_moves_of_20_mm_close() {
    let machine = hybrid();
    let tripod = machine.tripod.as_ref().unwrap();
    for along in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let mut last = AxisValues::default();
        for step in -4..=4 {
            let place = Point3::from(along * (5.0 * f64::from(step)));
            let q = machine.reach(&last, &place, &Vector3::z_axis()).expect("within reach");
            let (reached, direction) = machine.tool_in_table(&q);
            assert!((reached - place).norm() < 1e-8, "{place} {reached}");
            assert!(direction.cross(&Vector3::z()).norm() < 1e-11);
            assert!(tripod.closure_mm(&q).unwrap() < 1e-9);
            last = q;
        }
    }
}

/// S3 fig. 7–9: 10 µm at the reversal of axis 2 make about 30 µm in Y and 15 µm in Z, and nothing in X; the errors of the
/// actuator and the exact pose say the same.
#[test]
fn ten_micrometres_of_axis_2_move_the_tool_as_in_s3() {
    let machine = hybrid();
    let twist = machine.axis(Y).unwrap().positioning_twist() * 0.010;
    let mut errors = JointErrors::default();
    errors[Y] = twist;
    let moved = machine.machine_from_tool(&AxisValues::default(), &errors) * Point3::origin();
    let stroke =
        machine.machine_from_tool(&strokes(0.0, 0.010, 0.0), &JointErrors::default()) * Point3::origin();
    assert!((moved - stroke).norm() < 1e-12);
    assert!(moved.x.abs() < 1e-6, "{moved}");
    assert!((moved.y.abs() - 0.030).abs() < 0.0005 && (moved.z.abs() - 0.015).abs() < 0.0005, "{moved}");
}

#[test]
fn a_point_beyond_the_legs_is_refused_instead_of_guessed() {
    let machine = hybrid();
    let far = Point3::new(0.0, 0.0, 5000.0);
    assert_eq!(machine.follow(&AxisValues::default(), &far), None);
    assert_eq!(machine.reach(&AxisValues::default(), &far, &Unit::new_normalize(Vector3::z())), None);
    let q = strokes(-700.0, 0.0, 0.0);
    assert_eq!(machine.tripod.as_ref().unwrap().closure_mm(&q), None);
    assert!(machine.machine_from_tool(&q, &JointErrors::default()).translation.vector.x.is_nan());
}

#[test]
fn files_whose_legs_do_not_fit_are_refused_with_line_and_reason() {
    let check = |from: &str, to: &str, wanted: &[&str]| {
        let broken = text().replacen(from, to, 1);
        assert_ne!(broken, text(), "{from}");
        let problems = Machine::parse("h", "h.toml", &broken).unwrap_err();
        let shown = problems.to_string();
        assert!(wanted.iter().all(|word| shown.contains(word)), "{shown}");
        assert!(problems.0.iter().all(|problem| problem.line > 0), "{shown}");
    };
    check(
        "base_joint_mm = [500, 0, 0]",
        "base_joint_mm = [500, 3, 0]",
        &["base joints of legs X and Z", "one line"],
    );
    check("length_at_zero_mm = 722.773", "length_at_zero_mm = 72.2", &["cannot meet", "X 0.000, Y 0.000"]);
    check("travel_mm = [-150, 150]", "travel_mm = [-900, 150]", &["cannot meet", "X -900"]);
    check("kind = \"leg\"", "kind = \"linear\"", &["axis.X.kind", "leg"]);
    check("base_tilt_deg = 30\n", "", &["base_tilt_deg is missing"]);
    check("tool = [\"X\", \"Y\", \"Z\", \"C\", \"A\"]", "tool = [\"X\", \"Y\"]", &["fewer than three axes"]);
    let letters: Vec<_> = hybrid().axes().map(|axis| axis.letter).collect();
    assert_eq!(letters, [X, Y, Z, C, A] as [Joint; 5]);
}
