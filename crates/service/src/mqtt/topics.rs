//! The JSON topics: retained state and a last will.

use super::connection::Speaker;
use crate::board::{Board, offline};
use rumqttc::{AsyncClient, LastWill, Publish, QoS};
use tracing::{info, warn};
use trunnion::results::OfflineReason;

/// The topics below `trunnion/<machine>/`.
pub(super) struct Topics {
    machine: String,
    board: Board,
}

impl Topics {
    /// Of a machine, as its board has them.
    pub(super) fn new(machine: &str, board: Board) -> Self {
        Self { machine: machine.into(), board }
    }

    fn named(&self, topic: &str) -> String {
        format!("trunnion/{}/{topic}", self.machine)
    }
}

impl Speaker for Topics {
    const PART: &'static str = "broker";

    fn client_id(&self) -> String {
        format!("trunnion-{}-{}", self.machine, std::process::id())
    }

    fn last_will(&mut self) -> LastWill {
        LastWill::new(self.named("status"), offline(OfflineReason::Lost), QoS::AtLeastOnce, true)
    }

    /// A broker that forgot the session drops what was pending: everything is sent again.
    fn connected(&mut self, client: &AsyncClient) {
        self.board.forget_what_was_sent();
        if let Err(error) = client.try_subscribe(self.named("choose"), QoS::AtLeastOnce) {
            warn!(%error, "the broker was not asked for choices of a cycle");
        }
    }

    /// A retained choice was meant for a cycle that is long over.
    fn received(&mut self, message: &Publish) {
        if message.topic == self.named("choose") && !message.retain {
            let operator = self.board.operator();
            match operator.choose_unanswered(&message.payload) {
                Ok(()) => info!(cycle = ?operator.peek_chosen(), "the operator chose"),
                Err((refused, true)) => warn!("the choice of a cycle is not taken: {refused}"),
                // Counted in `status`.
                Err((_, false)) => {}
            }
        }
    }

    fn publish(&mut self, client: &AsyncClient) {
        for (name, topic) in self.board.lock().iter_mut().filter(|(_, topic)| !topic.sent) {
            match client.try_publish(self.named(name), QoS::AtLeastOnce, true, topic.stamped.clone()) {
                Ok(()) => topic.sent = true,
                Err(error) => {
                    warn!(%error, topic = name, "MQTT queue is full; the latest value is kept and sent later");
                    return;
                }
            }
        }
    }

    fn farewell(&mut self, client: &AsyncClient) -> Option<usize> {
        let words = self.board.farewell();
        for (name, value) in &words {
            client.try_publish(self.named(name), QoS::AtLeastOnce, true, value.as_str()).ok()?;
        }
        Some(words.len())
    }
}
