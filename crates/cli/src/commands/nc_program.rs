//! `trunnion nc-program`: a cycle as a program of the machine's controller.

use crate::outcome::Outcome;
use crate::{output, terminal};
use anyhow::{Context, bail};
use std::collections::BTreeMap;
use std::path::PathBuf;
use trunnion::Machine;
use trunnion::cycles::{CourseRules, DIALECTS, Pace, dialect, nc_program, whole_minutes};
use trunnion::results::{NcProgram, NcProgramFormat};
use trunnion_core::{State, convert};

/// Write a cycle as an NC program
///
/// The program moves every axis itself: switch tool-point following (TCP, RTCP, TRAORI, M128) off. Its header says what to
/// check before the start; it stops where ball, nest or bar have to be mounted. With --tcp it leaves the linear axes to the
/// control: what acts in the transformation alone, as most corrections do, then shows.
///
/// Example: trunnion nc-program config/cycles/r-test-static.toml --dialect siemens -o r-test.mpf
#[derive(clap::Args)]
pub struct Args {
    /// Cycle file (format trunnion-cycle/1)
    #[arg(value_name = "CYCLE.TOML")]
    cycle: PathBuf,
    /// Controller
    #[arg(long, value_parser = dialect_names())]
    dialect: String,
    /// File to write; without it, standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Largest distance of the straight blocks of a sweep from its path, um; longer blocks need more
    #[arg(long, value_name = "UM", default_value_t = convert::um_from_mm(CourseRules::default().chord_mm))]
    chord_um: f64,
    /// Dwell at a pose, s; without it settling and two windows of the cycle
    #[arg(long, value_name = "S")]
    dwell_s: Option<f64>,
    /// Height of the retracted spindle above the highest ball, mm
    #[arg(long, value_name = "MM", default_value_t = CourseRules::default().clearance_mm)]
    clearance_mm: f64,
    /// Decimals of positions in mm and degrees; without it what such controllers usually take
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=9))]
    decimals: Option<u8>,
    /// Number of the program on a control whose programs have numbers (fanuc); without it one that follows from the name of the cycle
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=7999))]
    number: Option<u32>,
    /// Run with tool centre point control (TRAORI, G43.4, TCPM): fanuc, heidenhain, siemens
    #[arg(long)]
    tcp: bool,
    /// Print JSON (format trunnion-nc-program/1) with the program and the poses it must visit
    #[arg(long, conflicts_with = "output")]
    json: bool,
}

fn dialect_names() -> Vec<&'static str> {
    DIALECTS.iter().map(|dialect| dialect.name).collect()
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    output::not_an_input(&[("-o", args.output.as_deref())], [args.cycle.as_path()])?;
    let rules = rules(args)?;
    let dialect = dialect(&args.dialect).context("the command line allows known dialects only")?;
    if args.number.is_some() && !dialect.numbered {
        bail!("programs in {} have no number: leave --number out", dialect.name);
    }
    let program = nc_program(&args.cycle, dialect, &rules, args.decimals.map(usize::from))?;
    if args.json {
        terminal::print_json(&NcProgram {
            format: NcProgramFormat::V1,
            cycle: program.cycle.name,
            dialect: dialect.name.into(),
            minutes: program.duration_s / 60.0,
            chord_um: args.chord_um,
            tcp: args.tcp,
            visits: program.visits.iter().map(|state| visit(&program.machine, state)).collect(),
            program: program.text,
        })?;
        return Ok(Outcome::Done);
    }
    let text = &program.text;
    let Some(path) = &args.output else {
        terminal::print_verbatim(text)?;
        return Ok(Outcome::Done);
    };
    output::write(path, text)?;
    let lines = text.lines().count();
    let minutes = whole_minutes(program.duration_s);
    terminal::print(&format!(
        "{lines} lines, about {minutes} minutes without stops -> {}\n",
        path.display()
    ))?;
    Ok(Outcome::Done)
}

fn rules(args: &Args) -> anyhow::Result<CourseRules> {
    for (option, value, low, high) in [
        ("--chord-um", args.chord_um, 0.01, 1000.0),
        ("--dwell-s", args.dwell_s.unwrap_or(1.0), 0.01, 3600.0),
        ("--clearance-mm", args.clearance_mm, 0.0, 10_000.0),
    ] {
        if !(low..=high).contains(&value) {
            bail!("{option} {value} is not possible; allowed: {low}..={high}");
        }
    }
    Ok(CourseRules {
        pace: Pace::default(),
        chord_mm: convert::mm_from_um(args.chord_um),
        dwell_s: args.dwell_s,
        clearance_mm: args.clearance_mm,
        tool_point: args.tcp,
        program_number: args.number,
        ..CourseRules::default()
    })
}

/// Positions in mm and degrees, and the speed where the axis is read in motion, degrees/s.
fn visit(machine: &Machine, state: &State) -> BTreeMap<String, f64> {
    let mut value = BTreeMap::new();
    for axis in machine.axes() {
        let letter = axis.letter;
        let (unit, at, speed) = if letter.is_rotary() {
            (
                "deg",
                convert::deg_from_rad(state.position[letter]),
                convert::deg_from_rad(state.velocity[letter]),
            )
        } else {
            ("mm", state.position[letter], state.velocity[letter])
        };
        value.insert(format!("{}_{unit}", letter.lower()), at);
        if speed != 0.0 {
            value.insert(format!("v{}_{unit}_per_s", letter.lower()), speed);
        }
    }
    value
}
