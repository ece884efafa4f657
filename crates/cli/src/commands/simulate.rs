//! `trunnion simulate`: points of a virtual machine whose truth is known, without ports.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use trunnion::Machine;
use trunnion::cycles::{Cycle, Pace, Run, RunKind};
use trunnion::results::{Simulation, SimulationFormat};
use trunnion_core::number::counted;
use trunnion_core::{AxisSample, NestSide, Point, Quality, Setup, State};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine, grid};
use trunnion_hil_sim::{Compensation, Instrument, NestOn, SimSetup, Truth};

/// Simulate a cycle on a machine whose truth is written in a file
///
/// Without --cycle the machine measures the standard grid of poses with the setups of its truth. With --cycle it runs that
/// cycle, at rest or on the fly, with any instrument; setups named and placed as in the truth keep their setting
/// error, others are mounted again. A run on the fly also holds what the axes' own encoders read: lag and reversal spikes, no
/// geometric errors.
///
/// Example: trunnion simulate truth.toml --cycle config/cycles/r-test-sweep-c.toml -o run.mcap
#[derive(clap::Args)]
pub struct Args {
    /// Truth file (format trunnion-truth/1)
    #[arg(value_name = "TRUTH.TOML")]
    truth: PathBuf,
    /// Cycle to run (format trunnion-cycle/1)
    #[arg(long, value_name = "CYCLE.TOML")]
    cycle: Option<PathBuf>,
    /// Number of the run: from 1 on all setups are mounted again, and the noise is another one
    #[arg(long, value_name = "N", default_value_t = 0)]
    run: u64,
    /// Points a second on the fly
    #[arg(long, value_name = "RATE", default_value_t = Pace::default().points_per_s)]
    points_per_s: f64,
    /// File of `correct` that the simulated controller applies; a HAL component of LinuxCNC it cannot read
    #[arg(long, value_name = "FILE")]
    compensation: Option<PathBuf>,
    /// Recording to write
    #[arg(short, long, value_name = "RUN.MCAP")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let text = load::read(&args.truth)?;
    let truth = Truth::parse(&args.truth.display().to_string(), &text)?;
    let (machine, machine_text) = load::machine_in(&args.truth, &truth.machine)?;
    let mut simulated = match &args.cycle {
        Some(path) => cycle_run(args, path, &machine, &truth)?,
        None => standard_run(args, &machine, &truth)?,
    };
    if let Some(path) = &args.compensation {
        let table = Compensation::parse(&machine, &path.display().to_string(), &load::read(path)?)?;
        simulated.machine = simulated.machine.compensated(table)?;
    }
    // While axes move, their own encoders are recorded as well.
    let axes: Vec<AxisSample> = match simulated.kind {
        RunKind::Static => Vec::new(),
        RunKind::OnTheFly => {
            simulated.states.iter().filter_map(|state| encoders(&simulated.machine, state)).collect()
        }
    };
    let mut sampler = Sampler::new(&simulated.machine, simulated.noise);
    let points = simulated
        .states
        .into_iter()
        .map(|state| Point {
            reading_mm: sampler.read_mm(&simulated.machine, &state),
            state,
            spread_mm: [0.0; 3],
            samples: 0,
            quality: Quality::Good,
        })
        .collect();
    let name = args.output.file_stem().context("the output has no name")?.to_string_lossy().into_owned();
    let (kind, setups) = (simulated.kind, simulated.setups);
    let run = Run { name, machine, kind, setups, channels: Vec::new(), points };
    trunnion::tables::record(&args.output, &run, &machine_text, &simulated.cycle_text, &axes)?;
    if args.json {
        terminal::print_json(&Simulation {
            format: SimulationFormat::V1,
            points: run.points.len(),
            minutes: simulated.duration_s / 60.0,
            run: args.output.display().to_string(),
        })?;
    } else {
        let points = counted(run.points.len() as u64, "point");
        terminal::print(&format!("{points} -> {}\n", args.output.display()))?;
    }
    Ok(Outcome::Done)
}

fn encoders(machine: &VirtualMachine, state: &State) -> Option<AxisSample> {
    Some(AxisSample {
        time_s: state.time_s?,
        position: machine.encoder_positions(state),
        ..AxisSample::default()
    })
}

struct Simulated {
    machine: VirtualMachine,
    kind: RunKind,
    setups: Vec<Setup>,
    states: Vec<State>,
    duration_s: f64,
    /// Stream of the noise.
    noise: u64,
    cycle_text: String,
}

/// The standard grid, pressed into the time for which the truth was drawn.
fn standard_run(args: &Args, machine: &Machine, truth: &Truth) -> anyhow::Result<Simulated> {
    let placed: Vec<_> = truth.setups.iter().map(|placed| placed.setup.clone()).collect();
    let duration_s = truth.run_duration_s;
    Ok(Simulated {
        machine: VirtualMachine::new(machine.clone(), truth.mounted(&placed, args.run))?,
        kind: RunKind::Static,
        setups: truth.setups.iter().map(|placed| setup_of(&placed.setup)).collect(),
        states: grid::compressed(grid::standard_bc(machine, &placed), duration_s),
        duration_s,
        noise: args.run,
        cycle_text: String::new(),
    })
}

/// The cycle of a file, at the pace of a real machine.
fn cycle_run(args: &Args, path: &Path, machine: &Machine, truth: &Truth) -> anyhow::Result<Simulated> {
    let cycle_text = load::read(path)?;
    let cycle = Cycle::parse(&path.display().to_string(), &cycle_text)?;
    if Machine::name_of(&cycle.machine) != machine.name {
        bail!(
            "cycle {} is for machine {}, the truth is of {}; choose a cycle of that machine",
            path.display(),
            cycle.machine,
            truth.machine
        );
    }
    let (of_cycle, _) = load::machine_in(path, &cycle.machine)?;
    if of_cycle != *machine {
        bail!(
            "cycle {} and the truth name two machine files {}, which differ; name the same file in both",
            path.display(),
            machine.name
        );
    }
    if !(0.01..=100_000.0).contains(&args.points_per_s) {
        bail!("--points-per-s {} is not possible; allowed: 0.01..=100000", args.points_per_s);
    }
    let pace = Pace { points_per_s: args.points_per_s, ..Pace::default() };
    let visits = cycle.visits(machine, &pace)?;
    let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
    Ok(Simulated {
        machine: VirtualMachine::new(machine.clone(), truth.mounted(&setups, args.run))?,
        kind: cycle.run_kind(),
        setups: cycle.setups.clone(),
        states: visits.states,
        duration_s: visits.duration_s,
        // Another cycle meets other noise, the same cycle the same.
        noise: args.run.wrapping_add(fingerprint(&cycle_text)),
        cycle_text,
    })
}

/// FNV-1a of a text, 32 bits.
fn fingerprint(text: &str) -> u64 {
    let step = |hash: u32, byte: u8| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
    u64::from(text.bytes().fold(0x811c_9dc5, step))
}

/// A setup of the truth file, which knows R-tests and ball bars.
fn setup_of(placed: &SimSetup) -> Setup {
    let Instrument { kind, length_mm, .. } = placed.instrument;
    let bar_length_mm = kind.keeps_bar_length().then_some(length_mm);
    let nest = match placed.nest {
        NestOn::Table => NestSide::Table,
        NestOn::Spindle => NestSide::Spindle,
    };
    Setup { bar_length_mm, ..Setup::new(&placed.name, kind, nest, placed.ball_in_table_mm) }
}
