//! The linear rule against the exact chain, and against the printed equations of the sources.

use super::*;
use crate::{Side, shipped};
use proptest::prelude::*;
use trunnion_core::axis::SLOTS;

fn errors_from(numbers: &[f64], scale: f64) -> JointErrors {
    let mut k = numbers.iter().map(|x| x * scale);
    let mut next = || k.next().expect("six numbers for each slot");
    JointErrors::from_fn(|_| Twist {
        translation_mm: Vector3::new(next(), next(), next()),
        rotation_rad: Vector3::new(next(), next(), next()) * 0.01,
    })
}

/// Sum of the linear displacements of a point fixed to the table or to the tool, machine axes, mm.
fn linear_displacement_mm(
    machine: &Machine,
    side: Side,
    position: &AxisValues<f64>,
    point_in_machine_mm: &Point3<f64>,
    errors: &JointErrors,
) -> Vector3<f64> {
    let axes = machine.from_bed(side).into_iter();
    let frames = axes.filter_map(|axis| Some((axis.letter, machine.joint_frame(axis.letter, position)?)));
    frames.map(|(letter, frame)| frame.displacement_mm(point_in_machine_mm, &errors[letter])).sum()
}

/// |exact − linear| of both sides for errors scaled by `scale`, mm.
fn disagreement_mm(
    machine: &Machine,
    q: &AxisValues<f64>,
    p: &Point3<f64>,
    numbers: &[f64],
    scale: f64,
) -> f64 {
    let errors = errors_from(numbers, scale);
    let none = JointErrors::default();
    [Side::Table, Side::Tool]
        .into_iter()
        .map(|side| {
            let pose = |e: &JointErrors| match side {
                Side::Table => machine.machine_from_table(q, e),
                Side::Tool => machine.machine_from_tool(q, e),
            };
            let nominal = pose(&none) * p;
            let exact = pose(&errors) * p - nominal;
            (exact - linear_displacement_mm(machine, side, q, &nominal, &errors)).norm()
        })
        .fold(0.0, f64::max)
}

fn robot() -> Machine {
    Machine::parse("robot", "robot.toml", include_str!("../../../../config/robots/ur5.toml")).unwrap()
}

fn two_carriages() -> Machine {
    let text = include_str!("../../tests/data/two-carriages.toml");
    Machine::parse("two-carriages", "two-carriages.toml", text).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn exact_and_linear_kinematics_agree_to_second_order_on_every_shipped_machine(
        numbers in prop::collection::vec(-1.0..1.0f64, 6 * SLOTS),
        q in prop::array::uniform13(-1.0..1.0f64),
        p in prop::array::uniform3(-200.0..200.0f64),
    ) {
        let shipped = shipped::FILES.iter().map(|(name, _)| shipped::machine(name).unwrap());
        for machine in shipped.chain([robot(), two_carriages()]) {
            let name = &machine.name;
            // Within the travel: beyond it legs stand nearly in one plane, where the second order has no limit.
            let mut within = AxisValues::default();
            for axis in machine.axes() {
                let (low, high) = axis.travel;
                within[axis.letter] = low + 0.5 * (1.0 + q[axis.letter.index()]) * (high - low);
            }
            let q = within;
            let coarse = disagreement_mm(&machine, &q, &Point3::from(p), &numbers, 0.1);
            let fine = disagreement_mm(&machine, &q, &Point3::from(p), &numbers, 0.01);
            // Ten times smaller errors: a hundred times smaller second-order terms (1e-9 mm of rounding allowed).
            prop_assert!(fine <= coarse * 0.011 + 1e-9, "{name}: {coarse} {fine}");
            prop_assert!(coarse < 0.1);
        }
    }
}

