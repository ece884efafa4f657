//! The poses of the usual cycles on a B–C table: the grid of S1 at rest, and a C sweep on the fly.
//!
//! S1 grid: B −90…90° step 30°, C 0…330° step 30° in one direction, then everything backwards, one setup
//! after the other; the linear axes follow the ball [docs/design/physics.md §4.1]. Times as on a real machine.

use crate::truth::SimSetup;
use nalgebra::Point3;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_machine::Machine;

/// A move to the next C and settling, s.
const POINT_S: f64 = 4.0;
/// What a change of B takes more, s.
const TILT_S: f64 = 6.0;
/// What a change of direction takes, s.
const TURN_ROUND_S: f64 = 6.0;
/// How far a rotary axis overruns to come from its side, degrees.
const OVERRUN_DEG: f64 = 10.0;
/// Fitting the next setup, s.
const REFIT_S: f64 = 190.0;

/// Where a rotary axis of a grid stands and where it turns round, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stations {
    /// The station with the smallest coordinate.
    pub first_deg: f64,
    /// From one to the next.
    pub step_deg: f64,
    /// How many.
    pub count: u32,
    /// The axis overruns this on its way up and down: smallest and largest coordinate of the cycle.
    pub ends_deg: [f64; 2],
}

impl Stations {
    /// The tilting axis of S1.
    pub const TILTING: Self = Self { first_deg: -90.0, step_deg: 30.0, count: 7, ends_deg: [-90.0, 90.0] };
    /// The turning axis of S1.
    pub const TURNING: Self = Self { first_deg: 0.0, step_deg: 30.0, count: 12, ends_deg: [0.0, 330.0] };

    fn upwards(self) -> impl Iterator<Item = f64> + Clone {
        (0..self.count).map(move |i| self.first_deg + f64::from(i) * self.step_deg)
    }

    /// Travel since the axis turned round, with its overrun, rad.
    fn since_reversal_rad(self, at_deg: f64, direction: f64) -> f64 {
        let [low, high] = self.ends_deg;
        (OVERRUN_DEG + if direction > 0.0 { at_deg - low } else { high - at_deg }).to_radians()
    }
}

/// The S1 grid for every setup, at rest. Rotary axes are the tilting and the turning one of the machine (B and C, or A and C).
/// Poses the linear axes cannot follow are left out; with both directions 168 points a setup.
pub fn standard_bc(machine: &Machine, setups: &[SimSetup]) -> Vec<State> {
    stations_bc(machine, setups, Stations::TILTING, Stations::TURNING)
}

/// As [`standard_bc`] with other stations of the tilting and of the turning axis.
pub fn stations_bc(machine: &Machine, setups: &[SimSetup], tilts: Stations, turns: Stations) -> Vec<State> {
    let [tilting, turning] = tilting_and_turning(machine);
    let mut states: Vec<State> = Vec::new();
    let mut time_s = -POINT_S;
    for (setup, placed) in setups.iter().enumerate() {
        let forward: Vec<(f64, f64)> =
            tilts.upwards().flat_map(|b_deg| turns.upwards().map(move |c_deg| (b_deg, c_deg))).collect();
        let backward: Vec<_> = forward.iter().rev().copied().collect();
        for (poses, direction) in [(forward, 1.0), (backward, -1.0)] {
            let mut last_tilt = poses[0].0;
            for &(b_deg, c_deg) in &poses {
                time_s += POINT_S + if b_deg == last_tilt { 0.0 } else { TILT_S };
                last_tilt = b_deg;
                let mut position = AxisValues::default();
                position[tilting] = b_deg.to_radians();
                position[turning] = c_deg.to_radians();
                let Some(position) = machine.follow(&position, &placed.ball_in_table_mm) else { continue };
                let mut state = State { position, time_s: Some(time_s), setup, ..State::default() };
                state.direction[tilting] = direction;
                state.direction[turning] = direction;
                // Every row of C is approached from the same side, with an overrun before its first pose.
                state.since_reversal[tilting] = tilts.since_reversal_rad(b_deg, direction);
                state.since_reversal[turning] = turns.since_reversal_rad(c_deg, direction);
                if let Some(before) = states.last() {
                    arrive(&mut state, before);
                }
                states.push(state);
            }
            time_s += TURN_ROUND_S;
        }
        time_s += REFIT_S - TURN_ROUND_S - POINT_S;
    }
    states
}

