//! What one pass of a run held: one setup, one direction of the rotary axes, one feed.

use super::spectrum::{Noise, Pyramid};
use super::{Sample, UNIT};
use std::collections::HashMap;
use trunnion_core::axis::SLOTS;
use trunnion_core::{AxisValues, Joint, Point, Slot, State};

/// Ratio of neighbouring classes of feed.
const FEED_CLASS: f64 = 1.25;
/// Samples from which on a pass speaks for its own noise.
const ENOUGH: u64 = 512;

/// A pass of a run, as counted while it was reduced.
#[derive(Clone, Debug, PartialEq)]
pub struct PassSummary {
    /// Index of the setup.
    pub setup: usize,
    /// Direction of travel of the rotary axes; of no axis when none turns.
    pub direction: AxisValues<f64>,
    /// Mean speed of each axis, mm/s and rad/s.
    pub speed: AxisValues<f64>,
    /// Samples averaged.
    pub samples: u64,
    /// Samples excluded.
    pub excluded: u64,
    /// Blocks they became.
    pub blocks: usize,
    /// Time from sample to sample, s; `None` without time.
    pub step_s: Option<f64>,
    /// What the readings hold beyond the blocks, fastest octave first.
    pub bands: Vec<Band>,
}

/// One octave of what is faster than the blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Periods from this on, samples; up to twice as many.
    pub from_samples: u32,
    /// Frequencies, Hz, low and high; `None` without time.
    pub hertz: Option<(f64, f64)>,
    /// Rms by component, mm.
    pub rms_mm: [f64; 3],
}

impl PassSummary {
    /// Rms of all that is faster than the blocks, by component, mm.
    pub fn faster_mm(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.bands.iter().map(|band| band.rms_mm[k].powi(2)).sum::<f64>().sqrt())
    }
}

