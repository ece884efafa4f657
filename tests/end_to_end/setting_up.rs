//! Setting up at the machine: `trunnion watch`, `trunnion calibrate-nest` and the sign test, against virtual devices on real ports.

use super::three_probes::{SILENCE_MS, devices, head};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Output, Stdio};
use std::sync::Arc;
use std::time::Duration;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_hil_sim::devices::cell::{Cell, CellConfig};
use trunnion_hil_sim::devices::{Fault, SimulatedCell, World, cell};
use trunnion_hil_sim::motion::{Program, Step, Trajectory};
use trunnion_service::config::Config;

/// Directions of the virtual probes, not perpendicular, and where the ball is at the beginning, nest axes.
const DIRECTIONS: [[f64; 3]; 3] =
    [[0.80, 0.10, 0.591_608], [-0.40, 0.72, 0.567_098], [-0.45, -0.66, 0.601_581]];
const BALL_MM: [f64; 3] = [0.42, 0.0, -0.10];
/// Steps of each axis there and back, with time enough to settle on a busy computer.
const STEP_MM: f64 = 0.1;
const MOVE_S: f64 = 0.1;
const DWELL_S: f64 = 1.0;

/// The ball moves with X, Y and Z, as with a nest on the table and the rotary axes at zero.
fn stepping() -> SimulatedCell {
    let start = AxisValues::default();
    let mut steps = vec![Step::Dwell { duration_s: 2.0 }];
    for _ in 0..20 {
        for axis in [Joint::X, Joint::Y, Joint::Z] {
            let mut there = start;
            there[axis] = STEP_MM;
            for target in [there, start] {
                steps.push(Step::Move { target, duration_s: MOVE_S });
                steps.push(Step::Dwell { duration_s: DWELL_S });
            }
        }
    }
    let along = SimulatedCell::along(Trajectory::compile(&Program { start, steps }).unwrap());
    let ball = |state: &State| {
        let moved = [Joint::X, Joint::Y, Joint::Z].map(|axis| state.position[axis]);
        [0, 1, 2].map(|k| BALL_MM[k] + moved[k])
    };
    SimulatedCell { deflection_mm: Box::new(ball), probe_directions: DIRECTIONS, noise_mm: 0.2e-3, ..along }
}

/// The machine stands.
fn standing() -> SimulatedCell {
    let steps = vec![Step::Dwell { duration_s: 600.0 }];
    let program = Program { start: AxisValues::default(), steps };
    SimulatedCell {
        probe_directions: DIRECTIONS,
        ..SimulatedCell::along(Trajectory::compile(&program).unwrap())
    }
}

async fn floor(folder: &Path, world: impl World + 'static) -> (Cell, String) {
    let mut floor = CellConfig { can: None, ..CellConfig::new(folder, 0) };
    let (agent, _) = floor.controller.as_mut().unwrap();
    agent.filters_duplicates = false;
    let cell = cell::start(Arc::new(world), floor, tokio::time::Instant::now()).await.unwrap();
    let url = cell.controller.as_ref().and_then(|agent| agent.url()).unwrap().to_owned();
    (cell, url)
}

