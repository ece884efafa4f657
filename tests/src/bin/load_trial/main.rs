//! The load trial: the service reads three probes at 4 kHz, an encoder at 1 kHz and axes at 200 Hz while C turns at 360
//! to 3600 °/min. Simulated devices live in this process, the service in another, so that its time and memory are its own.
//!
//! `floor` has the devices, `service` is the other process, `watch` reads its time and memory from /proc, `count` what is
//! in the finished recording, `table` writes `docs/measured/load.md`. `soak` runs one cycle after the other for hours, with `readers` of
//! page and broker; `soak_table` writes `docs/measured/soak.md`. `flood` runs a cycle in quiet and one while `attack` attacks the page.

mod attack;
mod count;
mod flood;
mod floor;
mod readers;
mod service;
mod soak;
mod soak_table;
mod table;
mod watch;

use anyhow::{Context, bail};
use clap::{Parser, Subcommand};
use count::Judged;
use flood::{AtPage, Page, Visitors};
use floor::{Floor, Rates};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use trunnion_tests::pauses::Pauses;
use trunnion_tests::stopped::Stopped;
use watch::Watch;

/// Measure on the fly at full rate for some minutes; count what was lost, and what it cost
#[derive(Parser)]
#[command(name = "load-trial")]
struct Args {
    #[command(subcommand)]
    part: Option<Part>,
    /// Length of the cycle, s
    #[arg(long, default_value_t = 600.0, value_name = "S")]
    seconds: f64,
    /// Write the tables to this file
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Low rates that any computer reads, and a probe that is silent for a second: is every sample of it counted as lost?
    #[arg(long)]
    low: bool,
    /// Two cycles with a page: in quiet, and while others attack it; are samples missing that were there in quiet?
    #[arg(long, conflicts_with = "low")]
    flood: bool,
    /// Keep the recording in this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Part {
    /// The service alone; started by the trial
    #[command(hide = true)]
    Service {
        /// Its configuration
        config: PathBuf,
    },
    /// Who attacks the page; started by the trial
    #[command(hide = true)]
    Attack {
        /// Address of the page
        address: SocketAddr,
        /// First it waits, s
        #[arg(long)]
        after: f64,
        /// For so long, s
        #[arg(long)]
        seconds: f64,
    },
    /// One cycle after the other, each analysed, with somebody at the page and at the broker
    Soak(soak::SoakArgs),
}

/// Exit codes. 0: nothing is missing, and the recording says so. 1: samples are missing, and the recording does not say so. 3: it does,
/// or it says so of samples that are there. 4: as 3, and this computer paused so long that nothing can be said of the service.
const LOST_IN_SILENCE: i32 = 1;
const LOST_AND_REPORTED: i32 = 3;
const TOO_SLOW_TO_JUDGE: i32 = 4;
/// A pseudo-terminal holds 4096 bytes, 114 ms of a probe at 4 kHz with 9 bytes a value. A pause of half of that, which the
/// service has to catch up with, is the computer's doing.
const TOO_LONG: Duration = Duration::from_millis(57);

