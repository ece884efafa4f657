//! `trunnion demo`: the main job on the simulator, through real ports.
//!
//! The simulator hides an effect and seals the truth; the program measures through its own drivers, identifies,
//! doubts, names what is missing, adds it; with a page the person adds. Only when all is said the seal is broken.

mod losses;
mod page;
mod story;

use super::progress_bar::ProgressBar;
use crate::commands::daemon::log_to_stderr;
use crate::outcome::Outcome;
use crate::{output, terminal};
use anyhow::{Context, bail};
use page::DemoPage;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use story::{proposed, story, truth_text};
use tokio_util::sync::CancellationToken;
use trunnion::cycles::{Cycle, Motion};
use trunnion::results::number::um;
use trunnion::results::sentences::repeatability;
use trunnion::results::{
    CycleProgress, CycleState, Demo, DemoFormat, DemoStep, ResultNow, RunResult, ServiceStatus, TimeQuality,
};
use trunnion::{Model, page as pages};
use trunnion_acquire::config::channels;
use trunnion_core::{Clock, names};
use trunnion_hil_sim::devices::{Later, SimulatedCell, World, cell};
use trunnion_hil_sim::pauses::Pauses;
use trunnion_hil_sim::physics::hidden;
use trunnion_hil_sim::scenario::{Pace, Station};
use trunnion_hil_sim::{HiddenChoice, SimSetup, Truth, VirtualMachine, scenario};
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::daemon;
use trunnion_service::daemon::{NewRun, Recorded, States, Texts, publish_live};
use trunnion_service::latest::Mounted;
use trunnion_service::live::{CycleBounds, Live, Plan, Progress, check};
use trunnion_service::page::own_model;

/// Measure, model, doubt, explain and correct a simulated five-axis machine with a hidden effect
///
/// Example: trunnion demo --hidden gravity-sag:B --seed 7
#[derive(Clone, clap::Args)]
pub struct Args {
    /// Hidden physics: an id (the axis may be left out), `random`, or `none`
    #[arg(long, default_value = "random", value_name = "ID")]
    hidden: String,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Size of the hidden effect, in units of its usual size
    #[arg(long, default_value_t = 1.0)]
    size: f64,
    /// Folder for recordings and the report; a number is added where it holds a demo already
    #[arg(long, value_name = "FOLDER", default_value = "trunnion-demo")]
    output: PathBuf,
    /// Leave out the on-the-fly cycle
    #[arg(long)]
    static_only: bool,
    /// Show it on a page for the browser of this computer too, where you add what is missing; Ctrl-C ends the page and breaks the seal
    #[arg(long)]
    page: bool,
    /// Print JSON instead of the story
    #[arg(long)]
    json: bool,
}

/// What every demo leaves.
const TRUTH: &str = "truth.toml";
const STATIC_CYCLE: &str = include_str!("../../../../config/cycles/demo-static.toml");
const SWEEP_CYCLE: &str = include_str!("../../../../config/cycles/demo-sweep-c.toml");
/// The simulated machine is quick: a newcomer waits.
const PACE: Pace = Pace { move_s: 0.055, dwell_s: 0.075 };
/// From switching on to the start of the program: drivers connect, clocks settle.
const WARM_UP: Duration = Duration::from_millis(2500);

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    if std::env::var_os("RUST_LOG").is_some() {
        log_to_stderr();
    }
    let output = folder_of_its_own(&args.output)?;
    if output != args.output {
        terminal::remark(&format!(
            "{} holds a demo already; this one is in {}",
            args.output.display(),
            output.display()
        ));
    }
    let args = &Args { output, ..args.clone() };
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("cannot make {}", args.output.display()))?;
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(demo(args))
}

/// The folder asked for, or the next number where it holds a demo: recordings, truth and report of one machine stay together.
fn folder_of_its_own(folder: &Path) -> anyhow::Result<PathBuf> {
    let is_free = |folder: &Path| !folder.join(TRUTH).exists();
    if is_free(folder) {
        return Ok(folder.to_owned());
    }
    let name = folder.file_name().with_context(|| {
        format!("{} holds a demo already; --output FOLDER takes another", folder.display())
    })?;
    let numbered = |number: u32| {
        let mut name = name.to_owned();
        name.push(format!("-{number}"));
        folder.with_file_name(name)
    };
    (2..10_000)
        .map(numbered)
        .find(|folder| is_free(folder))
        .context("there are too many demos; --output FOLDER takes another folder")
}