/// A configuration in the folder with these directions of the probes, if any; its path.
fn configure(folder: &Path, url: &str, nest: Option<[[f64; 3]; 3]>) -> String {
    let mut text = head("runs");
    for (k, direction) in nest.into_iter().flatten().enumerate() {
        text += if k == 0 { "[nest]\n" } else { "" };
        text += &format!("probe_{} = {direction:?}\n", k + 1);
    }
    text += &devices(folder, SILENCE_MS);
    text += &format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n");
    text += &format!(
        "[[device]]\nname = \"room\"\ndriver = \"ascii\"\npreset = \"sylvac\"\nport = '{}/gone'\nrole = \"temperature\"\nunit = \"degC\"\n",
        folder.display()
    );
    std::fs::write(folder.join("c.toml"), include_str!("../../config/cycles/demo-static.toml")).unwrap();
    let path = folder.join("trunnion.toml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

async fn trunnion(args: &[&str]) -> Output {
    let mut command = crate::program::command();
    command.args(args).env("COLUMNS", "1000");
    tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn watch_shows_probes_ball_axes_and_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let still = SimulatedCell { deflection_mm: Box::new(|_| BALL_MM), ..standing() };
    let (cell, url) = floor(folder.path(), still).await;
    let config = configure(folder.path(), &url, Some(DIRECTIONS));
    let output = trunnion(&["watch", "--config", &config, "--seconds", "8.5", "--json"]).await;
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines: Vec<Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!((3..=9).contains(&lines.len()), "{} lines", lines.len());
    let live = lines.last().unwrap();
    assert_eq!((&live["format"], &live["cycle"]), (&"trunnion-live/1".into(), &Value::Null));
    for (k, direction) in DIRECTIONS.iter().enumerate() {
        let expected_mm = 1.0 + (0..3).map(|i| direction[i] * BALL_MM[i]).sum::<f64>();
        let probe = &live["probes"][k];
        assert!((probe["value_mm"].as_f64().unwrap() - expected_mm).abs() < 0.002, "{live:#}");
        assert_eq!((&probe["range_mm"][1], &probe["zone"]), (&2.0.into(), &"centre".into()), "{live:#}");
    }
    for (axis, expected_mm) in ["x", "y", "z"].into_iter().zip(BALL_MM) {
        let found_mm = live["ball_offset_mm"][axis].as_f64().unwrap();
        assert!((found_mm - expected_mm).abs() < 0.005, "{live:#}");
    }
    let say = live["say"].as_str().unwrap();
    assert!(say.contains("Ball 0.42 mm too far in +X, 0.10 mm too far in −Z."), "{say}");
    assert!(say.contains("room: ") && say.contains("is not there"), "{say}");
    assert_eq!(live["devices"][3]["state"], "Streaming", "{live:#}");
    assert!(live["axes"].as_array().unwrap().iter().any(|axis| axis["name"] == "C" && axis["unit"] == "deg"));
    cell.shutdown().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_nest_is_calibrated_live_and_a_turned_probe_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (cell, url) = floor(folder.path(), stepping()).await;
    let config = configure(folder.path(), &url, None);
    let output = trunnion(&["watch", "--config", &config, "--seconds", "3.5"]).await;
    assert!(text(&output.stdout).contains("calibrate-nest"), "{}", text(&output.stdout));
    let output =
        trunnion(&["calibrate-nest", "--config", &config, "--seconds", "20", "--write", "--json"]).await;
    assert!(output.status.success(), "{}", text(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (k, direction) in DIRECTIONS.iter().enumerate() {
        let probe = &found["probes"][k];
        let u = 1e-3 * probe["u_direction_mrad"].as_f64().unwrap();
        assert!(u < 3e-3, "{found:#}");
        let length = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
        for i in 0..3 {
            let off = probe["direction"][i].as_f64().unwrap() - direction[i] / length;
            assert!(off.abs() < 4.0 * u + 1e-6, "{found:#}");
        }
        assert!(
            (probe["gain"].as_f64().unwrap() - length).abs() < 4.0 * probe["u_gain"].as_f64().unwrap() + 1e-6
        );
    }
    let written = std::fs::read_to_string(&config).unwrap();
    assert!(Config::parse(Path::new(&config), &written).is_ok(), "{written}");

    let signs = async |nest: [[f64; 3]; 3]| {
        let config = configure(folder.path(), &url, Some(nest));
        trunnion(&["watch", "--config", &config, "--sign-test", "--seconds", "25"]).await
    };
    let output = signs(DIRECTIONS).await;
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
    assert!(text(&output.stdout).contains("The probes follow as the nest says."));
    let turned = DIRECTIONS[1].map(|part: f64| -part);
    let output = signs([DIRECTIONS[0], turned, DIRECTIONS[2]]).await;
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).contains("probe-2 is turned"), "{}", text(&output.stdout));
    cell.shutdown().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_probe_out_of_place_and_one_that_is_away_are_said_before_the_cycle_begins() {
    let folder = tempfile::tempdir().unwrap();
    // The ball presses the first probe to the end of its range; the third is unplugged.
    let pressed = DIRECTIONS[0].map(|part| 0.97 * part);
    let still = SimulatedCell { deflection_mm: Box::new(move |_| pressed), ..standing() };
    let (cell, url) = floor(folder.path(), still).await;
    cell.probes[2].inject(Fault::Unplug { duration_s: 600.0 }).unwrap();
    let config = configure(folder.path(), &url, Some(DIRECTIONS));
    let text = std::fs::read_to_string(&config).unwrap();
    std::fs::write(&config, text.replace("[nest]", "[cycle_start]\nby = \"motion\"\n[nest]")).unwrap();
    let mut command = crate::program::command();
    command.args(["record", folder.path().join("c.toml").to_str().unwrap(), "--config", &config]);
    let mut child = command.env("COLUMNS", "1000").stderr(Stdio::piped()).spawn().unwrap();
    let stderr = child.stderr.take().unwrap();
    let (send, mut said) = tokio::sync::mpsc::unbounded_channel();
    std::thread::spawn(move || {
        BufReader::new(stderr).lines().map_while(Result::ok).all(|line| send.send(line).is_ok())
    });
    let mut lines = Vec::new();
    let expected = [
        "not ready: probe-1: +0.97 mm from its centre, near the end",
        "not ready: probe-3: ",
        "not ready: room: ",
    ];
    let all_said = async {
        while !expected.iter().all(|words| lines.iter().any(|line: &String| line.contains(words))) {
            lines.push(said.recv().await.expect("the command waits for its cycle"));
        }
    };
    let waited = tokio::time::timeout(Duration::from_secs(60), all_said).await;
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(waited.is_ok(), "{lines:#?}");
    cell.shutdown().await;
}

#[tokio::test]
async fn the_nest_is_calibrated_from_recorded_points_and_poor_steps_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let setup = "format = \"trunnion-points/1\"\nmachine = \"table-bc\"\n[[setup]]\nname = \"s\"\ninstrument = \"r-test\"\n\
                 ball_in_table_mm = [150.0, 0.0, 60.0]\n";
    std::fs::write(at("setup.toml"), setup).unwrap();
    let calibrated = async |axes: &[usize]| {
        let mut points =
            "setup,time_s,x_mm,y_mm,z_mm,b_deg,c_deg,direction_b,direction_c,dx_um,dy_um,dz_um\n".to_owned();
        let steps = axes.iter().flat_map(|&axis| [-0.2, -0.1, 0.0, 0.1, 0.2].map(|step| (axis, step)));
        for (row, (axis, step)) in steps.enumerate() {
            let mut moved = [0.0; 3];
            moved[axis] = step;
            let read = DIRECTIONS.map(|d| 1e3 * (0..3).map(|i| d[i] * moved[i]).sum::<f64>());
            points += &format!(
                "s,{row},{},{},{},0,0,1,1,{},{},{}\n",
                150.0 + moved[0],
                moved[1],
                60.0 + moved[2],
                read[0],
                read[1],
                read[2]
            );
        }
        std::fs::write(at("points.csv"), points).unwrap();
        let run = at(&format!("run-{}.mcap", axes.len()));
        let imported = trunnion(&["import", &at("points.csv"), "-o", &run]).await;
        assert!(imported.status.success(), "{}", text(&imported.stderr));
        trunnion(&["calibrate-nest", &run, "--gains"]).await
    };
    let output = calibrated(&[0, 1, 2]).await;
    let shown = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(shown.contains("[nest]\nprobe_1 = [0.8000000, 0.1000000, 0.5916080]"), "{shown}");
    let output = calibrated(&[0, 1]).await;
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("do not span all three directions"), "{}", text(&output.stderr));
}
