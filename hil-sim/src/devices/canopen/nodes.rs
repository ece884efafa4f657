//! The nodes of one bus, whatever carries their frames.

use super::BusConfig;
use super::node::Node;
use crate::devices::faults::Fault;
use crate::devices::handle::DeviceError;
use crate::devices::world::World;
use std::sync::Arc;
use trunnion_protocol::can::CanFrame;
use trunnion_protocol::canopen::NodeId;

/// Nodes that hear the same frames. Times are of the cell, s.
pub struct Nodes(Vec<Node>);

impl Nodes {
    /// Switched on at time 0.
    ///
    /// # Errors
    /// Settings no node has.
    pub fn new(world: Arc<dyn World>, config: &BusConfig) -> Result<Self, DeviceError> {
        config.check()?;
        Ok(Self(config.nodes.iter().map(|node| Node::new(*node, Arc::clone(&world))).collect()))
    }

    /// Takes a frame from the bus and gives the nodes' answers.
    pub fn on_frame(&mut self, frame: &CanFrame, now_s: f64) -> Vec<CanFrame> {
        self.0.iter_mut().flat_map(|node| node.on_frame(frame, now_s)).collect()
    }

    /// When one of them next sends on its own.
    pub fn next_due_s(&self) -> Option<f64> {
        self.0.iter().filter_map(Node::next_due_s).min_by(f64::total_cmp)
    }

    /// What they send on their own up to now.
    pub fn frames_due(&mut self, now_s: f64) -> Vec<CanFrame> {
        self.0.iter_mut().flat_map(|node| node.frames_due(now_s)).collect()
    }

    /// A node loses its supply: it says nothing any more.
    pub fn switch_off(&mut self, id: NodeId) {
        self.0.retain(|node| node.id() != id);
    }

    /// Faults a node can have. Values are asked for by SYNC and carry no count, and nobody uses the adapter's clock: no
    /// jump of either can show.
    pub fn have(fault: &Fault) -> bool {
        matches!(fault, Fault::WrongIdentity | Fault::StuckValue { .. } | Fault::OutOfRange { .. })
    }

    /// A fault begins: another node in the place of the first, or all values stuck or out of range.
    pub fn suffer(&mut self, fault: Fault, now_s: f64) {
        match fault {
            Fault::WrongIdentity => {
                if let Some(first) = self.0.first_mut() {
                    first.replace_by_another();
                }
            }
            Fault::StuckValue { duration_s } => {
                self.0.iter_mut().for_each(|node| node.stick(now_s, now_s + duration_s));
            }
            Fault::OutOfRange { duration_s } => {
                self.0.iter_mut().for_each(|node| node.leave_range(now_s + duration_s));
            }
            _ => {}
        }
    }
}
