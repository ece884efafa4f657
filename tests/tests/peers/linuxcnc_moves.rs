//! LinuxCNC moves five axes by our NC program while simulated probes follow its real positions: our service records the
//! cycle, and the location errors hidden in the machine are found.

use std::collections::{BTreeMap, VecDeque};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio_util::sync::CancellationToken;
use trunnion_acquire::config::channels;
use trunnion_core::axis::iso::{B, C, X, Y, Z};
use trunnion_core::{AxisValues, Clock, Joint, State, convert};
use trunnion_cycles::CourseRules;
use trunnion_cycles::Cycle;
use trunnion_cycles::nc::{Program, dialect};
use trunnion_effects::Model;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::{CycleState, TimeOrigin, World, cell, orthogonal_nest};
use trunnion_hil_sim::truth::minimum_set;
use trunnion_hil_sim::{Instrument, NestOn, SimSetup, Truth, VirtualMachine};
use trunnion_machine::shipped;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::Cycles;
use trunnion_service::daemon::{Texts, serve};
use trunnion_service::live::Plan;
use trunnion_tests::{SILENCE_MS, first_report, show_log, three_probes, workspace_root};

/// LinuxCNC's port here; its other parts allow one of it on a computer anyway.
const PORT: u16 = 5079;
/// Order of the joints in five-axis.ini.
const JOINTS: [Joint; 5] = [X, Y, Z, B, C];
/// Longest wait for LinuxCNC to do as commanded.
const LIMIT: Duration = Duration::from_secs(60);

/// A running LinuxCNC; shut down with this.
struct LinuxCnc {
    process: Child,
    _folder: tempfile::TempDir,
    program: PathBuf,
}

impl LinuxCnc {
    /// As an unprivileged user with a home of its own: it refuses nothing, but neither does it belong to root.
    fn start(program: &str) -> Self {
        let folder = tempfile::Builder::new().prefix("linuxcnc").tempdir().unwrap();
        let source = workspace_root().join("tests/peers/linuxcnc");
        let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
        let put = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let ini = put("five-axis.ini", &text("five-axis.ini").replace("PORT\n", &format!("{PORT}\n")));
        put("five-axis.hal", &text("five-axis.hal"));
        put("five-axis.tbl", "T1 P1 Z0 D0\n");
        put("five-axis.var", "");
        let program = put("trunnion-cycle.ngc", program);
        let is_root = Command::new("id").arg("-u").output().unwrap().stdout == b"0\n";
        let mut command = if is_root {
            let owned = Command::new("chown").args(["-R", "nobody"]).arg(folder.path()).status().unwrap();
            assert!(owned.success());
            let mut command = Command::new("setpriv");
            command.args(["--reuid=nobody", "--regid=nogroup", "--clear-groups", "linuxcnc"]);
            command
        } else {
            Command::new("linuxcnc")
        };
        let log = std::fs::File::create(folder.path().join("linuxcnc.log")).unwrap();
        let process = command
            .arg(ini)
            .env("HOME", folder.path())
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .spawn()
            .expect("linuxcnc-uspace is installed by tests/peers/run");
        Self { process, _folder: folder, program }
    }
}

impl Drop for LinuxCnc {
    fn drop(&mut self) {
        if let Ok(mut operator) = Conversation::open() {
            operator.say("set enable EMCTOO");
            operator.say("shutdown");
        } else {
            println!("LinuxCNC is gone already");
        }
        self.process.wait().unwrap();
    }
}

/// Lines to and from linuxcncrsh.
struct Conversation {
    stream: TcpStream,
    bytes: Vec<u8>,
}

