//! The way of the nodes' frames to the bus, and what happens on it.

use std::time::Duration;
use trunnion_protocol::can::CanFrame;
use trunnion_protocol::canopen::{Message, NodeId};

/// What happens to the frames of the nodes.
#[derive(Debug, Default)]
pub struct Way {
    /// The cable of this node is pulled: nothing of it comes.
    pub cut: Option<u8>,
    /// The values of this node do not come.
    pub lost: Option<u8>,
    /// Every value comes twice.
    pub doubled: bool,
    /// The values of this node come so much later.
    pub late: Option<(u8, Duration)>,
    /// Frames that were held back, with when they come, s.
    waiting: Vec<(f64, CanFrame)>,
}

impl Way {
    /// Frames that come with the next.
    pub fn owe(&mut self, frames: Vec<CanFrame>) {
        self.waiting.extend(frames.into_iter().map(|frame| (0.0, frame)));
    }

    /// When the next that was held back comes, s.
    pub fn next_due_s(&self) -> Option<f64> {
        self.waiting.iter().map(|(due_s, _)| *due_s).min_by(f64::total_cmp)
    }

    /// What comes of these frames now, with those that were held back.
    pub fn take(&mut self, frames: Vec<CanFrame>, now_s: f64) -> Vec<CanFrame> {
        let (due, waiting): (Vec<_>, Vec<_>) = self.waiting.drain(..).partition(|(due_s, _)| *due_s <= now_s);
        self.waiting = waiting;
        let mut come: Vec<CanFrame> = due.into_iter().map(|(_, frame)| frame).collect();
        for frame in frames {
            let (node, is_value) = (u8::try_from(frame.id().raw() & 0x7F).ok(), is_value(&frame));
            if node == self.cut && node.is_some() || is_value && node == self.lost && node.is_some() {
                continue;
            }
            match self.late.filter(|(late, _)| is_value && Some(*late) == node) {
                Some((_, by)) => self.waiting.push((now_s + by.as_secs_f64(), frame)),
                None => {
                    come.push(frame);
                    if self.doubled && is_value {
                        come.push(frame);
                    }
                }
            }
        }
        come
    }
}

fn is_value(frame: &CanFrame) -> bool {
    matches!(Message::from_frame(frame), Some(Message::Tpdo(..)))
}

/// A node says that it cannot measure (error register bit 5, CiA 301 §7.5.2.2), or with zeros that it can again.
pub fn emergency(node: u8, code: u16, register: u8) -> CanFrame {
    let node = NodeId::new(node).expect("a node number");
    trunnion_protocol::canopen::Emergency { code, register, detail: [0; 5] }.frame(node)
}
