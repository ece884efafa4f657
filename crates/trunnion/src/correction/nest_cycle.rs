//! A cycle at rest in which ball and nest of one setup stay together.

use crate::Experiment;
use trunnion_core::Setup;
use trunnion_core::convert::{self, mm_from_um};
use trunnion_cycles::cycle::{Cycle, GridAxis, Motion, Settle};

/// When a pose may be read: as in the shipped static cycles.
const SETTLE: Settle = Settle {
    window_s: 0.5,
    drift_mm: mm_from_um(0.6),
    noise_mm: mm_from_um(2.0),
    standstill_mm: mm_from_um(2.0),
    standstill_rad: convert::rad_from_deg(0.002),
    timeout_s: 10.0,
};

pub(super) fn cycle(runs: &Experiment, setup: &Setup, grid: Vec<GridAxis>) -> Cycle {
    Cycle {
        name: "sign-of-the-correction".into(),
        machine: runs.machine().name.clone(),
        setups: vec![setup.clone()],
        motion: Motion::Static { grid, passes: vec![1.0], settle: SETTLE },
        rounds: Default::default(),
        bar: Default::default(),
    }
}