impl Conversation {
    fn open() -> std::io::Result<Self> {
        let stream = TcpStream::connect(("127.0.0.1", PORT))?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(LIMIT))?;
        let mut conversation = Self { stream, bytes: Vec::new() };
        conversation.answer("hello EMC test 1.1", "HELLO");
        conversation.say("set echo off");
        conversation.answer("get echo", "ECHO");
        Ok(conversation)
    }

    /// Says something that has no answer of its own.
    fn say(&mut self, line: &str) {
        self.stream.write_all(format!("{line}\r\n").as_bytes()).unwrap();
    }

    /// What follows the word in the answer. linuxcncrsh mixes up requests of connections that speak at the same moment:
    /// what it refuses is asked again.
    fn answer(&mut self, line: &str, word: &str) -> String {
        self.say(line);
        let mut refused = 0;
        loop {
            if let Some(end) = self.bytes.iter().position(|byte| *byte == b'\n') {
                let text = String::from_utf8(self.bytes.drain(..=end).collect()).unwrap();
                let reported = text.trim().split_once(' ').filter(|(first, _)| *first == word);
                match reported.filter(|_| !text.contains("NAK")) {
                    Some((_, rest)) => return rest.trim().to_owned(),
                    None if text.trim().is_empty()
                        || text.starts_with("set ")
                        || text.starts_with("get ") => {}
                    None => {
                        refused += 1;
                        assert!(refused < 20, "{line}: {text}");
                        self.say(line);
                    }
                }
                continue;
            }
            let mut bytes = [0; 1024];
            let count = self.stream.read(&mut bytes).unwrap();
            assert!(count > 0, "LinuxCNC closed the connection");
            self.bytes.extend_from_slice(&bytes[..count]);
        }
    }

    /// Repeats an order until it is done.
    fn until(&mut self, order: &str, ask: &str, word: &str, wanted: &str) {
        let begun = Instant::now();
        while self.answer(ask, word) != wanted {
            assert!(begun.elapsed() < LIMIT, "{order}: not {wanted}");
            self.say(order);
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn axes(&mut self) -> AxisValues<f64> {
        let reported = self.answer("get joint_pos", "JOINT_POS");
        let numbers: Vec<f64> = reported.split(' ').map(|number| number.parse().unwrap()).collect();
        let mut axes = AxisValues::default();
        for (letter, number) in JOINTS.into_iter().zip(numbers) {
            axes[letter] = if letter.is_rotary() { convert::rad_from_deg(number) } else { number };
        }
        axes
    }
}

/// Waits until linuxcncrsh listens.
fn reach() -> Conversation {
    let begun = Instant::now();
    loop {
        match Conversation::open() {
            Ok(conversation) => return conversation,
            Err(error) => assert!(begun.elapsed() < LIMIT, "LinuxCNC does not start: {error}"),
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// The simulated machine at LinuxCNC's positions.
struct Followed {
    machine: VirtualMachine,
    /// Time of the cell and position, the newest last.
    history: Mutex<VecDeque<(f64, AxisValues<f64>)>>,
}

impl Followed {
    /// Asks LinuxCNC on a connection of its own until asked to stop.
    fn follow(self: Arc<Self>, origin: TimeOrigin, stop: Arc<AtomicBool>) -> std::thread::JoinHandle<()> {
        std::thread::spawn(move || {
            let mut conversation = reach();
            while !stop.load(Ordering::Relaxed) {
                let axes = conversation.axes();
                let mut history = self.history.lock().unwrap();
                history.push_back((origin.now_s(), axes));
                if history.len() > 4096 {
                    history.pop_front();
                }
                drop(history);
                std::thread::sleep(Duration::from_millis(2));
            }
        })
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
    operator.say("set enable EMCTOO");
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

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn location_errors_are_found_in_a_cycle_that_linuxcnc_moves() {
    show_log();
    let cycle_text = include_str!("../../../config/cycles/demo-static.toml")
        .replace("step_deg = 30", "step_deg = 90")
        .replace("to_deg = 330", "to_deg = 270");
    let cycle = Cycle::parse("c.toml", &cycle_text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let rules = CourseRules {
        dwell_s: Some(0.5),
        transfer_mm_per_s: 100.0,
        transfer_rad_per_s: convert::rad_from_deg(180.0),
        ..CourseRules::default()
    };
    let program = Program::of_cycle(&cycle, &machine, &rules).unwrap();
    let linuxcnc = dialect("linuxcnc").unwrap();
    let cnc = LinuxCnc::start(&(linuxcnc.write)(&program, linuxcnc.decimals));

    let setups: Vec<SimSetup> = cycle
        .setups
        .iter()
        .map(|s| SimSetup::new(s.name.clone(), NestOn::Table, s.ball_in_table_mm, Instrument::R_TEST))
        .collect();
    let truth = Truth::draw(&machine, &setups, &[], 600.0, 11).unwrap();
    let hidden: BTreeMap<String, f64> =
        minimum_set(&machine).iter().map(|error| (error.name(), error.of(&truth.location))).collect();
    let world = Arc::new(Followed {
        machine: VirtualMachine::new(machine.clone(), truth).unwrap(),
        history: Mutex::default(),
    });

    let folder = tempfile::tempdir().unwrap();
    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    let mut floor = CellConfig::new(folder.path(), clock.wall_ns());
    (floor.can, floor.controller) = (None, None);
    let origin = tokio::time::Instant::now();
    let stop = Arc::new(AtomicBool::new(false));
    let follower = world.clone().follow(TimeOrigin(origin), stop.clone());
    let cell = cell::start(world, floor, origin).await.unwrap();
    let start = "[cycle_start]\nby = \"program\"\nprogram = \"*/trunnion-cycle.ngc\"\n";
    let cnc_table = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"linuxcnc\"\nhost = \"127.0.0.1\"\nport = {PORT}\njoints = \"XYZBC\"\n"
    );
    let text = three_probes(folder.path(), SILENCE_MS, start, &cnc_table);
    let config = Config::parse(&folder.path().join("trunnion.toml"), &text).unwrap();
    let plan =
        Plan { machine: machine.clone(), cycle, nest: config.nest, channels: channels(&config.devices) };
    let poses = plan.cycle.poses(&machine).unwrap().len();
    let texts = Texts { machine: shipped::FILES[0].1.into(), cycle: cycle_text, config: text };
    let cycles = Cycles::one(plan, texts, Model::base("table-bc").into()).expect("it can be measured");
    let runs = config.recordings.clone();
    let cancel = CancellationToken::new();
    let service = tokio::spawn(serve(config, cycles, clock, cancel.clone()));

    let path = cnc.program.clone();
    tokio::task::spawn_blocking(move || operate(&path)).await.unwrap();
    let report = first_report(&runs, Duration::from_secs(120))
        .await
        .expect("a report within two minutes")
        .with_extension("identification.json");
    cancel.cancel();
    service.await.unwrap().unwrap();
    cell.shutdown().await;
    stop.store(true, Ordering::Relaxed);
    follower.join().unwrap();
    drop(cnc);

    let reported: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&report).unwrap()).unwrap();
    assert_eq!(reported["points"].as_u64(), Some(poses as u64), "every pose is read");
    println!("{poses} poses, rms {} µm", reported["rms_um"]);
    let mut found = 0;
    for parameter in reported["parameters"].as_array().unwrap() {
        let name = parameter["name"].as_str().unwrap();
        let (Some(hidden), Some(value), Some(u)) =
            (hidden.get(name), parameter["value"].as_f64(), parameter["u"].as_f64())
        else {
            continue;
        };
        let hidden = hidden * 1e3 * if name.as_bytes()[1] <= b'C' { 1e3 } else { 1.0 };
        println!("{name}: {value:.2} ± {u:.2}, hidden {hidden:.2}");
        // µm and µrad.
        assert!((value - hidden).abs() <= 4.0 * u + 0.3, "{name}: {value} ± {u} is not {hidden}");
        found += 1;
    }
    assert!(found >= 8, "{found} location errors: {}", reported["parameters"]);
}
