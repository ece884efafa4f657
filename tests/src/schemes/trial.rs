//! One trial: the machine of a row measured and identified by one seed.

use super::judged::{Found, found, injected};
use super::named;
use super::rows::Row;
use crate::workspace_root;
use anyhow::Context;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trunnion::Model;
use trunnion_core::{Point, Quality};
use trunnion_cycles::{Cycle, Pace, Run};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine};
use trunnion_hil_sim::truth::Noise;
use trunnion_hil_sim::{SimSetup, Truth};
use trunnion_machine::shipped;
use trunnion_methods::recipes::MethodOptions;

/// What the readings of a trial suffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseKind {
    /// 0.3 µm, white.
    White,
    /// The same, with drift and a step at each pass, as a good machine in a good room has them.
    DriftAndSteps,
}

impl NoiseKind {
    fn noise(self, run_duration_s: f64) -> Noise {
        let quiet = Noise {
            repeatability_rad: 0.0,
            natural_motion_mm: 0.0,
            outlier_share: 0.0,
            ..Noise::real(run_duration_s)
        };
        match self {
            Self::White => Noise::WHITE,
            Self::DriftAndSteps => quiet,
        }
    }
}

/// Errors of a trial are up to this many times those of the truth file, or as much smaller, with either sign.
const MOST_TIMES: f64 = 2.0;
/// Stream of the seed for the size of the errors; the simulator has its own.
const SIZE_STREAM: u64 = 0x7369_7a65;

/// The machine of the row with errors of another size, mounted again, measured, recorded, opened and identified.
///
/// # Errors
/// A file of the row that cannot be used, or a fit that fails.
pub fn trial(row: &Row, kind: NoiseKind, seed: u64) -> anyhow::Result<Vec<Found>> {
    let text = |folder: &str, name: &str| trunnion::files::read(&config(folder, name));
    let cycle_text = text("cycles", row.cycle)?;
    let cycle = Cycle::parse(row.cycle, &cycle_text)?;
    let machine = shipped::machine(&cycle.machine).context("the machine ships")?;
    let visits = cycle.visits(&machine, &Pace::default())?;

    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(SIZE_STREAM);
    let sign = if rng.random() { 1.0 } else { -1.0 };
    let times = sign * MOST_TIMES.powf(rng.random_range(-1.0..1.0));
    let truth_text = text("truths", row.truth)?;
    let mut truth = Truth { seed, ..Truth::parse(row.truth, &truth_text)? };
    for joint in machine.joints() {
        truth.location[joint] = truth.location[joint] * times;
    }
    truth.named.iter_mut().for_each(|error| error.amount *= times);
    truth.hidden.iter_mut().for_each(|hidden| hidden.amplitude *= times);
    truth.noise = kind.noise(visits.duration_s);

    let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
    let virtual_machine = VirtualMachine::new(machine.clone(), truth.mounted(&setups, 1))?;
    let mut sampler = Sampler::new(&virtual_machine, 0);
    let point = |state| Point {
        reading_mm: sampler.read_mm(&virtual_machine, &state),
        state,
        spread_mm: [0.0; 3],
        samples: 0,
        quality: Quality::Good,
    };
    let run = Run {
        name: cycle.name.clone(),
        kind: cycle.run_kind(),
        setups: cycle.setups.clone(),
        channels: Vec::new(),
        points: visits.states.into_iter().map(point).collect(),
        machine,
    };
    let folder = tempfile::tempdir()?;
    let recording = folder.path().join("run.mcap");
    let machine_text = trunnion::files::machine_text(&cycle.machine)?;
    trunnion::tables::record(&recording, &run, &machine_text, &cycle_text, &[])?;

    let mut injected = injected(&truth_text, row.also);
    injected.values_mut().for_each(|value| *value *= times);
    let experiment = trunnion::open(&recording)?;
    if let Some(method) = row.method {
        let findings = serde_json::to_value(experiment.by_method(method, &MethodOptions::default())?)?;
        return Ok(named::found(row, &findings, &cycle, &truth, &injected));
    }
    let model = match row.model {
        Some(name) => Model::load(config("models", name))?,
        None => Model::base(&cycle.machine),
    };
    let answer = serde_json::to_value(experiment.fit(&model)?.results())?;
    Ok(found(&answer, &injected))
}

fn config(folder: &str, name: &str) -> std::path::PathBuf {
    workspace_root().join(format!("config/{folder}/{name}.toml"))
}
