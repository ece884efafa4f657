//! Which nodes are on a bus: each number is asked for its device type 1000h, which every node has (CiA 301 §7.5.2.1); who answers is asked
//! what it is, as at the start of a session. Objects are read and none is written.

use super::bus::{self, Bus, BusEvent};
use super::description::{identity, is_thermometer};
use crate::link::Link;
use crate::probe::Found;
use crate::session_end::SessionEnd;
use std::collections::BTreeSet;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_protocol::canopen::{NodeId, ObjectKey, Profile, SdoProgress, SdoTransfer};

const DEVICE_TYPE: ObjectKey = ObjectKey::new(0x1000, 0);
/// From one question to the next: request and answer, 130 bits each, take 2.1 ms at 125 kbit/s.
const STEP: Duration = Duration::from_millis(3);
/// Wait for the answers to the last questions: nodes answer within some ms, an adapter on USB holds them for 16.
const LAST: Duration = Duration::from_millis(150);

/// What the nodes say of themselves, and the key `nodes` with those that measure.
pub(in crate::drivers) async fn scan(bus: &mut impl Bus, link: &mut Link) -> Result<Nodes, SessionEnd> {
    let mut there = BTreeSet::new();
    let mut asked = Vec::new();
    for id in (1..=127).filter_map(|id| NodeId::new(id).ok()) {
        let (transfer, request) = SdoTransfer::upload(id, DEVICE_TYPE);
        bus.send(request).await?;
        asked.push((id, transfer));
        take_answers(bus, STEP, &mut asked, &mut there, link).await?;
    }
    take_answers(bus, LAST, &mut asked, &mut there, link).await?;
    let mut nodes = Nodes::default();
    for id in there {
        match bus::describe(bus, id, &[], link).await {
            Ok(found) => {
                let role = if is_thermometer(&found) { "\"temperature\"" } else { "{role}" };
                if !matches!(found.profile(), Profile::Other(_)) && !found.tpdos.is_empty() {
                    nodes.measuring.push(format!("{{ id = {}, role = {role} }}", id.get()));
                }
                nodes.words.push(identity(&found));
            }
            Err(end) => nodes.words.push(format!("node {}, which does not say what it is ({end})", id.get())),
        }
    }
    Ok(nodes)
}

async fn take_answers(
    bus: &mut impl Bus,
    limit: Duration,
    asked: &mut [(NodeId, SdoTransfer)],
    there: &mut BTreeSet<NodeId>,
    link: &Link,
) -> Result<(), SessionEnd> {
    let deadline = Instant::now() + limit;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        for event in bus.receive(left, link).await? {
            let BusEvent::Frame { frame, .. } = event else { continue };
            for (id, transfer) in asked.iter_mut() {
                // A refusal comes from a node too.
                if transfer.on_frame(&frame) != SdoProgress::NotMine {
                    there.insert(*id);
                }
            }
        }
        if left.is_zero() {
            return Ok(());
        }
    }
}

/// Nodes of a bus.
#[derive(Debug, Default)]
pub(in crate::drivers) struct Nodes {
    words: Vec<String>,
    /// Entries of the key `nodes`.
    measuring: Vec<String>,
    /// Why nobody was asked.
    not_asked: Option<String>,
}

impl Nodes {
    /// Of a bus on which nothing was sent, with the reason and what to do.
    pub(in crate::drivers) fn not_asked(why: String) -> Self {
        Self { not_asked: Some(why), ..Self::default() }
    }

    /// True where nobody answered.
    pub(in crate::drivers) fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Them behind what carries their frames, whose lines of the configuration these are.
    pub(in crate::drivers) fn found(&self, carrier: &str, mut keys: Vec<String>) -> Found {
        let identity = match (&self.not_asked, self.is_empty()) {
            (Some(why), _) => format!("{carrier}; CANopen nodes were not asked: {why}"),
            (None, true) => format!(
                "{carrier}; no CANopen node answers: check supply, bit rate and terminators, then put the ids into `nodes`"
            ),
            (None, false) => format!("{carrier}; {}", self.words.join("; ")),
        };
        let nodes = match self.measuring.is_empty() {
            true => "{ id = 1, role = {role} }".into(),
            false => self.measuring.join(", "),
        };
        keys.push(format!("nodes = [{nodes}]"));
        Found { identity, keys }
    }
}
