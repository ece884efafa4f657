//! `trunnion simulate`: points of a virtual machine whose truth is known, without ports.

use crate::load;
use crate::outcome::{self, Outcome};
use anyhow::Context;
use std::path::PathBuf;
use trunnion_hil_sim::physics::{Sampler, VirtualMachine, grid};
use trunnion_hil_sim::{Instrument, NestOn, Truth};
use trunnion_measurement::{InstrumentKind, NestSide, Point, Quality, Run, RunKind, Setup};

/// Simulate a static cycle of a machine whose truth is written in a file
///
/// Example: trunnion simulate truth.toml -o run.mcap
#[derive(clap::Args)]
pub struct Args {
    /// Truth file (format trunnion-truth/1)
    #[arg(value_name = "TRUTH.TOML")]
    truth: PathBuf,
    /// Recording to write
    #[arg(short, long, value_name = "RUN.MCAP")]
    output: PathBuf,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let text = load::read(&args.truth)?;
    let truth = Truth::parse(&args.truth.display().to_string(), &text)?;
    let machine = load::machine(&truth.machine)?;
    let machine_text = load::machine_text(&truth.machine)?;
    let virtual_machine = VirtualMachine::new(machine.clone(), truth)?;
    let placed: Vec<_> = virtual_machine.truth().setups.iter().map(|placed| placed.setup.clone()).collect();
    let states =
        grid::compressed(grid::standard_bc(&machine, &placed), virtual_machine.truth().run_duration_s);
    let mut sampler = Sampler::new(&virtual_machine, 0);
    let points = states
        .into_iter()
        .map(|state| Point {
            reading_mm: sampler.read_mm(&virtual_machine, &state),
            state,
            spread_mm: [0.0; 3],
            samples: 0,
            quality: Quality::Good,
        })
        .collect();
    let name = args.output.file_stem().context("the output has no name")?.to_string_lossy().into_owned();
    let setups = placed.iter().map(setup_of).collect();
    let run = Run { name, machine, kind: RunKind::Static, setups, channels: Vec::new(), points };
    let header = trunnion_record::RunHeader::of_run(&run, &machine_text, env!("CARGO_PKG_VERSION"), 0);
    trunnion_record::write_run(&args.output, &header, &run)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    outcome::print(&format!("{} points -> {}\n", run.points.len(), args.output.display()))?;
    Ok(Outcome::Done)
}

fn setup_of(placed: &trunnion_hil_sim::SimSetup) -> Setup {
    let (instrument, bar_length_mm) = match placed.instrument {
        Instrument::RTest => (InstrumentKind::RTest, None),
        Instrument::BallBar { length_mm } => (InstrumentKind::BallBar, Some(length_mm)),
    };
    let nest = match placed.nest {
        NestOn::Table => NestSide::Table,
        NestOn::Spindle => NestSide::Spindle,
    };
    Setup {
        name: placed.name.clone(),
        instrument,
        nest,
        ball_in_table_mm: placed.ball_in_table_mm,
        bar_length_mm,
    }
}
