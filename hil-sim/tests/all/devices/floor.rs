//! The shop floor the tests read: a ball on a turning table, readings that change with the angle.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;
use tokio::time::Instant;
use trunnion_core::AxisValues;
use trunnion_core::axis::iso::{B, C, X, Y};
use trunnion_hil_sim::devices::SimulatedCell;
use trunnion_hil_sim::devices::cell::{Cell, CellConfig, start};
use trunnion_hil_sim::motion::{Follow, Program, Step, Trajectory};

/// The controller's wall clock at time 0: 2026-01-01 00:00 UTC.
pub const WALL_NS: i64 = 1_767_225_600_000_000_000;

/// C turns from time 0.5 s on for longer than any test lasts; X and Y follow the ball at radius 100 mm.
pub fn world() -> Arc<SimulatedCell> {
    let mut start = AxisValues::default();
    (start[X], start[B]) = (100.0, 0.25);
    let follow = Follow::new(|axes| {
        let mut axes = *axes;
        (axes[X], axes[Y]) = (100.0 * axes[C].cos(), 100.0 * axes[C].sin());
        axes
    });
    let sweep = Step::Sweep { axis: C, from: 0.0, to: 100.0 * TAU, feed: 1.0, ramp_s: 0.2, follow };
    let program = Program { start, steps: vec![Step::Dwell { duration_s: 0.5 }, sweep] };
    Arc::new(SimulatedCell {
        program: "O1000".into(),
        deflection_mm: Box::new(|state| {
            let c = state.position[C];
            [0.1 * c.sin(), 0.05 * c.cos(), 0.02]
        }),
        // Grows with the angle, so that a value shows its instant
        bar_mm: Box::new(|state| 0.5 * state.position[C]),
        temperature_degc: Box::new(|t_s| 21.0 + 0.5 * t_s),
        noise_mm: 0.0005,
        ..SimulatedCell::along(Trajectory::compile(&program).unwrap())
    })
}

pub async fn cell(directory: &Path, change: impl FnOnce(&mut CellConfig)) -> (Arc<SimulatedCell>, Cell) {
    let world = world();
    let mut config = CellConfig::new(directory, WALL_NS);
    change(&mut config);
    let cell = start(world.clone(), config, Instant::now()).await.unwrap();
    (world, cell)
}
