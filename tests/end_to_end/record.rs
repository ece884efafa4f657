//! `trunnion record`: a cycle that the controller resets half-way is kept, counted, and not judged.

use super::three_probes::{SILENCE_MS, devices, head, nest};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trunnion_cycles::Cycle;
use trunnion_hil_sim::devices::cell;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::mtconnect::Shown;
use trunnion_hil_sim::scenario::{Pace, Station, static_cycle};
use trunnion_hil_sim::{SimSetup, Truth, VirtualMachine};
use trunnion_machine::shipped;

const CYCLE: &str = include_str!("../../config/cycles/demo-static.toml");

fn config(folder: &Path, url: &str) -> String {
    let text = head("runs").replace("c.toml", "other.toml") + &nest() + &devices(folder, SILENCE_MS);
    text + &format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cycle_that_is_reset_is_kept_counted_and_not_judged() {
    let text = CYCLE.replace("step_deg = 30", "step_deg = 90");
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let poses = cycle.poses(&machine).unwrap();
    let stations: Vec<Station> =
        poses.iter().map(|pose| Station { setup: pose.setup, position: pose.position }).collect();
    let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
    let truth = Truth::draw(&machine, &setups, &[], 60.0, 3).unwrap();
    let world = VirtualMachine::new(machine, truth).unwrap();
    // Slow enough that a busy computer reads some poses before the reset.
    let pace = Pace { move_s: 0.3, dwell_s: 0.4 };
    let world = static_cycle(Arc::new(world), "c", &stations, pace).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let mut floor = CellConfig { can: None, ..CellConfig::new(folder.path(), 0) };
    let (agent, _) = floor.controller.as_mut().unwrap();
    agent.filters_duplicates = false;
    agent.shown = vec![Shown { from_s: 8.0, to_s: 1e6, execution: "READY" }];
    let origin = tokio::time::Instant::now() + Duration::from_millis(200);
    let cell = cell::start(Arc::new(world), floor, origin).await.unwrap();
    let url = cell.controller.as_ref().and_then(|agent| agent.url()).unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("trunnion.toml"), config(folder.path(), url) + WITH_SECRETS).unwrap();
    std::fs::write(file("c.toml"), &text).unwrap();
    let (cycle_file, config_file) = (file("c.toml"), file("trunnion.toml"));
    let recorded = tokio::task::spawn_blocking(move || {
        let mut command = crate::program::command();
        command.arg("record").arg(cycle_file).arg("--config").arg(config_file).env("COLUMNS", "1000");
        command.output().unwrap()
    });
    let output = recorded.await.unwrap();
    cell.shutdown().await;
    let shown = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(3), "{shown}{}", String::from_utf8_lossy(&output.stderr));
    let planned = format!("of {} planned points were read", stations.len());
    for words in ["Not judged: a part of the cycle is missing", &planned, "Repeat the cycle", ".html"] {
        assert!(shown.contains(words), "{words:?} is not in:\n{shown}");
    }
    let read: usize = shown
        .split(&format!(" {planned}"))
        .next()
        .unwrap()
        .rsplit(' ')
        .next()
        .unwrap()
        .trim()
        .parse()
        .unwrap();
    assert!((1..stations.len() / 2).contains(&read), "{shown}");

    let said = shown + &String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains(SECRET), "{said}");
    let written: Vec<_> = walk(&folder.path().join("runs"));
    for path in &written {
        let bytes = std::fs::read(path).unwrap();
        assert!(!bytes.windows(SECRET.len()).any(|bytes| bytes == SECRET.as_bytes()), "{}", path.display());
    }
    let run = written.iter().find(|path| path.extension().is_some_and(|ending| ending == "mcap")).unwrap();
    let config = trunnion_record::read_header(run).unwrap().config_text;
    assert!(config.contains("user = \"cell\"") && !config.contains(SECRET), "{config}");
    exports(run, stations.len(), read);
    forms_again(run, read);
    goes_through_again(run);
}

const SECRET: &str = "hunter2";
const WITH_SECRETS: &str = "# hunter2 is the password of the cell
[mqtt]
host = \"127.0.0.1\"
port = 9
user = \"cell\"
password = \"hunter2\"
";

fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}

fn trunnion(args: &[&str]) -> (Option<i32>, String, String) {
    let mut command = crate::program::command();
    let output = command.args(args).env("COLUMNS", "1000").output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Every part of the recording is a table.
fn exports(run: &Path, planned: usize, read: usize) {
    let part = |what: &str| {
        let (code, table, said) = trunnion(&["export", "csv", run.to_str().unwrap(), "--what", what]);
        assert!(matches!(code, Some(0 | 3)), "{what}: {said}");
        table
    };
    let rows = |table: &str| table.lines().count() - 1;
    let every = part("every-point");
    assert_eq!(rows(&every), planned);
    assert_eq!(every.lines().filter(|line| line.ends_with(",good,")).count(), read, "{every}");
    assert!(every.lines().next().unwrap().ends_with(",quality,why") && every.contains(",no-reading,"));
    assert!(!every.contains("NaN"));
    assert_eq!(rows(&part("points")), read);
    let samples = part("samples");
    assert!(samples.starts_with("time_s,probe,device_ticks,raw,value_um\n") && samples.contains(",probe-3,"));
    assert!(rows(&samples) > 1000, "{} samples in seconds at 1 kHz", rows(&samples));
    let axes = part("axes");
    assert!(axes.starts_with("time_s,x_mm,y_mm,z_mm,b_deg,c_deg\n") && rows(&axes) > 100);
    let residuals = part("residuals");
    assert!(residuals.starts_with("setup,time_s,x_mm,y_mm,z_mm,b_deg,c_deg,measured_1_um"), "{residuals}");
    assert_eq!(rows(&residuals), read);
    for line in residuals.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(7).map(|cell| cell.parse().unwrap()).collect();
        for k in 0..3 {
            assert!((cells[k] - cells[3 + k] - cells[6 + k]).abs() < 2e-4, "{line}");
        }
    }
}

/// The cycle in its own time, and then what a replay says without it.
fn goes_through_again(run: &Path) {
    let replay = |speed: &[&str]| {
        let begun = Instant::now();
        let (_, answer, said) = trunnion(&[&["replay", run.to_str().unwrap()], speed].concat());
        (answer, said, begun.elapsed().as_secs_f64())
    };
    let (at_once, nothing, _) = replay(&[]);
    let (shown, said, took_s) = replay(&["--speed", "4"]);
    assert_eq!(shown, at_once);
    assert!(!nothing.contains(" s: ") && said.contains(" s: "), "{nothing}\n{said}");
    let (_, axes, _) = trunnion(&["export", "csv", run.to_str().unwrap(), "--what", "axes"]);
    let last_s: f64 = axes.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(last_s > 2.0 && took_s > 0.9 * last_s / 4.0, "{took_s} s for {last_s} s: {said}");
    let (code, _, said) = trunnion(&["replay", run.to_str().unwrap(), "--speed", "0"]);
    assert!(code == Some(2) && said.contains("0.01..=1000000"), "{said}");
}

/// The points of the samples under other settings.
fn forms_again(run: &Path, read: usize) {
    let replay = |form: &str| trunnion(&["replay", run.to_str().unwrap(), "--form", form]);
    let (_, identification, said) = replay("settle.window_s=0.05");
    let again = identification.split("\"complete\"").nth(1).unwrap_or_else(|| panic!("{said}"));
    let again = again.split("\"read\": ").nth(1).unwrap().split(',').next().unwrap();
    let again: usize = again.parse().unwrap();
    assert!(again + 2 >= read, "a shorter window settles as often: {again} of {read}");
    let (code, _, said) = replay("settle.noise_um=0.01");
    assert_eq!(code, Some(1), "nothing is as quiet as that: {said}");
    let (code, _, said) = replay("settle.windw_s=0.05");
    assert!(code == Some(1) && said.contains("windw_s"), "{said}");
    let (code, _, said) = replay("settle");
    assert!(code == Some(1) && said.contains("KEY=VALUE"), "{said}");
}
