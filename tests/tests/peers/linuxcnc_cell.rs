//! A cell whose controller is LinuxCNC, without a screen: it moves five axes by our NC programs while simulated probes follow
//! where the axes really are, and our service records the cycle.

use crate::linuxcnc_process::{Drives, JOINTS, LinuxCnc, PORT, axes_of, reach, unprivileged};
use std::collections::VecDeque;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::config::channels;
use trunnion_core::{AxisValues, Clock, Joint, State, convert};
use trunnion_cycles::nc::{Program, dialect};
use trunnion_cycles::{CourseRules, Cycle};
use trunnion_effects::Model;
use trunnion_hil_sim::VirtualMachine;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::{CycleState, TimeOrigin, World, cell, orthogonal_nest};
use trunnion_machine::{Machine, shipped};
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::Cycles;
use trunnion_service::daemon::{Texts, serve};
use trunnion_service::live::Plan;
use trunnion_tests::{SILENCE_MS, first_report, three_probes};

/// The simulated machine at LinuxCNC's positions.
pub struct Followed {
    machine: VirtualMachine,
    /// Time of the cell and position, the newest last.
    history: Mutex<VecDeque<(f64, AxisValues<f64>)>>,
}

impl Followed {
    pub fn new(machine: VirtualMachine) -> Arc<Self> {
        Arc::new(Self { machine, history: Mutex::default() })
    }

    fn is_at(&self, time_s: f64, axes: AxisValues<f64>) {
        let mut history = self.history.lock().unwrap();
        history.push_back((time_s, axes));
        if history.len() > 4096 {
            history.pop_front();
        }
    }

