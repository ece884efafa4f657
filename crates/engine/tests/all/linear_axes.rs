//! Geometry of the linear axes in a rotary cycle: every machine has some of all of it, so several names are the plain answer where an expression
//! of two components may fit as well.

use crate::common::{points_run, set};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use trunnion_core::{Joint, Point, Twist};
use trunnion_effects::Model;
use trunnion_engine::diagnosis::Options;
use trunnion_engine::{Diagnosis, Experiment, Verdict, diagnose};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Site};

/// The run without a hidden effect, of a simulator that shares no code with this program, on axes with these angles of Y to X, Z to X and Z to Y
/// (E_C0Y, E_B0Z, E_A0Z) and these scales of X, Y and Z [ISO 230-1: signs of rotations].
fn with_axes(angles_urad: [f64; 3], scales_um_per_m: [f64; 3]) -> Diagnosis {
    let mut run = points_run("points-nothing-hidden");
    let [ec0y, eb0z, ea0z] = angles_urad.map(|urad| 1e-6 * urad);
    let scales = scales_um_per_m.map(|um| 1e-6 * um);
    for point in &mut run.points {
        let [x, y, z] = [Joint::X, Joint::Y, Joint::Z].map(|axis| point.state.position[axis]);
        let leaning = Vector3::new(-ec0y * y + eb0z * z, -ea0z * z, 0.0);
        let longer = Vector3::new(scales[0] * x, scales[1] * y, scales[2] * z);
        // The nest turns with the table, and reads in its axes.
        let [b, c] = [Joint::B, Joint::C].map(|axis| point.state.position[axis]);
        let table = Rotation3::from_axis_angle(&Vector3::y_axis(), b)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), c);
        let read = table.inverse() * (leaning + longer);
        for (reading_mm, mm) in point.reading_mm.iter_mut().zip(read.iter()) {
            *reading_mm += mm;
        }
    }
    let model = Model::base(&run.machine.name);
    diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap()
}

/// Sizes of either sign, none of which hides in the noise.
fn drawn(rng: &mut ChaCha8Rng) -> [f64; 3] {
    std::array::from_fn(|_| rng.random_range(12.0..40.0) * if rng.random_bool(0.5) { 1.0 } else { -1.0 })
}

#[test]
fn three_squarenesses_have_their_names_and_angles() {
    for seed in 1..=4 {
        let angles_urad = drawn(&mut ChaCha8Rng::seed_from_u64(seed));
        let found = with_axes(angles_urad, [0.0; 3]);
        assert_eq!(found.verdict, Verdict::MissingEffect, "{angles_urad:?}: {}", found.why);
        assert_eq!(set(&found), ["squareness:YX", "squareness:ZX", "squareness:ZY"], "{angles_urad:?}");
        let together = found.together.expect("three effects");
        assert!(together.adequate, "{angles_urad:?}: {}", found.why);
        for (name, injected) in ["EC0Y", "EB0Z", "EA0Z"].into_iter().zip(angles_urad) {
            let fitted = together.parameters.iter().find(|parameter| parameter.name == name).unwrap();
            let (value, u) = fitted.value.zip(fitted.u).expect("seen in this cycle");
            assert!((value - injected).abs() < 4.0 * u, "{name} = {value} ± {u}, injected {injected}");
        }
    }
}

/// The scale that all axes share is the size of the ball: five of the six can be separated. A diagnosis looks ahead as far as four.
#[test]
fn squarenesses_and_scales_together_have_names() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (angles_urad, scales_um_per_m) = (drawn(&mut rng), drawn(&mut rng));
    let found = with_axes(angles_urad, scales_um_per_m);
    let of_linear = |id: &&str| id.starts_with("squareness:") || id.starts_with("linear-scale:");
    assert_eq!(found.verdict, Verdict::MissingEffect, "{}", found.why);
    assert!(set(&found).iter().all(of_linear), "{:?}", set(&found));
    assert_eq!(found.set.len(), Options::default().look_ahead);
}

/// The run without a hidden effect, where the carriage of X pitches in proportion to its place and the raceway of C rocks twice a turn under the
/// weight's share across the axis. Of six components of the pitch, yaw and roll of X one is there.
fn with_pitch_and_loaded_tilt(pitch_urad: f64, tilt_urad: f64, phase: f64) -> Diagnosis {
    let mut run = points_run("points-nothing-hidden");
    let x = |point: &Point| point.state.position[Joint::X];
    let (low, high) = run.points.iter().map(x).fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    for point in &mut run.points {
        let state = &point.state;
        let s = (state.position[Joint::X] - 0.5 * (high + low)) / (0.5 * (high - low));
        let [b, c] = [Joint::B, Joint::C].map(|axis| state.position[axis]);
        let mut errors = Errors::default();
        errors.add(Site::Joint(Joint::X), Twist::rotation(Vector3::new(0.0, 1e-6 * pitch_urad * s, 0.0)));
        let (sin, cos) = (2.0 * c + phase).sin_cos();
        errors.add(
            Site::Joint(Joint::C),
            Twist::rotation(1e-6 * tilt_urad * b.sin() * Vector3::new(cos, sin, 0.0)),
        );
        let setup = &run.setups[state.setup];
        let moved = predict(&run.machine, setup, state, &errors)
            - predict(&run.machine, setup, state, &Errors::default());
        for (reading_mm, mm) in point.reading_mm.iter_mut().zip(moved.iter()) {
            *reading_mm += mm;
        }
    }
    let model = Model::base(&run.machine.name);
    diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap()
}

/// A name pays for six components where one is there; an expression pays for one.
#[test]
fn a_pitch_without_yaw_and_roll_has_its_name_next_to_another_effect() {
    for seed in 1..=4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (pitch_urad, tilt_urad) = (rng.random_range(8.0..30.0), rng.random_range(4.0..15.0));
        let found = with_pitch_and_loaded_tilt(pitch_urad, tilt_urad, rng.random_range(0.0..TAU));
        assert_eq!(found.verdict, Verdict::MissingEffect, "{pitch_urad}, {tilt_urad}: {}", found.why);
        assert_eq!(set(&found), ["angular-motion:X", "stacked-tilt:C"], "{pitch_urad}, {tilt_urad}");
        let together = found.together.expect("two effects");
        for turn in together.parameters.iter().filter(|parameter| parameter.effect == "angular-motion:X") {
            let injected = if turn.name == "EBX.P1" { pitch_urad } else { 0.0 };
            let (value, u) = turn.value.zip(turn.u).expect("seen in this cycle");
            assert!((value - injected).abs() < 4.0 * u, "{} = {value} ± {u}, injected {injected}", turn.name);
        }
    }
}
