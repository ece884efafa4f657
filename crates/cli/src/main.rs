//! `trunnion`: the one binary. Each command is one file under `commands`.
//!
//! Exit codes (docs/design/contracts.md §5): 0 done, 1 failed, 2 usage, 3 done with data loss or without a verdict,
//! or refused because the runs are doubted.

mod commands;
mod kept;
mod load;
mod one_of;
mod outcome;
mod output;
mod terminal;

use clap::{Parser, Subcommand};
use commands::{
    add, analyse_run, answer_page, attribute, calibrate_nest, check, check_config, compare, correct, cycle,
    daemon, demo, devices, diagnose, export, history, identify, import, join, ladder, nc_program, open, plan,
    predict, record, remove, replay, report, scrub, simulate, volumetric, watch,
};
use outcome::Outcome;
use std::process::ExitCode;

/// Finds out why a five-axis machine tool is not accurate.
#[derive(Parser)]
#[command(name = "trunnion", version, max_term_width = 80)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print lists in full that are longer than the screen
    #[arg(long, global = true)]
    all: bool,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Args),
    Daemon(daemon::Args),
    Devices(devices::Args),
    Open(open::Args),
    Watch(watch::Args),
    CalibrateNest(calibrate_nest::Args),
    Check(check::Args),
    CheckConfig(check_config::Args),
    Cycle(cycle::Args),
    Record(record::Args),
    Import(import::Args),
    Export(export::Args),
    Join(join::Args),
    Replay(replay::Args),
    Report(report::Args),
    History(history::Args),
    Identify(identify::Args),
    Compare(compare::Args),
    Diagnose(diagnose::Args),
    Add(add::Args),
    Attribute(attribute::Args),
    Remove(remove::Args),
    Ladder(ladder::Args),
    Plan(plan::Args),
    Predict(predict::Args),
    NcProgram(nc_program::Args),
    #[command(visible_alias = "compensation")]
    Correct(correct::Args),
    Scrub(scrub::Args),
    Simulate(simulate::Args),
    Volumetric(volumetric::Args),
    #[command(hide = true)]
    AnalyseRun(analyse_run::Args),
    #[command(hide = true)]
    AnswerPage(answer_page::Args),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    if cli.all {
        terminal::show_all();
    }
    if let Some(folder) = kept::folder() {
        trunnion::keep_in(&folder);
    }
    let outcome = match cli.command {
        Command::Demo(args) => demo::run(&args),
        Command::Daemon(args) => daemon::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Open(args) => open::run(&args),
        Command::Watch(args) => watch::run(&args),
        Command::CalibrateNest(args) => calibrate_nest::run(&args),
        Command::Check(args) => check::run(&args),
        Command::CheckConfig(args) => check_config::run(&args),
        Command::Cycle(args) => cycle::run(&args),
        Command::Record(args) => record::run(&args),
        Command::Import(args) => import::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Join(args) => join::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Report(args) => report::run(&args),
        Command::History(args) => history::run(&args),
        Command::Identify(args) => identify::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Diagnose(args) => diagnose::run(&args),
        Command::Add(args) => add::run(&args),
        Command::Attribute(args) => attribute::run(&args),
        Command::Remove(args) => remove::run(&args),
        Command::Ladder(args) => ladder::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Predict(args) => predict::run(&args),
        Command::NcProgram(args) => nc_program::run(&args),
        Command::Correct(args) => correct::run(&args),
        Command::Scrub(args) => scrub::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Volumetric(args) => volumetric::run(&args),
        Command::AnalyseRun(args) => analyse_run::run(&args),
        Command::AnswerPage(args) => answer_page::run(&args),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::DataLoss | Outcome::Withheld) => ExitCode::from(3),
        Err(error) => {
            terminal::remark(&format!("{error:#}"));
            match error.downcast_ref() {
                // An axis is known only with the machine of the recording.
                Some(trunnion::Error::NoSuchAxis { .. }) => ExitCode::from(2),
                _ if error.is::<load::NotTrusted>() => ExitCode::from(3),
                _ => ExitCode::FAILURE,
            }
        }
    }
}
