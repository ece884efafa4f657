//! Listening to a bus before anything is asked on it. A question at a wrong bit rate disturbs everybody; on a bus of drives a frame may
//! be a command; and where another computer asks the nodes, each takes the answers of the other for its own.

use super::bus::{Bus, BusEvent};
use super::scan::{Nodes, scan};
use crate::link::Link;
use crate::session_end::SessionEnd;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::CobId;

/// Longer than the usual heartbeat of 1 s. A node may send one only every 65.5 s, or none (CiA 301 §7.5.2.14, object 1017h), so that
/// silence for so long does not prove that nobody is on the bus.
const LISTENED: Duration = Duration::from_millis(1100);

/// What a bus says before anybody is asked.
#[derive(Debug, PartialEq)]
pub(in crate::drivers) enum Heard {
    Nothing,
    /// Frames, all as CANopen nodes send them.
    Nodes,
    /// What speaks against a question, and what to do.
    NotToBeAsked(String),
}

/// The nodes of a bus at the only bit rate it can have.
pub(in crate::drivers) async fn listen_and_scan(
    bus: &mut impl Bus,
    link: &mut Link,
) -> Result<Nodes, SessionEnd> {
    match listen(bus, link).await? {
        Heard::NotToBeAsked(why) => Ok(Nodes::not_asked(why)),
        Heard::Nothing | Heard::Nodes => scan(bus, link).await,
    }
}

/// Sends nothing.
pub(in crate::drivers) async fn listen(bus: &mut impl Bus, link: &Link) -> Result<Heard, SessionEnd> {
    let deadline = Instant::now() + LISTENED;
    let mut heard = Heard::Nothing;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        for event in bus.receive(left, link).await? {
            let against = match event {
                BusEvent::Frame { frame, .. } => match against_questions(&frame) {
                    None => {
                        heard = Heard::Nodes;
                        None
                    }
                    against => against,
                },
                BusEvent::Remark { warning: true, text } => Some(text),
                BusEvent::Remark { .. } | BusEvent::SyncSent { .. } | BusEvent::SyncRefused => None,
            };
            if let Some(against) = against {
                return Ok(Heard::NotToBeAsked(against));
            }
        }
        if left.is_zero() {
            return Ok(heard);
        }
    }
}

/// Why nodes are not asked on a bus with this frame; none where a CANopen node sends it unasked.
fn against_questions(frame: &CanFrame) -> Option<String> {
    let id = match frame.id() {
        CanId::Standard(id) => format!("{id:03X}h"),
        CanId::Extended(id) => format!("{id:08X}h"),
    };
    match CobId::from_can_id(frame.id()) {
        None => Some(format!(
            "frame {id} is none of CANopen's predefined ones: this may be a bus of drives, for whose devices a question could be a \
             command. If gauges are on it, put their ids into `nodes`"
        )),
        Some(CobId::Nmt | CobId::Sync | CobId::SdoRequest(_)) => Some(format!(
            "frame {id} comes from another computer that leads these nodes: stop it and look again, or put the ids into `nodes`"
        )),
        Some(
            CobId::Emergency(_)
            | CobId::Tpdo(..)
            | CobId::Rpdo(..)
            | CobId::SdoAnswer(_)
            | CobId::Heartbeat(_),
        ) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe;
    use trunnion_core::HostTime;
    use trunnion_protocol::canopen::network::sync_frame;
    use trunnion_protocol::canopen::{NmtState, NodeId, SdoTransfer};

    /// Says this once, and counts what is sent on it.
    struct Played {
        says: Vec<BusEvent>,
        sent: usize,
    }

    impl Bus for Played {
        const SYNCS_UNDER_WAY: u64 = 1;

        fn hear(&mut self, _: &[CanId]) -> Result<(), SessionEnd> {
            Ok(())
        }

        async fn send(&mut self, _: CanFrame) -> Result<(), SessionEnd> {
            self.sent += 1;
            Ok(())
        }

        async fn send_sync(&mut self) -> Result<(), SessionEnd> {
            self.sent += 1;
            Ok(())
        }

        async fn receive(&mut self, limit: Duration, _: &Link) -> Result<Vec<BusEvent>, SessionEnd> {
            if self.says.is_empty() {
                tokio::time::sleep(limit).await;
            }
            Ok(std::mem::take(&mut self.says))
        }

        async fn tend(&mut self) -> Result<(), SessionEnd> {
            Ok(())
        }

        fn fault(&self) -> Option<String> {
            None
        }

        fn dropped_bytes(&self) -> u64 {
            0
        }
    }

    /// Frames sent, and what is said of the bus.
    async fn looked(says: Vec<BusEvent>) -> (usize, String) {
        let mut bus = Played { says, sent: 0 };
        let nodes = listen_and_scan(&mut bus, &mut probe::link(Duration::from_millis(500))).await.unwrap();
        (bus.sent, nodes.found("CAN interface, up", Vec::new()).identity)
    }

    #[tokio::test]
    async fn nothing_is_sent_on_a_bus_that_another_leads_that_is_none_of_canopen_or_has_errors() {
        let frame = |frame| BusEvent::Frame { frame, at: HostTime(0) };
        let of = |id| frame(CanFrame::data_frame(id, &[0; 8]).unwrap());
        let node = NodeId::new(5).unwrap();
        let error = || BusEvent::Remark { warning: true, text: "can0 reports a stuff error".into() };
        for (says, words) in [
            (of(CanId::Extended(0x18FE_F100)), "frame 18FEF100h is none of CANopen's"),
            (of(CanId::Standard(0x7E0)), "frame 7E0h is none of CANopen's"),
            (frame(sync_frame(None)), "frame 080h comes from another computer"),
            (
                frame(SdoTransfer::upload(node, trunnion_protocol::canopen::ObjectKey::new(0x1000, 0)).1),
                "605h",
            ),
            (error(), "can0 reports a stuff error"),
        ] {
            let heartbeat = frame(NmtState::Operational.heartbeat(node));
            let (sent, identity) = looked(vec![heartbeat, says]).await;
            assert_eq!(sent, 0, "{identity}");
            assert!(identity.contains("were not asked") && identity.contains(words), "{identity}");
        }
    }

    #[tokio::test]
    async fn a_silent_bus_and_one_of_canopen_nodes_are_asked() {
        let node = NodeId::new(5).unwrap();
        let heartbeat = BusEvent::Frame { frame: NmtState::Operational.heartbeat(node), at: HostTime(0) };
        for says in [vec![], vec![heartbeat]] {
            let (sent, identity) = looked(says).await;
            assert_eq!(sent, 127);
            assert!(identity.contains("no CANopen node answers"), "{identity}");
        }
    }
}
