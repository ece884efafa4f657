//! Effects against figures and identities from outside this program.

use nalgebra::Vector3;
use std::slice::from_ref;
use trunnion_effects::{Instance, Scene};
use trunnion_machine::{Machine, State, shipped};
use trunnion_units::{AxisLetter, Twist};

fn table_bc() -> Machine {
    shipped::machine("table-bc").expect("shipped")
}

fn at(letter: AxisLetter, position: f64) -> State {
    let mut state = State::default();
    state.position[letter] = position;
    state
}

/// Twist of each parameter at `state` in a scene of `scene_states`.
fn twists(id: &str, shape: &[f64], scene_states: &[State], state: &State) -> Vec<Twist> {
    let machine = table_bc();
    let scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), scene_states.iter());
    let instance = Instance::find(id, &machine).expect("known id");
    let mut twists = vec![Twist::default(); 6];
    instance.motions(&scene, shape, state, &mut |i, _, twist| twists[i] += twist);
    twists
}

#[test]
fn squareness_has_the_signs_of_the_review_model() {
    // S2 eq. 1 with constant angles: ex = EB0Z·z − EC0Y·y, ey = −EA0Z·z.
    let (y_mm, z_mm) = (168.0, 100.0);
    for (id, letter, travel_mm, expected) in [
        ("squareness:YX", AxisLetter::Y, y_mm, Vector3::new(-y_mm, 0.0, 0.0)),
        ("squareness:ZX", AxisLetter::Z, z_mm, Vector3::new(z_mm, 0.0, 0.0)),
        ("squareness:ZY", AxisLetter::Z, z_mm, Vector3::new(0.0, -z_mm, 0.0)),
    ] {
        let state = at(letter, travel_mm);
        assert_eq!(twists(id, &[], from_ref(&state), &state)[0].translation_mm, expected, "{id}");
    }
}

#[test]
fn a_two_micrometre_reversal_shift_moves_b_by_two_micrometres_between_directions() {
    // S4 §4.3, measurement B-Y: 2 µm axial displacement when B changes its direction.
    let way = |direction: f64| {
        let mut state = State::default();
        state.direction[AxisLetter::B] = direction;
        (twists("direction-shift:B", &[], from_ref(&state), &state)[1] * 2.0).translation_mm.y
    };
    assert_eq!(way(1.0) - way(-1.0), 2.0);
}

#[test]
fn forward_and_backward_phasors_make_any_fourier_term() {
    // cos 2C along X alone, as ISO 230-7 plots EXC: half of each phasor.
    for c in [0.0f64, 0.4, 2.0] {
        let state = at(AxisLetter::C, c);
        let seen = twists("radial-error-motion:C", &[2.0], from_ref(&state), &state);
        let sum = (seen[0] * 0.5 + seen[2] * 0.5).translation_mm;
        assert!((sum - Vector3::x() * (2.0 * c).cos()).norm() < 1e-12, "{c} {sum}");
    }
}

#[test]
fn eleven_lobes_read_as_one_on_a_30_degree_grid() {
    // DIAGNOSIS §4: harmonic n is identical to 12 − n on the S1 grid.
    for i in 0..12 {
        let state = at(AxisLetter::C, f64::from(i) * 30f64.to_radians());
        let fine = twists("drive-pitch:C", &[11.0], from_ref(&state), &state);
        let coarse = twists("encoder-eccentricity:C", &[], from_ref(&state), &state);
        assert!((fine[0].rotation_rad - coarse[0].rotation_rad).norm() < 1e-12);
        assert!((fine[1].rotation_rad + coarse[1].rotation_rad).norm() < 1e-12);
    }
}

#[test]
fn a_warm_up_has_done_63_percent_after_one_time_constant() {
    // 1 − 1/e = 0.6321: definition of the time constant of a first-order system.
    let timed = |time_s: f64| State { time_s: Some(time_s), ..State::default() };
    let states = [timed(100.0), timed(700.0)];
    let seen = twists("thermal-drift", &[600.0, 1e12], &states, &states[1]);
    assert!((seen[0].translation_mm.x - 0.6321).abs() < 1e-4);
    assert!(seen[3].translation_mm.norm() < 1e-8);
    let grown = twists("spindle-growth", &[600.0], &states, &states[1])[0].translation_mm;
    assert!((grown.z + 0.6321).abs() < 1e-4, "the tool tip moves away from the spindle");
}

#[test]
fn a_vertical_weight_never_moves_the_frame_along_its_axis() {
    // gravity-sag is symmetric about the plane across the axis: no EYB.
    for b in [-1.5, 0.2, 1.0] {
        let state = at(AxisLetter::B, b);
        let seen = twists("gravity-sag:B", &[], from_ref(&state), &state);
        assert!(seen.iter().all(|t| t.translation_mm.y.abs() < 1e-15));
        assert!((seen[2].rotation_rad.y - f64::sin(b)).abs() < 1e-15);
    }
}
