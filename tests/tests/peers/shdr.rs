//! An independent reader of SHDR takes state and results of the service, and holds them against the words of MTConnect.

use serde_json::json;
use tokio_util::sync::CancellationToken;
use trunnion::results::{LocationError, LocationErrors, RunResult, Verdict};
use trunnion_service::board::Board;
use trunnion_service::mtconnect::{MtConnectConfig, serve};
use trunnion_tests::peer::PythonPeer;

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a peer test: tests/peers/run"]
async fn an_agent_reads_state_verdict_and_location_errors() {
    let board = Board::default();
    board.set(
        "status",
        &json!({ "state": "online", "reason": null, "devices": {}, "chosen": null,
            "cycle": { "state": "done", "run": "r-test-1" },
            "health": { "state": "limited", "parts": { "disk": { "state": "limited", "why": "3 GB are left" } } } }),
    );
    let error = |symbol: &str, unit: &str, value, u| LocationError {
        symbol: symbol.into(),
        unit: unit.into(),
        value,
        u,
        ..LocationError::default()
    };
    let values = vec![
        error("EX0C", "um", Some(-12.5), Some(0.25)),
        error("EA0C", "urad", Some(56.25), Some(0.5)),
        error("EY0B", "um", None, None),
    ];
    let result = RunResult {
        run: "r-test-1.mcap".into(),
        verdict: Verdict::MissingEffect,
        missing_effects: vec!["gravity-sag:B".into()],
        location_errors: Some(LocationErrors { notation: "absolute".into(), values }),
        ..RunResult::default()
    };
    board.set("result", &serde_json::to_value(result).unwrap());
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (listen, cancel) = (listener.local_addr().unwrap(), CancellationToken::new());
    let config = MtConnectConfig { listen, agents: Vec::new() };
    let served = tokio::spawn(serve(listener, config, board, cancel.clone()));
    let port = listen.port().to_string();
    let read = tokio::task::spawn_blocking(move || {
        PythonPeer::start("shdr_agent.py", &[port.as_ref()]).reported.clone()
    });
    let read: serde_json::Value = serde_json::from_str(&read.await.unwrap()).expect("what the reader took");
    assert_eq!(
        read,
        json!({
            "avail": "AVAILABLE",
            "execution": "PROGRAM_COMPLETED",
            "program": "r-test-1",
            "system": ["WARNING", "disk: 3 GB are left"],
            "verdict": ["missing-effect", "missing-effect: gravity-sag:B"],
            "errors": {
                "EX0C": { "MEASUREMENT_ID": "r-test-1.mcap", "MEASUREMENT_TYPE": "LENGTH", "MEASUREMENT_VALUE": -0.0125,
                    "MEASUREMENT_UNITS": "MILLIMETER", "UNCERTAINTY": 0.00025, "UNCERTAINTY_TYPE": "COMBINED" },
                "EA0C": { "MEASUREMENT_ID": "r-test-1.mcap", "MEASUREMENT_TYPE": "ANGLE", "MEASUREMENT_VALUE": 56.25,
                    "MEASUREMENT_UNITS": "MICRO_RADIAN", "UNCERTAINTY": 0.5, "UNCERTAINTY_TYPE": "COMBINED" },
            },
        })
    );
    cancel.cancel();
    served.await.unwrap();
}