async fn demo(args: &Args) -> anyhow::Result<Outcome> {
    let show = |text: &str| if args.json { Ok(()) } else { terminal::print(text) };
    let static_cycle = Cycle::parse("demo-static.toml", STATIC_CYCLE)?;
    let machine = trunnion::files::machine(&static_cycle.machine)?;
    let poses = static_cycle.poses(&machine).context("the demo machine follows the ball")?;
    let stations: Vec<Station> =
        poses.iter().map(|pose| Station { setup: pose.setup, position: pose.position }).collect();

    let setups: Vec<SimSetup> = static_cycle.setups.iter().map(SimSetup::from).collect();
    let choices = hidden_choices(args, &machine)?;
    let truth =
        Truth::draw(&machine, &setups, &choices, scenario::duration_s(stations.len(), PACE), args.seed)?;
    let truth_path = args.output.join(TRUTH);
    output::write(&truth_path, &truth.to_toml())?;
    let virtual_machine = Arc::new(VirtualMachine::new(machine.clone(), truth)?);

    show(&format!(
        "A simulated five-axis machine ({}) with errors of its own{}. The truth is sealed.\n\
         Three probes on serial ports and the controller on the network; the program knows only what they say.\n\n",
        machine.name,
        if args.hidden == "none" { "" } else { " and something hidden" },
    ))?;
    let board = Board::default();
    let served = match args.page {
        true => {
            let mut cycles = vec![static_cycle.clone()];
            if !args.static_only {
                cycles.push(Cycle::parse("demo-sweep-c.toml", SWEEP_CYCLE)?);
            }
            let served = DemoPage::start(&args.output, &machine, &cycles, &board).await?;
            show(&format!("Watch it at {}\n\n", served.address()))?;
            Some(served)
        }
        false => None,
    };
    show(&format!("Static cycle: {} poses, two heights, both directions.\n", stations.len()))?;
    let world = scenario::static_cycle(virtual_machine.clone(), &static_cycle.name, &stations, PACE)?;
    let mut longest_pause = Duration::ZERO;
    let cycle = measure(args, &board, &static_cycle, STATIC_CYCLE, world, "static");
    let recorded = watched(cycle, &args.output, &mut longest_pause).await?;
    show(&format!("Recorded {}\n\n", recorded.path.display()))?;

    let date = daemon::day(SystemClock::start().wall_ns());
    let (path, base) = (recorded.path.clone(), Model::base(&machine.name));
    let mut losses = pages::losses(&recorded.gaps, recorded.lost_samples);
    let analysed =
        tokio::task::spawn_blocking(move || daemon::analyse_recording(&path, &base, &date)).await?;
    let too_little = |error| losses::failed(&losses, longest_pause, &recorded.path, error);
    let analysed = analysed.map_err(|error| too_little(error.into()))?;
    // With a page the terminal proposes, the person adds: all that follows is of the model that was judged.
    let (words, left) = match &served {
        Some(served) => (proposed(&analysed, &served.address()), analysed.first()),
        None => (story(&analysed), analysed.last()),
    };
    show(&words)?;
    // The page that follows the demo opens it as soon as there is a result.
    let report = args.output.join("report.html");
    let compared = left.compare().with_left_out(analysed.left_out());
    output::write(&report, &compared.with_losses(&losses).page())?;
    let found =
        RunResult { report: report.display().to_string(), ..daemon::in_short(&recorded.path, &analysed) };
    board.publish(&ResultNow::Found(Box::new(found)));

    let mut timing: Vec<TimeQuality> = Vec::new();
    let on_the_fly = if args.static_only {
        None
    } else {
        let sweep_cycle = Cycle::parse("demo-sweep-c.toml", SWEEP_CYCLE)?;
        show("\nOn-the-fly cycle: C turns both ways at two feeds.\n")?;
        let world = sweep_world(virtual_machine.clone(), &sweep_cycle)?;
        let sweep = measure(args, &board, &sweep_cycle, SWEEP_CYCLE, world, "sweep-c");
        let swept = watched(sweep, &args.output, &mut longest_pause).await?;
        losses.extend(pages::losses(&swept.gaps, swept.lost_samples));
        let swept_runs = trunnion::open(&swept.path)?;
        let too_little = |error| losses::failed(&losses, longest_pause, &swept.path, error);
        // What a turning C cannot show is left out, not guessed.
        let fit = swept_runs.fit_within_reach(left.fit().model());
        let fit = fit.map_err(|error| too_little(error.into()))?.results();
        timing.extend(swept_runs.time_quality());
        show(&format!(
            "Recorded {}; {} points while turning. The model of the static cycle leaves {} there, {}.\n",
            swept.path.display(),
            fit.points,
            um(fit.rms_um),
            repeatability(fit.noise_um, fit.noise_readings),
        ))?;
        Some(fit)
    };

    let why_lost = losses::why(&losses, longest_pause);
    if !why_lost.is_empty() {
        show(&format!("{why_lost}\n"))?;
    }
    // Where the page and `open` look for it.
    let model_path = own_model(&recorded.path);
    let left = match served {
        None => {
            left.fit().model().save(&model_path)?;
            left.clone()
        }
        Some(served) => {
            show("\nThe seal is broken when Ctrl-C ends the page.\n")?;
            served.until_interrupted(&show).await?;
            let (path, model) = (recorded.path.clone(), Model::load_or_base(&model_path, &machine.name)?);
            let judged = move || Ok::<_, trunnion::Error>(trunnion::open(path)?.fit(&model)?.compare());
            tokio::task::spawn_blocking(judged).await??.diagnosed().clone()
        }
    };
    let compared = left.compare().with_left_out(analysed.left_out());
    output::write(&report, &compared.with_losses(&losses).with_time_quality(&timing).page())?;
    show(&format!("\nReport: {}\n", report.display()))?;
    if model_path.exists() {
        show(&format!("Model:  {}\n", model_path.display()))?;
    }
    show(&format!("\nThe seal is broken. {}\n", truth_text(&virtual_machine, left.fit(), &truth_path)))?;
    if args.json {
        let ladder = left.fit().model().ladder();
        terminal::print_json(&Demo {
            format: DemoFormat::V1,
            seed: args.seed,
            hidden: virtual_machine.truth().hidden.iter().map(hidden::Hidden::id).collect(),
            found: ladder.added().map(|(effect, _)| effect.into()).collect(),
            verdict: analysed.first().results().verdict,
            diagnosis: analysed.first().results(),
            ladder: ladder.added().map(|(effect, row)| DemoStep::new(effect, row)).collect(),
            identification: left.fit().results(),
            last_diagnosis: left.results(),
            on_the_fly,
            report: report.display().to_string(),
            losses: losses.clone(),
            why_lost,
        })?;
    }
    Ok(if losses.is_empty() { Outcome::Done } else { Outcome::DataLoss })
}

