//! No effect is another one by a second name.

use crate::scenes::{AT_ONE_POSE_FROM, machines, rich_states};
use nalgebra::{DMatrix, Point3, Vector3};
use trunnion_core::{AxisValues, Joint, State};
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Instance, Scene, SceneSetup, r_test_reading};
use trunnion_machine::Machine;

/// Sine of the largest angle between what two effects leave beyond the base model, below which they are one: of 100 µm of
/// either, 0.1 µm is left, the repeatability of a good probe at rest. Rounding leaves 1e-12; the nearest pair of the
/// catalogue, a reversal spike of 10° and backlash, is 0.3 apart.
const ONE_AND_THE_SAME: f64 = 1e-3;

/// Spindle-side ball of each setup: below the pivot of a head at two tool lengths, once off the line of the spindle.
const SPINDLE_BALLS_IN_TOOL_MM: [Point3<f64>; 3] =
    [Point3::new(0.0, 0.0, -120.0), Point3::new(0.0, 0.0, -220.0), Point3::new(30.0, 20.0, -120.0)];

/// Columns of an instance over all readings of a rich scene, for one shape.
fn columns(instance: &Instance, scene: &Scene, shape: &[f64], states: &[State]) -> DMatrix<f64> {
    let mut columns = DMatrix::zeros(3 * states.len(), instance.parameters(scene).len());
    for (point, state) in states.iter().enumerate() {
        let spindle_ball_in_tool_mm = SPINDLE_BALLS_IN_TOOL_MM[state.setup];
        r_test_reading(instance, scene, shape, state, spindle_ball_in_tool_mm, &mut |i, reading| {
            let mut rows = columns.view_mut((3 * point, i), (3, 1));
            rows += reading;
        });
    }
    columns
}

/// Orthonormal basis of the span of columns, each taken at length 1.
fn span(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    let longest = columns.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    columns.column_iter_mut().filter(|c| c.norm() > 1e-9 * longest).for_each(|mut c| {
        c.normalize_mut();
    });
    let svd = columns.svd(true, false);
    let kept = svd.singular_values.iter().filter(|s| **s > 1e-6).count();
    svd.u.expect("asked for").columns(0, kept).into_owned()
}

/// Three setups at two heights and two radii, both targets of a plate, rotary and linear axes at rest and in motion, each
/// axis with places, directions, speeds, accelerations and travel since its reversal of its own, temperatures, over time.
fn rich_scene(machine: &Machine) -> (Scene, Vec<State>) {
    // Steps by roots of primes: no two axes, and no two multiples of their angles, ever go together.
    let roots = [2.0f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0].map(f64::sqrt);
    let mut states = rich_states(machine);
    for (i, state) in states.iter_mut().enumerate() {
        let share = |letter: Joint, use_of: usize| {
            (0.5 + i as f64 * roots[(letter.index() + use_of) % roots.len()] * (1 + use_of) as f64).fract()
        };
        let way = |letter| if share(letter, 1) < 0.5 { -1.0 } else { 1.0 };
        let speed = |letter| if i % 3 == 0 { 0.0 } else { 0.1 + share(letter, 2) };
        state.setup = i % 4 % 3;
        state.target = i % 5 % 2;
        let stands = i >= AT_ONE_POSE_FROM;
        state.position = AxisValues::of(machine.joints(), |letter| match machine.axis(letter) {
            Some(axis) if !(stands && letter.is_rotary()) => {
                axis.travel.0 + (axis.travel.1 - axis.travel.0) * share(letter, 0)
            }
            _ => state.position[letter],
        });
        state.direction = AxisValues::of(machine.joints(), way);
        state.velocity = AxisValues::of(machine.joints(), |letter| way(letter) * speed(letter));
        state.acceleration =
            AxisValues::of(machine.joints(), |letter| speed(letter) * (share(letter, 3) - 0.5));
        // Each probe by its own way: a share of its neighbour's is no gain of it then.
        state.deflection_mm = Vector3::from(Joint::LINEAR.map(|letter| 0.2 * (share(letter, 5) - 0.5)));
        // Just after a reversal and long after it.
        let longest = |letter: Joint| if letter.is_rotary() { 0.3 } else { 10.0 };
        state.since_reversal =
            AxisValues::of(machine.joints(), |letter| longest(letter) * share(letter, 4).powi(3));
    }
    let setups = [("low", [150.0, 0.0, 60.0]), ("high", [150.0, 0.0, 160.0]), ("inner", [40.0, 60.0, 60.0])]
        .map(|(name, ball_mm)| SceneSetup::r_test(name, Point3::from(ball_mm)).with_plate());
    let scene = Scene::new(machine.clone(), setups.into(), vec!["frame".into()], states.iter());
    (scene, states)
}

/// Part of columns that a span does not hold, as an orthonormal basis.
fn beyond(base: &DMatrix<f64>, basis: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = (basis - base * base.tr_mul(basis)).svd(true, false);
    let kept = svd.singular_values.iter().filter(|s| **s > ONE_AND_THE_SAME).count();
    svd.u.expect("asked for").columns(0, kept).into_owned()
}

#[test]
fn no_effect_is_another_by_a_second_name_or_hidden_behind_the_base_model() {
    let mut same = Vec::new();
    for machine in machines() {
        let (scene, states) = rich_scene(&machine);
        let of_base = |id| columns(&Instance::find(id, &machine).unwrap(), &scene, &[], &states);
        let base = BASE.map(of_base);
        let base =
            span(DMatrix::from_columns(&base.iter().flat_map(|b| b.column_iter()).collect::<Vec<_>>()));
        let mut seen: Vec<(String, DMatrix<f64>)> = Vec::new();
        for instance in Instance::all(&machine).into_iter().filter(|instance| !instance.is_base()) {
            for shape in instance.shapes(&scene).grid {
                let all = span(columns(&instance, &scene, &shape, &states));
                let id = format!("{} {shape:?}", instance.id());
                let left = beyond(&base, &all);
                if left.is_empty() {
                    same.push(format!("{}: the base model holds all of {id}", machine.name));
                } else {
                    seen.push((id, left));
                }
            }
        }
        let instance = |id: &str| id.split(' ').next().map(String::from);
        for (k, (one, a)) in seen.iter().enumerate() {
            for (other, b) in &seen[..k] {
                if instance(one) != instance(other) && a.ncols() == b.ncols() {
                    let sine = (a - b * b.tr_mul(a)).svd(false, false).singular_values.max();
                    if sine < ONE_AND_THE_SAME {
                        same.push(format!(
                            "{}: {one} is {other}, sine of their angle {sine:.1e}",
                            machine.name
                        ));
                    }
                }
            }
        }
    }
    assert!(same.is_empty(), "{}", same.join("\n"));
}
