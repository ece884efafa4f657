//! Whatever is called: the page answers each call that is framed as HTTP, and no bytes end it.
//!
//! Every run makes the same calls; `PROPTEST_CASES=100000 cargo test -p trunnion-service --test all any_calls` makes more of them.

use crate::calls_table::routes;
use crate::page::Page;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use trunnion::results::Serves;
use trunnion_service::page::Access;

/// A page takes so many calls at once before it refuses more for a while.
const CALLS_OF_A_PAGE: u32 = 150;
const LIMIT: std::time::Duration = std::time::Duration::from_secs(60);

/// Paths of every call but the one whose answer does not end; any name is `NAME`.
fn paths() -> Vec<String> {
    let named = |path: &str| {
        let part = |part: &str| if part.starts_with('{') { "NAME".into() } else { part.to_owned() };
        path.split('/').map(part).collect::<Vec<_>>().join("/")
    };
    let calls = routes().into_iter().filter_map(|call| Some(named(call.split_once(' ')?.1)));
    let others = ["/", "/assets/NAME", "/NAME"].map(str::to_owned);
    calls.filter(|path| path != "/api/live").chain(others).collect()
}

#[derive(Clone, Debug)]
struct Call {
    line: String,
    headers: String,
    body: String,
}

fn any_name() -> impl Strategy<Value = String> {
    prop_oneof![
        "[a-zA-Z0-9_.:~-]{1,20}",
        "[!-~]{1,30}",
        "(%[0-9A-F]{2}){1,12}",
        Just("..%2f..%2fetc%2fpasswd".into()),
        Just("%00".into()),
        Just("a".repeat(3000)),
    ]
}

fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        ".{0,20}".prop_map(Value::from),
    ];
    // Keys of the calls among others.
    let key = prop_oneof![
        "[a-z_]{1,6}",
        prop::sample::select(vec!["by", "what", "cycle", "token", "run", "site"]).prop_map(str::to_owned)
    ];
    leaf.prop_recursive(4, 24, 4, move |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::btree_map(key.clone(), inner, 0..5).prop_map(|map| json!(map)),
        ]
    })
}

/// Short: a call whose body is not read in one piece with its head ends by a reset, which may overtake the answer.
fn any_body() -> impl Strategy<Value = String> {
    prop_oneof![
        any_json().prop_map(|value| value.to_string()),
        ".{0,60}",
        Just(String::new()),
        Just("[".repeat(2000)),
        Just(r#"{"by":"a","by":"b"}"#.into()),
        Just(r#"{"cycle":1e999}"#.into()),
        Just("x".repeat(2000)),
    ]
}

fn any_call() -> impl Strategy<Value = Call> {
    let method = prop::sample::select(vec!["GET", "POST", "DELETE", "PUT", "HEAD", "OPTIONS", "get", "X"]);
    let own = "x-trunnion: test\r\nContent-Type: application/json\r\n";
    let headers = prop_oneof![3 => Just(own.to_owned()), 1 => "([A-Z][a-z]{1,9}: [ -~]{0,30}\r\n){0,4}"];
    (method, prop::sample::select(paths()), any_name(), any_name(), headers, any_body()).prop_map(
        |(method, path, first, second, headers, body)| {
            let path = path.replacen("NAME", &first, 1).replacen("NAME", &second, 1);
            Call { line: format!("{method} {path}"), headers, body }
        },
    )
}

fn cases() -> u32 {
    ProptestConfig::default().cases
}

async fn page() -> Page {
    Page::serving(Serves::Service, &["low", "high"], Access::this_computer()).await
}

#[tokio::test]
async fn any_call_is_answered_and_is_no_fault_of_ours() {
    let mut runner = TestRunner::deterministic();
    let mut at = page().await;
    for case in 0..cases() {
        if case % CALLS_OF_A_PAGE == CALLS_OF_A_PAGE - 1 {
            at = page().await;
        }
        let call = any_call().new_tree(&mut runner).unwrap().current();
        let (status, answer) = at.ask(&call.line, &call.headers, &call.body).await;
        // A connection whose task panics ends without an answer.
        assert!((200..600).contains(&status) && status != 500, "{call:?}: {status} {answer}");
    }
    assert_eq!(at.ask("GET /api/status", "", "").await.0, 200);
}

#[tokio::test]
async fn no_bytes_end_the_page() {
    let mut runner = TestRunner::deterministic();
    let mut at = page().await;
    let cut = (any_call(), any::<prop::sample::Index>(), prop::collection::vec(any::<u8>(), 0..40));
    for case in 0..cases() {
        if case % CALLS_OF_A_PAGE == CALLS_OF_A_PAGE - 1 {
            assert_eq!(at.ask("GET /api/status", "", "").await.0, 200, "after {case} calls");
            at = page().await;
        }
        let (call, cut, garbage) = cut.new_tree(&mut runner).unwrap().current();
        let text = format!("{} HTTP/1.1\r\nHost: {}\r\n{}\r\n{}", call.line, at.at, call.headers, call.body);
        let mut bytes = text.into_bytes();
        let place = cut.index(bytes.len());
        bytes.splice(place.., garbage);
        let mut stream = TcpStream::connect(at.at).await.unwrap();
        // It may be refused before all is sent.
        stream.write_all(&bytes).await.ok();
        stream.shutdown().await.ok();
        let mut answer = Vec::new();
        tokio::time::timeout(LIMIT, stream.read_to_end(&mut answer)).await.expect("it is not held").ok();
    }
    assert_eq!(at.ask("GET /api/status", "", "").await.0, 200);
}
