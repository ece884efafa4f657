//! Golden cases: what an R-test reads of an effect, by a publication or by a formula of one worked by hand.
//!
//! Machine table-bc, nest on the table, readings in table axes: R_table⁻¹ (d_tool − d_table). A case proves sign, unit, frame
//! and site of an effect with a number that this program did not compute.

use crate::{Instance, Scene, SceneSetup, r_test_reading};
use nalgebra::{Point3, Vector3};
use trunnion_core::{AxisLetter, AxisValues, State, convert};
use trunnion_machine::shipped;

/// A case whose answer comes from outside this program.
pub struct Golden {
    /// Standard, paper, data sheet or table, with the place in it.
    pub source: &'static str,
    /// How the readings follow from it: a line or two that a person can check by hand.
    pub derivation: &'static str,
    /// Id on machine table-bc.
    pub id: &'static str,
    /// Shape numbers, inside units.
    pub shape: &'static [f64],
    /// Parameters that are not zero: name and value on the screen.
    pub values: &'static [(&'static str, f64)],
    /// Nominal centre of the table-side ball in table axes, mm: of setup `low`, then of setup `high`.
    pub balls_mm: &'static [[f64; 3]],
    /// What the machine does, in time order; together they are the scene.
    pub moments: &'static [Moment],
    /// Half of the last digit that the source gives, µm.
    pub within_um: f64,
}

/// Values of axes that are not zero, by letter.
pub type ByAxis = &'static [(&'static str, f64)];

/// One state of the machine and what is read there.
pub struct Moment {
    /// Positions, mm and degrees.
    pub position: ByAxis,
    /// Directions of approach, −1 or +1.
    pub direction: ByAxis,
    /// Velocities, mm/s and degrees/s.
    pub velocity: ByAxis,
    /// Accelerations, mm/s² and degrees/s².
    pub acceleration: ByAxis,
    /// Travel since the last reversal, mm and degrees.
    pub since_reversal: ByAxis,
    /// Seconds since the run began.
    pub time_s: f64,
    /// Value of the one temperature channel, `frame`, °C.
    pub frame_degc: f64,
    /// Deflection of the probes, nest axes, mm.
    pub deflection_mm: [f64; 3],
    /// Index of the setup.
    pub setup: usize,
    /// Index of the target of the plate.
    pub target: usize,
    /// What the effect adds to the reading, table axes, µm; `None` where the moment only belongs to the scene.
    pub read_um: Option<[f64; 3]>,
}

impl Moment {
    /// All axes at zero and at rest, at time 0 and 20 °C; nothing expected.
    pub const AT_REST: Self = Self {
        position: &[],
        direction: &[],
        velocity: &[],
        acceleration: &[],
        since_reversal: &[],
        time_s: 0.0,
        frame_degc: 20.0,
        deflection_mm: [0.0; 3],
        setup: 0,
        target: 0,
        read_um: None,
    };

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

/// A reading that a golden case expects, and what the effect gives there.
pub struct Checked {
    /// Expected, table axes, µm.
    pub expected_um: Vector3<f64>,
    /// Computed, table axes, µm.
    pub found_um: Vector3<f64>,
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

fn by_letter(values: ByAxis, inside: impl Fn(AxisLetter, f64) -> f64) -> AxisValues<f64> {
    AxisValues::of(AxisLetter::ALL, |letter| {
        values
            .iter()
            .find(|(name, _)| *name == letter.as_str())
            .map_or(0.0, |(_, value)| inside(letter, *value))
    })
}
