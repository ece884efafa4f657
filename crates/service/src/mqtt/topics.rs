//! The JSON topics: retained state and a last will.

use super::connection::Speaker;
use crate::board::{Board, offline};
use rumqttc::{AsyncClient, LastWill, Packet, Publish, QoS};
use tracing::{info, warn};
use trunnion::results::OfflineReason;

/// The topics below `trunnion/<machine>/`.
pub(super) struct Topics {
    machine: String,
    board: Board,
    /// Values that the broker has not acknowledged.
    under_way: usize,
}

impl Topics {
    /// Of a machine, as its board has them.
    pub(super) fn new(machine: &str, board: Board) -> Self {
        Self { machine: machine.into(), board, under_way: 0 }
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
        self.under_way = 0;
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

    fn answered(&mut self, answer: &Packet) -> bool {
        let is_acknowledged = matches!(answer, Packet::PubAck(_));
        self.under_way = self.under_way.saturating_sub(usize::from(is_acknowledged));
        is_acknowledged
    }

    /// One value of each topic at a time: a slow broker gets fewer values, and each as it is when it goes, not a queue of old ones behind
    /// which its answers come too late.
    fn publish(&mut self, client: &AsyncClient) {
        if self.under_way > 0 {
            return;
        }
        for (name, topic) in self.board.lock().iter_mut().filter(|(_, topic)| !topic.sent) {
            match client.try_publish(self.named(name), QoS::AtLeastOnce, true, topic.stamped.clone()) {
                Ok(()) => (topic.sent, self.under_way) = (true, self.under_way + 1),
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
        Some(self.under_way + words.len())
    }
}
