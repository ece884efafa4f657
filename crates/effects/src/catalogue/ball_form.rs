//! Form of the measured ball: the probes touch other places of it as it turns against the nest.
//!
//! d = Σ_i n_i f(R n_i),  f(u) = Σ_m a_m Y_lm(u),  l = 2 (oval) or 3 (three-lobed)       [docs/design/physics.md §9.16: function of contact direction; ISO 3290-1]
//! n_i direction from the ball centre to where probe i touches, nest axes; R = ball from nest, which changes with every
//! rotary axis between the two. l = 1 is the place of the ball's centre: a location error or the ball setting.
//! Y_lm: real surface harmonics of order m = 0…l about the ball's Z, P_l^m scaled to 1 where it is largest.
//! Probe triads: `triad` 0 along the nest's x, y, z; 1 three probes under the ball, square to each other, 120° apart.
//! Limits: probes square to each other; ball not turned in its holder or by the spindle; the probes touch flat.

use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::{UnitQuaternion, Vector3};
use trunnion_core::{State, Twist};
use trunnion_machine::{JointErrors, Machine, Side, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "ball-form",
    role: Role::CAUSE,
    about: About {
        title: "Form of the measured ball",
        source: "docs/design/physics.md §9.16; ISO 3290-1 (deviation from spherical form); Abramowitz & Stegun ch. 8 (surface harmonics)",
        equation: "d = Σ_i n_i f(R n_i), f = Σ a_m Y_lm, l = 2 (oval) or 3 (three-lobed)",
        symbols: "d error of the reading in nest axes; n_i direction from the ball to probe i; R ball from nest; f radius of the ball minus its mean, µm; a_m peak of each surface harmonic, µm (c0 about the ball's Z, c1 s1 … around it); shape numbers lobes = l, triad = 0 probes along x, y, z, 1 three probes under the ball",
        validity: "R-test with probes square to each other; the ball stays fixed in its holder; l = 1 is a place of the ball and belongs to location errors and setting.",
        typical: "0.05–0.3 µm (grade 5 ball: 0.13 µm)",
        explanation: "The ball is not quite round, and the probes touch another spot of it at every pose.",
        cause: "Ball of a low grade, worn, dirty or rusty; not an error of the machine.",
        seen_by: "Many poses of both rotary axes; the ball turned in its holder, or another ball, changes it and leaves the machine's errors.",
        needs: &[Need::ThreeComponents, Need::BallTurns],
        helps: &[Need::SeveralTilts, Need::FinerStep],
    },
    subjects: |machine: &Machine| {
        if machine.rotary().is_empty() { Vec::new() } else { vec![Subject::Whole] }
    },
    parameters,
    shapes: |_, _| Shapes {
        names: vec!["lobes".into(), "triad".into()],
        grid: [[2.0, 0.0], [2.0, 1.0], [3.0, 0.0], [3.0, 1.0]].map(Vec::from).into(),
        ..Shapes::default()
    },
    motions,
    example: Example {
        id: "ball-form",
        shape: &[2.0, 1.0],
        values: &[("c0", 0.1), ("c2", 0.2)],
        view: View::Poses,
    },
    golden: Golden {
        source: "ISO 3290-1 (grade 5: deviation from spherical form 0.13 µm)",
        derivation: "An oval ball, P₂ = 1 at the pole and −½ at the equator, amplitude 0.13/1.5 µm: z reads the pole, and after B = 90° the equator, 0.13 µm less.",
        id: "ball-form",
        shape: &[2.0, 0.0],
        values: &[("c0", 0.13 / 1.5)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([-0.0433, -0.0433, 0.0867]), ..Moment::AT_REST },
            Moment { position: &[("B", 90.0)], read_um: Some([0.0867, -0.0433, -0.0433]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

const NAMES: [&str; 7] = ["c0", "c1", "s1", "c2", "s2", "c3", "s3"];

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let three_components = scene.setups.iter().any(|setup| setup.components.len() == 3);
    if !three_components || !scene.machine.rotary().iter().any(|axis| scene.moves(axis.letter)) {
        return Vec::new();
    }
    NAMES.map(|name| Parameter::new(name, Unit::UM)).into()
}

fn motions(scene: &Scene, _: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(setup), &[lobes, triad]) = (scene.setups.get(state.setup), shape) else { return };
    if setup.components.len() != 3 {
        return;
    }
    let ball_from_nest = ball_from_nest(scene, setup.nest, state);
    let mut errors = [Vector3::zeros(); NAMES.len()];
    for to_probe_in_nest in contacts(triad) {
        let radius = surface_harmonics(lobes, &(ball_from_nest * to_probe_in_nest));
        for ((error, y), peak) in errors.iter_mut().zip(radius).zip(peaks(lobes)) {
            *error += to_probe_in_nest * (y / peak);
        }
    }
    for (m, error) in errors.into_iter().enumerate().take(2 * lobes as usize + 1) {
        emit(m, Site::Reading, Twist::translation(error));
    }
}

/// Ball axes are the tool's when the nest is on the table, the table's when it is in the spindle.
fn ball_from_nest(scene: &Scene, nest: Side, state: &State) -> UnitQuaternion<f64> {
    let none = JointErrors::default();
    let machine_from_table = scene.machine.machine_from_table(&state.position, &none).rotation;
    let machine_from_tool = scene.machine.machine_from_tool(&state.position, &none).rotation;
    match nest {
        Side::Table => machine_from_tool.inverse() * machine_from_table,
        Side::Tool => machine_from_table.inverse() * machine_from_tool,
    }
}

/// Directions from the ball centre to the places where the probes touch, nest axes.
fn contacts(triad: f64) -> [Vector3<f64>; 3] {
    if triad < 0.5 {
        return [Vector3::x(), Vector3::y(), Vector3::z()];
    }
    // Three edges of a cube that stands on its corner: each 54.7° from the downward diagonal.
    let (side, down) = ((2.0f64 / 3.0).sqrt(), (1.0f64 / 3.0).sqrt());
    [0.0f64, 120.0, 240.0].map(|around_deg| {
        let around = around_deg.to_radians();
        Vector3::new(side * around.cos(), side * around.sin(), -down)
    })
}

/// Largest P_l^m on the sphere, in the order of the parameters.
fn peaks(lobes: f64) -> [f64; 7] {
    if lobes < 2.5 {
        [1.0, 1.5, 1.5, 3.0, 3.0, 1.0, 1.0]
    } else {
        // 3/2·s(4 − 5s²) at s = √(4/15), 15·c·s² at c = √(1/3).
        let (p31, p32) = (4.0 * (4.0f64 / 15.0).sqrt(), 10.0 / 3.0f64.sqrt());
        [1.0, p31, p31, p32, p32, 15.0, 15.0]
    }
}

/// P_l^m cos mφ and sin mφ of degree 2 or 3 at a unit vector, in the order of the parameters.
fn surface_harmonics(lobes: f64, u: &Vector3<f64>) -> [f64; 7] {
    let (x, y, z) = (u.x, u.y, u.z);
    if lobes < 2.5 {
        let p21 = 3.0 * z;
        [(3.0 * z * z - 1.0) / 2.0, p21 * x, p21 * y, 3.0 * (x * x - y * y), 6.0 * x * y, 0.0, 0.0]
    } else {
        let p31 = 1.5 * (5.0 * z * z - 1.0);
        let cos3 = x * (x * x - 3.0 * y * y);
        let sin3 = y * (3.0 * x * x - y * y);
        [
            (5.0 * z * z * z - 3.0 * z) / 2.0,
            p31 * x,
            p31 * y,
            15.0 * z * (x * x - y * y),
            30.0 * z * x * y,
            15.0 * cos3,
            15.0 * sin3,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_harmonics_have_the_values_of_the_tables() {
        // Abramowitz & Stegun ch. 8: P2(0.5) = −0.125, P3(0.5) = −0.4375; at 60° from the pole without
        // the Condon–Shortley sign P21 = 3·0.5·sin 60° = 1.29904, P22 = 2.25, P31 = 1.5·(5/4 − 1)·sin 60° = 0.32476,
        // P32 = 15·0.5·0.75 = 5.625, P33 = 15·sin³60° = 9.74279.
        let at = Vector3::new(0.75f64.sqrt(), 0.0, 0.5);
        for (lobes, expected) in [
            (2.0, [-0.125, 1.29904, 0.0, 2.25, 0.0, 0.0, 0.0]),
            (3.0, [-0.4375, 0.32476, 0.0, 5.625, 0.0, 9.74279, 0.0]),
        ] {
            for (y, expected) in surface_harmonics(lobes, &at).into_iter().zip(expected) {
                assert!((y - expected).abs() < 1e-5, "{y} {expected}");
            }
        }
    }

    #[test]
    fn no_harmonic_is_larger_than_its_peak_and_each_reaches_it() {
        for lobes in [2.0, 3.0] {
            let mut largest = [0.0f64; 7];
            for i in 0..=180 {
                for j in 0..180 {
                    let (polar, around) = (f64::from(i).to_radians(), f64::from(2 * j).to_radians());
                    let u = Vector3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos());
                    for (most, y) in largest.iter_mut().zip(surface_harmonics(lobes, &u)) {
                        *most = most.max(y.abs());
                    }
                }
            }
            let count = 2 * lobes as usize + 1;
            for (most, peak) in largest.into_iter().zip(peaks(lobes)).take(count) {
                assert!((most / peak - 1.0).abs() < 2e-3, "{lobes} {most} {peak}");
            }
        }
    }

    #[test]
    fn a_ball_that_is_only_off_centre_would_read_its_offset() {
        // d = Σ n_i (a·R n_i) = Rᵀ a for probes square to each other: why l = 1 is left out.
        for triad in [0.0, 1.0] {
            let a = Vector3::new(0.3, -0.2, 0.5);
            let sum: Vector3<f64> = contacts(triad).iter().map(|n| n * a.dot(n)).sum();
            assert!((sum - a).norm() < 1e-12);
        }
    }
}
