//! The service end to end: virtual devices on real ports, a probe unplugged in the middle of the cycle.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::config::channels;
use trunnion_daemon::clock::SystemClock;
use trunnion_daemon::config::Config;
use trunnion_daemon::live::Plan;
use trunnion_daemon::service::{Texts, serve};
use trunnion_effects::Model;
use trunnion_hil_sim::devices::cell::{self, CellConfig};
use trunnion_hil_sim::devices::{Fault, ScheduledFault, orthogonal_nest};
use trunnion_hil_sim::scenario::{self, Pace, Station};
use trunnion_hil_sim::{Instrument, NestOn, SimSetup, Truth, VirtualMachine};
use trunnion_machine::shipped;
use trunnion_measurement::{Cycle, Quality};
use trunnion_units::Clock;

const CYCLE: &str = include_str!("../../config/cycles/demo-static.toml");

fn config_text(ports: &Path, agent: &str) -> String {
    let mut text = String::from(
        "format = \"trunnion-config/1\"\nname = \"m\"\ncycle = \"c.toml\"\nrecordings = \"runs\"\n[nest]\n",
    );
    for (k, direction) in orthogonal_nest().iter().enumerate() {
        text += &format!("probe_{} = {direction:?}\n", k + 1);
    }
    for k in 1..=3 {
        text += &format!(
            "[[device]]\nname = \"probe-{k}\"\ndriver = \"optoncdt\"\nport = '{}/probe-{k}'\nrole = \"probe-{k}\"\nrange_mm = 2\n",
            ports.display()
        );
    }
    text + &format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{agent}\"\n")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_probe_unplugged_for_three_seconds_leaves_a_gap_and_the_cycle_goes_on_to_its_report() {
    let folder = tempfile::tempdir().unwrap();
    let cycle_text = CYCLE.replace("step_deg = 30", "step_deg = 60");
    let cycle = Cycle::parse("c.toml", &cycle_text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let stations: Vec<Station> = cycle
        .poses(&machine)
        .unwrap()
        .iter()
        .map(|pose| Station { setup: pose.setup, position: pose.position })
        .collect();
    let setups: Vec<SimSetup> = cycle
        .setups
        .iter()
        .map(|setup| {
            SimSetup::new(setup.name.clone(), NestOn::Table, setup.ball_in_table_mm, Instrument::RTest)
        })
        .collect();
    let pace = Pace { move_s: 0.06, dwell_s: 0.1 };
    let truth = Truth::draw(&machine, &setups, &[], scenario::duration_s(stations.len(), pace), 3).unwrap();
    let virtual_machine = Arc::new(VirtualMachine::new(machine.clone(), truth).unwrap());
    let world = scenario::static_cycle(virtual_machine, "c", &stations, pace).unwrap();

    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    let mut floor = CellConfig::new(folder.path(), clock.wall_ns());
    floor.can = None;
    floor.probes[1].1.push(ScheduledFault { at_s: 4.0, fault: Fault::Unplug { duration_s: 3.0 } });
    if let Some((agent, _)) = &mut floor.controller {
        agent.filters_duplicates = false;
    }
    let begin = tokio::time::Instant::now() + Duration::from_secs(3);
    let cell = cell::start(Arc::new(world), floor, begin).await.unwrap();
    let url = cell.controller.as_ref().unwrap().url().unwrap().to_string();
    let text = config_text(folder.path(), &url);
    let config = Config::parse(&folder.path().join("trunnion.toml"), &text).unwrap();
    let plan =
        Plan { machine: machine.clone(), cycle, nest: config.nest, channels: channels(&config.devices) };
    let texts = Texts { machine: shipped::FILES[0].1.into(), cycle: cycle_text, config: text };
    let runs = config.recordings.clone();
    let cancel = CancellationToken::new();
    let service = tokio::spawn(serve(config, plan, texts, Model::base("table-bc"), clock, cancel.clone()));

    let report = async {
        loop {
            let done = std::fs::read_dir(&runs).ok().and_then(|mut files| {
                files.find_map(|f| {
                    Some(f.ok()?.path()).filter(|p| p.to_string_lossy().ends_with("diagnosis.json"))
                })
            });
            if let Some(done) = done {
                return done;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    let report = tokio::time::timeout(Duration::from_secs(180), report).await.expect("the cycle is reported");
    cancel.cancel();
    service.await.unwrap().unwrap();
    cell.shutdown().await;

    let path = report.to_string_lossy().replace("diagnosis.json", "mcap");
    let recording = trunnion_record::read_run(Path::new(&path), &|_| Some(machine.clone())).unwrap();
    let gap =
        recording.gaps.iter().find(|gap| gap.source.contains("probe-2") && gap.to_s > 3.0).expect("a gap");
    assert!(gap.to_s - gap.from_s > 2.5 && gap.to_s - gap.from_s < 8.0, "{gap:?}");
    assert_eq!(recording.run.points.len(), stations.len(), "every pose is accounted for");
    let good = recording.run.points.iter().filter(|point| point.quality == Quality::Good).count();
    assert!(good > stations.len() / 2 && good < stations.len(), "{good} of {}", stations.len());
    assert!(Path::new(&path.replace(".mcap", ".html")).exists());
}
