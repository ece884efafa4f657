//! What the service reads: its configuration, and what others send it.

use super::entry::{Entry, text, without_comments};
use std::path::Path;
use trunnion_service::config::Config;
use trunnion_service::mqtt::sparkplug::Session;
use trunnion_service::operator::Operator;

/// All of it.
pub const RECEIVED: &[Entry] = &[
    Entry {
        name: "configuration",
        read_in: &["service/src/config.rs"],
        read: |bytes| drop(Config::parse(Path::new("/nowhere/trunnion.toml"), &text(bytes))),
        seeds: || vec![without_comments(include_bytes!("../../../../config/trunnion.toml"))],
    },
    Entry {
        name: "choice of a cycle over MQTT",
        read_in: &["service/src/operator.rs"],
        read: |bytes| {
            let operator = Operator::default();
            operator.offer(["demo-static", "demo-sweep-c"].into_iter());
            // Refused, it stays readable for the topic: of a name of 255 bytes each may be shown as six letters.
            if operator.choose_unanswered(bytes).is_err() {
                assert!(operator.refused().is_some_and(|refused| refused.why.len() < 6 * 255 + 200));
            }
        },
        seeds: || vec![b"demo-static".to_vec(), b"".to_vec(), b" demo-sweep-c\n".to_vec()],
    },
    Entry {
        name: "Sparkplug command",
        read_in: &["service/src/mqtt/sparkplug/session.rs"],
        read: |bytes| {
            Session::new("group", "node").asks_for_rebirth(bytes);
        },
        seeds: || {
            // A metric (field 2) with a name (1) and a boolean (14).
            let metric = [b"\x12\x18\x0a\x14", &b"Node Control/Rebirth"[..], b"\x70\x01"].concat();
            assert!(Session::new("group", "node").asks_for_rebirth(&metric), "a good one");
            vec![metric.clone(), metric.repeat(2), Session::new("group", "node").next_death().payload]
        },
    },
];
