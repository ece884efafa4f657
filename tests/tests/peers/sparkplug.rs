//! An independent host of Sparkplug B (pysparkplug) follows this service over a real broker: births, data, deaths, and what a broker or a
//! service that dies leaves.

use crate::mosquitto::broker;
use serde_json::{Value, json};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use tokio::runtime::Runtime;
use tokio_util::sync::CancellationToken;
use trunnion::results::{LocationError, LocationErrors, RunResult, Verdict};
use trunnion_service::board::Board;
use trunnion_service::mqtt::{Broker, MqttConfig, SparkplugConfig, run};
use trunnion_tests::page_status::free_port;
use trunnion_tests::peer::PythonPeer;

/// More messages than numbers: they begin again at 0.
const MANY: u32 = 300;

/// What the host has seen, message by message; each must keep all rules.
struct Host {
    peer: PythonPeer,
}

impl Host {
    fn start(port: u16) -> Self {
        let peer = PythonPeer::start("sparkplug_host.py", &[port.to_string().as_ref()]);
        assert_eq!(peer.reported, "ready");
        Self { peer }
    }

    fn next(&mut self) -> Value {
        let message = self.peer.json();
        assert_eq!(message["problems"], json!([]), "{message}");
        message
    }

    /// The next message of this kind; others may come before.
    fn until(&mut self, kind: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        loop {
            let message = self.next();
            if message["kind"] == kind && is_it(&message) {
                return message;
            }
        }
    }

    fn rebirth(&mut self) {
        self.peer.order("rebirth plant cell-4");
    }
}

fn status(state: &str, device: &str) -> Value {
    json!({ "state": "online", "reason": null, "chosen": null, "cycle": { "state": state, "run": "r-1" },
        "health": { "state": "limited", "parts": { "disk": { "state": "limited", "why": "3 GB are left" } } },
        "devices": { "probe-1": { "state": device, "identity": "optoNCDT 1420", "connections": 1, "ends": 0,
            "lost_messages": 0, "last_end": null } } })
}

fn live(value_mm: f64) -> Value {
    json!({ "format": "trunnion-live/1", "at": "", "ball_offset_mm": null, "say": "", "axes": [], "devices": [],
        "temperatures": [], "cycle": null, "probes": [{ "name": "probe-1", "device": "probe-1", "role": "probe-1",
            "value_mm": value_mm, "range_mm": null, "centre_mm": null, "zone": "unknown", "say": "" }] })
}

fn result() -> Value {
    let error = |symbol: &str, unit: &str, value, u| LocationError {
        symbol: symbol.into(),
        unit: unit.into(),
        value,
        u,
        ..LocationError::default()
    };
    let values = vec![error("EX0C", "um", Some(-12.5), Some(0.25)), error("EA0C", "urad", Some(56.25), None)];
    let result = RunResult {
        run: "r-1.mcap".into(),
        verdict: Verdict::MissingEffect,
        missing_effects: vec!["gravity-sag:B".into()],
        location_errors: Some(LocationErrors { notation: "absolute".into(), values }),
        rms_um_before: 9.5,
        rms_um_after: 1.25,
        ..RunResult::default()
    };
    serde_json::to_value(result).unwrap()
}

/// A service in a runtime of its own, which can be taken from it as a kill does.
struct Service {
    runtime: Runtime,
    ended: Receiver<()>,
    cancel: CancellationToken,
}

impl Service {
    fn start(port: u16, board: &Board) -> Self {
        let sparkplug = Some(SparkplugConfig { group: "plant".into(), node: "cell-4".into() });
        let config = MqttConfig { broker: Broker::local(port), machine: "cell-4".into(), sparkplug };
        let (runtime, cancel) = (Runtime::new().unwrap(), CancellationToken::new());
        let (end, ended) = channel();
        let running = run(config, board.clone(), cancel.clone());
        runtime.spawn(async move {
            running.await;
            end.send(()).ok();
        });
        Self { runtime, ended, cancel }
    }

    /// Its sockets close without a word.
    fn kill(self) {
        self.runtime.shutdown_background();
    }