fn hidden_choices(args: &Args, machine: &trunnion::Machine) -> anyhow::Result<Vec<HiddenChoice>> {
    match args.hidden.as_str() {
        "none" => Ok(Vec::new()),
        "random" => Ok(vec![hidden::random(machine, args.seed)]),
        name => {
            let possible =
                |id: &String| hidden::find(id).is_ok_and(|(_, place)| hidden::fits(machine, place));
            let ids: Vec<String> = hidden::ids().into_iter().filter(possible).collect();
            let wanted = ids
                .iter()
                .find(|id| *id == name)
                .or_else(|| ids.iter().find(|id| id.split(':').next() == Some(name)));
            let Some(id) = wanted else {
                let choices = ["none", "random"].into_iter().chain(ids.iter().map(String::as_str));
                bail!("there is no hidden physics \"{name}\"; allowed: {}", names::allowed(name, choices))
            };
            Ok(vec![HiddenChoice { id: id.clone(), sigma: args.size }])
        }
    }
}

fn sweep_world(machine: Arc<VirtualMachine>, cycle: &Cycle) -> anyhow::Result<SimulatedCell> {
    let Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } = &cycle.motion else {
        bail!("the demo's sweep cycle is not on the fly")
    };
    Ok(scenario::sweep_cycle(machine, &cycle.name, *axis, *from_to_rad, feeds_rad_per_s, others)?)
}

/// Measures, and how long this computer paused meanwhile, if longer than before.
async fn watched(
    measuring: impl Future<Output = anyhow::Result<Recorded>>,
    folder: &Path,
    longest_pause: &mut Duration,
) -> anyhow::Result<Recorded> {
    let pauses = Pauses::watch();
    let recorded = measuring.await;
    *longest_pause = pauses.longest().max(*longest_pause);
    recorded.map_err(|error| losses::failed(&[], *longest_pause, folder, error))
}

