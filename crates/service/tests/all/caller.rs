//! A command calls the page of a running service: over a real socket, plain and with TLS.

use crate::attempts::{TOKEN, page_of_lan};
use crate::page::Page;
use serde_json::json;
use std::path::Path;
use trunnion::results::{Serves, ServiceStatus};
use trunnion_service::caller::{CallError, Caller};
use trunnion_service::config::PageConfig;
use trunnion_service::page::Access;

/// Of a page that serves cycles of these names to whom `access` lets in, and the caller that its configuration makes.
async fn called(config: PageConfig, cycles: &[&str], access: Access) -> (Page, Caller) {
    let page = Page::serving(Serves::Service, cycles, access).await;
    let caller = Caller::new(&PageConfig { listen: page.at, ..config }).unwrap();
    (page, caller)
}

fn plain() -> PageConfig {
    PageConfig { listen: "127.0.0.1:1".parse().unwrap(), lan: None }
}

#[tokio::test]
async fn a_cycle_is_chosen_begun_and_refused_in_the_words_of_the_service() {
    let (page, caller) = called(plain(), &["low", "high"], Access::this_computer()).await;
    let names: Vec<String> =
        caller.status().await.unwrap().cycles.into_iter().map(|cycle| cycle.name).collect();
    assert_eq!(names, ["low", "high"]);
    let mut asked = page.board.operator().asked();
    page.board.publish(&ServiceStatus::default());
    let answer = caller.choose("high").await.unwrap();
    assert_eq!(answer.topics["status"]["chosen"], "high", "the answer shows the choice");
    assert_eq!(page.board.operator().peek_chosen().as_deref(), Some("high"));
    let (board, mut begins) = (page.board.clone(), page.board.operator().asked());
    board.set("cycle", &json!({ "state": "ready" }));
    let begun = tokio::spawn(async move {
        begins.begins().await;
        board.set("cycle", &json!({ "state": "measuring", "cycle": "low" }));
    });
    let answer = caller.begin("low").await.unwrap();
    assert_eq!(answer.topics["cycle"]["state"], "measuring", "the answer is the state after");
    begun.await.unwrap();
    page.board.set("cycle", &json!({ "state": "done" }));
    assert_eq!(page.board.operator().peek_chosen().as_deref(), Some("low"));
    tokio::time::timeout(std::time::Duration::from_secs(10), asked.begins()).await.unwrap();
    let refused = |answer: Result<_, CallError>| match answer {
        Err(CallError::Refused(why)) => why,
        other => panic!("{other:?}"),
    };
    let why = refused(caller.begin("hihg").await);
    assert!(why.contains("no cycle \"hihg\"") && why.contains("high"), "{why}");
    assert_eq!(refused(caller.abort().await), "no cycle is being measured");
}

#[tokio::test]
async fn over_tls_only_the_certificate_of_the_configuration_is_the_service() {
    let folder = tempfile::tempdir().unwrap();
    let config = page_of_lan(folder.path(), TOKEN);
    let access = Access::of_lan(config.lan.as_ref().unwrap()).unwrap();
    let (page, caller) = called(config.clone(), &["low"], access).await;
    assert_eq!(caller.status().await.unwrap().cycles[0].name, "low");
    // Another certificate in its place: what answers is a stranger and gets no token.
    let other = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/other.crt");
    let mut lan = config.lan.unwrap();
    lan.certificate = other;
    let caller = Caller::new(&PageConfig { listen: page.at, lan: Some(lan) }).unwrap();
    assert!(matches!(caller.status().await, Err(CallError::Stranger { .. })));
}

#[tokio::test]
async fn where_no_service_runs_the_command_says_so() {
    let error = Caller::new(&plain()).unwrap().status().await.unwrap_err();
    assert!(error.to_string().contains("is it running with this configuration?"), "{error}");
}
