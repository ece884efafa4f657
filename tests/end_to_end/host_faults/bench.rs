//! A service at work on simulated devices, and what it left of a run.

use super::Fault;
use super::losses::{Hole, gaps_and_silent_losses};
use crate::broker::Broker;
use crate::shop::{self, Floor, Service, files, floor, journal, record, until};
use std::any::Any;
use std::os::unix::net::UnixDatagram;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};
use trunnion::results::{RunRecord, RunState};
use trunnion_core::HostTime;
use trunnion_cycles::RunKind;
use trunnion_hil_sim::devices;
use trunnion_hil_sim::devices::cell::Cell;
use trunnion_hil_sim::scenario::Pace;
use trunnion_record::{Recorder, RunHeader};

/// A journal of this size holds a second of three probes at 1 kHz.
const BEGUN: u64 = 100_000;
/// A disk that has room for a cycle, MB.
const DISK_MB: u64 = 128;

/// The service, and what a fault needs.
pub struct Bench {
    folder: PathBuf,
    pub service: Option<Service>,
    pub broker: Broker,
    /// Bytes of the broker that were looked at.
    published: usize,
    cell: Cell,
    /// What systemd would have heard and nobody took.
    systemd: Arc<Mutex<String>>,
}

impl Bench {
    /// Starts the service, again where it was killed.
    pub fn start(&mut self) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
        command.args(["daemon", "--config"]).arg(self.folder.join("trunnion.toml"));
        self.start_by(&mut command);
    }

    /// The same where `runs` is a small disk, in a mount namespace of its own, which needs no rights where user namespaces are allowed.
    pub fn start_on_a_small_disk(&mut self) {
        let script =
            format!("mount -t tmpfs -o size={DISK_MB}m none \"$1\" && exec \"$0\" daemon --config \"$2\"");
        let mut command = Command::new("unshare");
        command.args(["--map-root-user", "--mount", "sh", "-c", &script, env!("CARGO_BIN_EXE_trunnion")]);
        command.arg(self.folder.join("runs")).arg(self.folder.join("trunnion.toml"));
        self.start_by(&mut command);
    }

    /// The same where `runs` cannot be written, until [`Self::make_writable`].
    pub fn start_on_a_read_only_disk(&mut self) {
        let script = "mount --bind -o ro \"$1\" \"$1\" && exec \"$0\" daemon --config \"$2\"";
        let mut command = Command::new("unshare");
        command.args(["--map-root-user", "--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_trunnion")]);
        command.arg(self.folder.join("runs")).arg(self.folder.join("trunnion.toml"));
        self.start_by(&mut command);
    }

    /// The disk of the service can be written.
    pub fn make_writable(&self) {
        let Service(process) = self.service.as_ref().unwrap();
        let mut command = Command::new("nsenter");
        command.args(["--preserve-credentials", "--user", "--mount", "--target", &process.id().to_string()]);
        command.args(["mount", "-o", "remount,bind,rw"]).arg(self.folder.join("runs"));
        assert!(command.status().unwrap().success(), "{command:?}");
    }

    /// Waits until the broker gets these words, after those that were waited for before.
    pub fn publishes(&mut self, words: &str) {
        self.published += until(words, || {
            let since = String::from_utf8_lossy(&self.broker.sent()[self.published..]).into_owned();
            since.find(words).map(|at| at + words.len())
        });
    }

    /// The same with a clock that can be set and a disk that can hang, as faults of this program alone, and somebody who listens as systemd does.
    pub fn start_with_faults(&mut self) {
        let (library, heard) = (self.folder.join("faults.so"), self.folder.join("systemd"));
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/end_to_end/host_faults/faults.c");
        let mut compiler = Command::new("cc");
        let built = compiler.args(["-shared", "-fPIC", "-o"]).arg(&library).arg(source).status().unwrap();
        assert!(built.success(), "cc builds {source}");
        let systemd = UnixDatagram::bind(&heard).unwrap();
        // A socket that nobody empties holds who writes to it.
        let words = Arc::downgrade(&self.systemd);
        systemd.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        std::thread::spawn(move || {
            let mut message = [0; 4096];
            while let Some(words) = words.upgrade() {
                if let Ok(size) = systemd.recv(&mut message) {
                    words.lock().unwrap().push_str(&String::from_utf8_lossy(&message[..size]));
                }
            }
        });
        let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
        command.args(["daemon", "--config"]).arg(self.folder.join("trunnion.toml"));
        command.env("LD_PRELOAD", library).env("TRUNNION_FAULTS", &self.folder).env("NOTIFY_SOCKET", heard);
        // WatchdogSec of the unit.
        command.env("WATCHDOG_USEC", "30000000");
        self.start_by(&mut command);
    }

    /// What systemd heard since it was asked last.
    pub fn heard(&self) -> String {
        std::mem::take(&mut *self.systemd.lock().unwrap())
    }

    /// Begins or ends a fault of [`Self::start_with_faults`].
    pub fn fault(&self, name: &str, text: Option<&str>) {
        let (file, next) = (self.folder.join(name), self.folder.join("next"));
        match text {
            // Whole at once: the program may look at any moment.
            Some(text) => {
                std::fs::write(&next, text).unwrap();
                std::fs::rename(&next, &file).unwrap();
            }
            None => std::fs::remove_file(&file).unwrap(),
        }
    }

    /// A run of the day before that has its report.
    pub fn earlier_run(&self) -> PathBuf {
        let header = RunHeader::new("earlier", RunKind::OnTheFly, "table-bc");
        let recorder = Recorder::create(&self.folder.join("runs"), "earlier", &header).unwrap();
        let file = recorder.finish(HostTime(0)).unwrap().files.remove(0).path;
        let yesterday = SystemTime::now() - Duration::from_secs(24 * 3600);
        std::fs::File::options().write(true).open(&file).unwrap().set_modified(yesterday).unwrap();
        std::fs::write(file.with_extension("diagnosis.json"), "{}").unwrap();
        file
    }

    fn start_by(&mut self, command: &mut Command) {
        let log = std::fs::File::options().create(true).append(true).open(self.log()).unwrap();
        self.service = Some(Service::start_by(command.stderr(log)));
    }

    /// As a power cut ends it.
    pub fn kill(&mut self) {
        self.service.take().unwrap().kill();
    }

    /// The same, and started again.
    pub fn restart(&mut self) {
        self.kill();
        self.start();
    }

    /// The folder of the recordings, as the service sees it.
    pub fn runs(&self) -> PathBuf {
        let seen = self.folder.join("runs");
        let Some(Service(process)) = &self.service else { return seen };
        Path::new(&format!("/proc/{}/root", process.id())).join(seen.strip_prefix("/").unwrap())
    }

    /// Waits until a cycle is recorded.
    pub fn recording(&self) -> PathBuf {
        journal(&self.runs(), BEGUN)
    }

    /// Waits until the log has these words.
    pub fn says(&self, words: &str) {
        until(words, || self.has_said(words).then_some(()));
    }

    pub fn has_said(&self, words: &str) -> bool {
        std::fs::read_to_string(self.log()).unwrap_or_default().contains(words)
    }

    /// Waits for the state of the run.
    pub fn state(&self, fits: impl Fn(&RunRecord) -> bool) -> RunRecord {
        until("the state of the run", || {
            files(&self.runs(), ".state.json").iter().filter_map(|file| record(file)).find(&fits)
        })
    }

    /// The state on disk of what was being analysed, as a kill a moment earlier leaves it.
    pub fn set_back(&self, state: RunState) {
        for file in files(&self.runs(), ".state.json") {
            let kept = record(&file).filter(|kept| kept.state == RunState::Analysing);
            let Some(kept) = kept else { continue };
            let earlier = RunRecord { state, tries: 0, ..kept };
            std::fs::write(&file, serde_json::to_string(&earlier).unwrap()).unwrap();
        }
    }

    /// Makes a device of the floor fail.
    pub fn controller(&self, fault: devices::Fault) {
        self.cell.controller.as_ref().unwrap().inject(fault).unwrap();
    }

    pub fn configure(&self, more: &str) {
        let file = self.folder.join("trunnion.toml");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text + more).unwrap();
    }

    fn log(&self) -> PathBuf {
        self.folder.join("log.txt")
    }
}

