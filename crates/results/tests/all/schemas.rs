//! The committed schemas are those of the types.

use crate::json_schema::{differences, schema_of_topic};
use serde_json::{json, to_value};
use std::collections::BTreeSet;
use std::path::PathBuf;
use trunnion_results::{OF_THE_PRESENT, Offline, OfflineReason, OfflineState, Presence, ServiceStatus};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas")
}

#[test]
fn committed_schemas_are_current() {
    for (name, schema) in trunnion_results::schemas() {
        let file = folder().join(format!("{name}.schema.json"));
        let committed = std::fs::read_to_string(&file).unwrap_or_default();
        let generated = trunnion_results::schema_text(&schema).unwrap();
        assert!(
            committed == generated,
            "{} is not current: run `cargo run -p trunnion-results --example schemas`",
            file.display()
        );
    }
}

#[test]
fn every_committed_schema_is_of_a_type() {
    let expected: BTreeSet<String> =
        trunnion_results::schemas().iter().map(|(name, _)| format!("{name}.schema.json")).collect();
    let committed: BTreeSet<String> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".schema.json"))
        .collect();
    assert_eq!(committed, expected);
}

#[test]
fn a_topic_of_the_present_is_whole_or_offline() {
    let said = |reason| Offline {
        state: OfflineState::Offline,
        reason,
        time: String::new(),
        version: String::new(),
    };
    for topic in OF_THE_PRESENT {
        let schema = schema_of_topic(topic);
        for reason in [OfflineReason::Stopped, OfflineReason::Lost] {
            let said = to_value(said(reason)).unwrap();
            assert_eq!(differences(&said, &schema), Vec::<String>::new(), "{topic}: {said}");
        }
    }
    let status = schema_of_topic("status");
    let online = to_value(ServiceStatus { state: Presence::Online, ..ServiceStatus::default() }).unwrap();
    assert_eq!(differences(&online, &status), Vec::<String>::new());
    for wrong in [
        json!({ "state": "online" }),
        json!({ "state": "offline", "reason": "away", "time": "", "version": "" }),
    ] {
        assert!(!differences(&wrong, &status).is_empty(), "{wrong}");
    }
}

#[test]
fn every_topic_has_a_schema() {
    let sources = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut listed = std::fs::read_to_string(sources.join("schema.rs")).unwrap();
    let mut topics = 0;
    for file in std::fs::read_dir(&sources).unwrap().map(|entry| entry.unwrap().path()) {
        let text = if file.is_file() { std::fs::read_to_string(&file).unwrap() } else { continue };
        for implemented in text.split("impl Published for ").skip(1) {
            let name = implemented.split_whitespace().next().unwrap();
            let line = format!("of_topic::<{name}>(),");
            assert!(listed.contains(&line), "{line} is missing in crates/results/src/schema.rs");
            listed = listed.replacen(&line, "", 1);
            topics += 1;
        }
    }
    assert!(topics >= 11, "{topics}");
}
