//! Figures and identities of the literature that are no reading of one effect: those are the golden cases of the catalogue.

use nalgebra::{Point3, Vector3};
use std::slice::from_ref;
use trunnion_core::{AxisValues, Joint, State, Twist};
use trunnion_effects::{Instance, Scene, SceneSetup};
use trunnion_machine::{Machine, Site, shipped};

fn table_bc() -> Machine {
    shipped::machine("table-bc").expect("shipped")
}

fn at(letter: Joint, position: f64) -> State {
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
fn forward_and_backward_phasors_make_any_fourier_term() {
    // cos 2C along X alone, as ISO 230-7 plots EXC: half of each phasor.
    for c in [0.0f64, 0.4, 2.0] {
        let state = at(Joint::C, c);
        let seen = twists("radial-error-motion:C", &[2.0], from_ref(&state), &state);
        let sum = (seen[0] * 0.5 + seen[2] * 0.5).translation_mm;
        assert!((sum - Vector3::x() * (2.0 * c).cos()).norm() < 1e-12, "{c} {sum}");
    }
}

#[test]
fn eleven_lobes_read_as_one_on_a_30_degree_grid() {
    // docs/design/statistics.md §4.4: harmonic n is identical to 12 − n on the S1 grid.
    for i in 0..12 {
        let state = at(Joint::C, f64::from(i) * 30f64.to_radians());
        let fine = twists("drive-pitch:C", &[11.0], from_ref(&state), &state);
        let coarse = twists("encoder-eccentricity:C", &[], from_ref(&state), &state);
        assert!((fine[0].rotation_rad - coarse[0].rotation_rad).norm() < 1e-12);
        assert!((fine[1].rotation_rad + coarse[1].rotation_rad).norm() < 1e-12);
    }
}

#[test]
fn a_vertical_weight_never_moves_the_frame_along_its_axis() {
    // gravity-sag is symmetric about the plane across the axis: no EYB.
    for b in [-1.5, 0.2, 1.0] {
        let state = at(Joint::B, b);
        let seen = twists("gravity-sag:B", &[], from_ref(&state), &state);
        assert!(seen.iter().all(|t| t.translation_mm.y.abs() < 1e-15));
        assert!((seen[2].rotation_rad.y - f64::sin(b)).abs() < 1e-15);
    }
}

fn setup(name: &str, ball_in_table_mm: Point3<f64>, run: usize) -> SceneSetup {
    SceneSetup { run, ..SceneSetup::r_test(name, ball_in_table_mm) }
}

/// C turns at 360°/min with X and Y following a ball at radius 200 mm.
fn following(machine: &Machine, ball_in_table_mm: &Point3<f64>) -> Vec<State> {
    let feed_rad_s = 360f64.to_radians() / 60.0;
    let at = |c: f64| {
        let mut position = AxisValues::default();
        position[Joint::C] = c;
        machine.follow(&position, ball_in_table_mm).expect("X, Y, Z reach the ball")
    };
    let state = |i: i32| {
        let c = f64::from(i) * 0.5;
        let (before, after) = (at(c - 1e-4), at(c + 1e-4));
        let velocity = AxisValues::from_fn(|l| feed_rad_s * (after[l] - before[l]) / 2e-4);
        State { position: at(c), velocity, ..State::default() }
    };
    (0..12).map(state).collect()
}

#[test]
fn rotary_axes_one_millisecond_late_on_a_followed_path_read_21_um_and_a_common_delay_reads_nothing() {
    // docs/design/physics.md §9.8: 21 µm per ms at 360°/min, R 200 mm (2π·200 mm/60 s·1 ms = 20.94 µm).
    let machine = table_bc();
    let ball = Point3::new(200.0, 0.0, 0.0);
    let states = following(&machine, &ball);
    let scene = Scene::new(machine.clone(), vec![setup("low", ball, 0)], Vec::new(), states.iter());
    assert!(scene.path.linear_with_rotary && !scene.path.changes_reading);
    let instance = Instance::find("sync-delay", &machine).unwrap();
    let names: Vec<String> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
    assert_eq!(names, ["rotary"]);
    for state in &states {
        let mut read_um = 0.0;
        instance.motions(&scene, &[], state, &mut |_, site, twist| {
            let Site::Joint(letter) = site else { panic!("{site:?}") };
            let frame = machine.joint_frame(letter, &state.position).unwrap();
            let point = machine.machine_from_table(&state.position, &Default::default()) * ball;
            read_um += frame.displacement_mm(&point, &(twist * 1e-3)).norm() * 1e3;
        });
        assert!((read_um - 20.94).abs() < 0.01, "{read_um}");
    }
    // The same turn with the linear axes at rest: only a delay of the probes, which is then all there is.
    let turning: Vec<State> = states
        .iter()
        .map(|state| {
            let velocity = AxisValues::from_fn(|l| if l.is_rotary() { state.velocity[l] } else { 0.0 });
            State { velocity, ..state.clone() }
        })
        .collect();
    let scene = Scene::new(machine.clone(), vec![setup("low", ball, 0)], Vec::new(), turning.iter());
    let names: Vec<String> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
    assert_eq!(names, ["probes"]);
}

/// Points every `step_s` while C turns.
fn sampled(step_s: f64, n: u32) -> Vec<State> {
    let state = |i: u32| {
        let mut state = State { time_s: Some(step_s * f64::from(i)), ..State::default() };
        state.velocity[Joint::C] = 0.1;
        state
    };
    (0..n).map(state).collect()
}

#[test]
fn one_micrometre_at_50_hz_shakes_with_a_hundredth_of_g() {
    // Vibration nomographs: acceleration = (2πf)²·displacement; 1 µm at 50 Hz is 0.0987 m/s².
    let states = sampled(1e-4, 400);
    let x_um: Vec<f64> =
        states.iter().map(|s| twists("vibration", &[50.0], &states, s)[0].translation_mm.x).collect();
    let bend = x_um.windows(3).map(|w| ((w[0] - 2.0 * w[1] + w[2]) / 1e-8).abs()).fold(0.0, f64::max);
    assert!((bend * 1e-6 - 0.0987).abs() < 1e-4, "{bend}");
}

#[test]
fn sixty_hertz_read_a_hundred_times_a_second_is_forty() {
    // Sampling theorem: f and f_s − f are the same to the samples, so the grid ends at f_s/2 = 50 Hz.
    let states = sampled(0.01, 100);
    for state in &states {
        let [fast, slow] = [60.0, 40.0].map(|f| twists("vibration", &[f], &states, state));
        assert!((fast[0].translation_mm - slow[0].translation_mm).norm() < 1e-9);
        assert!((fast[1].translation_mm + slow[1].translation_mm).norm() < 1e-9);
    }
    let machine = table_bc();
    let scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), states.iter());
    let grid = Instance::find("vibration", &machine).unwrap().shapes(&scene).grid;
    assert!(grid.iter().all(|f| (2.0..50.0).contains(&f[0])), "{grid:?}");
}

