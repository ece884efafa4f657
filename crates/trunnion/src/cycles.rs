//! Cycle files: what a cycle shows before it is measured, and the NC program that runs it.

use crate::{Error, files};
use std::path::Path;
use trunnion_core::State;
use trunnion_cycles::nc::Program;
use trunnion_engine::next_cycle;
use trunnion_machine::Machine;
use trunnion_results as results;

pub use trunnion_cycles::cycle::Motion;
pub use trunnion_cycles::nc::{DIALECTS, Dialect, dialect, whole_minutes};
pub use trunnion_cycles::{CourseRules, Cycle, Pace, Run, RunKind};

/// A cycle as a program of a controller.
pub struct NcProgram {
    /// The cycle.
    pub cycle: Cycle,
    /// Its machine.
    pub machine: Machine,
    /// The program.
    pub text: String,
    /// How long it runs without its stops, s.
    pub duration_s: f64,
    /// The states in which it must be read.
    pub visits: Vec<State>,
}

/// Reads a cycle file and the machine that it names.
///
/// # Errors
/// A file that cannot be read; every problem of it.
pub fn load(path: &Path) -> Result<(Cycle, Machine), Error> {
    let cycle = Cycle::parse(&path.display().to_string(), &files::read(path)?)?;
    let (machine, _) = files::machine_in(path, &cycle.machine)?;
    Ok((cycle, machine))
}

/// What a cycle shows, and which effects coincide in it.
///
/// # Errors
/// As [`load`]; a cycle that its machine cannot run.
pub fn preview(path: &Path) -> Result<results::Preview, Error> {
    let (cycle, machine) = load(path)?;
    let preview = next_cycle::preview(&machine, &cycle, &next_cycle::Options::default())?;
    Ok((&preview).into())
}

/// The NC program of a cycle file; without `decimals` as many as such controllers usually take.
///
/// # Errors
/// As [`load`]; a machine whose controller moves no single axes; a cycle that its machine cannot run; a dialect without the tool centre point control that
/// `rules` ask for.
pub fn nc_program(
    path: &Path,
    dialect: &Dialect,
    rules: &CourseRules,
    decimals: Option<usize>,
) -> Result<NcProgram, Error> {
    let (cycle, machine) = load(path)?;
    if machine.tripod.is_some() {
        return Err(Error::Legs { machine: machine.name });
    }
    if rules.tool_point && dialect.tool_point.is_none() {
        return Err(Error::NoToolPoint { dialect: dialect.name });
    }
    let program = Program::of_cycle(&cycle, &machine, rules)?;
    let visits = cycle.visits(&machine, &rules.pace)?.states;
    let text = (dialect.write)(&program, decimals.unwrap_or(dialect.decimals));
    Ok(NcProgram { text, duration_s: program.duration_s, visits, cycle, machine })
}
