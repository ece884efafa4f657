//! A real broker: retained status, last will, and the latest values again after the broker was killed.

use rumqttc::{AsyncClient, Event, MqttOptions, Packet, QoS};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use tracing::level_filters::LevelFilter;
use trunnion::results::{Condition, OF_THE_PRESENT, ServiceStatus};
use trunnion_acquire::config::channels;
use trunnion_core::{AxisValues, Secret};
use trunnion_cycles::Cycle;
use trunnion_hil_sim::devices::cell::{Cell, CellConfig};
use trunnion_hil_sim::devices::{SimulatedCell, cell, orthogonal_nest};
use trunnion_hil_sim::motion::{Program, Step, Trajectory};
use trunnion_machine::shipped;
use trunnion_service::analysis::Analyst;
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::Cycles;
use trunnion_service::daemon::{ServiceError, Texts, serve_on};
use trunnion_service::live::Plan;
use trunnion_service::mqtt::{Broker, MqttConfig, MqttTls, run};
use trunnion_tests::json_schema::{differences, schema_of_topic};
use trunnion_tests::log::Log;
use trunnion_tests::mosquitto::Mosquitto;
use trunnion_tests::page_status::free_port;
use trunnion_tests::{SILENCE_MS, three_probes};

/// Holds every topic that a service sent against its schema.
pub fn as_schemas_say(topics: &BTreeMap<String, serde_json::Value>) {
    for (topic, message) in topics {
        let name = topic.rsplit('/').next().unwrap_or_default();
        // What an operator sends.
        if name != "choose" {
            let differences = differences(message, &schema_of_topic(name));
            assert!(differences.is_empty(), "{topic}: {differences:?} in {message}");
        }
    }
}

pub fn broker(port: u16) -> Mosquitto {
    Mosquitto::start(port).expect("mosquitto starts")
}

/// Bytes of a message that is read; the library's own limit is 10 kB.
const LARGEST: usize = 1 << 20;

