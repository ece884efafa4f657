//! What there is to see in the cell, as a function of time.

use crate::motion::Trajectory;
use trunnion_core::{AxisValues, State};

/// What the devices observe. Every function is pure: the same time gives the same answer, whoever asks.
/// `t_s` is time of the cell, s.
pub trait World: Send + Sync {
    /// Axis positions, mm and rad; what is commanded and what the encoders show are the same.
    fn axes(&self, t_s: f64) -> AxisValues<f64>;
    /// What the three probes read: deflection of the ball along each probe's direction, mm.
    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3];
    /// Change of length of the ball bar, mm.
    fn bar_reading_mm(&self, t_s: f64) -> f64;
    /// Temperature of the machine, °C.
    fn temperature_degc(&self, t_s: f64) -> f64;
    /// What the controller is executing.
    fn cycle(&self, t_s: f64) -> CycleState;
}

/// What the controller is executing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CycleState {
    /// Name of the program.
    pub program: String,
    /// Number of the block, 1 for the first step.
    pub block: usize,
    /// False before the start and after the end.
    pub running: bool,
}

/// Unit vectors of the probes of a nest, as rows, in nest axes: mutually perpendicular, each 54.74° from z, the first
/// over +x (Weikert, CIRP Annals 53 (2004) 429: three sensors on a tripod).
pub fn orthogonal_nest() -> [[f64; 3]; 3] {
    let (flat, up) = ((2.0_f64 / 3.0).sqrt(), (1.0_f64 / 3.0).sqrt());
    [0.0, 120.0, 240.0].map(|turn_deg: f64| {
        let turn = turn_deg.to_radians();
        [flat * turn.cos(), flat * turn.sin(), up]
    })
}

/// A function of the machine's state, as the physics supplies it.
pub type Reading<T> = Box<dyn Fn(&State) -> T + Send + Sync>;

/// The world of a simulated machine: a trajectory, the physics as functions of the state, and noise.
pub struct SimulatedCell {
    /// How the axes move.
    pub trajectory: Trajectory,
    /// Name of the program the controller shows.
    pub program: String,
    /// Index of the setup, given to the physics.
    pub setup: usize,
    /// Deflection of ball against nest in nest axes, mm.
    pub deflection_mm: Reading<[f64; 3]>,
    /// Change of length of the ball bar, mm.
    pub bar_mm: Reading<f64>,
    /// Temperature of the machine as a function of time, °C.
    pub temperature_degc: Box<dyn Fn(f64) -> f64 + Send + Sync>,
    /// Unit vectors of the probes in nest axes, as rows; see [`orthogonal_nest`].
    pub probe_directions: [[f64; 3]; 3],
    /// Standard deviation of the white noise of each probe and of the bar, mm.
    pub noise_mm: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl SimulatedCell {
    /// A machine that moves so; nothing deflects, it is 20 °C, the nest is orthogonal, and there is no noise.
    pub fn along(trajectory: Trajectory) -> Self {
        Self {
            trajectory,
            program: String::new(),
            setup: 0,
            deflection_mm: Box::new(|_| [0.0; 3]),
            bar_mm: Box::new(|_| 0.0),
            temperature_degc: Box::new(|_| 20.0),
            probe_directions: orthogonal_nest(),
            noise_mm: 0.0,
            seed: 1,
        }
    }

    /// Deflection in nest axes without noise, mm.
    pub fn true_deflection_mm(&self, t_s: f64) -> [f64; 3] {
        (self.deflection_mm)(&self.state(t_s))
    }

    /// Change of length of the ball bar without noise, mm.
    pub fn true_bar_mm(&self, t_s: f64) -> f64 {
        (self.bar_mm)(&self.state(t_s))
    }

    /// The machine's state at `t_s`.
    pub fn state(&self, t_s: f64) -> State {
        self.trajectory.at(t_s).state(t_s, vec![(self.temperature_degc)(t_s)], self.setup)
    }

    fn noise(&self, t_s: f64, channel: u64) -> f64 {
        if self.noise_mm == 0.0 { 0.0 } else { self.noise_mm * white(self.seed, t_s, channel) }
    }
}

impl World for SimulatedCell {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        self.trajectory.at(t_s).position
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        let deflection_mm = self.true_deflection_mm(t_s);
        let along = |direction: [f64; 3]| -> f64 { (0..3).map(|k| direction[k] * deflection_mm[k]).sum() };
        [0, 1, 2].map(|probe| along(self.probe_directions[probe]) + self.noise(t_s, probe as u64))
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.true_bar_mm(t_s) + self.noise(t_s, 3)
    }

    fn temperature_degc(&self, t_s: f64) -> f64 {
        (self.temperature_degc)(t_s)
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        let here = self.trajectory.at(t_s);
        CycleState { program: self.program.clone(), block: here.step + 1, running: here.running }
    }
}

/// A world whose program starts later: the devices are on before, as on a real floor.
pub struct Later<W> {
    /// What happens then.
    pub world: W,
    /// By how much later, s.
    pub by_s: f64,
}

impl<W: World> World for Later<W> {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        self.world.axes(t_s - self.by_s)
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        self.world.probe_readings_mm(t_s - self.by_s)
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.world.bar_reading_mm(t_s - self.by_s)
    }

    fn temperature_degc(&self, t_s: f64) -> f64 {
        self.world.temperature_degc(t_s - self.by_s)
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        self.world.cycle(t_s - self.by_s)
    }
}

/// Standard normal number that belongs to a seed, a sample and a channel; samples closer than 1 µs share theirs.
/// Box–Muller on two hashes.
fn white(seed: u64, t_s: f64, channel: u64) -> f64 {
    let sample = (t_s * 1e6).round() as i64 as u64;
    let bits = mix(mix(mix(seed) ^ sample) ^ channel);
    let uniform = |bits: u64| ((bits >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    let (radius, angle) = (uniform(bits), uniform(mix(bits)));
    (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
}

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
pub(super) fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_white_normal_and_repeatable() {
        let samples: Vec<f64> = (0..20_000).map(|k| white(7, f64::from(k) * 1e-3, 1)).collect();
        let mean = samples.iter().sum::<f64>() / 20_000.0;
        let variance = samples.iter().map(|x| x * x).sum::<f64>() / 20_000.0;
        let neighbours = samples.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 20_000.0;
        // Five standard deviations of each estimate
        assert!(mean.abs() < 0.036 && (variance - 1.0).abs() < 0.05 && neighbours.abs() < 0.036);
        assert_eq!(white(7, 0.123, 1), white(7, 0.123, 1));
        assert_ne!(white(7, 0.123, 1), white(7, 0.123, 2));
        assert_ne!(white(7, 0.123, 1), white(8, 0.123, 1));
    }

    #[test]
    fn the_probes_of_the_nest_are_perpendicular_unit_vectors() {
        let nest = orthogonal_nest();
        for i in 0..3 {
            for j in 0..3 {
                let dot: f64 = (0..3).map(|k| nest[i][k] * nest[j][k]).sum();
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
            assert!((nest[i][2].acos().to_degrees() - 54.7356).abs() < 1e-3);
        }
    }
}
