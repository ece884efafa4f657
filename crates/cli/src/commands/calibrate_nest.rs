//! `trunnion calibrate-nest`: directions of the probes from known steps of the linear axes.

use super::setting_up::{Connected, SettingUp};
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::PathBuf;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};
use trunnion::gaps::Missing;
use trunnion::nest::calibrate_nest;
use trunnion::report::nest_text;
use trunnion::results::NestCalibrated;
use trunnion_core::{Clock, Joint};
use trunnion_service::clock::SystemClock;
use trunnion_service::nest_file::write_nest;

/// Find the directions of the probes from known steps of X, Y and Z, and print the `[nest]` table
///
/// Without RUN the steps are read live. Bring the ball into the nest and leave the rotary axes at rest. Step each linear axis by 0.1 mm and
/// more, both ways; stand for a second after each step. It ends ten seconds after the last step, or by Control-C. Steps that are too few, in a
/// plane or too small, and readings that drift or scatter, are refused with the reason. The linear axes must be right to a small share of
/// the steps.
///
/// Example: trunnion calibrate-nest --config config/trunnion.toml --write
#[derive(clap::Args)]
pub struct Args {
    /// Recording that holds the steps, at one pose of the rotary axes; without it, live
    #[arg(value_name = "RUN")]
    run: Option<PathBuf>,
    /// Configuration: devices, cycle (which names the machine and says where the nest stands)
    #[arg(long, value_name = "FILE", required_unless_present = "run")]
    config: Option<PathBuf>,
    /// Keep the gains of the probes in the lengths of the directions
    #[arg(long)]
    gains: bool,
    /// Write the directions into the configuration; as it was it stays next to it
    #[arg(long, requires = "config")]
    write: bool,
    /// End after so many seconds
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Print JSON (format trunnion-nest/1)
    #[arg(long)]
    json: bool,
}

/// The steps are over when the machine has stood for so long.
const OVER: Duration = Duration::from_secs(10);

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let (found, missing) = match (&args.run, &args.config) {
        (Some(run), _) => {
            load::no_points_file(run)?;
            calibrate_nest(run, args.gains)?
        }
        (None, Some(config)) => {
            let setting_up = SettingUp::read(config)?;
            let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
            runtime.block_on(async {
                let mut connected = setting_up.connect(args.seconds);
                let found = live(args, &setting_up, &mut connected).await;
                connected.stop().await;
                // Steps that were not read are steps that are not counted: a person repeats them.
                found.map(|found| (found, Missing::default()))
            })?
        }
        (None, None) => bail!("give a recording or --config"),
    };
    match args.json {
        true => terminal::print_json(&found)?,
        false => terminal::print(&nest_text(&found))?,
    }
    if let Some(path) = args.config.as_ref().filter(|_| args.write) {
        let directions = found.directions(args.gains).context("three probes are calibrated")?;
        let before = write_nest(path, directions, SystemClock::start().wall_ns())?;
        terminal::remark(&format!(
            "[nest] of {} was written; as it was it is {}",
            path.display(),
            before.display()
        ));
    }
    Ok(load::outcome(&missing))
}

/// Takes steps until the machine stands.
async fn live(
    args: &Args,
    setting_up: &SettingUp,
    connected: &mut Connected,
) -> anyhow::Result<NestCalibrated> {
    let mut steps = setting_up.steps()?;
    terminal::remark("step X, Y and Z by 0.1 mm and more, both ways; stand for a second after each step");
    let mut seen = 0;
    let mut over: Option<Instant> = None;
    loop {
        let next = match over {
            None => connected.message().await,
            Some(over) => timeout_at(over, connected.message()).await.ok().flatten(),
        };
        let is_over = over.is_some_and(|over| Instant::now() >= over);
        let Some(message) = next.filter(|_| !is_over) else { break };
        connected.step(&message, &mut steps);
        if std::mem::replace(&mut seen, steps.count()) != steps.count() {
            over = (seen > 1).then(|| Instant::now() + OVER);
            if let Some(dwell) = steps.last() {
                let [x, y, z] = [Joint::X, Joint::Y, Joint::Z].map(|axis| dwell.position[axis]);
                let [a, b, c] = dwell.probes_mm;
                terminal::remark(&format!(
                    "{seen}: X {x:.3} Y {y:.3} Z {z:.3} mm, probes {a:.4} {b:.4} {c:.4} mm"
                ));
            }
        }
    }
    if steps.count() == 0 {
        bail!("the machine was never read at rest: {}", connected.latest.snapshot().say);
    }
    Ok(steps.calibrate(args.gains)?)
}