/// Latest payloads of all `trunnion/#` topics once `enough` holds; fails after a minute.
pub async fn wait_for(port: u16, name: &str, enough: impl Fn(&BTreeMap<String, serde_json::Value>) -> bool) {
    let mut topics = BTreeMap::new();
    let watching = async {
        loop {
            let mut options = MqttOptions::new(name, "127.0.0.1", port);
            options.set_keep_alive(Duration::from_secs(5));
            options.set_max_packet_size(LARGEST, LARGEST);
            let (client, mut events) = AsyncClient::new(options, 16);
            client.subscribe("trunnion/#", QoS::AtLeastOnce).await.expect("queued");
            while let Ok(event) = events.poll().await {
                if let Event::Incoming(Packet::Publish(publish)) = event {
                    topics.insert(publish.topic, serde_json::from_slice(&publish.payload).expect("JSON"));
                    if enough(&topics) {
                        return;
                    }
                }
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    let waited = tokio::time::timeout(Duration::from_secs(60), watching).await;
    assert!(waited.is_ok(), "{name}: the topics never came to what was expected: {topics:?}");
}

/// A board with something to say: a broker counts as reached once it has taken a value.
fn spoken() -> Board {
    let board = Board::default();
    board.set("status", &serde_json::json!({ "state": "online" }));
    board
}

#[tokio::test]
#[ignore = "a peer test: tests/peers/run"]
async fn the_latest_state_reaches_a_broker_that_was_killed_and_restarted() {
    let port = free_port();
    let first = broker(port);
    let config = MqttConfig { broker: Broker::local(port), machine: "m1".into(), sparkplug: None };
    let (board, cancel) = (Board::default(), CancellationToken::new());
    let service = tokio::spawn(run(config, board.clone(), cancel.clone()));
    board.set("status", &serde_json::json!({ "state": "online" }));
    board.set("cycle", &serde_json::json!({ "state": "measuring", "done": 1 }));
    wait_for(port, "before", |t| t.get("trunnion/m1/cycle").is_some_and(|v| v["done"] == 1)).await;

    // Killed mid-cycle; the new broker has no memory of the session or of anything retained.
    drop(first);
    board.set("cycle", &serde_json::json!({ "state": "measuring", "done": 2 }));
    let _second = broker(port);
    wait_for(port, "after", |t| {
        t.get("trunnion/m1/cycle").is_some_and(|v| v["done"] == 2)
            && t.get("trunnion/m1/status").is_some_and(|v| v["state"] == "online")
    })
    .await;

    // Larger than what the client's library sends by itself.
    let large = "x".repeat(40_000);
    board.set("result", &serde_json::json!({ "why": large }));
    wait_for(port, "large", |t| t.get("trunnion/m1/result").is_some_and(|v| v["why"] == large)).await;

    cancel.cancel();
    service.await.expect("the service ends");
    // No dashboard goes on "measuring" after the service.
    wait_for(port, "end", |t| {
        ["status", "cycle"].iter().all(|topic| {
            t.get(&format!("trunnion/m1/{topic}")).is_some_and(|v| {
                v["state"] == "offline" && v["time"].is_string() && v["version"] == env!("CARGO_PKG_VERSION")
            })
        })
    })
    .await;
}

/// A service that publishes at `port`, with probes at a ball that stands `pressed` away from where they read zero.
pub async fn standing_service(
    port: u16,
    folder: &Path,
    pressed: [f64; 3],
    board: Board,
) -> (Cell, CancellationToken, JoinHandle<Result<(), ServiceError>>) {
    let steps = vec![Step::Dwell { duration_s: 600.0 }];
    let trajectory =
        Trajectory::compile(&Program { start: AxisValues::default(), steps }).expect("it stands");
    let world =
        SimulatedCell { deflection_mm: Box::new(move |_| pressed), ..SimulatedCell::along(trajectory) };
    let floor = CellConfig { can: None, controller: None, ..CellConfig::new(folder, 0) };
    let cell = cell::start(Arc::new(world), floor, tokio::time::Instant::now()).await.expect("it starts");
    let tables = format!("[cycle_start]\nby = \"motion\"\n[mqtt]\nhost = \"127.0.0.1\"\nport = {port}\n");
    let text = three_probes(folder, SILENCE_MS, &tables, "");
    let config = Config::parse(&folder.join("trunnion.toml"), &text).expect("it is good");
    let cycle_text = include_str!("../../../config/cycles/demo-static.toml");
    let cycle = Cycle::parse("c.toml", cycle_text).expect("it is good");
    let machine = shipped::machine("table-bc").expect("it is shipped");
    let plan = Plan { machine, cycle, nest: config.nest, channels: channels(&config.devices) };
    let texts = Texts { machine: String::new(), cycle: cycle_text.into(), config: text };
    let (clock, cancel) = (Arc::new(SystemClock::start()), CancellationToken::new());
    let model = trunnion::Model::base("table-bc");
    let cycles = Cycles::one(plan, texts, model).expect("the devices can measure it");
    let service = serve_on(config, cycles, clock, cancel.clone(), board, Analyst::Here);
    (cell, cancel, tokio::spawn(service))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn the_service_publishes_what_is_read_and_what_stands_against_a_cycle() {
    let port = free_port();
    let _broker = broker(port);
    let folder = tempfile::tempdir().expect("a folder");
    // The first probe, on the nest's x side, is pressed to the end of its 2 mm.
    let pressed = orthogonal_nest()[0].map(|part| 0.97 * part);
    let (cell, cancel, service) = standing_service(port, folder.path(), pressed, Board::default()).await;
    wait_for(port, "live", |t| {
        as_schemas_say(t);
        let ball = |live: &serde_json::Value| live["ball_offset_mm"]["x"].as_f64();
        let is_seen = |live| ball(live).is_some_and(|x| (x - pressed[0]).abs() < 0.01);
        let is_said = |ready: &serde_json::Value| {
            ready["ready"] == false
                && ready["why"][0].as_str().is_some_and(|why| why.contains("probe-1: +0.97 mm"))
        };
        let is_well = |status: &serde_json::Value| {
            let status: ServiceStatus = serde_json::from_value(status.clone()).expect("as its schema says");
            let health = status.health.expect("it is online");
            let parts: Vec<&str> = health.parts.keys().map(String::as_str).collect();
            assert_eq!(parts, ["analysis", "broker", "devices", "disk", "recorder", "service"]);
            health.state == Condition::Good && status.devices["probe-1"].state == "Streaming"
        };
        t.get("trunnion/m/live").is_some_and(is_seen)
            && t.get("trunnion/m/ready").is_some_and(is_said)
            && t.get("trunnion/m/status").is_some_and(is_well)
    })
    .await;
    cancel.cancel();
    service.await.expect("no panic").expect("no failure");
    wait_for(port, "stopped", |t| {
        as_schemas_say(t);
        let stopped = t.values().filter(|message| message["reason"] == "stopped");
        stopped.count() == OF_THE_PRESENT.len()
    })
    .await;
    cell.shutdown().await;
}

#[tokio::test]
#[ignore = "a peer test: tests/peers/run"]
async fn a_service_that_dies_leaves_its_last_will() {
    let port = free_port();
    let _broker = broker(port);
    let config = MqttConfig { broker: Broker::local(port), machine: "m2".into(), sparkplug: None };
    let board = Board::default();
    let service = tokio::spawn(run(config, board.clone(), CancellationToken::new()));
    board.set("status", &serde_json::json!({ "state": "online" }));
    wait_for(port, "alive", |t| t.get("trunnion/m2/status").is_some_and(|v| v["state"] == "online")).await;
    service.abort();
    wait_for(port, "dead", |t| {
        let is_lost = t.get("trunnion/m2/status").is_some_and(|v| v["reason"] == "lost");
        if is_lost {
            as_schemas_say(t);
        }
        is_lost
    })
    .await;
}

#[tokio::test]
#[ignore = "a peer test: tests/peers/run"]
async fn a_wrong_password_is_logged_once_and_the_right_one_is_read_from_its_file() {
    let (port, folder) = (free_port(), tempfile::tempdir().expect("a folder"));
    let file = |name: &str| folder.path().join(name);
    let made = Command::new("mosquitto_passwd")
        .args(["-b", "-c"])
        .arg(file("users"))
        .args(["cell", "hunter2"])
        .status();
    assert!(made.expect("mosquitto_passwd runs").success());
    // The broker gives up root before it reads the file.
    std::fs::set_permissions(file("users"), std::os::unix::fs::PermissionsExt::from_mode(0o644))
        .expect("ours");
    std::fs::set_permissions(folder.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755))
        .expect("ours");
    let settings = format!(
        "listener {port} 127.0.0.1\nallow_anonymous false\npassword_file {}\n",
        file("users").display()
    );
    std::fs::write(file("mosquitto.conf"), settings).expect("written");
    let _broker = Mosquitto::with_settings(port, &file("mosquitto.conf")).expect("mosquitto starts");

    let (log, _logging) = Log::begin(LevelFilter::INFO);
    let secret = Secret::File { name: "password".into(), folder: folder.path().into() };
    let login = Some(("cell".to_owned(), Some(secret)));
    let config =
        MqttConfig { broker: Broker { login, ..Broker::local(port) }, machine: "m3".into(), sparkplug: None };
    let cancel = CancellationToken::new();
    let service = tokio::spawn(run(config, spoken(), cancel.clone()));
    log.until("the password file").await;
    std::fs::write(file("password"), "wrong\n").expect("written");
    log.until("it does not let this user in; check `user` and `password_file`").await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    assert_eq!(log.text().matches("does not let this user in").count(), 1, "{}", log.text());

    std::fs::write(file("password"), "hunter2\n").expect("written");
    log.until("connected to the MQTT broker").await;
    assert!(!log.text().contains("hunter2"), "{}", log.text());
    cancel.cancel();
    service.await.expect("the service ends");
}

/// Runs openssl in a folder.
fn openssl(folder: &Path, words: &str) {
    let made =
        Command::new("openssl").args(words.split(' ')).current_dir(folder).stderr(Stdio::null()).status();
    assert!(made.expect("openssl runs").success(), "openssl {words}");
}

/// A certificate for the broker on this computer, and one for us, signed by `ca.pem`.
fn certificates(folder: &Path) {
    openssl(folder, "req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -days 2 -subj /CN=plant");
    std::fs::write(folder.join("names"), "subjectAltName=IP:127.0.0.1").expect("written");
    for who in ["broker", "trunnion"] {
        openssl(
            folder,
            &format!("req -newkey rsa:2048 -nodes -keyout {who}.key -out {who}.csr -subj /CN={who}"),
        );
        let sign = format!(
            "x509 -req -in {who}.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile names"
        );
        openssl(folder, &format!("{sign} -out {who}.pem"));
    }
    openssl(
        folder,
        "req -x509 -newkey rsa:2048 -nodes -keyout other.key -out other.pem -days 2 -subj /CN=other",
    );
    for file in std::fs::read_dir(folder).expect("ours") {
        let mode = std::os::unix::fs::PermissionsExt::from_mode(0o644);
        std::fs::set_permissions(file.expect("ours").path(), mode).expect("ours");
    }
}

#[tokio::test]
#[ignore = "a peer test: tests/peers/run"]
async fn a_broker_that_encrypts_is_reached_with_its_authority_and_our_certificate() {
    let (port, folder) = (free_port(), tempfile::tempdir().expect("a folder"));
    std::fs::set_permissions(folder.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755))
        .expect("ours");
    certificates(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let settings = format!(
        "listener {port} 127.0.0.1\nallow_anonymous true\ncafile {}\ncertfile {}\nkeyfile {}\nrequire_certificate true\n",
        at("ca.pem"),
        at("broker.pem"),
        at("broker.key")
    );
    std::fs::write(at("mosquitto.conf"), settings).expect("written");
    let settings = folder.path().join("mosquitto.conf");
    let _broker = Mosquitto::with_settings(port, &settings).expect("mosquitto starts");

    let (log, _logging) = Log::begin(LevelFilter::INFO);
    let key = |name: &str| Secret::File { name: name.into(), folder: folder.path().into() };
    // Who signed, and with which certificate we come: what is logged.
    for (ca, client, expected) in [
        ("gone.pem", None, "gone.pem cannot be read as certificates"),
        ("other.pem", None, "`ca` of [mqtt.tls] must have signed the broker's certificate"),
        ("ca.pem", None, "cannot reach the MQTT broker"),
        ("ca.pem", Some(("trunnion.pem", "broker.key")), "certificate and key of [mqtt.tls] cannot be used"),
        ("ca.pem", Some(("trunnion.pem", "trunnion.key")), "connected to the MQTT broker"),
    ] {
        log.clear();
        let client = client.map(|(certificate, name)| (folder.path().join(certificate), key(name)));
        let tls = Some(MqttTls { ca: folder.path().join(ca), client });
        let config = MqttConfig {
            broker: Broker { tls, ..Broker::local(port) },
            machine: "m4".into(),
            sparkplug: None,
        };
        let cancel = CancellationToken::new();
        let service = tokio::spawn(run(config, spoken(), cancel.clone()));
        log.until(expected).await;
        let is_in = log.text().contains("connected to the MQTT broker");
        assert_eq!(is_in, expected.starts_with("connected"), "{}", log.text());
        cancel.cancel();
        service.await.expect("the service ends");
    }
}