/// What is not as its row says.
#[derive(Debug)]
pub enum Wrong {
    /// Nothing but these holes without a gap, with all that is known.
    Silent(Vec<Hole>, String),
    /// Anything else.
    Other(String),
}

/// Runs one fault.
pub async fn judge(fault: &'static Fault) -> Result<(), Wrong> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    std::fs::create_dir(path.join("runs")).unwrap();
    let broker = Broker::start("cell", "password".into());
    let Floor { cell, url, cycle } = floor(&path, 90, Pace { move_s: 0.1, dwell_s: 0.2 }, |_| {}).await;
    let mqtt = format!(
        "[mqtt]\nhost = \"127.0.0.1\"\nport = {}\nuser = \"cell\"\npassword = \"password\"\n",
        broker.port
    );
    std::fs::write(path.join("c.toml"), cycle).unwrap();
    std::fs::write(path.join("trunnion.toml"), shop::config(&path, "runs", &shop::agent(&url), &mqtt))
        .unwrap();
    let mut bench =
        Bench { folder: path, service: None, broker, published: 0, cell, systemd: Arc::default() };
    let judging = tokio::task::spawn_blocking(move || {
        let judged = catch_unwind(AssertUnwindSafe(|| judged(&mut bench, fault)));
        bench.service = None;
        (bench, judged)
    });
    let (bench, judged) = judging.await.map_err(|ended| Wrong::Other(ended.to_string()))?;
    let log = std::fs::read_to_string(bench.log()).unwrap_or_default();
    bench.cell.shutdown().await;
    match judged {
        Ok(judged) => judged.map_err(|wrong| match wrong {
            Wrong::Silent(holes, what) => Wrong::Silent(holes, format!("{what}\n{log}")),
            Wrong::Other(what) => Wrong::Other(format!("{what}\n{log}")),
        }),
        Err(panic) => Err(Wrong::Other(format!("{}\n{log}", words(panic.as_ref())))),
    }
}