#[test]
fn each_run_has_its_own_course_of_temperature() {
    // Two runs, each with its own clock: one at rest at 20 °C, one that steps to 25 °C at its start and is felt by 63 % after τ.
    let machine = table_bc();
    let state = |setup: usize, time_s: f64, degc: f64| State {
        setup,
        time_s: Some(time_s),
        temperature_degc: vec![degc],
        ..State::default()
    };
    let mut states: Vec<State> = (0..=240).map(|i| state(0, f64::from(i), 20.0)).collect();
    states.extend((0..=240).map(|i| state(1, f64::from(i), if i == 0 { 20.0 } else { 25.0 })));
    let setups = vec![setup("1.low", Point3::origin(), 0), setup("2.low", Point3::origin(), 1)];
    let scene = Scene::new(machine, setups, vec!["frame".into()], states.iter());
    let felt = |setup: usize| scene.lagged_temperature_degc(0, 60.0, &state(setup, 60.5, 20.0)).unwrap();
    assert!((felt(0) - 20.0).abs() < 1e-12);
    assert!((felt(1) - (20.0 + 5.0 * 0.6321)).abs() < 1e-3, "{}", felt(1));
}

#[test]
fn without_a_clamp_signal_a_clamp_shows_only_between_rest_and_motion() {
    // Every stop shifts alike in static data: that is a location error (docs/design/physics.md §9.14).
    let machine = table_bc();
    let still = [at(Joint::C, 0.0), at(Joint::C, 1.0)];
    let mut moving = at(Joint::C, 2.0);
    moving.velocity[Joint::C] = 0.1;
    let clamp = Instance::find("clamp-shift:C", &machine).unwrap();
    let static_scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), still.iter());
    assert_eq!(
        clamp.out_of_reach(&static_scene).unwrap(),
        "needs readings of the axis both at rest and in motion"
    );
    let both = [still[0].clone(), moving.clone()];
    let shift = |state: &State| twists("clamp-shift:C", &[], &both, state)[0].translation_mm.x;
    assert_eq!((shift(&still[0]), shift(&moving)), (1.0, 0.0));
}