    fn stop(self) {
        self.cancel.cancel();
        self.ended.recv_timeout(Duration::from_secs(30)).expect("it ends");
    }
}

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn a_sparkplug_host_follows_births_data_deaths_and_a_broker_that_dies() {
    let port = free_port();
    let first = broker(port);
    let (mut host, board) = (Host::start(port), Board::default());
    board.set("status", &status("measuring", "Streaming"));
    board.set("cycle", &json!({ "state": "measuring", "done": 3, "total": 50, "seconds_left": 90.5 }));
    board.set("live", &live(1.25));
    let service = Service::start(port, &board);

    let birth = host.next();
    assert_eq!(birth["kind"], "NBIRTH");
    let metric = |message: &Value, name: &str| message["metrics"][name].clone();
    assert_eq!(metric(&birth, "bdSeq"), 0);
    assert_eq!(metric(&birth, "Node Control/Rebirth"), false);
    assert_eq!(metric(&birth, "Cycle/State"), "measuring");
    assert_eq!((metric(&birth, "Cycle/Done"), metric(&birth, "Cycle/Time left")), (json!(3), json!(90.5)));
    assert_eq!(birth["units"]["Cycle/Time left"], "s");
    assert_eq!(metric(&birth, "Health/State"), "limited");
    assert_eq!(metric(&birth, "Health/disk/Why"), "3 GB are left");
    assert_eq!(metric(&birth, "Result/Verdict"), Value::Null);
    let device = host.next();
    assert_eq!((&device["kind"], &device["device"]), (&json!("DBIRTH"), &json!("probe-1")));
    assert_eq!(metric(&device, "Probes/probe-1/Value"), 1.25);
    assert_eq!(device["units"]["Probes/probe-1/Value"], "mm");

    // What changes comes alone.
    board.set("live", &live(1.5));
    let data = host.next();
    assert_eq!((&data["kind"], &data["metrics"]), (&json!("DDATA"), &json!({ "Probes/probe-1/Value": 1.5 })));
    // Location errors were in no birth.
    board.set("result", &result());
    let again = host.until("NBIRTH", |birth| birth["metrics"]["Result/Verdict"] == "missing-effect");
    assert_eq!(metric(&again, "bdSeq"), 0);
    assert_eq!(metric(&again, "Result/Missing effects"), "gravity-sag:B");
    assert_eq!(
        (metric(&again, "Location errors/EX0C/Value"), metric(&again, "Location errors/EX0C/u")),
        (json!(-12.5), json!(0.25))
    );
    assert_eq!(metric(&again, "Location errors/EA0C/u"), Value::Null);
    assert_eq!(again["units"]["Location errors/EA0C/Value"], "urad");
    assert_eq!(host.next()["kind"], "DBIRTH");

    // The numbers of messages begin again after 255.
    for count in 0..MANY {
        let value = f64::from(count) * 0.001;
        board.set("live", &live(value));
        host.until("DDATA", |data| data["metrics"]["Probes/probe-1/Value"] == value);
    }

    board.set("status", &status("measuring", "Silent"));
    assert_eq!(host.next()["kind"], "DDEATH");
    board.set("status", &status("done", "Streaming"));
    host.until("NDATA", |data| data["metrics"]["Cycle/State"] == "done");
    assert_eq!(host.next()["kind"], "DBIRTH");

    host.rebirth();
    let asked = host.next();
    assert_eq!((&asked["kind"], metric(&asked, "bdSeq")), (&json!("NBIRTH"), json!(0)));
    assert_eq!(host.next()["kind"], "DBIRTH");

    // A broker that knows nothing: a new session, with a number of its own. A host that comes later asks for it.
    drop(first);
    board.set("live", &live(0.75));
    let _second = broker(port);
    let after = host.until("NBIRTH", |_| true);
    assert_eq!(metric(&after, "bdSeq"), 1);
    assert_eq!(metric(&host.until("DBIRTH", |_| true), "Probes/probe-1/Value"), 0.75);

    // Killed: the broker says so.
    service.kill();
    assert_eq!(metric(&host.until("NDEATH", |_| true), "bdSeq"), 1);
    let service = Service::start(port, &board);
    let next = host.until("NBIRTH", |_| true);
    assert_eq!(metric(&next, "bdSeq"), 0);
    service.stop();
    assert_eq!(metric(&host.until("NDEATH", |_| true), "bdSeq"), 0);
}
