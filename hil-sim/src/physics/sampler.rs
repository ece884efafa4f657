//! Noisy readings: the parts of docs/design/statistics.md §1.1.
//!
//! white + pass offset + Ornstein–Uhlenbeck drift `x ← a x + √(1 − a²) σ ξ`, `a = exp(−Δt/τ)`, + scatter of
//! the tilting axis at each positioning + outliers. Offsets and drift are in machine axes at the tool. Same seed, same noise.

use super::grid::tilting_and_turning;
use super::natural::normal_vector;
use super::{Disturbance, VirtualMachine, chain};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{Joint, State, Twist};

/// Reads a virtual machine in the order of time.
#[derive(Clone, Debug)]
pub struct Sampler {
    rng: ChaCha8Rng,
    drift_mm: Vector3<f64>,
    last_time_s: Option<f64>,
    pass: Option<Pass>,
    pass_offset_mm: Vector3<f64>,
    tilt: Option<f64>,
    tilt_scatter_rad: f64,
    outlier_mm: Vector3<f64>,
}

/// What makes one pass: setup and directions of the rotary axes.
#[derive(Clone, Debug, PartialEq)]
struct Pass {
    setup: usize,
    directions: [f64; 2],
}

impl Sampler {
    /// A sampler with the noise the truth's seed gives; `run` distinguishes several runs of one machine.
    pub fn new(machine: &VirtualMachine, run: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(machine.truth().seed);
        rng.set_stream(run + 1);
        let drift_mm = normal_vector(&mut rng) * machine.truth().noise.drift_mm;
        Self {
            rng,
            drift_mm,
            last_time_s: None,
            pass: None,
            pass_offset_mm: Vector3::zeros(),
            tilt: None,
            tilt_scatter_rad: 0.0,
            outlier_mm: Vector3::zeros(),
        }
    }

    /// One settled reading of the setup the state names, mm: white noise, drift, offsets and now and then an outlier.
    pub fn read_mm(&mut self, machine: &VirtualMachine, state: &State) -> [f64; 3] {
        let still_mm = self.still_mm(machine, state);
        let noise = &machine.truth().noise;
        let white_mm = normal_vector(&mut self.rng) * noise.white_mm;
        let off = self.rng.random::<f64>() < noise.outlier_share;
        let hit = normal_vector(&mut self.rng) * noise.outlier_mm;
        let outlier_mm = if off { hit } else { Vector3::zeros() };
        self.outlier_mm = outlier_mm;
        std::array::from_fn(|i| still_mm[i] + white_mm[i] + outlier_mm[i])
    }

    /// The reading with everything that does not change while the machine is at rest: no white noise, no outlier.
    /// For devices that sample on and make their own white noise.
    pub fn still_mm(&mut self, machine: &VirtualMachine, state: &State) -> [f64; 3] {
        let noise = machine.truth().noise;
        let [tilting, turning] = tilting_and_turning(machine.machine());
        self.drift(noise.drift_mm, noise.drift_time_s, state.time_s);
        let pass =
            Pass { setup: state.setup, directions: [state.direction[tilting], state.direction[turning]] };
        if self.pass.as_ref() != Some(&pass) {
            self.pass = Some(pass);
            self.pass_offset_mm = normal_vector(&mut self.rng) * noise.pass_offset_mm;
        }
        self.position(tilting, noise.repeatability_rad, state);
        let scatter = Twist::rotation(chain::unit(tilting) * self.tilt_scatter_rad);
        let extra =
            Disturbance::joint(tilting, scatter) + Disturbance::tool(self.drift_mm + self.pass_offset_mm);
        machine.disturbed_reading_mm(state.setup, state, extra)
    }

    /// The outlier that was added to the last reading, mm; zero for most.
    pub fn last_outlier_mm(&self) -> [f64; 3] {
        self.outlier_mm.into()
    }

    fn drift(&mut self, drift_mm: f64, drift_time_s: f64, time_s: Option<f64>) {
        let elapsed_s = match (self.last_time_s, time_s) {
            (Some(last), Some(now)) => (now - last).max(0.0),
            _ => 0.0,
        };
        self.last_time_s = time_s.or(self.last_time_s);
        let kept = (-elapsed_s / drift_time_s).exp();
        let fresh = normal_vector(&mut self.rng) * (drift_mm * (1.0 - kept * kept).sqrt());
        self.drift_mm = self.drift_mm * kept + fresh;
    }

    /// A new scatter for each new place where the tilting axis stands.
    fn position(&mut self, tilting: Joint, repeatability_rad: f64, state: &State) {
        let here = state.position[tilting];
        if state.velocity[tilting] == 0.0 && self.tilt != Some(here) {
            self.tilt = Some(here);
            let draw: f64 = StandardNormal.sample(&mut self.rng);
            self.tilt_scatter_rad = draw * repeatability_rad;
        }
    }
}
