//! asyncua reads state and results from our OPC UA server, by the names of OPC 40001-101.

use serde_json::json;
use tokio_util::sync::CancellationToken;
use trunnion::results::{LocationError, LocationErrors, RunResult, Verdict};
use trunnion_service::board::Board;
use trunnion_service::opcua::serve;
use trunnion_tests::peer::PythonPeer;

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a peer test: tests/peers/run"]
async fn asyncua_browses_to_the_result_and_sees_the_next_one() {
    let board = Board::default();
    let status = |state: &str| {
        json!({ "state": "online", "reason": null, "devices": {}, "chosen": null,
            "cycle": { "state": state, "run": "r-test-1" },
            "health": { "state": "limited", "parts": { "disk": { "state": "limited", "why": "3 GB are left" } } } })
    };
    board.set("status", &status("analysing"));
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port().to_string();
    let cancel = CancellationToken::new();
    let served = tokio::spawn(serve(listener, board.clone(), cancel.clone()));
    let peer = tokio::task::spawn_blocking(move || PythonPeer::start("opcua_client.py", &[port.as_ref()]));
    // What comes while the client is connected: it waits for the result.
    let error = |symbol: &str, unit: &str, value, u| LocationError {
        symbol: symbol.into(),
        unit: unit.into(),
        value,
        u,
        ..LocationError::default()
    };
    let values = vec![error("EX0C", "um", Some(-12.5), Some(0.25)), error("EY0B", "um", None, None)];
    let result = RunResult {
        run: "r-test-1.mcap".into(),
        verdict: Verdict::MissingEffect,
        missing_effects: vec!["gravity-sag:B".into()],
        location_errors: Some(LocationErrors { notation: "absolute".into(), values }),
        ..RunResult::default()
    };
    let result = serde_json::to_value(result).unwrap();
    board.set("status", &status("done"));
    board.set("result", &result);
    let read = peer.await.unwrap().reported.clone();
    let read: serde_json::Value = serde_json::from_str(&read).expect("what the client read");
    assert_eq!(
        read,
        json!({
            "State": "done", "Run": "r-test-1", "Health": "limited", "Why": "disk: 3 GB are left",
            "ResultId": "r-test-1.mcap", "ResultEvaluation": 0,
            "ResultEvaluationDetails": "missing-effect: gravity-sag:B",
            "ResultContent": result,
            "errors": { "EX0C": [-12.5, 0.25, "um"] },
            "refused": true,
        })
    );
    cancel.cancel();
    served.await.unwrap().unwrap();
}
