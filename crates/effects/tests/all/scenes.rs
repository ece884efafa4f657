//! Scenes in which every effect has something to show.

use nalgebra::{Point3, Vector3};
use trunnion_core::{AxisValues, Joint, State, Twist};
use trunnion_effects::{Instance, Scene, SceneSetup};
use trunnion_machine::{Machine, Site, shipped};

pub fn machines() -> Vec<Machine> {
    let other = [
        ("robot", include_str!("../../../../config/robots/ur5.toml")),
        ("two-carriages", include_str!("../../../machine/tests/data/two-carriages.toml")),
    ]
    .map(|(name, text)| Machine::parse(name, name, text).expect("a machine of other joints"));
    shipped::FILES.iter().map(|(name, _)| shipped::machine(name).expect("shipped")).chain(other).collect()
}

/// State of a rich scene from which on the rotary axes stand at one pose.
pub const AT_ONE_POSE_FROM: usize = 60;

/// States all over the travels of the machine, at rest and in motion, both ways, with time and a temperature.
pub fn rich_states(machine: &Machine) -> Vec<State> {
    let place = |i: usize, letter: Joint| {
        let (low, high) = machine.axis(letter).map_or((0.0, 0.0), |axis| axis.travel);
        let golden = (0.5 + (i * (letter.index() + 1)) as f64 * 0.618_033_988_75).fract();
        low + (high - low)
            * if i == 0 {
                0.0
            } else if i == 1 {
                1.0
            } else {
                golden
            }
    };
    (0..75)
        .map(|i| {
            let way = if i % 2 == 0 { 1.0 } else { -1.0 };
            let moving = f64::from(u8::from(i % 3 != 0));
            State {
                position: AxisValues::of(machine.joints(), |l| {
                    if l.is_rotary() { place(i.min(AT_ONE_POSE_FROM), l) } else { place(i, l) }
                }),
                direction: AxisValues::from_fn(|l| if (l.index()).is_multiple_of(2) { way } else { -way }),
                velocity: AxisValues::from_fn(|l| moving * way * (l.index() + 1) as f64 * 0.1),
                acceleration: AxisValues::from_fn(|l| moving * (i as f64 * 0.7 + l.index() as f64).sin()),
                since_reversal: AxisValues::from_fn(|_| i as f64 * 0.01),
                time_s: Some(i as f64 * 60.0),
                temperature_degc: vec![20.0 + (i as f64 / 10.0).sin()],
                setup: 0,
                target: i % 2,
                deflection_mm: Vector3::new(0.1, -0.05, 0.02) * (i as f64).cos(),
            }
        })
        .collect()
}

pub fn scene(machine: &Machine, states: &[State]) -> Scene {
    let setup = SceneSetup::r_test("low", Point3::new(150.0, 0.0, 60.0)).with_plate();
    let channels = states[0].temperature_degc.iter().map(|_| "frame".to_string()).collect();
    Scene::new(machine.clone(), vec![setup], channels, states.iter())
}

pub fn each_motion(
    instance: &Instance,
    scene: &Scene,
    states: &[State],
    mut check: impl FnMut(&[f64], usize, Site, Twist),
) {
    for shape in &instance.shapes(scene).grid {
        for state in states {
            instance.motions(scene, shape, state, &mut |i, site, twist| check(shape, i, site, twist));
        }
    }
}