/// The same grid pressed into `duration_s`: order and shares of time kept.
pub fn compressed(mut states: Vec<State>, duration_s: f64) -> Vec<State> {
    let last_s = states.last().and_then(|state| state.time_s).unwrap_or(1.0);
    for state in &mut states {
        state.time_s = state.time_s.map(|time_s| time_s * duration_s / last_s);
    }
    states
}

/// Feeds and sampling of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// Index of the setup.
    pub setup: usize,
    /// The tilting axis stands here, rad.
    pub tilt_rad: f64,
    /// Feed of the turning axis, rad/s.
    pub feed_rad_per_s: f64,
    /// Samples a revolution.
    pub samples: u32,
    /// When it starts, s.
    pub start_s: f64,
}

/// One revolution of the turning axis each way on the fly, linear axes following: positions, velocities, accelerations.
pub fn c_sweep(machine: &Machine, ball_in_table_mm: &Point3<f64>, sweep: &Sweep) -> Vec<State> {
    let [tilting, turning] = tilting_and_turning(machine);
    let step_rad = std::f64::consts::TAU / f64::from(sweep.samples);
    let follow = |angle_rad: f64| {
        let mut position = AxisValues::default();
        position[tilting] = sweep.tilt_rad;
        position[turning] = angle_rad;
        machine.follow(&position, ball_in_table_mm)
    };
    let mut states = Vec::new();
    let mut time_s = sweep.start_s;
    for direction in [1.0, -1.0] {
        let first_rad = if direction > 0.0 { 0.0 } else { std::f64::consts::TAU };
        for i in 0..sweep.samples {
            let travelled_rad = step_rad * f64::from(i);
            let angle_rad = first_rad + direction * travelled_rad;
            let around = [angle_rad - step_rad, angle_rad, angle_rad + step_rad].map(follow);
            let [Some(before), Some(position), Some(after)] = around else { continue };
            let mut state = State { position, time_s: Some(time_s), setup: sweep.setup, ..State::default() };
            for (letter, _) in position.iter() {
                let slope = (after[letter] - before[letter]) / (2.0 * step_rad);
                let bend = (after[letter] - 2.0 * position[letter] + before[letter]) / step_rad.powi(2);
                let velocity = slope * sweep.feed_rad_per_s * direction;
                state.velocity[letter] = velocity;
                state.acceleration[letter] = bend * sweep.feed_rad_per_s.powi(2);
                state.direction[letter] = if velocity.abs() < 1e-9 { 0.0 } else { velocity.signum() };
            }
            state.since_reversal[turning] = travelled_rad;
            states.push(state);
            time_s += step_rad / sweep.feed_rad_per_s;
        }
        time_s += TURN_ROUND_S;
    }
    states
}

/// Notes how each linear axis arrived: direction of its last move, and travel since it last reversed.
fn arrive(state: &mut State, before: &State) {
    for letter in Joint::LINEAR {
        let moved = state.position[letter] - before.position[letter];
        let stands = moved.abs() < 1e-9;
        let direction = if stands { before.direction[letter] } else { moved.signum() };
        let so_far = if direction == before.direction[letter] { before.since_reversal[letter] } else { 0.0 };
        state.direction[letter] = direction;
        state.since_reversal[letter] = so_far + moved.abs();
    }
}

/// The axis nearest the bed and the one it carries; B and C when the machine has no two rotary axes.
pub fn tilting_and_turning(machine: &Machine) -> [Joint; 2] {
    match machine.rotary()[..] {
        [tilting, turning, ..] => [tilting.letter, turning.letter],
        _ => [Joint::B, Joint::C],
    }
}
