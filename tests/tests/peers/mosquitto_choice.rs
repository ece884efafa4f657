//! The operator at a real broker: a refused program on its topic, and the topic that chooses a cycle.

use crate::mosquitto::{as_schemas_say, broker, wait_for};
use rumqttc::{AsyncClient, Event, MqttOptions, Packet, QoS};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::config::channels;
use trunnion_core::Clock;
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::{Later, SimulatedCell, World, cell};
use trunnion_hil_sim::motion::{Program, Step, Trajectory};
use trunnion_hil_sim::{SimSetup, Truth, VirtualMachine, scenario};
use trunnion_machine::shipped;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::{Choice, Cycles};
use trunnion_service::daemon::{Texts, serve};
use trunnion_service::live::Plan;
use trunnion_tests::in_turn::InTurn;
use trunnion_tests::page_status::free_port;
use trunnion_tests::{SILENCE_MS, three_probes};

/// Steps of a program that nobody chose, long enough to be seen to run.
const UNKNOWN_S: f64 = 2.0;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn a_program_without_a_cycle_is_refused_on_its_topic_until_the_topic_chooses_one() {
    let port = free_port();
    let _broker = broker(port);
    let folder = tempfile::tempdir().expect("a folder");
    let sweep_text =
        include_str!("../../../config/cycles/demo-sweep-c.toml").replace("[5400, 7200]", "[7200]");
    let cycle = Cycle::parse("c.toml", &sweep_text).expect("it is good");
    let machine = shipped::machine("table-bc").expect("it is shipped");
    let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
    let truth = Truth::draw(&machine, &setups, &[], 30.0, 5).expect("it can be drawn");
    let virtual_machine = Arc::new(VirtualMachine::new(machine.clone(), truth).expect("it is possible"));
    let Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } = &cycle.motion else {
        panic!("the cycle is on the fly")
    };
    let sweep = scenario::sweep_cycle(virtual_machine, "O77", *axis, *from_to_rad, feeds_rad_per_s, others);
    let sweep = sweep.expect("it can be run");
    // Where the sweep begins, for the axes do not jump.
    let standing = {
        let steps = vec![Step::Dwell { duration_s: UNKNOWN_S }];
        let program = Program { start: sweep.axes(0.0), steps };
        let trajectory = Trajectory::compile(&program).expect("it stands");
        SimulatedCell { program: "O77".into(), noise_mm: 0.2e-3, ..SimulatedCell::along(trajectory) }
    };
    let worlds = vec![standing, sweep];
    let world = Later { world: InTurn { worlds, pause_s: 4.0 }, by_s: 4.0 };
    let clock = Arc::new(SystemClock::start());
    let mut floor = CellConfig { can: None, ..CellConfig::new(folder.path(), clock.wall_ns()) };
    floor.controller.as_mut().expect("it has one").0.filters_duplicates = false;
    let cell = cell::start(Arc::new(world), floor, tokio::time::Instant::now()).await.expect("it starts");
    let url = cell.controller.as_ref().and_then(|agent| agent.url()).expect("an agent").to_string();
    let agent = format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n");
    let tables = format!(
        "[[program]]\nname = \"SWEEP*\"\ncycle = \"w.toml\"\n[mqtt]\nhost = \"127.0.0.1\"\nport = {port}\n"
    );
    let text = three_probes(folder.path(), SILENCE_MS, &tables, &agent).replace("cycle = \"c.toml\"\n", "");
    let config = Config::parse(&folder.path().join("trunnion.toml"), &text).expect("it is good");
    let plan = Plan { machine, cycle, nest: config.nest, channels: channels(&config.devices) };
    let texts = Texts { machine: shipped::FILES[0].1.into(), cycle: sweep_text, config: text };
    let model = trunnion::Model::base("table-bc");
    let begun_by = config.programs[0].begun_by.clone();
    let choice = Choice { begun_by, plan, texts, model, model_file: None };
    let cycles = Cycles::new(vec![choice]).expect("the devices can measure it");
    let cancel = CancellationToken::new();
    let service = tokio::spawn(serve(config, cycles, clock, cancel.clone()));

    let is = |topics: &BTreeMap<String, serde_json::Value>, state: &str, why: &str| {
        topics.get("trunnion/m/cycle").is_some_and(|cycle| {
            cycle["state"] == state
                && (why.is_empty() || cycle["why"].as_str().is_some_and(|w| w.contains(why)))
        })
    };
    wait_for(port, "refused", |t| {
        is(t, "refused", "no [[program]] of the configuration is named like \"O77\"")
    })
    .await;
    say(port, "trunnion/m/choose", "demo-sweep").await;
    wait_for(port, "mistyped", |t| {
        let refused =
            |status: &serde_json::Value| status["choice_refused"]["why"].as_str().map(str::to_owned);
        let why = t.get("trunnion/m/status").and_then(refused).unwrap_or_default();
        why.contains("did you mean demo-sweep-c?") && t["trunnion/m/status"]["chosen"].is_null()
    })
    .await;
    say(port, "trunnion/m/choose", "demo-sweep-c").await;
    wait_for(port, "measuring", |t| {
        is(t, "measuring", "") && t["trunnion/m/cycle"]["cycle"] == "demo-sweep-c"
    })
    .await;
    wait_for(port, "done", |t| {
        as_schemas_say(t);
        is(t, "done", "") && t.contains_key("trunnion/m/result")
    })
    .await;
    cancel.cancel();
    service.await.expect("no panic").expect("no failure");
    cell.shutdown().await;
}

/// Publishes as an operator's panel does; returns when the broker has it.
async fn say(port: u16, topic: &str, payload: &str) {
    let (client, mut events) = AsyncClient::new(MqttOptions::new("panel", "127.0.0.1", port), 4);
    client.publish(topic, QoS::AtLeastOnce, false, payload).await.expect("queued");
    let taken = async {
        while !matches!(events.poll().await.expect("the broker is there"), Event::Incoming(Packet::PubAck(_)))
        {
        }
    };
    tokio::time::timeout(Duration::from_secs(30), taken).await.expect("the broker takes it");
}
