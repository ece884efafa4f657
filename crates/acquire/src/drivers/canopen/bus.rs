//! What a CANopen session needs of whatever carries its frames, and how it reads a node's description over it.

use crate::link::Link;
use crate::session_end::SessionEnd;
use std::future::Future;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_core::{HostTime, chain};
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::{Message, NmtState, NodeDescription, NodeId, NodeStartup, StartupProgress};

/// Longest wait for one SDO answer.
const SDO_LIMIT: Duration = Duration::from_millis(500);
/// Times that one object is asked for, and that a node may begin again: an answer is rarely lost, and not twice in a row.
const TRIES: u32 = 3;

/// What happened on the bus, in the order in which it happened.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::drivers) enum BusEvent {
    /// A frame of a node.
    Frame {
        /// The frame.
        frame: CanFrame,
        /// When it reached the host, as well as the transport knows.
        at: HostTime,
    },
    /// The oldest SYNC under way was sent.
    SyncSent {
        /// When it was on the bus; `None` when the transport only knows that it was sent.
        at: Option<HostTime>,
    },
    /// The transport did not take the oldest SYNC under way.
    SyncRefused,
    /// For the log of the run.
    Remark {
        /// True when a person should look at it.
        warning: bool,
        /// What the transport has to say.
        text: String,
    },
}

/// A way to send and receive frames. Its errors end the session.
pub(in crate::drivers) trait Bus: Send {
    /// SYNCs that may be sent without knowing that the first of them was on the bus. 1 where each comes back with the
    /// stamp of its moment, which must not be given to another.
    const SYNCS_UNDER_WAY: u64;

    /// From now on frames of other identifiers need not be received: those of others may fill the bus.
    fn hear(&mut self, ids: &[CanId]) -> Result<(), SessionEnd>;
    /// Hands over a frame.
    fn send(&mut self, frame: CanFrame) -> impl Future<Output = Result<(), SessionEnd>> + Send;
    /// Hands over a SYNC, which [`BusEvent::SyncSent`] answers.
    fn send_sync(&mut self) -> impl Future<Output = Result<(), SessionEnd>> + Send;
    /// What happened; empty after `limit`. Cancel safe.
    fn receive(
        &mut self,
        limit: Duration,
        link: &Link,
    ) -> impl Future<Output = Result<Vec<BusEvent>, SessionEnd>> + Send;
    /// Called about once a second: asks the transport how the bus is doing.
    fn tend(&mut self) -> impl Future<Output = Result<(), SessionEnd>> + Send;
    /// What is wrong with the bus as far as the transport knows, and what to do about it.
    fn fault(&self) -> Option<String>;
    /// Bytes that belonged to no message.
    fn dropped_bytes(&self) -> u64;
}

/// A silence, with the fault of the bus that explains it.
pub(super) fn explain(end: SessionEnd, bus: &impl Bus) -> SessionEnd {
    match (end, bus.fault()) {
        (SessionEnd::Silent { who, .. }, Some(fault)) => SessionEnd::Disconnected(format!("{who}; {fault}")),
        (end, _) => end,
    }
}

/// Reads what the node says about itself. `known`: what the nodes before have said.
pub(super) async fn describe(
    bus: &mut impl Bus,
    node: NodeId,
    known: &[NodeDescription],
    link: &mut Link,
) -> Result<NodeDescription, SessionEnd> {
    let (mut startup, request) = NodeStartup::new(node);
    bus.send(request).await?;
    let mut deadline = Instant::now() + SDO_LIMIT;
    let (mut asked, mut booted) = (1, 0);
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        for event in bus.receive(left, link).await? {
            let frame = match event {
                BusEvent::Frame { frame, .. } => frame,
                BusEvent::Remark { warning, text } => {
                    link.log(warning, text);
                    continue;
                }
                BusEvent::SyncSent { .. } | BusEvent::SyncRefused => continue,
            };
            if let Some(Message::Heartbeat(id, NmtState::BootUp)) = Message::from_frame(&frame) {
                // What a node has said is true until it begins again: another may be in its place.
                if known.iter().any(|known| known.node == id) || id == node && booted == TRIES {
                    let what = format!("node {} booted while the nodes were read", id.get());
                    return Err(SessionEnd::Restarted(what));
                }
                if id == node {
                    booted += 1;
                    let (fresh, request) = NodeStartup::new(node);
                    bus.send(std::mem::replace(&mut startup, fresh).give_up()).await?;
                    bus.send(request).await?;
                    deadline = Instant::now() + SDO_LIMIT;
                }
                continue;
            }
            match startup.on_frame(&frame) {
                StartupProgress::NotMine => {}
                StartupProgress::Send(next) => {
                    bus.send(next).await?;
                    asked = 1;
                    deadline = Instant::now() + SDO_LIMIT;
                }
                StartupProgress::Done(description) => return Ok(*description),
                StartupProgress::Failed { error, abort } => {
                    if let Some(abort) = abort {
                        bus.send(abort).await?;
                    }
                    return Err(SessionEnd::Protocol {
                        doing: "reading a node's description",
                        fault: chain(&error),
                    });
                }
            }
        }
        // Frames of others that come all the time are no answer.
        if left.is_zero() && deadline <= Instant::now() {
            if asked == TRIES {
                return Err(no_answer(bus, startup, node, link).await?);
            }
            asked += 1;
            link.log(
                false,
                format!("node {} did not answer for {}; it is asked again", node.get(), startup.reading()),
            );
            for frame in startup.ask_again() {
                bus.send(frame).await?;
            }
            deadline = Instant::now() + SDO_LIMIT;
        }
    }
}

/// How a session ends whose node does not answer; the transport is asked what it knows.
async fn no_answer(
    bus: &mut impl Bus,
    startup: NodeStartup,
    node: NodeId,
    link: &Link,
) -> Result<SessionEnd, SessionEnd> {
    let who = format!(
        "CANopen node {} does not answer for {}; check its supply, its number and the bit rate",
        node.get(),
        startup.reading()
    );
    bus.send(startup.give_up()).await?;
    bus.tend().await?;
    bus.receive(SDO_LIMIT, link).await?;
    Ok(explain(SessionEnd::Silent { who, waited: TRIES * SDO_LIMIT }, bus))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe;

    /// A bus full of frames of others.
    struct Full;

    impl Bus for Full {
        const SYNCS_UNDER_WAY: u64 = 1;

        fn hear(&mut self, _: &[CanId]) -> Result<(), SessionEnd> {
            Ok(())
        }

        async fn send(&mut self, _: CanFrame) -> Result<(), SessionEnd> {
            Ok(())
        }

        async fn send_sync(&mut self) -> Result<(), SessionEnd> {
            Ok(())
        }

        async fn receive(&mut self, _: Duration, _: &Link) -> Result<Vec<BusEvent>, SessionEnd> {
            tokio::task::yield_now().await;
            let frame = CanFrame::data_frame(CanId::Standard(0x4E4), &[0; 8]).expect("eight bytes");
            Ok(vec![BusEvent::Frame { frame, at: HostTime(0) }])
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

    #[tokio::test]
    async fn a_node_that_does_not_answer_is_silent_however_much_others_say() {
        let node = NodeId::new(3).unwrap();
        let end = describe(&mut Full, node, &[], &mut probe::link(SDO_LIMIT)).await.unwrap_err();
        assert!(matches!(&end, SessionEnd::Silent { who, .. } if who.contains("node 3")), "{end:?}");
    }
}
