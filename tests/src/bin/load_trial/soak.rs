//! One cycle after the other for hours, by the program itself: each is recorded and analysed while the next one is measured.

use crate::count::{self, Judged};
use crate::floor::{Floor, Order, Rates};
use crate::readers::{self, Received};
use crate::soak_table;
use crate::watch::{Sample, Watch};
use anyhow::{Context, bail};
use clap::Args;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};
use trunnion_results::RunRecord;
use trunnion_tests::mosquitto::Mosquitto;
use trunnion_tests::page_status::{free_address, free_port, status};
use trunnion_tests::pauses::Pauses;
use trunnion_tests::stopped::Stopped;

/// What is run, and for how long
#[derive(Args)]
pub struct SoakArgs {
    /// The program `trunnion`
    #[arg(long, value_name = "FILE")]
    program: PathBuf,
    /// How long, s
    #[arg(long, default_value_t = 7200.0, value_name = "S")]
    seconds: f64,
    /// Length of a cycle, s
    #[arg(long, default_value_t = 200.0, value_name = "S")]
    cycle_seconds: f64,
    /// Write the tables to this file, again each minute
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
}

/// Between two programs: a person starts the next.
const PAUSE_S: f64 = 20.0;
/// Raw recordings that the service may keep, MB: some cycles, so that the oldest go while the trial runs.
const BUDGET_MB: f64 = 200.0;
const MINUTE: Duration = Duration::from_secs(60);
/// How often the processes of the analyses are looked at.
const LOOK: Duration = Duration::from_secs(2);

/// What is known at one minute.
pub struct Minute {
    /// The process of the service.
    pub service: Sample,
    /// Most memory of an analysis so far, MiB.
    pub analysis_mib: f64,
    /// Size of the folder of the recordings, MB.
    pub folder_mb: f64,
    /// Load of the computer over a minute, from /proc/loadavg.
    pub load: f64,
    /// Health, as the page says it; empty where the page did not answer.
    pub health: String,
}

/// What came out so far.
pub struct Soak {
    /// Rates of the devices.
    pub rates: Rates,
    /// Length of a program, s.
    pub cycle_s: f64,
    /// Since the first program began, s.
    pub ran_s: f64,
    /// The looks.
    pub minutes: Vec<Minute>,
    /// What is in each recording, by its name.
    pub judged: BTreeMap<String, Judged>,
    /// Recordings that cannot be read, with why.
    pub unreadable: Vec<String>,
    /// Runs by the state in their files.
    pub states: BTreeMap<&'static str, usize>,
    /// Bytes the simulated devices could not hand to the system.
    pub bytes_not_taken: u64,
    /// The page's events and the broker's messages.
    pub page: Arc<Received>,
    /// See above.
    pub broker: Arc<Received>,
    /// The longest pause of a thread that asked for 2 ms of sleep.
    pub longest_pause: Duration,
    /// True for optimised devices.
    pub release: bool,
}

/// Runs, and writes the document again each minute, so that a trial that is ended says what it saw.
pub fn run(args: &SoakArgs) -> anyhow::Result<()> {
    let folder = tempfile::tempdir().context("cannot make a folder for ports and recordings")?;
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(soak(args, folder.path()))
}