/// What came out.
pub struct Trial {
    /// Rates of the devices.
    pub rates: Rates,
    /// What is in the recording, against what was sent.
    pub judged: Judged,
    /// Bytes the simulated devices could not hand to the system.
    pub bytes_not_taken: u64,
    /// Time and memory of the service.
    pub watch: Watch,
    /// Highest fill of the queue between drivers and cycle, and of that to the recorder, in messages.
    pub queues: service::Queues,
    /// What was seen of its page, where it had one.
    pub at_page: Option<AtPage>,
    /// True for an optimised program.
    pub release: bool,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    match &args.part {
        Some(Part::Service { config }) => return service::run(config),
        Some(Part::Attack { address, after, seconds }) => return attack::run(*address, *after, *seconds),
        Some(Part::Soak(soak)) => return soak::run(soak),
        None => {}
    }
    if !(10.0..=7200.0).contains(&args.seconds) {
        bail!("--seconds {} is not possible; allowed: 10..=7200", args.seconds);
    }
    let folder = tempfile::tempdir().context("cannot make a folder for ports and recording")?;
    let place = args.keep.clone().unwrap_or_else(|| folder.path().join("runs"));
    // The service reads paths from the folder of its configuration.
    let place = std::path::absolute(&place).with_context(|| format!("no folder {}", place.display()))?;
    std::fs::create_dir_all(&place).with_context(|| format!("cannot make {}", place.display()))?;
    if args.flood {
        std::process::exit(flood::run(args.seconds, &place, args.markdown.as_deref())?);
    }
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    let pauses = Pauses::watch();
    let full = Order { seconds: args.seconds, ..Order::full(folder.path(), &place) };
    let order = if args.low { Order { rates: Rates::LOW, is_faulty: true, ..full } } else { full };
    let trial = runtime.block_on(trial(order))?;
    let text = table::document(&trial);
    print!("{text}");
    if let Some(path) = &args.markdown {
        std::fs::write(path, &text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    std::process::exit(verdict(&trial, pauses.longest()))
}

/// Says what is missing; the exit code.
fn verdict(trial: &Trial, longest: Duration) -> i32 {
    if trial.judged.is_late() {
        eprintln!("the service began after the program: encoder and axes are not judged");
    }
    let ((missing, unreported), counts) = (trial.judged.missing(), &trial.judged.counts);
    for silent in trial.judged.silent() {
        eprintln!("{silent}");
    }
    match (missing, counts.lost, counts.uncounted) {
        (0, 0, 0) => return 0,
        (0, 1.., _) => {
            let lost = counts.lost;
            match trial.judged.overcounted() {
                0 => eprintln!("{lost} samples are recorded as lost where nothing was compared"),
                many => eprintln!(
                    "{lost} samples are recorded as lost, and {many} of them are there: it counts too many"
                ),
            }
        }
        (_, lost, uncounted) => eprintln!(
            "{missing} samples are missing, {unreported} of them without a gap; {lost} were recorded as lost, and {uncounted} gaps have \
             no number"
        ),
    }
    match (unreported, longest > TOO_LONG) {
        (1.., _) => LOST_IN_SILENCE,
        (0, true) => {
            let rates = "whether the service keeps up with these rates is not judged";
            eprintln!("too slow to judge: this computer paused {} ms; {rates}", longest.as_millis());
            TOO_SLOW_TO_JUDGE
        }
        (0, false) => LOST_AND_REPORTED,
    }
}

/// Of two exit codes that of the worse trial; one that cannot be judged hides no loss in silence.
fn severest(a: i32, b: i32) -> i32 {
    let order = [LOST_IN_SILENCE, TOO_SLOW_TO_JUDGE, LOST_AND_REPORTED];
    order.into_iter().find(|code| [a, b].contains(code)).unwrap_or(0)
}

/// One cycle.
#[derive(Clone, Copy)]
struct Order<'a> {
    /// Its length, s.
    seconds: f64,
    rates: Rates,
    /// A probe is silent for a second.
    is_faulty: bool,
    page: Option<&'a Page>,
    /// Folder of ports and configuration.
    folder: &'a Path,
    recordings: &'a Path,
}

impl<'a> Order<'a> {
    /// At full rate, without a page.
    fn full(folder: &'a Path, recordings: &'a Path) -> Self {
        Self { seconds: 600.0, rates: Rates::FULL, is_faulty: false, page: None, folder, recordings }
    }
}

/// After the cycle: rewriting the recording and reading it back.
const FINISH_LIMIT: Duration = Duration::from_secs(300);
/// From the finished file to the line in the log.
const LINE_LIMIT: Duration = Duration::from_secs(300);

async fn trial(order: Order<'_>) -> anyhow::Result<Trial> {
    let Order { seconds, rates, is_faulty, page, folder, recordings } = order;
    let tables = page.map_or(String::new(), |page| format!("\n[page]\nlisten = \"{}\"\n", page.address));
    let of_floor = floor::Order { seconds, rates, is_faulty, pause_s: None, tables: &tables };
    let floor = Floor::start(of_floor, folder, recordings).await?;
    let program = std::env::current_exe().context("where is this program?")?;
    let log = folder.join("service.log");
    let output = std::fs::File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
    let child = Command::new(program)
        .arg("service")
        .arg(&floor.config)
        .stdin(Stdio::null())
        .stderr(output)
        .spawn()
        .context("cannot start the service")?;
    let mut child = Stopped(child);
    let mut watch = Watch::new(child.0.id());
    floor.until_begin().await;
    let begun = Instant::now();
    let visitors = page.map(|page| Visitors::start(page, floor.duration_s)).transpose()?;
    while begun.elapsed().as_secs_f64() < floor.duration_s {
        watch.sample().context("reading the time and memory of the service")?;
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
    watch.sample()?;
    let at_page = match visitors {
        Some(visitors) => Some(visitors.leave().await?),
        None => None,
    };
    let finished = finished(recordings, &mut child).await;
    // The line about the queues follows the file.
    let queues = async {
        loop {
            let reported = std::fs::read_to_string(&log).unwrap_or_default();
            match service::Queues::of_log(&reported) {
                Some(queues) => return queues,
                None => tokio::time::sleep(Duration::from_millis(100)).await,
            }
        }
    };
    let queues = tokio::time::timeout(LINE_LIMIT, queues).await.context("no line about the queues");
    let reported = std::fs::read_to_string(&log).unwrap_or_default();
    let queues = queues.with_context(|| format!("the service said:\n{reported}"))?;
    let path = finished.with_context(|| format!("the service said:\n{reported}"))?;
    let (sent, bytes_not_taken) = (floor.sent(0), floor.bytes_not_taken());
    let counts = count::count(&path, rates, floor.duration_s)?;
    let judged = Judged { seconds: floor.duration_s, counts, sent };
    floor.shutdown().await;
    drop(child);
    let release = !cfg!(debug_assertions);
    Ok(Trial { rates, judged, bytes_not_taken, watch, queues, at_page, release })
}

async fn finished(folder: &Path, child: &mut Stopped) -> anyhow::Result<PathBuf> {
    let begun = Instant::now();
    while begun.elapsed() < FINISH_LIMIT {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|ending| ending == "mcap") {
                return Ok(path);
            }
        }
        if let Some(status) = child.0.try_wait()? {
            bail!("the service ended by itself: {status}");
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    bail!("no finished recording in {} after {} s", folder.display(), FINISH_LIMIT.as_secs())
}