/// S1 eq. 8–9 with the mended sign (docs/design/physics.md §4: the reading is minus the printed equations):
/// change of the ball in table axes, for B errors (δ, α β γ) and C errors.
#[test]
fn the_reading_is_minus_equations_8_and_9_of_oyama() {
    let machine = shipped::machine("table-bc").unwrap();
    let b_error = Twist {
        translation_mm: Vector3::new(0.004, 0.006, 0.013),
        rotation_rad: Vector3::new(2.3e-4, -4e-5, 1.1e-4),
    };
    let c_error = Twist {
        translation_mm: Vector3::new(-0.003, 0.002, 0.005),
        rotation_rad: Vector3::new(5e-5, -7e-5, 3e-5),
    };
    let p = Vector3::new(150.0, -20.0, 60.0);
    for b_deg in [-90.0, -30.0, 0.0, 60.0f64] {
        for c_deg in [0.0, 30.0, 210.0f64] {
            let (sb, cb) = b_deg.to_radians().sin_cos();
            let (sc, cc) = c_deg.to_radians().sin_cos();
            let (tb, tc, rb, rc) =
                (b_error.translation_mm, c_error.translation_mm, b_error.rotation_rad, c_error.rotation_rad);
            let x = (tb.y + tc.y) * sc + (tb.x * cb - tb.z * sb + tc.x) * cc;
            let y = (tb.y + tc.y) * cc - (tb.x * cb - tb.z * sb + tc.x) * sc;
            let z = tb.x * sb + tb.z * cb + tc.z;
            let a = (rb.y + rc.y) * sc + (rb.x * cb - rb.z * sb + rc.x) * cc;
            let b = (rb.y + rc.y) * cc - (rb.x * cb - rb.z * sb + rc.x) * sc;
            let c = rb.x * sb + rb.z * cb + rc.z;
            let printed = Vector3::new(x - c * p.y + b * p.z, y + c * p.x - a * p.z, z - b * p.x + a * p.y);

            let mut q = AxisValues::default();
            q[Joint::B] = b_deg.to_radians();
            q[Joint::C] = c_deg.to_radians();
            let mut errors = JointErrors::default();
            errors[Joint::B] = b_error;
            errors[Joint::C] = c_error;
            let nominal_pose = machine.machine_from_table(&q, &JointErrors::default());
            let ball_in_machine = nominal_pose * Point3::from(p);
            let ball_in_table = machine.machine_from_table(&q, &errors).inverse() * ball_in_machine;
            let reading = ball_in_table.coords - p;
            // second order: 2.3e-4 rad · 0.04 mm ≈ 1e-5 mm
            assert!((reading + printed).norm() < 3e-5, "B {b_deg} C {c_deg}: {reading} against {printed}");
        }
    }
}

/// S2 eq. 1 with the mended slip (EAX·y in ez): three linear axes, angular errors with their arms.
#[test]
fn three_linear_axes_follow_the_review_model() {
    let machine = shipped::machine("three-axis").unwrap();
    let mut q = AxisValues::default();
    let (y, z) = (170.0, 90.0);
    (q[Joint::X], q[Joint::Y], q[Joint::Z]) = (130.0, y, z);
    let mut e = JointErrors::default();
    let (eax, ebx, ecx, eay, eby) = (1e-5, -2e-5, 3e-5, 4e-5, 5e-5);
    e[Joint::X] =
        Twist { translation_mm: Vector3::new(1e-3, 2e-3, 3e-3), rotation_rad: Vector3::new(eax, ebx, ecx) };
    e[Joint::Y] =
        Twist { translation_mm: Vector3::new(4e-3, 5e-3, 6e-3), rotation_rad: Vector3::new(eay, eby, 6e-5) };
    e[Joint::Z] = Twist {
        translation_mm: Vector3::new(7e-3, 8e-3, 9e-3),
        rotation_rad: Vector3::new(9e-5, 9e-5, 9e-5),
    };
    let tip = machine.machine_from_tool(&q, &JointErrors::default()) * Point3::origin();
    let d = linear_displacement_mm(&machine, Side::Tool, &q, &tip, &e);
    let expected = Vector3::new(12e-3 + (ebx + eby) * z - ecx * y, 15e-3 - (eax + eay) * z, 18e-3 + eax * y);
    assert!((d - expected).norm() < 1e-12, "{d} {expected}");
}

#[test]
fn following_the_ball_closes_the_gap_on_every_machine_that_can() {
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).unwrap();
        let ball = Point3::new(150.0, 10.0, 60.0);
        let mut q = AxisValues::default();
        (q[Joint::A], q[Joint::B], q[Joint::C]) = (0.4, -0.7, 2.0);
        let q = machine.follow(&q, &ball).unwrap();
        let none = JointErrors::default();
        let gap = machine.machine_from_table(&q, &none) * ball
            - machine.machine_from_tool(&q, &none) * Point3::origin();
        assert!(gap.norm() < 1e-9, "{name}: {gap}");
    }
}

#[test]
fn a_broken_machine_file_names_line_found_and_allowed() {
    let text =
        shipped::FILES[0].1.replace("sense = 1\ntravel_deg = [-110, 110]", "sense = 0\ntravel_deg = [110]");
    let problems = Machine::parse("m", "m.toml", &text).unwrap_err();
    let shown = problems.to_string();
    assert!(
        shown.contains("axis.B.sense") && shown.contains("1 or -1") && shown.contains("travel_deg"),
        "{shown}"
    );
    assert!(problems.0.iter().all(|p| p.line > 5), "{shown}");
}