    /// Asks LinuxCNC on a connection of its own until asked to stop.
    fn follow(self: Arc<Self>, origin: TimeOrigin, stop: Arc<AtomicBool>) {
        let mut conversation = reach();
        while !stop.load(Ordering::Relaxed) {
            let axes = conversation.axes();
            self.is_at(origin.now_s(), axes);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Reads the sampled commands of the drives until asked to stop.
    fn sample(self: Arc<Self>, origin: TimeOrigin, stop: Arc<AtomicBool>) {
        // HAL is there when linuxcncrsh answers.
        let _connection = reach();
        let mut sampler = unprivileged("stdbuf")
            .args(["-oL", "halsampler"])
            .stdout(Stdio::piped())
            .spawn()
            .expect("halsampler comes with linuxcnc-uspace");
        for line in BufReader::new(sampler.stdout.take().unwrap()).lines() {
            // Also says "overrun" after a pause.
            let line = line.unwrap();
            let numbers: Vec<f64> =
                line.split_whitespace().filter_map(|number| number.parse().ok()).collect();
            if numbers.len() == JOINTS.len() {
                self.is_at(origin.now_s(), axes_of(&numbers));
            }
            if stop.load(Ordering::Relaxed) {
                break;
            }
        }
        sampler.kill().unwrap();
        sampler.wait().unwrap();
    }

    /// The setup whose ball the tool is at.
    fn setup(&self, axes: &AxisValues<f64>) -> usize {
        let setups = &self.machine.truth().setups;
        let off = |k: usize| {
            let ball = setups[k].setup.ball_in_table_mm;
            self.machine.machine().follow(axes, &ball).map_or(f64::INFINITY, |nominal| {
                Joint::LINEAR.map(|letter| axes[letter] - nominal[letter]).iter().map(|d| d * d).sum()
            })
        };
        (0..setups.len()).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap()
    }
}

impl World for Followed {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        let history = self.history.lock().unwrap();
        let after = history.partition_point(|(time_s, _)| *time_s < t_s);
        match (after.checked_sub(1).and_then(|k| history.get(k)), history.get(after)) {
            (Some((t0, a)), Some((t1, b))) => {
                let share = (t_s - t0) / (t1 - t0);
                AxisValues::from_fn(|letter| a[letter] + share * (b[letter] - a[letter]))
            }
            (Some((_, axes)), None) | (None, Some((_, axes))) => *axes,
            (None, None) => AxisValues::default(),
        }
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        let position = self.axes(t_s);
        let setup = self.setup(&position);
        let state = State { position, setup, time_s: Some(t_s), ..State::default() };
        let deflection_mm = self.machine.ideal_reading_mm(setup, &state);
        orthogonal_nest().map(|along| (0..3).map(|k| along[k] * deflection_mm[k]).sum())
    }

    fn bar_reading_mm(&self, _: f64) -> f64 {
        0.0
    }

    fn temperature_degc(&self, _: f64) -> f64 {
        20.0
    }

    fn cycle(&self, _: f64) -> CycleState {
        CycleState { program: String::new(), block: 0, running: false }
    }
}

/// Starts the program and goes on after each stop, as the operator would. Ends with the program.
fn operate(program: &Path) {
    let mut operator = reach();
    operator.enable();
    operator.until("set estop off", "get estop", "ESTOP", "OFF");
    operator.until("set machine on", "get machine", "MACHINE", "ON");
    operator.until("set mode auto", "get mode", "MODE", "AUTO");
    let path = program.display().to_string();
    operator.until(&format!("set open {path}"), "get program", "PROGRAM", &path);
    operator.until("set run", "get program_status", "PROGRAM_STATUS", "RUNNING");
    // One answer may be meant for another connection: only a program that stays idle has ended.
    let mut idle = 0;
    while idle < 10 {
        let status = operator.answer("get program_status", "PROGRAM_STATUS");
        idle = if status == "IDLE" { idle + 1 } else { 0 };
        if status == "PAUSED" {
            operator.say("set resume");
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    assert_eq!(operator.answer("get error", "ERROR"), "OK");
}

/// What is measured in this cell.
pub struct Task<'a> {
    pub cnc: &'a LinuxCnc,
    pub drives: Drives,
    pub machine: &'a Machine,
    pub cycle_text: &'a str,
    /// By the rules of the cycle where it is not given.
    pub dwell_s: Option<f64>,
    /// False where the readings are too few for the service to analyse: then the recording is waited for.
    pub analysed: bool,
    /// Between poses, mm/s.
    pub transfer_mm_per_s: f64,
}

/// LinuxCNC runs the cycle in this world, the service records it: the recording.
pub async fn measure(folder: &Path, world: Arc<Followed>, task: &Task<'_>) -> PathBuf {
    let cycle = Cycle::parse("c.toml", task.cycle_text).unwrap();
    let rules = CourseRules {
        dwell_s: task.dwell_s,
        transfer_mm_per_s: task.transfer_mm_per_s,
        transfer_rad_per_s: convert::rad_from_deg(1.8 * task.transfer_mm_per_s),
        ..CourseRules::default()
    };
    let program = Program::of_cycle(&cycle, task.machine, &rules).unwrap();
    let linuxcnc = dialect("linuxcnc").unwrap();
    let path = task.cnc.put(&(linuxcnc.write)(&program, linuxcnc.decimals));
    std::fs::create_dir_all(folder).unwrap();

    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    let mut floor = CellConfig::new(folder, clock.wall_ns());
    (floor.can, floor.controller) = (None, None);
    let origin = tokio::time::Instant::now();
    let stop = Arc::new(AtomicBool::new(false));
    let (following, asked, direct) = (world.clone(), stop.clone(), task.drives == Drives::Direct);
    let follower = std::thread::spawn(move || match direct {
        true => following.follow(TimeOrigin(origin), asked),
        false => following.sample(TimeOrigin(origin), asked),
    });
    let cell = cell::start(world, floor, origin).await.unwrap();
    let start = "[cycle_start]\nby = \"program\"\nprogram = \"*/trunnion-cycle.ngc\"\n";
    let cnc_table = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"linuxcnc\"\nhost = \"127.0.0.1\"\nport = {PORT}\njoints = \"XYZBC\"\n"
    );
    let text = three_probes(folder, SILENCE_MS, start, &cnc_table);
    let config = Config::parse(&folder.join("trunnion.toml"), &text).unwrap();
    let machine = task.machine.clone();
    let plan = Plan { machine, cycle, nest: config.nest, channels: channels(&config.devices) };
    let texts = Texts { machine: shipped::FILES[0].1.into(), cycle: task.cycle_text.into(), config: text };
    let model = Model::base(&task.machine.name).into();
    let cycles = Cycles::one(plan, texts, model).expect("it can be measured");
    let runs = config.recordings.clone();
    let cancel = CancellationToken::new();
    let service = tokio::spawn(serve(config, cycles, clock, cancel.clone()));

    tokio::task::spawn_blocking(move || operate(&path)).await.unwrap();
    let limit = Duration::from_secs(120);
    let recording = match task.analysed {
        true => first_report(&runs, limit).await.expect("a report within two minutes"),
        false => recorded(&runs, limit).await.expect("a recording within two minutes"),
    };
    cancel.cancel();
    service.await.unwrap().unwrap();
    cell.shutdown().await;
    stop.store(true, Ordering::Relaxed);
    follower.join().unwrap();
    recording
}

/// Waits for a finished recording; while it is written its name ends otherwise.
async fn recorded(runs: &Path, limit: Duration) -> Option<PathBuf> {
    let written = async {
        loop {
            let mut files = std::fs::read_dir(runs).into_iter().flatten().flatten().map(|file| file.path());
            if let Some(path) = files.find(|path| path.extension().is_some_and(|ending| ending == "mcap")) {
                return path;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    tokio::time::timeout(limit, written).await.ok()
}
