//! What a fitted model says of each axis over its own travel: location errors and component errors as tables.
//!
//! The joint twist of the model, Σ parameter · motion(state), is a table over an axis only where it depends on nothing but
//! that axis' own position. Every effect is therefore asked at states that differ in one thing at a time: what changes with
//! direction, speed, acceleration, time, temperature, setup, deflection or another axis is left out and named. A twist that
//! is the same everywhere is a location error [ISO 230-1: EX0C …], the rest are component errors [EXC …].
//!
//! error = actual − nominal pose of what the axis carries, in the nominal axes of what carries the axis, about a point of the
//! axis line (rotary) or the travelling carriage (linear), as everywhere in the program. Limits: valid over the measured
//! range of the axis. Of confounded parameters the fit keeps one representative: the pivot of their null direction is zero, the
//! others stand for it (`Identification::solution`). The tables hold that, since any representative moves the measured readings
//! alike (`representative`); which parameters are only known together is named.

mod representative;

pub use representative::Confounded;

use representative::{confounded, representative};
use std::collections::BTreeSet;
use trunnion_core::{AxisValues, Joint, Slot, State, Twist, convert};
use trunnion_effects::{Instance, Model, Role, Scene};
use trunnion_engine::{Experiment, FittedParameter, Identification, IdentifyError};
use trunnion_machine::{JointErrors, Site};

/// Between the rows of a table the straight line is this close, mm.
const STRAIGHT_MM: f64 = 0.02e-3;
/// The same for rotations, rad.
const STRAIGHT_RAD: f64 = 0.1e-6;
/// Widest steps that a table starts from: 10 mm, 5°.
const STEP_MM: f64 = 10.0;
/// See [`STEP_MM`].
const STEP_DEG: f64 = 5.0;
/// Most rows of a table.
const MOST_ROWS: usize = 4097;
/// A rotary axis measured over more than this has a table of a whole turn, rad.
const NEARLY_A_TURN: f64 = 300.0 / 180.0 * std::f64::consts::PI;
/// Twists that differ by less are the same, mm and rad.
const SAME: f64 = 1e-12;
/// States at which dependences are looked for.
const PROBES: usize = 7;

/// The errors of all axes that a model can put into tables.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisErrors {
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs the model was fitted to.
    pub runs: Vec<String>,
    /// Axes with any error, from the bed: table side, then tool side.
    pub axes: Vec<AxisTable>,
    /// Ids of the effects whose motions are in the tables.
    pub effects: Vec<String>,
    /// What is not in the tables.
    pub left_out: Vec<NotTabulated>,
    /// Parameters of which only a combination is known, and what stands for it in the tables.
    pub confounded: Vec<Confounded>,
}

/// The errors of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisTable {
    /// The axis.
    pub axis: Joint,
    /// Constant errors of place and direction, mm and rad.
    pub location: Twist,
    /// Positions of the rows, mm or rad, rising; empty without component errors.
    pub positions: Vec<f64>,
    /// Component errors at them, mm and rad.
    pub errors: Vec<Twist>,
    /// True when the table is a whole turn and goes on periodically.
    pub whole_turn: bool,
}

/// An effect, or some of its parameters, that no table of axis errors can hold.
#[derive(Clone, Debug, PartialEq)]
pub struct NotTabulated {
    /// Id of the effect.
    pub effect: String,
    /// Why.
    pub why: String,
    /// The parameter that holds an error of an axis at rest as well.
    pub holds_axis_at_rest: Option<String>,
}

/// An effect with the numbers found.
struct Fitted {
    id: String,
    instance: Instance,
    shape: Vec<f64>,
    values: Vec<f64>,
}

