//! How large an effect is in the readings: raw, and after location errors and settings have swallowed their share.

use super::{
    Circumstances, Hidden, HiddenChoice, Kind, Place, SeenIn, TYPICAL_RMS_MM, UnknownHidden, find, fits,
};
use crate::physics::{VirtualMachine, grid, simulate_points};
use crate::truth::{SimSetup, Truth, minimum_set};
use nalgebra::{DMatrix, DVector, Vector3};
use rand_chacha::ChaCha8Rng;
use trunnion_core::State;
use trunnion_machine::Machine;

/// Small enough for every transform to be linear, large enough for every digit to count.
const PROBE_AMPLITUDE: f64 = 1e-6;

impl Hidden {
    /// Draws the shape of an effect and gives it the size asked for.
    ///
    /// # Errors
    /// Unknown id, an axis the machine has not, or an effect these setups cannot see.
    pub fn draw(
        choice: &HiddenChoice,
        machine: &Machine,
        setups: &[SimSetup],
        run_duration_s: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, UnknownHidden> {
        let (kind, place) = find(&choice.id)?;
        if !fits(machine, place) {
            return Err(UnknownHidden::NoSuchAxis { id: choice.id.clone(), machine: machine.name.clone() });
        }
        let states = states(kind, machine, setups, run_duration_s);
        let travel = travel(place, &states);
        let around = Circumstances { machine, place, setups: setups.len(), travel, run_duration_s };
        let shape = (kind.draw)(rng, &around);
        let mut hidden = Self { kind, place, amplitude: 1.0, shape };
        // Sized by a small amplitude, so that the exact transforms stay in their linear range.
        hidden.amplitude = PROBE_AMPLITUDE;
        let probed_mm = effect_rms_mm(&hidden, machine, setups, &states);
        if probed_mm < 1e-12 {
            return Err(UnknownHidden::NoEffect { id: choice.id.clone(), machine: machine.name.clone() });
        }
        hidden.amplitude *= choice.sigma * TYPICAL_RMS_MM / probed_mm;
        Ok(hidden)
    }
}

/// Smallest and largest coordinate of the axis at a place; zeros where there is none.
fn travel(place: Place, states: &[State]) -> (f64, f64) {
    let (Place::Axis(letter) | Place::Pair(letter, _)) = place else { return (0.0, 0.0) };
    let positions = || states.iter().map(|state| state.position[letter]);
    let low = positions().fold(f64::INFINITY, f64::min);
    let high = positions().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// The cycle in which a kind shows.
fn states(kind: &Kind, machine: &Machine, setups: &[SimSetup], run_duration_s: f64) -> Vec<State> {
    match kind.seen_in {
        SeenIn::StaticGrid | SeenIn::Turns => {
            grid::compressed(grid::standard_bc(machine, setups), run_duration_s)
        }
        SeenIn::OnTheFly => sweeps(machine, setups),
    }
}

fn sweeps(machine: &Machine, setups: &[SimSetup]) -> Vec<State> {
    let mut states = Vec::new();
    for (setup, placed) in setups.iter().enumerate() {
        for tilt_deg in [-45.0_f64, 0.0, 45.0] {
            let sweep = grid::Sweep {
                setup,
                tilt_rad: tilt_deg.to_radians(),
                feed_rad_per_s: 30_f64.to_radians(),
                samples: 72,
                start_s: 0.0,
            };
            states.extend(grid::c_sweep(machine, &placed.ball_in_table_mm, &sweep));
        }
    }
    states
}

/// Root mean square of what an effect adds to all readings of a list of states, mm.
pub fn effect_rms_mm(hidden: &Hidden, machine: &Machine, setups: &[SimSetup], states: &[State]) -> f64 {
    rms(&effect(hidden, machine, setups, states))
}

/// The same after least squares of the minimum set of location errors and of one offset of ball and nest for each setup.
pub fn surviving_rms_mm(hidden: &Hidden, machine: &Machine, setups: &[SimSetup], states: &[State]) -> f64 {
    let effect = effect(hidden, machine, setups, states);
    let base = base_columns(machine, setups, states);
    let fitted = base.clone().svd(true, true).solve(&effect, 1e-9 * base.amax());
    let solution = fitted.expect("both factors were asked for");
    rms(&(effect - base * solution))
}

fn effect(hidden: &Hidden, machine: &Machine, setups: &[SimSetup], states: &[State]) -> DVector<f64> {
    let mut truth = Truth::perfect(&machine.name, setups, 1.0);
    let nothing = readings(machine, truth.clone(), states);
    truth.hidden = vec![hidden.clone()];
    readings(machine, truth, states) - nothing
}

/// Derivatives by differences of one unit of each location error and setting.
fn base_columns(machine: &Machine, setups: &[SimSetup], states: &[State]) -> DMatrix<f64> {
    let perfect = Truth::perfect(&machine.name, setups, 1.0);
    let nothing = readings(machine, perfect.clone(), states);
    let mut columns = Vec::new();
    let mut change = |truth: Truth| columns.push((readings(machine, truth, states) - &nothing) / 1e-5);
    for error in minimum_set(machine) {
        let mut truth = perfect.clone();
        truth.location[error.axis] += error.twist() * 1e-5;
        change(truth);
    }
    for setup in 0..setups.len() {
        for direction in 0..3 {
            let mut truth = perfect.clone();
            truth.setups[setup].setting_mm = Vector3::ith(direction, 1e-5);
            change(truth);
        }
    }
    DMatrix::from_columns(&columns)
}

fn readings(machine: &Machine, truth: Truth, states: &[State]) -> DVector<f64> {
    let components: Vec<usize> =
        truth.setups.iter().map(|placed| placed.setup.instrument.components()).collect();
    let machine = VirtualMachine::new(machine.clone(), truth).expect("the truth was made for this machine");
    let points = simulate_points(&machine, states);
    let all = points.iter().zip(states).flat_map(|(point, state)| &point[..components[state.setup]]).copied();
    DVector::from_iterator(states.iter().map(|state| components[state.setup]).sum(), all)
}

fn rms(values: &DVector<f64>) -> f64 {
    (values.norm_squared() / values.len().max(1) as f64).sqrt()
}
