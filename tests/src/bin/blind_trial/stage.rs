//! The stage: the machine, the grid on which it is measured and one that nobody has seen.
//!
//! The unseen grid has the same order and pace, other heights, and poses between those of the trial. There a noise-free signal
//! is compared with what a model says of it; the base model may be fitted again, as after every set-up.

use nalgebra::{DMatrix, DVector, Point3};
use trunnion_core::{InstrumentKind, NestSide, Point, Quality, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Instance, catalogue};
use trunnion_engine::Experiment;
use trunnion_hil_sim::physics::{grid, simulate_points};
use trunnion_hil_sim::{Instrument, NestOn, SimSetup, Truth, VirtualMachine};
use trunnion_machine::{Machine, shipped};

/// The S1 grid takes this long on a real machine, s.
pub const RUN_S: f64 = 1682.0;
/// White noise of a reading, and the unit of sizes, mm.
pub const SIGMA_MM: f64 = 0.3e-3;
/// Singular values below this share of the largest are directions that the base model does not have.
const BASE_RANK: f64 = 1e-9;

/// Machine and grids.
pub struct Stage {
    pub machine: Machine,
    pub trial: Grid,
    pub unseen: Grid,
}

/// One cycle at rest.
pub struct Grid {
    machine: Machine,
    pub setups: Vec<SimSetup>,
    pub states: Vec<State>,
    /// Orthonormal basis of the base model's columns, rows × rank.
    base: DMatrix<f64>,
}

impl Stage {
    pub fn new() -> Self {
        let machine = shipped::machine("table-bc").expect("the machine is shipped");
        let trial = setups([60.0, 160.0]);
        let trial_states = grid::standard_bc(&machine, &trial);
        let unseen = setups([85.0, 135.0]);
        // The axes turn round where they did in the trial: what remembers a reversal must find it at the same place.
        let tilts = grid::Stations { first_deg: -75.0, count: 6, ..grid::Stations::TILTING };
        let turns = grid::Stations { first_deg: 7.5, ..grid::Stations::TURNING };
        let unseen_states = grid::stations_bc(&machine, &unseen, tilts, turns);
        Self {
            trial: Grid::new(&machine, trial, grid::compressed(trial_states, RUN_S)),
            unseen: Grid::new(&machine, unseen, grid::compressed(unseen_states, RUN_S)),
            machine,
        }
    }
}

fn setups(heights_mm: [f64; 2]) -> Vec<SimSetup> {
    let place = |(name, z_mm): (&str, f64)| {
        SimSetup::new(name, NestOn::Table, Point3::new(150.0, 0.0, z_mm), Instrument::R_TEST)
    };
    ["low", "high"].into_iter().zip(heights_mm).map(place).collect()
}

impl Grid {
    fn new(machine: &Machine, setups: Vec<SimSetup>, states: Vec<State>) -> Self {
        let mut grid = Self { machine: machine.clone(), setups, states, base: DMatrix::zeros(0, 0) };
        let nothing = vec![[0.0; 3]; grid.states.len()];
        let experiment = experiment(&grid.run("nominal", &nothing));
        let columns = catalogue::BASE.map(|id| {
            let instance = Instance::find(id, machine).expect("base effects fit every machine");
            experiment.columns(&instance, &[])
        });
        let mut columns =
            DMatrix::from_columns(&columns.iter().flat_map(|block| block.column_iter()).collect::<Vec<_>>());
        columns.column_iter_mut().for_each(|mut column| {
            column.normalize_mut();
        });
        let svd = columns.svd(true, false);
        let u = svd.u.expect("asked for");
        let largest = svd.singular_values.amax();
        let seen: Vec<usize> =
            (0..u.ncols()).filter(|&i| svd.singular_values[i] > BASE_RANK * largest).collect();
        grid.base = u.select_columns(&seen);
        grid
    }

    /// What remains of a signal after ordinary least squares with the base model, mm.
    pub fn surviving(&self, signal: &DVector<f64>) -> DVector<f64> {
        signal - &self.base * self.base.tr_mul(signal)
    }

    /// What remains of each column.
    pub fn surviving_columns(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        columns - &self.base * self.base.tr_mul(columns)
    }

    /// This machine with the setups of the grid; a truth of another grid has its setups mounted again.
    pub fn machine(&self, truth: &Truth) -> VirtualMachine {
        let mounted = truth.mounted(&self.setups, 0);
        VirtualMachine::new(self.machine.clone(), mounted).expect("the truth was drawn for this machine")
    }

    /// Readings without noise, mm.
    pub fn ideal_mm(&self, truth: &Truth) -> Vec<[f64; 3]> {
        simulate_points(&self.machine(truth), &self.states)
    }

    /// What the hidden physics alone put into the readings, mm: with them minus without them.
    pub fn hidden_mm(&self, truth: &Truth) -> DVector<f64> {
        let innocent = Truth { hidden: Vec::new(), ..truth.clone() };
        stacked(&self.ideal_mm(truth)) - stacked(&self.ideal_mm(&innocent))
    }

    /// A recording as the program under test gets it: nothing but what was asked for and what was read.
    pub fn run(&self, name: &str, readings_mm: &[[f64; 3]]) -> Run {
        let point = |(state, reading_mm): (&State, &[f64; 3])| Point {
            state: state.clone(),
            reading_mm: *reading_mm,
            spread_mm: [0.0; 3],
            samples: 0,
            quality: Quality::Good,
        };
        let setup = |placed: &SimSetup| {
            Setup::new(placed.name.clone(), InstrumentKind::RTest, NestSide::Table, placed.ball_in_table_mm)
        };
        Run {
            name: name.into(),
            machine: self.machine.clone(),
            kind: RunKind::Static,
            setups: self.setups.iter().map(setup).collect(),
            channels: Vec::new(),
            points: self.states.iter().zip(readings_mm).map(point).collect(),
        }
    }
}

/// The experiment of one run.
pub fn experiment(run: &Run) -> Experiment {
    Experiment::new(std::slice::from_ref(run)).expect("a simulated run is complete")
}

/// Readings under each other.
pub fn stacked(readings_mm: &[[f64; 3]]) -> DVector<f64> {
    DVector::from_column_slice(readings_mm.as_flattened())
}

/// Root mean square.
pub fn rms(values: &DVector<f64>) -> f64 {
    (values.norm_squared() / values.len().max(1) as f64).sqrt()
}