impl AxisErrors {
    /// Tables of a model fitted to an experiment.
    ///
    /// # Errors
    /// An effect the machine cannot have.
    pub fn new(experiment: &Experiment, model: &Model, fit: &Identification) -> Result<Self, IdentifyError> {
        let scene = &experiment.scene;
        let mut settings = BTreeSet::new();
        for entry in &model.effects {
            if Instance::from_model_effect(entry, &scene.machine)?.role() == Role::Setting {
                settings.insert(entry.id.as_str());
            }
        }
        let mut solution = representative(fit, &settings);
        let (mut tabulated, mut left_out) = (Vec::new(), Vec::new());
        for resting in fit.unobservable.iter().filter(|direction| direction.at_rest) {
            let machine_errors = resting.inside[1..]
                .iter()
                .map(|(j, _)| *j)
                .filter(|j| !settings.contains(fit.parameters[*j].effect.as_str()) && solution[*j] != 0.0);
            for j in machine_errors.collect::<Vec<_>>() {
                let FittedParameter { name, effect, .. } = &fit.parameters[j];
                solution[j] = 0.0;
                left_out.push(NotTabulated {
                    effect: effect.clone(),
                    why: format!(
                        "{name} holds {} as well, whose axis was at rest in these runs: entered, it would be right only where that axis stood. \
                         Measure with it at several positions",
                        resting.terms[0].0
                    ),
                    holds_axis_at_rest: Some(name.clone()),
                });
            }
        }
        for entry in &model.effects {
            let instance = Instance::from_model_effect(entry, &scene.machine)?;
            let of_effect = |(_, p): &(usize, &FittedParameter)| p.effect == entry.id;
            let found: Vec<(usize, &FittedParameter)> =
                fit.parameters.iter().enumerate().filter(of_effect).collect();
            let shape = fit.effects.iter().find(|e| e.id == entry.id).map_or(Vec::new(), |e| e.shape.clone());
            let values = found.iter().map(|(j, _)| solution[*j]).collect();
            let fitted = Fitted { id: entry.id.clone(), instance, shape, values };
            let unseen: Vec<&str> = found
                .iter()
                .filter(|(j, p)| !p.observable() && solution[*j] == 0.0)
                .map(|(_, p)| p.name.as_str())
                .collect();
            if let Some(why) = fitted.why_no_table(scene) {
                left_out.push(NotTabulated { effect: entry.id.clone(), why, holds_axis_at_rest: None });
                continue;
            }
            if !unseen.is_empty() {
                let why = format!("no number, taken as zero: {}", unseen.join(", "));
                left_out.push(NotTabulated { effect: entry.id.clone(), why, holds_axis_at_rest: None });
            }
            tabulated.push(fitted);
        }
        let held = |j: usize| tabulated.iter().any(|fitted: &Fitted| fitted.id == fit.parameters[j].effect);
        let axes = scene.machine.axes().map(|axis| table(scene, &tabulated, axis.letter));
        Ok(Self {
            machine: fit.machine.clone(),
            runs: fit.runs.clone(),
            axes: axes
                .filter(|table| table.location != Twist::default() || !table.errors.is_empty())
                .collect(),
            confounded: confounded(fit, &solution, held),
            effects: tabulated.into_iter().map(|fitted| fitted.id).collect(),
            left_out,
        })
    }
}

impl Fitted {
    /// Motions of all joints at a state; true when something other than the joints moves.
    fn motions(&self, scene: &Scene, state: &State) -> (JointErrors, bool) {
        let (mut joints, mut elsewhere) = (JointErrors::default(), false);
        self.instance.motions(scene, &self.shape, state, &mut |parameter, site, twist| {
            let part = twist * self.values[parameter];
            match site {
                Site::Joint(letter) => joints[letter] += part,
                Site::TableBall | Site::SpindleBall | Site::Reading | Site::Instrument(_) => {
                    elsewhere |= size(&part) > SAME;
                }
            }
        });
        (joints, elsewhere)
    }

    /// Why the effect is no function of each axis' own position; `None` when it is.
    fn why_no_table(&self, scene: &Scene) -> Option<String> {
        if self.values.iter().all(|value| *value == 0.0) {
            return Some("the data determine none of its numbers".into());
        }
        for probe in 0..PROBES {
            let here = state_at(scene, |letter| along(scene, letter, probe));
            let (joints, elsewhere) = self.motions(scene, &here);
            if elsewhere {
                return Some("it moves ball, nest or reading, not an axis".into());
            }
            let changes = |state: &State| {
                let (changed, elsewhere) = self.motions(scene, state);
                elsewhere || Slot::ALL.into_iter().any(|k| differ(&changed[k], &joints[k]))
            };
            if let Some(what) = changed_states(scene, &here).into_iter().find(|(_, state)| changes(state)) {
                return Some(format!("it depends on {}", what.0));
            }
            for other in scene.machine.axes().map(|axis| axis.letter) {
                let moved = state_at(scene, |letter| {
                    along(scene, letter, if letter == other { probe + 1 } else { probe })
                });
                let (changed, _) = self.motions(scene, &moved);
                let also = |joint: &Joint| *joint != other && differ(&changed[*joint], &joints[*joint]);
                if let Some(joint) = scene.machine.joints().into_iter().find(also) {
                    return Some(format!("its motion at {joint} depends on the position of {other}"));
                }
            }
        }
        None
    }
}

/// A state at rest with the axes where `position` says.
pub(crate) fn state_at(scene: &Scene, position: impl Fn(Joint) -> f64) -> State {
    State {
        position: AxisValues::of(scene.machine.joints(), position),
        time_s: scene.time_range_s.map(|(first, _)| first),
        temperature_degc: scene.first_temperature_degc.clone(),
        ..State::default()
    }
}