async fn soak(args: &SoakArgs, folder: &Path) -> anyhow::Result<()> {
    let (runs, page, port) = (folder.join("runs"), free_address(), free_port());
    std::fs::create_dir_all(&runs).with_context(|| format!("cannot make {}", runs.display()))?;
    let _broker = Mosquitto::start(port).context("mosquitto does not start")?;
    let tables = format!(
        "\n[page]\nlisten = \"{page}\"\n\n[mqtt]\nhost = \"127.0.0.1\"\nport = {port}\n\n[storage]\nbudget_mb = {BUDGET_MB}\n"
    );
    let order = Order {
        seconds: args.cycle_seconds,
        rates: Rates::FULL,
        is_faulty: false,
        pause_s: Some(PAUSE_S),
        tables: &tables,
    };
    let floor = Floor::start(order, folder, &runs).await?;
    let log = folder.join("service.log");
    let output = std::fs::File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
    let mut command = Command::new(&args.program);
    command.arg("daemon").arg("--config").arg(&floor.config).stdin(Stdio::null()).stderr(output);
    command.envs(environment_of_the_unit());
    let mut child = Stopped(command.spawn().context("cannot start the service")?);
    let (at_page, at_broker) = (Arc::<Received>::default(), Arc::<Received>::default());
    tokio::spawn(readers::broker(port, at_broker.clone()));
    floor.until_begin().await;
    tokio::spawn(readers::page(page.clone(), at_page.clone()));
    let (begun, began, pauses) = (Instant::now(), SystemTime::now(), Pauses::watch());
    let mut soak = Soak {
        rates: Rates::FULL,
        cycle_s: floor.duration_s,
        ran_s: 0.0,
        minutes: Vec::new(),
        judged: BTreeMap::new(),
        unreadable: Vec::new(),
        states: BTreeMap::new(),
        bytes_not_taken: 0,
        page: at_page,
        broker: at_broker,
        longest_pause: Duration::ZERO,
        release: !cfg!(debug_assertions),
    };
    let mut watch = Watch::new(child.0.id());
    let mut analysis_mib = 0.0_f64;
    while soak.ran_s < args.seconds {
        let minute = Instant::now();
        while minute.elapsed() < MINUTE {
            tokio::time::sleep(LOOK).await;
            analysis_mib = analysis_mib.max(watch.children_mib());
        }
        if let Some(status) = child.0.try_wait()? {
            let said = std::fs::read_to_string(&log).unwrap_or_default();
            bail!("the service ended by itself: {status}; it said:\n{said}");
        }
        watch.sample()?;
        let service = watch.samples.last().cloned().context("just looked")?;
        let at = page.clone();
        let shown = tokio::task::spawn_blocking(move || status(&at)).await?;
        let health =
            shown.and_then(|shown| Some(shown.pointer("/topics/status/health/state")?.as_str()?.to_owned()));
        soak.look_into(&runs, &floor, began);
        let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
        let load = load.split(' ').next().and_then(|load| load.parse().ok()).unwrap_or(f64::NAN);
        let (folder_mb, health) = (folder_mb(&runs), health.unwrap_or_default());
        soak.minutes.push(Minute { service, analysis_mib, folder_mb, load, health });
        (soak.ran_s, soak.longest_pause) = (begun.elapsed().as_secs_f64(), pauses.longest());
        soak.bytes_not_taken = floor.bytes_not_taken();
        if let Some(path) = &args.markdown {
            let text = soak_table::document(&soak);
            std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    println!("{}", soak_table::document(&soak));
    drop(child);
    floor.shutdown().await;
    Ok(())
}

impl Soak {
    /// Counts what is in recordings that were finished since the last look, and where the runs are.
    fn look_into(&mut self, runs: &Path, floor: &Floor, began: SystemTime) {
        let entries: Vec<PathBuf> =
            std::fs::read_dir(runs).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
        let read = |path: &PathBuf| -> Option<RunRecord> {
            serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
        };
        let states: Vec<PathBuf> =
            entries.into_iter().filter(|path| path.to_string_lossy().ends_with(".state.json")).collect();
        self.states = BTreeMap::new();
        for path in states {
            let Some(record) = read(&path) else { continue };
            *self.states.entry(record.state.as_str()).or_default() += 1;
            let name = path.file_name().unwrap_or_default().to_string_lossy().replace(".state.json", ".mcap");
            let recording = runs.join(&name);
            if self.judged.contains_key(&name)
                || !recording.exists()
                || self.unreadable.iter().any(|why| why.contains(&name))
            {
                continue;
            }
            match judge(&recording, floor, self.rates, began) {
                Ok(judged) => drop(self.judged.insert(name, judged)),
                Err(error) => self.unreadable.push(format!("{name}: {error:#}")),
            }
        }
    }
}

/// Which program a recording is of is seen from the time when it was finished, at least the program's length after its start.
fn judge(recording: &Path, floor: &Floor, rates: Rates, began: SystemTime) -> anyhow::Result<Judged> {
    let finished = std::fs::metadata(recording)?.modified()?.duration_since(began)?.as_secs_f64();
    let program = ((finished - floor.duration_s) / floor.period_s).max(0.0) as usize;
    let counts = count::count(recording, rates, floor.duration_s)?;
    Ok(Judged { seconds: floor.duration_s, counts, sent: floor.sent(program) })
}

fn folder_mb(folder: &Path) -> f64 {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    files.filter_map(|file| file.metadata().ok()).map(|about| about.len()).sum::<u64>() as f64 / 1e6
}

/// What the unit sets for the service.
fn environment_of_the_unit() -> impl Iterator<Item = (&'static str, &'static str)> {
    let lines = include_str!("../../../../systemd/trunnion.service").lines();
    let assignments = lines.filter_map(|line| line.strip_prefix("Environment="));
    assignments.flat_map(str::split_whitespace).filter_map(|assignment| assignment.split_once('='))
}