impl Band {
    /// Rms of the loudest component, mm.
    pub fn largest(&self) -> f64 {
        self.rms_mm.iter().fold(0.0, |most, rms| rms.max(most))
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct PassKey {
    setup: usize,
    heading: [i8; SLOTS],
    feed_class: i32,
}

/// The pass a state belongs to, and the feed that stands for its class. `feed` of the sample before, if it goes on: a
/// feed near the border of two classes must not flicker between them.
pub(super) fn key(state: &State, feed: Option<f64>) -> (PassKey, f64) {
    let speeds =
        |rotary| state.velocity.iter().filter(move |(slot, _)| slot.is_rotary() == rotary).map(|(_, v)| v);
    let rotary = speeds(true).fold(0.0_f64, |most, v| most.max(v.abs()));
    let linear = speeds(false).map(|v| v * v).sum::<f64>().sqrt();
    // A standing encoder flickers: turning is what is not tiny beside the motion of the linear axes.
    let turns = rotary / UNIT[Joint::C] > 0.02 * linear / UNIT[Joint::X];
    let speed = if turns { rotary } else { linear };
    let feed = match feed {
        Some(feed) if speed <= feed * FEED_CLASS && speed >= feed / FEED_CLASS => feed,
        _ if speed > 0.0 => FEED_CLASS.powf((speed.ln() / FEED_CLASS.ln()).round()),
        _ => 0.0,
    };
    let feed_class = if feed > 0.0 { (feed.ln() / FEED_CLASS.ln()).round() as i32 } else { i32::MIN };
    let heading = Slot::ALL.map(|slot| {
        let direction = if slot.is_rotary() { state.direction[slot] } else { 0.0 };
        i8::from(direction > 0.0) - i8::from(direction < 0.0)
    });
    (PassKey { setup: state.setup, heading, feed_class }, feed)
}

/// Sums of one pass.
#[derive(Clone, Debug)]
pub(super) struct PassSums {
    setup: usize,
    direction: AxisValues<f64>,
    speed: AxisValues<f64>,
    count: u64,
    samples: u64,
    pub excluded: u64,
    blocks: usize,
    scatter: Scatter,
    last_s: Option<f64>,
    step_s: f64,
    steps: u64,
    pyramid: Pyramid,
}

impl PassSums {
    pub fn new(setup: usize, state: &State) -> Self {
        let direction =
            AxisValues::from_fn(|letter| if letter.is_rotary() { state.direction[letter] } else { 0.0 });
        Self {
            setup,
            direction,
            speed: AxisValues::default(),
            count: 0,
            samples: 0,
            excluded: 0,
            blocks: 0,
            scatter: Scatter::default(),
            last_s: None,
            step_s: 0.0,
            steps: 0,
            pyramid: Pyramid::default(),
        }
    }

    pub fn add(&mut self, sample: &Sample) {
        let Point { state, samples, .. } = &sample.point;
        self.count += 1;
        self.samples += u64::from((*samples).max(1));
        for (letter, v) in state.velocity.iter() {
            self.speed[letter] += (v.abs() - self.speed[letter]) / self.count as f64;
        }
        if let (Some(before), Some(now)) = (self.last_s, state.time_s) {
            self.step_s += now - before;
            self.steps += 1;
        }
        self.last_s = state.time_s;
        self.pyramid.add(sample.departure_mm);
    }

    /// The next sample does not follow the last one.
    pub fn interrupt(&mut self) {
        self.last_s = None;
        self.pyramid.interrupt();
    }

    /// Notes the scatter of one of its blocks.
    pub fn add_block(&mut self, scatter_mm: [f64; 3], degrees_of_freedom: f64) {
        self.blocks += 1;
        self.scatter.add(scatter_mm, degrees_of_freedom);
    }

    fn noise(&self) -> Noise {
        Noise { variances: self.pyramid.variances(), scatter_mm: self.scatter.rms_mm() }
    }

    pub fn summary(&self) -> PassSummary {
        let known = self.pyramid.octaves();
        let step_s = (self.steps > 0).then(|| self.step_s / self.steps as f64);
        let per_block = (self.count as f64 / self.blocks.max(1) as f64).max(1.0);
        let faster = (per_block.log2().ceil() as usize).min(known.len());
        let bands = (0..faster).map(|octave| {
            let from_samples = 2u32 << octave;
            Band {
                from_samples,
                hertz: step_s.filter(|s| *s > 0.0).map(|step_s| {
                    let high = 1.0 / (step_s * f64::from(from_samples));
                    (0.5 * high, high)
                }),
                rms_mm: known[octave].map(f64::sqrt),
            }
        });
        PassSummary {
            setup: self.setup,
            direction: self.direction,
            speed: self.speed,
            samples: self.samples,
            excluded: self.excluded,
            blocks: self.blocks,
            step_s,
            bands: bands.collect(),
        }
    }
}

/// Pooled scatter of blocks.
#[derive(Clone, Copy, Debug, Default)]
struct Scatter {
    squares: [f64; 3],
    degrees_of_freedom: f64,
}

impl Scatter {
    fn add(&mut self, scatter_mm: [f64; 3], degrees_of_freedom: f64) {
        self.degrees_of_freedom += degrees_of_freedom;
        for (sum, scatter) in self.squares.iter_mut().zip(scatter_mm) {
            *sum += scatter * scatter * degrees_of_freedom;
        }
    }

    fn rms_mm(&self) -> [f64; 3] {
        self.squares.map(|sum| if sum > 0.0 { (sum / self.degrees_of_freedom).sqrt() } else { 0.0 })
    }
}

/// Noise of each pass; one that holds too little borrows that of all passes of its setup.
pub(super) fn noises(passes: &[PassSums]) -> Vec<Noise> {
    let mut pooled: HashMap<usize, (Pyramid, Scatter)> = HashMap::new();
    for pass in passes {
        let (pyramid, scatter) = pooled.entry(pass.setup).or_default();
        pyramid.absorb(&pass.pyramid);
        scatter.add(pass.scatter.rms_mm(), pass.scatter.degrees_of_freedom);
    }
    let of_setup = |setup: usize| {
        let (pyramid, scatter) = &pooled[&setup];
        Noise { variances: pyramid.variances(), scatter_mm: scatter.rms_mm() }
    };
    passes.iter().map(|pass| if pass.count >= ENOUGH { pass.noise() } else { of_setup(pass.setup) }).collect()
}