/// A place inside the measured range, another one for every probe and axis.
fn along(scene: &Scene, letter: Joint, probe: usize) -> f64 {
    let (low, high) = scene.position_range[letter];
    // Fractions of multiples of the golden ratio never repeat.
    let u = (0.61803 * (probe + 1) as f64 + 0.1731 * letter.index() as f64).fract();
    low + (high - low) * u
}

/// The state with one thing changed, and what that is.
pub(crate) fn changed_states(scene: &Scene, here: &State) -> Vec<(String, State)> {
    let mut all = Vec::new();
    for letter in scene.machine.axes().map(|axis| axis.letter) {
        let mut of_axis = |what: &str, change: &dyn Fn(&mut State)| {
            let mut state = here.clone();
            change(&mut state);
            all.push((format!("the {what} of {letter}"), state));
        };
        for direction in [-1.0, 1.0] {
            of_axis("direction", &|state| state.direction[letter] = direction);
            of_axis("speed", &|state| state.velocity[letter] = 10.0 * direction);
            of_axis("acceleration", &|state| state.acceleration[letter] = 10.0 * direction);
        }
        of_axis("travel since the last reversal", &|state| state.since_reversal[letter] = 0.5);
    }
    if let Some((first_s, last_s)) = scene.time_range_s {
        for part in [0.31, 0.77] {
            all.push((
                "time".into(),
                State { time_s: Some(first_s + (last_s - first_s) * part), ..here.clone() },
            ));
        }
    }
    for (channel, name) in scene.channels.iter().enumerate() {
        let mut state = here.clone();
        if let Some(degc) = state.temperature_degc.get_mut(channel) {
            *degc += 3.0;
        }
        all.push((format!("the temperature {name}"), state));
    }
    for setup in 1..scene.setups.len() {
        all.push(("the setup".into(), State { setup, ..here.clone() }));
    }
    let deflection_mm = nalgebra::Vector3::new(0.1, -0.07, 0.05);
    all.push(("the deflection of the probes".into(), State { deflection_mm, ..here.clone() }));
    all
}

fn table(scene: &Scene, effects: &[Fitted], letter: Joint) -> AxisTable {
    let at = |fitted: &Fitted, position: f64| {
        let state = state_at(scene, |axis| if axis == letter { position } else { along(scene, axis, 0) });
        fitted.motions(scene, &state).0[letter]
    };
    let (low, high) = scene.position_range[letter];
    let turn = letter.is_rotary() && high - low > NEARLY_A_TURN;
    let (from, to) = if turn { (0.0, std::f64::consts::TAU) } else { (low, high) };
    let constant = |fitted: &&Fitted| {
        let places = (0..PROBES).map(|k| from + (to - from) * (k as f64 + 0.37) / PROBES as f64);
        let first = at(fitted, from);
        places.into_iter().all(|place| !differ(&at(fitted, place), &first))
    };
    let (steady, changing): (Vec<&Fitted>, Vec<&Fitted>) = effects.iter().partition(constant);
    let sum = |effects: &[&Fitted], position: f64| {
        effects.iter().fold(Twist::default(), |sum, fitted| sum + at(fitted, position))
    };
    let location = sum(&steady, from);
    if changing.is_empty() || to <= from {
        return AxisTable {
            axis: letter,
            location,
            positions: Vec::new(),
            errors: Vec::new(),
            whole_turn: false,
        };
    }
    let (positions, errors) = rows(from, to, letter, &|position| sum(&changing, position));
    AxisTable { axis: letter, location, positions, errors, whole_turn: turn }
}

/// Rows close enough for straight lines between them.
fn rows(from: f64, to: f64, letter: Joint, error: &dyn Fn(f64) -> Twist) -> (Vec<f64>, Vec<Twist>) {
    let step = if letter.is_rotary() { convert::rad_from_deg(STEP_DEG) } else { STEP_MM };
    let mut count = ((to - from) / step - 1e-9).ceil().max(1.0) as usize;
    loop {
        let place = |k: f64| from + (to - from) * k / count as f64;
        let straight = (0..count).map(|k| k as f64).all(|k| {
            let middle = (error(place(k)) + error(place(k + 1.0))) * 0.5 + error(place(k + 0.5)) * -1.0;
            middle.translation_mm.amax() <= STRAIGHT_MM && middle.rotation_rad.amax() <= STRAIGHT_RAD
        });
        if straight || 2 * count + 1 > MOST_ROWS {
            let positions: Vec<f64> = (0..=count).map(|k| place(k as f64)).collect();
            let errors = positions.iter().map(|position| error(*position)).collect();
            return (positions, errors);
        }
        count *= 2;
    }
}

pub(crate) fn differ(a: &Twist, b: &Twist) -> bool {
    size(&(*a + *b * -1.0)) > SAME
}

/// Largest component, mm or rad.
pub(crate) fn size(twist: &Twist) -> f64 {
    twist.translation_mm.amax().max(twist.rotation_rad.amax())
}
