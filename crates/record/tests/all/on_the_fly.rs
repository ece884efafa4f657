//! Tables of points on the fly: nothing is lost on the way out and in, and what a table does not state follows from its positions.

use proptest::prelude::*;
use trunnion_core::{AxisSample, AxisValues, Joint, Point, Quality, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::shipped;
use trunnion_record::{export, points_csv};

const SETUP: &str = include_str!("../../../../tests/data/points-gravity/setup.toml");

fn import(points: &str) -> Result<(Run, Vec<AxisSample>), String> {
    let (mut taken, mut axes) = (Vec::new(), Vec::new());
    let run = points_csv::visit_files(
        RunKind::OnTheFly,
        "run",
        ("points.csv", points),
        ("setup.toml", SETUP),
        &shipped::machine,
        &mut |_, point, actual| {
            taken.push(point);
            axes.extend(actual);
        },
    );
    run.map(|run| (Run { points: taken, ..run }, axes)).map_err(|problems| problems.to_string())
}

const HEADER: &str = "setup,time_s,x_mm,y_mm,z_mm,b_deg,c_deg,dx_um,dy_um,dz_um";

fn empty() -> Run {
    import(&format!("{HEADER},ambient_degc\nlow,0,0,0,0,0,0,0,0,0,20\n")).unwrap().0
}

/// Numbers of a machine: zeros, whole ones, and any between nanometres and metres.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(-1.0), -1e-6..1e-6, -1e3..1e3]
}

fn values() -> impl Strategy<Value = AxisValues<f64>> {
    proptest::array::uniform5(number()).prop_map(|q| {
        let joints = [Joint::X, Joint::Y, Joint::Z, Joint::B, Joint::C];
        let mut values = AxisValues::default();
        joints.into_iter().zip(q).for_each(|(joint, q)| values[joint] = q);
        values
    })
}

prop_compose! {
    fn sample()(
        step_s in 0.0..2.0,
        position in values(),
        direction in values(),
        velocity in values(),
        acceleration in values(),
        since_reversal in values(),
        actual in values(),
        reading_mm in proptest::array::uniform3(number()),
        spread_mm in proptest::array::uniform3(0.0..1e-2),
        (samples, setup, degc) in (0..5000_u32, 0..2_usize, -10.0..50.0),
    ) -> (f64, Point, AxisValues<f64>) {
        let state = State {
            position,
            direction: AxisValues(direction.0.map(|d| if d == 0.0 { 0.0 } else { d.signum() })),
            velocity,
            acceleration,
            since_reversal,
            temperature_degc: vec![degc],
            setup,
            ..State::default()
        };
        (step_s, Point { state, reading_mm, spread_mm, samples, quality: Quality::Good }, actual)
    }
}

/// Equal but for the last bit or two, which degrees and micrometres cost.
fn nearly_equal(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 4.0 * f64::EPSILON * a.abs())
}

fn numbers(point: &Point) -> Vec<f64> {
    let State {
        position, direction, velocity, acceleration, since_reversal, time_s, temperature_degc, ..
    } = &point.state;
    let axes = [position, direction, velocity, acceleration, since_reversal];
    let mut all: Vec<f64> = axes.into_iter().flat_map(|values| values.0).collect();
    all.extend(time_s);
    all.extend(temperature_degc);
    all.extend(point.reading_mm.iter().chain(&point.spread_mm));
    all
}

proptest! {
    #[test]
    fn a_run_on_the_fly_survives_export_and_import(
        samples in proptest::collection::vec(sample(), 1..20),
        with_encoders in any::<bool>(),
    ) {
        let (mut run, mut axes, mut time_s) = (empty(), Vec::new(), 0.0);
        run.points.clear();
        for (step_s, mut point, position) in samples {
            time_s += step_s;
            point.state.time_s = Some(time_s);
            run.points.push(point);
            // One reading of the encoders for each moment.
            if with_encoders && axes.last().is_none_or(|last: &AxisSample| last.time_s < time_s) {
                axes.push(AxisSample { time_s, position, ..AxisSample::default() });
            }
        }
        let text = export::points_csv_with_axes(&run, &axes);
        let (again, actual) = import(&text).map_err(TestCaseError::fail)?;
        prop_assert_eq!(again.points.len(), run.points.len());
        for (a, b) in run.points.iter().zip(&again.points) {
            prop_assert!(nearly_equal(&numbers(a), &numbers(b)), "{:?}\n{:?}", a, b);
            prop_assert_eq!((a.samples, a.state.setup), (b.samples, b.state.setup));
        }
        for point in again.points.iter().filter(|_| with_encoders) {
            let of = |axes: &[AxisSample]| {
                axes.iter().find(|axes| Some(axes.time_s) == point.state.time_s).map(|axes| axes.position.0)
            };
            prop_assert!(nearly_equal(&of(&axes).unwrap(), &of(&actual).unwrap()));
        }
    }
}

#[test]
fn speeds_accelerations_and_directions_follow_from_the_positions() {
    // C at 10 °/s, accelerating by 2 °/s².
    let row = |k: i32| {
        let t = 0.1 * f64::from(k);
        format!("low,{t},0,0,0,0,{},1,2,3\n", 10.0 * t + t * t)
    };
    let (run, axes) = import(&format!("{HEADER}\n{}", (0..20).map(row).collect::<String>())).unwrap();
    assert!(axes.is_empty());
    for (k, point) in run.points.iter().enumerate().skip(1).take(18) {
        let state = &point.state;
        assert!((state.velocity[Joint::C].to_degrees() - (10.0 + 0.2 * k as f64)).abs() < 1e-9, "{k}");
        assert!((state.acceleration[Joint::C].to_degrees() - 2.0).abs() < 1e-9, "{k}");
        assert_eq!((state.direction[Joint::C], state.direction[Joint::X]), (1.0, 0.0));
    }
}

#[test]
fn feed_gives_the_speed_of_a_path_without_time_and_a_spindle_is_kept() {
    let text = "setup,x_mm,y_mm,z_mm,b_deg,c_deg,feed_mm_per_min,dx_um,dy_um,dz_um,x_actual_mm,spindle_deg\n\
                low,0,0,0,0,0,600,1,2,3,0.001,30\nlow,3,4,0,0,0,600,1,2,3,3.001,60\n";
    let (run, axes) = import(text).unwrap();
    let speed = run.points[1].state.velocity;
    assert!((speed[Joint::X] - 6.0).abs() < 1e-12 && (speed[Joint::Y] - 8.0).abs() < 1e-12);
    assert_eq!(axes[1].position[Joint::X], 3.001);
    assert!(axes[1].position.0.iter().any(|q| *q == 60_f64.to_radians()), "{axes:?}");
}

#[test]
fn rows_out_of_order_are_refused_with_their_line() {
    let shown = import(&format!("{HEADER}\nlow,1,0,0,0,0,0,1,2,3\nlow,0.5,0,0,0,0,0,1,2,3\n")).unwrap_err();
    assert!(shown.contains("points.csv:3:1: time_s = 0.5 after 1"), "{shown}");
}
