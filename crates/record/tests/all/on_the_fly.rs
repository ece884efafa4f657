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
    // At both ends too: the motion is a parabola.
    for (k, point) in run.points.iter().enumerate() {
        let state = &point.state;
        assert!((state.velocity[Joint::C].to_degrees() - (10.0 + 0.2 * k as f64)).abs() < 1e-9, "{k}");
        assert!((state.acceleration[Joint::C].to_degrees() - 2.0).abs() < 1e-9, "{k}");
        assert_eq!((state.direction[Joint::C], state.direction[Joint::X]), (1.0, 0.0));
    }
}

/// X = 50 cos ωt and Y = 50 sin ωt, a circle: at the ends of the pass as good as inside, and each axis turns where it turns.
#[test]
fn a_circle_has_its_speeds_at_both_ends_and_its_directions_at_every_row() {
    let (radius_mm, rad_per_s, step_s) = (50.0, 0.4, 0.1);
    let angle = |k: usize| rad_per_s * (step_s * k as f64 + 1.03);
    let row = |k: usize| {
        let (sin, cos) = angle(k).sin_cos();
        format!("low,{},{:.9},{:.9},0,0,0,1,2,3\n", step_s * k as f64, radius_mm * cos, radius_mm * sin)
    };
    let (run, _) = import(&format!("{HEADER}\n{}", (0..160).map(row).collect::<String>())).unwrap();
    for (k, point) in run.points.iter().enumerate() {
        let (sin, cos) = angle(k).sin_cos();
        let state = &point.state;
        for (joint, speed, acceleration, crest_mm) in [
            (Joint::X, -rad_per_s * radius_mm * sin, -rad_per_s.powi(2) * radius_mm * cos, radius_mm * cos),
            (Joint::Y, rad_per_s * radius_mm * cos, -rad_per_s.powi(2) * radius_mm * sin, radius_mm * sin),
        ] {
            // h²/3 of the third derivative at an end, h²/6 inside.
            let of_third = rad_per_s.powi(3) * radius_mm * step_s * step_s;
            assert!((state.velocity[joint] - speed).abs() < 0.34 * of_third, "{joint} {k}");
            assert!(
                (state.acceleration[joint] - acceleration).abs() < 1.01 * of_third / step_s,
                "{joint} {k}"
            );
            assert_eq!(state.direction[joint], speed.signum(), "{joint} {k}");
            // It turns at ± 50 mm, up to 8 µm beyond the last row before.
            let first_mm = run.points[0].state.position[joint];
            let turned_before =
                run.points[..=k].iter().any(|other| other.state.direction[joint] != state.direction[joint]);
            let since_mm = if turned_before {
                radius_mm + crest_mm * speed.signum()
            } else {
                (state.position[joint] - first_mm).abs()
            };
            assert!(
                (state.since_reversal[joint] - since_mm).abs() < 2e-4,
                "{joint} {k}: {} {since_mm}",
                state.since_reversal[joint]
            );
        }
    }
}

/// There and back in two passes: at the first row back the axis goes back.
#[test]
fn a_pass_back_goes_back_from_its_first_row() {
    let row = |k: usize| {
        let (pass, at) = (k / 10, k % 10);
        let time_s = 0.1 * at as f64 + 5.0 * pass as f64;
        let degrees = if pass == 0 { at } else { 9 - at };
        format!("low,{time_s},0,0,0,0,{degrees},1,2,3\n")
    };
    let (run, _) = import(&format!("{HEADER}\n{}", (0..20).map(row).collect::<String>())).unwrap();
    let of = |of: fn(&State) -> f64| run.points.iter().map(|point| of(&point.state)).collect::<Vec<f64>>();
    let directions = of(|state| state.direction[Joint::C]);
    assert_eq!(directions, [[1.0; 10], [-1.0; 10]].concat());
    let since_deg = of(|state| state.since_reversal[Joint::C].to_degrees().round());
    assert_eq!(since_deg[10..], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
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

#[test]
fn columns_of_a_run_on_the_fly_in_points_at_rest_name_the_option() {
    let text = "setup,x_mm,y_mm,z_mm,b_deg,c_deg,feed_mm_per_min,dx_um,dy_um,dz_um,x_actual_mm,force_n\n\
                low,0,0,0,0,0,600,1,2,3,0.001,30\n";
    let at_rest =
        points_csv::import_files("run", ("points.csv", text), ("setup.toml", SETUP), &shipped::machine);
    let problems = at_rest.unwrap_err().0;
    let named: Vec<bool> =
        problems.iter().map(|problem| problem.advice.contains("--kind on-the-fly")).collect();
    assert_eq!(named, [true, true, false], "{problems:?}");
    // With the option, the one that no run has is left.
    let shown = import(text).unwrap_err();
    assert!(shown.contains("force_n") && !shown.contains("--kind"), "{shown}");
}
