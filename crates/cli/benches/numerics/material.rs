//! Runs to work on.

use nalgebra::Point3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use trunnion_core::{InstrumentKind, Joint, NestSide, Point, Quality, Setup, State};
use trunnion_cycles::{Cycle, Run, RunKind};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine, grid};
use trunnion_hil_sim::{HiddenChoice, Instrument, NestOn, SimSetup, Truth};
use trunnion_machine::shipped;

pub fn setups() -> Vec<SimSetup> {
    let placed =
        |(name, z)| SimSetup::new(name, NestOn::Table, Point3::new(150.0, 0.0, z), Instrument::R_TEST);
    [("low", 60.0), ("high", 160.0)].map(placed).into()
}

/// The run that measures these states on a machine with this hidden effect.
pub fn run(kind: RunKind, hidden: &str, states: impl FnOnce(&[SimSetup]) -> Vec<State>) -> Run {
    let machine = shipped::machine("table-bc").unwrap();
    let placed = setups();
    let hidden = [HiddenChoice { id: hidden.into(), sigma: 1.0 }];
    let truth = Truth::draw(&machine, &placed, &hidden, 1200.0, 7).unwrap();
    let virtual_machine = VirtualMachine::new(machine.clone(), truth).unwrap();
    let mut sampler = Sampler::new(&virtual_machine, 0);
    let samples = u32::from(kind == RunKind::OnTheFly);
    let read = |state: State| {
        let reading_mm = sampler.read_mm(&virtual_machine, &state);
        Point { state, reading_mm, spread_mm: [0.0; 3], samples, quality: Quality::Good }
    };
    let points = states(&placed).into_iter().map(read).collect();
    let setups = placed.iter().map(|placed| {
        Setup::new(placed.name.clone(), InstrumentKind::RTest, NestSide::Table, placed.ball_in_table_mm)
    });
    Run { name: "bench".into(), machine, kind, setups: setups.collect(), channels: Vec::new(), points }
}

/// Sweeps of C both ways: two setups, three tilts, three feeds.
pub fn on_the_fly(samples: u32) -> Run {
    let machine = shipped::machine("table-bc").unwrap();
    run(RunKind::OnTheFly, "servo-lag:X", |setups| {
        let (mut states, mut start_s) = (Vec::new(), 0.0);
        for (setup, placed) in setups.iter().enumerate() {
            for tilt_deg in [-45.0_f64, 0.0, 45.0] {
                for feed_deg in [10.0_f64, 20.0, 40.0] {
                    let (tilt_rad, feed_rad_per_s) = (tilt_deg.to_radians(), feed_deg.to_radians());
                    let sweep =
                        grid::Sweep { setup, tilt_rad, feed_rad_per_s, samples: samples / 36, start_s };
                    states.extend(grid::c_sweep(&machine, &placed.ball_in_table_mm, &sweep));
                    start_s += 2.0 * 360.0 / feed_deg + 20.0;
                }
            }
        }
        states
    })
}

/// A ball bar around a circle in XY, three laps each way, read at rest; the places scatter by 3 µm, so that none comes back.
pub fn laps_at_rest() -> Run {
    const LAPS: [f64; 6] = [1.0, 1.0, 1.0, -1.0, -1.0, -1.0];
    const POINTS: u32 = 900;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles/circle-xy.toml");
    let cycle = Cycle::parse(path, &std::fs::read_to_string(path).unwrap()).unwrap();
    let length_mm = cycle.setups[0].bar_length_mm.unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut points = Vec::new();
    for (lap, way) in LAPS.into_iter().enumerate() {
        for i in 0..POINTS {
            let angle = way * TAU * f64::from(i) / f64::from(POINTS);
            let mut state = State { time_s: Some((points.len() + 100 * lap) as f64), ..State::default() };
            let place = [length_mm * angle.cos(), length_mm * angle.sin()].map(|mm| mm + 3e-3 * normal());
            let heading = [-way * angle.sin(), way * angle.cos()].map(f64::signum);
            for (k, letter) in [Joint::X, Joint::Y].into_iter().enumerate() {
                (state.position[letter], state.direction[letter]) = (place[k], heading[k]);
            }
            state.position[Joint::Z] = 100.0;
            let [x, y] = [0, 1].map(|k| place[k] + 1e-3 * heading[k]);
            let reading_mm = [x.hypot(y) - length_mm + 1e-4 * normal(), 0.0, 0.0];
            points.push(Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Quality::Good });
        }
    }
    let machine = shipped::machine(&cycle.machine).unwrap();
    Run {
        name: "bench".into(),
        machine,
        kind: RunKind::Static,
        setups: cycle.setups,
        channels: Vec::new(),
        points,
    }
}

/// The same points as if each had been read at rest.
pub fn at_rest(mut run: Run) -> Run {
    run.kind = RunKind::Static;
    for point in &mut run.points {
        (point.state.velocity, point.state.acceleration) = Default::default();
    }
    run
}