/// Switches a shop floor on, connects the real drivers to its ports, records one cycle.
async fn measure(
    args: &Args,
    board: &Board,
    cycle: &Cycle,
    cycle_text: &str,
    world: SimulatedCell,
    name: &str,
) -> anyhow::Result<Recorded> {
    let ports = std::env::temp_dir().join(format!("trunnion-demo-{}", std::process::id()));
    std::fs::create_dir_all(&ports).with_context(|| format!("cannot make {}", ports.display()))?;
    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    let mut floor = cell::CellConfig::new(&ports, clock.wall_ns());
    floor.can = None;
    if let Some((agent, _)) = &mut floor.controller {
        // The poses are short: a stand must show at once.
        agent.filters_duplicates = false;
    }
    let world: Arc<dyn World> = Arc::new(Later { world, by_s: WARM_UP.as_secs_f64() });
    let cell = cell::start(world, floor, tokio::time::Instant::now()).await?;
    let agent =
        cell.controller.as_ref().and_then(|handle| handle.url()).context("the cell has a controller")?;
    let config_text = config_text(&ports, agent, &args.output);
    let config = Config::parse(Path::new("demo.toml"), &config_text)?;
    let machine = trunnion::files::machine(&cycle.machine)?;
    let machine_text = crate::load::machine_text(&cycle.machine)?;
    let plan = Plan { machine, cycle: cycle.clone(), nest: config.nest, channels: channels(&config.devices) };
    let texts = Texts { machine: machine_text, cycle: cycle_text.into(), config: config_text };

    let cancel = CancellationToken::new();
    let names = config.devices.iter().map(|device| device.name.clone()).collect();
    let live = Live::start(config.devices, CycleBounds::default(), clock, cancel.clone());
    let mut live = live.led_by(board.operator());
    live.latest().set_mounted(Mounted::of(&plan));
    let shown = publish_live(live.latest().clone(), check(&plan)?, board.clone(), cancel.clone());
    let shown = tokio::spawn(shown);
    let states = States::new(board.clone());
    let status = daemon::publish_status(names, live.states(), board.clone(), states.clone(), cancel.clone());
    let status = tokio::spawn(status);
    let start = live.wait_for_start();
    let start = tokio::time::timeout(Duration::from_secs(20), start)
        .await
        .context("the simulated controller did not start its program within 20 s")?
        .context("the simulated devices went away")?;
    let run_name = daemon::free_name(&args.output, name);
    let mut bar = ProgressBar::new(args.json);
    let run = NewRun { plan: &plan, texts: &texts, calibrations: &[], folder: &args.output, name: &run_name };
    states.begin(
        CycleState::Measuring,
        &run_name,
        CycleProgress { cycle: Some(cycle.name.clone()), ..CycleProgress::default() },
    );
    let mut progress = |now: Progress| {
        bar.show(now);
        states.go_on(CycleState::Measuring, &run_name, daemon::cycle_under_way(now));
    };
    let recorded = daemon::record_cycle(&run, &mut live, start, &mut progress).await;
    bar.clear();
    if let Ok(recorded) = &recorded {
        states.go_on(
            CycleState::Done,
            &run_name,
            CycleProgress { ended: Some(recorded.ended.clone()), ..CycleProgress::default() },
        );
    }
    cancel.cancel();
    live.stop().await;
    status.await.context("the status ended badly")?;
    shown.await.context("the live values ended badly")?;
    board.publish(&ServiceStatus::default());
    cell.shutdown().await;
    std::fs::remove_dir_all(&ports).with_context(|| format!("cannot remove {}", ports.display()))?;
    Ok(recorded?)
}

fn config_text(ports: &Path, agent: &str, recordings: &Path) -> String {
    let mut text = format!(
        "format = \"trunnion-config/1\"\nname = \"demo\"\ncycle = \"demo.toml\"\nrecordings = '{}'\n\n[nest]\n",
        recordings.display()
    );
    for (k, direction) in trunnion_hil_sim::devices::orthogonal_nest().iter().enumerate() {
        text += &format!("probe_{} = {direction:?}\n", k + 1);
    }
    for k in 1..=3 {
        text += &format!(
            "\n[[device]]\nname = \"probe-{k}\"\ndriver = \"optoncdt\"\nport = '{}/probe-{k}'\nrole = \"probe-{k}\"\n\
             range_mm = 2\nrate_khz = 1\n",
            ports.display()
        );
    }
    text + &format!("\n[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{agent}\"\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_demo_has_a_folder_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let asked = folder.path().join("demo");
        let leave = |in_folder: &Path| {
            std::fs::create_dir_all(in_folder).unwrap();
            std::fs::write(in_folder.join(TRUTH), "").unwrap();
        };
        assert_eq!(folder_of_its_own(&asked).unwrap(), asked);
        leave(&asked);
        leave(&folder.path().join("demo-2"));
        assert_eq!(folder_of_its_own(&asked).unwrap(), folder.path().join("demo-3"));
    }
}
