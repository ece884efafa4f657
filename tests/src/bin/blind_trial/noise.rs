//! Three kinds of noise: white, as real machines make it, and such as no bank of noise models contains.

use crate::stage::{Grid, RUN_S, SIGMA_MM};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};
use std::f64::consts::{FRAC_PI_2, TAU};
use trunnion_core::{Joint, State};
use trunnion_hil_sim::truth::Noise;
use trunnion_hil_sim::{Sampler, Truth};

/// Kind of noise of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 0.3 µm, independent.
    White,
    /// White, slow drift, pass offsets, re-positioning scatter, natural error motions, outliers.
    Real,
    /// Wandering with jumps, heavy tails, a size that depends on the pose, a slow sine.
    Foreign,
}

impl Kind {
    pub const ALL: [Self; 3] = [Self::White, Self::Real, Self::Foreign];

    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Real => "real",
            Self::Foreign => "foreign",
        }
    }
}

/// Degrees of freedom of the heavy tails; their variance is ν/(ν − 2).
const TAIL_FREEDOM: f64 = 4.0;
/// Size of the noise at B = 0 and what |B| = 90° adds, in units of σ: 1 rms over the grid.
const SIZE_OF_POSE: (f64, f64) = (0.55, 0.73);
/// Wandering: standard deviation after the whole run, mm.
const WANDER_MM: f64 = 0.25e-3;
/// Jumps in a run, and their size, mm.
const JUMPS: f64 = 2.0;
const JUMP_MM: f64 = 0.15e-3;
/// Amplitude of the slow sine, mm, and its period in shares of the run.
const SINE_MM: f64 = 0.1e-3;
const SINE_PERIODS: std::ops::Range<f64> = 0.1..0.35;

/// What the instrument reads, mm. `truth.seed` decides the noise.
pub fn read_mm(kind: Kind, grid: &Grid, truth: &Truth) -> Vec<[f64; 3]> {
    let noise = match kind {
        Kind::White => Noise { white_mm: SIGMA_MM, ..Noise::NONE },
        Kind::Real => Noise { white_mm: SIGMA_MM, ..Noise::real(RUN_S) },
        Kind::Foreign => Noise::NONE,
    };
    let machine = grid.machine(&Truth { noise, ..truth.clone() });
    let mut sampler = Sampler::new(&machine, 0);
    let mut readings_mm: Vec<[f64; 3]> =
        grid.states.iter().map(|state| sampler.read_mm(&machine, state)).collect();
    if kind == Kind::Foreign {
        add_foreign(&mut readings_mm, &grid.states, truth.seed);
    }
    readings_mm
}

fn add_foreign(readings_mm: &mut [[f64; 3]], states: &[State], seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(0x666f_7265);
    let tails = StudentT::new(TAIL_FREEDOM).expect("degrees of freedom are above zero");
    let tails_rms = (TAIL_FREEDOM / (TAIL_FREEDOM - 2.0)).sqrt();
    let sine = normal_vector(&mut rng).normalize() * SINE_MM;
    let (period_s, phase) = (RUN_S * rng.random_range(SINE_PERIODS), rng.random_range(0.0..TAU));
    let (mut wandered_mm, mut last_s) = (Vector3::zeros(), 0.0);
    for (reading_mm, state) in readings_mm.iter_mut().zip(states) {
        let time_s = state.time_s.unwrap_or(last_s);
        let share = (time_s - last_s) / RUN_S;
        last_s = time_s;
        wandered_mm += normal_vector(&mut rng) * (WANDER_MM * share.sqrt());
        let jump_mm = normal_vector(&mut rng) * JUMP_MM;
        if rng.random::<f64>() < JUMPS * share {
            wandered_mm += jump_mm;
        }
        let tool_in_machine_mm = wandered_mm + sine * (TAU * time_s / period_s + phase).sin();
        let in_table_mm = table_from_machine(state) * tool_in_machine_mm;
        let (upright, tilted) = SIZE_OF_POSE;
        let size_mm = SIGMA_MM * (upright + tilted * state.position[Joint::B].abs() / FRAC_PI_2);
        for (k, value) in reading_mm.iter_mut().enumerate() {
            *value += in_table_mm[k] + size_mm * tails.sample(&mut rng) / tails_rms;
        }
    }
}

/// Directions of the machine seen from the table: back by B about Y, then by C about Z.
fn table_from_machine(state: &State) -> Rotation3<f64> {
    let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), -state.position[Joint::B]);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), -state.position[Joint::C]);
    turn * tilt
}

fn normal_vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}