fn judged(bench: &mut Bench, fault: &Fault) -> Result<(), Wrong> {
    (fault.run)(bench);
    fault.says.iter().for_each(|words| bench.says(words));
    // A run that is not judged stays so. One that failed may go on: of a part alone nothing can be said, of the joined run much.
    let ended =
        bench.state(|record| fault.ends.contains(&record.state) || record.state == RunState::NotJudged);
    let runs = bench.runs();
    let (gaps, silent) = gaps_and_silent_losses(&files(&runs, ".mcap"));
    let reasons: Vec<String> = gaps.iter().map(|gap| format!("{}: {}", gap.source, gap.reason)).collect();
    let is_as_said = match fault.gap {
        Some(words) => reasons.iter().any(|reason| reason.contains(words)),
        None => gaps.iter().all(|gap| gap.source != "recorder"),
    };
    let holes: Vec<String> = silent.iter().map(Hole::to_string).collect();
    let what = format!("{:?} ({}), gaps {reasons:#?}, silent losses {holes:#?}", ended.state, ended.why);
    match (is_as_said && fault.ends.contains(&ended.state), silent.is_empty()) {
        (true, true) => Ok(()),
        (true, false) => Err(Wrong::Silent(silent, what)),
        (false, _) => Err(Wrong::Other(what)),
    }
}

/// What a panic said.
fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it panicked")
}
