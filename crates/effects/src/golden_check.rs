//! Golden cases against the effects as they are computed.

use crate::golden::{ByAxis, Golden, Moment};
use crate::{Instance, Scene, SceneSetup, r_test_reading};
use nalgebra::{Point3, Vector3};
use trunnion_core::{AxisValues, Joint, State, convert};
use trunnion_machine::shipped;

/// A reading that a golden case expects, and what the effect gives there.
pub struct Checked {
    /// Expected, table axes, µm.
    pub expected_um: Vector3<f64>,
    /// Computed, table axes, µm.
    pub found_um: Vector3<f64>,
}

impl Moment {
    fn state(&self) -> State {
        State {
            position: inside(self.position),
            direction: by_letter(self.direction, |_, value| value),
            velocity: inside(self.velocity),
            acceleration: inside(self.acceleration),
            since_reversal: inside(self.since_reversal),
            time_s: Some(self.time_s),
            temperature_degc: vec![self.frame_degc],
            setup: self.setup,
            target: self.target,
            deflection_mm: self.deflection_mm.into(),
        }
    }
}

impl Golden {
    /// Every expected reading with the computed one.
    pub fn check(&self) -> Vec<Checked> {
        let (instance, scene, states) = self.placed();
        let parameters = instance.parameters(&scene);
        let on_screen =
            |name: &str| self.values.iter().find(|(known, _)| *known == name).map_or(0.0, |v| v.1);
        let values: Vec<f64> = parameters.iter().map(|p| on_screen(&p.name) / p.unit.per_inside).collect();
        let found_um = |state: &State| {
            let mut read_mm = Vector3::zeros();
            r_test_reading(&instance, &scene, self.shape, state, Point3::origin(), &mut |i, per_unit| {
                read_mm += per_unit * values[i];
            });
            read_mm.map(convert::um_from_mm)
        };
        let expected = self.moments.iter().zip(&states).filter_map(|(moment, state)| {
            Some(Checked { expected_um: moment.read_um?.into(), found_um: found_um(state) })
        });
        expected.collect()
    }

    /// Why the case cannot be checked: its moments do not show the effect, or it gives numbers that the effect does not have.
    pub fn flaw(&self) -> Option<String> {
        let (instance, scene, _) = self.placed();
        if let Some(why) = instance.out_of_reach(&scene) {
            return Some(format!("its moments do not show it: it {why}"));
        }
        let shapes = instance.shapes(&scene).names;
        if shapes.len() != self.shape.len() {
            return Some(format!("{} shape numbers, the effect has {shapes:?}", self.shape.len()));
        }
        let names: Vec<String> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
        let unknown = self.values.iter().find(|(name, _)| names.iter().all(|known| known != name));
        unknown.map(|(name, _)| format!("a value of \"{name}\", the effect has {names:?}"))
    }

    fn placed(&self) -> (Instance, Scene, Vec<State>) {
        let machine = shipped::machine("table-bc").expect("shipped machines parse (tested)");
        let instance = Instance::find(self.id, &machine).expect("golden cases are on table-bc (tested)");
        let setup = |(name, &ball_mm): (&str, &[f64; 3])| {
            SceneSetup::r_test(name, Point3::from(ball_mm)).with_plate()
        };
        let setups = ["low", "high"].into_iter().zip(self.balls_mm).map(setup).collect();
        let states: Vec<State> = self.moments.iter().map(Moment::state).collect();
        let scene = Scene::new(machine, setups, vec!["frame".into()], states.iter());
        (instance, scene, states)
    }
}

fn inside(values: ByAxis) -> AxisValues<f64> {
    by_letter(values, |letter, value| if letter.is_rotary() { value.to_radians() } else { value })
}

fn by_letter(values: ByAxis, inside: impl Fn(Joint, f64) -> f64) -> AxisValues<f64> {
    AxisValues::of(Joint::ALL, |letter| {
        values
            .iter()
            .find(|(name, _)| *name == letter.as_str())
            .map_or(0.0, |(_, value)| inside(letter, *value))
    })
}
