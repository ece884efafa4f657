//! CANopen nodes behind a Lawicel (slcan) adapter: the encoder of a ball bar (CiA 406) and, if wanted, probes
//! and thermometers (CiA 404). The adapter is powered over its cable, the nodes are not.
//!
//! A SYNC from the host latches all nodes at the instant its line arrives. Sources of the formats:
//! [`trunnion_protocol::slcan`], [`trunnion_protocol::canopen`].

mod config;
mod node;
mod nodes;
mod objects;

pub use config::{BusConfig, FrameKind, Listening, NodeConfig, NodeKind, SdoFault};

pub use nodes::Nodes;

use super::clock::{DeviceClock, TimeOrigin};
use super::faults::{Fault, ScheduledFault};
use super::handle::{DeviceError, Handle};
use super::serial::{self, Outbox, SerialDevice};
use super::world::World;
use std::path::Path;
use std::sync::Arc;
use trunnion_protocol::can::CanFrame;
use trunnion_protocol::canopen::{CobId, Message, NmtCommand, NodeId};
use trunnion_protocol::slcan::{Adapter, AdapterDecoder, AdapterMessage, HostCommand, StatusFlags};

impl BusConfig {
    /// A ball bar as node 5 with steps of 100 nm, position every 10 ms and after every SYNC.
    pub fn ball_bar(clock: DeviceClock) -> Self {
        let id = NodeId::new(5).expect("5 is in 1..=127");
        let kind = NodeKind::BallBar { step_nm: 100, zero_mm: 10.0 };
        let node = NodeConfig { id, kind, serial: 4711, heartbeat_ms: 500, event_timer_ms: 10, clock };
        Self {
            nodes: vec![node],
            adapter_clock: clock,
            listening: Listening::Obeyed,
            sdo_fault: None,
            frame_fault: None,
        }
    }

    /// The ball bar and three probes of ±1 mm as nodes 1 to 3, read by SYNC.
    pub fn ball_bar_and_probes(clock: DeviceClock) -> Self {
        let mut bus = Self::ball_bar(clock);
        for channel in 0..3 {
            let id = NodeId::new(channel as u8 + 1).expect("1..=3 is in 1..=127");
            let kind = NodeKind::Probe { channel, digits: 5 };
            let serial = 1001 + channel as u32;
            bus.nodes.push(NodeConfig { id, kind, serial, heartbeat_ms: 500, event_timer_ms: 0, clock });
        }
        bus
    }

    fn check(&self) -> Result<(), DeviceError> {
        let refuse = |setting, found, allowed| {
            Err(DeviceError::Setting { device: "CANopen bus", setting, found, allowed })
        };
        for (index, node) in self.nodes.iter().enumerate() {
            if self.nodes[..index].iter().any(|other| other.id == node.id) {
                return refuse("node", f64::from(node.id.get()), "each number once");
            }
            match node.kind {
                NodeKind::Probe { channel, .. } if channel > 2 => {
                    return refuse("channel", channel as f64, "0..=2");
                }
                NodeKind::Probe { digits, .. } if digits > 8 => {
                    return refuse("digits", f64::from(digits), "0..=8");
                }
                NodeKind::Thermometer { digits } if digits > 2 => {
                    return refuse("digits", f64::from(digits), "0..=2, so that 100 °C fit into 16 bits");
                }
                NodeKind::BallBar { step_nm: 0, .. } => return refuse("step_nm", 0.0, "1 or more"),
                NodeKind::Probe { .. } | NodeKind::Thermometer { .. } | NodeKind::BallBar { .. } => {}
            }
        }
        Ok(())
    }
}

/// Starts adapter and nodes on a pseudo-terminal that `port` will link to. Must be called within a tokio runtime.
pub fn spawn(
    world: Arc<dyn World>,
    config: &BusConfig,
    port: &Path,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    let fault_of = |kind: FrameKind| {
        config.frame_fault.filter(|(of, ..)| *of == kind).map(|(_, number, fault)| (number, fault))
    };
    let bus = Bus {
        nodes: Nodes::new(world, config)?,
        off_until_s: f64::NEG_INFINITY,
        adapter: Adapter::default(),
        commands: AdapterDecoder::default(),
        adapter_clock: config.adapter_clock,
        listening: config.listening,
        sdo_answers: Outbox::with_fault(config.sdo_fault.and_then(|(number, fault)| match fault {
            SdoFault::Reply(fault) => Some((number, fault)),
            SdoFault::BootUp => None,
        })),
        sdo_count: 0,
        boots_at: config.sdo_fault.and_then(|(number, fault)| (fault == SdoFault::BootUp).then_some(number)),
        commands_sent: Outbox::with_fault(fault_of(FrameKind::Command)),
        heartbeats: Outbox::with_fault(fault_of(FrameKind::Heartbeat)),
        values: Outbox::with_fault(fault_of(FrameKind::Values)),
    };
    serial::spawn("CANopen bus", bus, port, origin, faults)
}

struct Bus {
    nodes: Nodes,
    /// Whatever drives the adapter's controller to bus-off lasts until then.
    off_until_s: f64,
    adapter: Adapter,
    commands: AdapterDecoder,
    adapter_clock: DeviceClock,
    listening: Listening,
    /// Lines of SDO answers on their way.
    sdo_answers: Outbox,
    /// SDO answers so far, and the number of that instead of which a node begins again.
    sdo_count: u64,
    boots_at: Option<u64>,
    /// Commands of the host on their way to the nodes: pairs of command and node, 0 for all.
    commands_sent: Outbox,
    /// Lines of the nodes on their way.
    heartbeats: Outbox,
    values: Outbox,
}

impl Bus {
    /// Lines of what the nodes answer at once; those of SDO answers leave by way of their faults, as commands come by theirs.
    fn answers(&mut self, frame: &CanFrame, now_s: f64) -> Vec<u8> {
        if matches!(Message::from_frame(frame), Some(Message::Nmt(..))) {
            self.commands_sent.put(now_s, frame.data().to_vec());
            return self.obeyed(now_s);
        }
        let mut lines = Vec::new();
        for answer in self.nodes.on_frame(frame, now_s) {
            let Some(Message::SdoAnswer(node)) = Message::from_frame(&answer) else {
                lines.extend(self.lines_on_their_way(vec![answer], now_s));
                continue;
            };
            if self.boots_at == Some(self.sdo_count) {
                let boot_up = self.nodes.on_frame(&NmtCommand::ResetNode.frame(Some(node)), now_s);
                lines.extend(self.lines(boot_up, now_s));
            } else {
                let answer = self.lines(vec![answer], now_s);
                self.sdo_answers.put(now_s, answer);
                lines.extend(self.sdo_answers.take_due(now_s));
            }
            self.sdo_count += 1;
        }
        lines
    }

    /// What the nodes say to commands that have come by now.
    fn obeyed(&mut self, now_s: f64) -> Vec<u8> {
        let commands = self.commands_sent.take_due(now_s);
        let mut lines = Vec::new();
        for command in commands.chunks_exact(2) {
            let frame = CanFrame::data_frame(CobId::Nmt.can_id(), command).expect("two bytes fit");
            let answers = self.nodes.on_frame(&frame, now_s);
            lines.extend(self.lines_on_their_way(answers, now_s));
        }
        lines
    }

    /// Lines that leave now of what the nodes send, by way of their faults.
    fn lines_on_their_way(&mut self, frames: Vec<CanFrame>, now_s: f64) -> Vec<u8> {
        let mut lines = Vec::new();
        for frame in frames {
            let message = Message::from_frame(&frame);
            let line = self.lines(vec![frame], now_s);
            match message {
                Some(Message::Heartbeat(..)) => self.heartbeats.put(now_s, line),
                Some(Message::Tpdo(..)) => self.values.put(now_s, line),
                _ => lines.extend(line),
            }
        }
        lines.extend(self.heartbeats.take_due(now_s));
        lines.extend(self.values.take_due(now_s));
        lines
    }

    /// The adapter's lines for frames seen on the bus.
    fn lines(&self, frames: Vec<CanFrame>, now_s: f64) -> Vec<u8> {
        let clock_ms = (self.adapter_clock.device_s(now_s) * 1e3).max(0.0) as u64;
        let seen = frames.into_iter().filter_map(|frame| self.adapter.receive(frame, clock_ms));
        seen.flat_map(|message: AdapterMessage| message.encode()).collect()
    }
}

impl SerialDevice for Bus {
    fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        let mut lines = Vec::new();
        for command in self.commands.push(bytes) {
            if command == Some(HostCommand::Open) && now_s >= self.off_until_s {
                self.adapter.set_status(StatusFlags::default()); // opening restarts the controller
            }
            let (answer, frame) = match (&command, self.listening) {
                (Some(HostCommand::Listen), Listening::Refused) => (Some(AdapterMessage::Refused), None),
                (Some(HostCommand::Listen), Listening::Ignored) => (None, None),
                _ => self.adapter.answer(command),
            };
            lines.extend(answer.iter().flat_map(AdapterMessage::encode));
            if let Some(frame) = frame {
                lines.extend(self.answers(&frame, now_s));
            }
        }
        lines
    }

    fn next_due_s(&self) -> Option<f64> {
        let on_their_way = [&self.sdo_answers, &self.commands_sent, &self.heartbeats, &self.values];
        let due_s = on_their_way.into_iter().filter_map(Outbox::next_due_s);
        due_s.chain(self.nodes.next_due_s()).min_by(f64::total_cmp)
    }

    fn send_due(&mut self, now_s: f64) -> Vec<u8> {
        let obeyed = self.obeyed(now_s);
        let frames = self.nodes.frames_due(now_s);
        [obeyed, self.lines_on_their_way(frames, now_s), self.sdo_answers.take_due(now_s)].concat()
    }

    fn plugged_in(&mut self) {
        self.adapter = Adapter::default();
        self.commands = AdapterDecoder::default();
        for on_its_way in
            [&mut self.sdo_answers, &mut self.commands_sent, &mut self.heartbeats, &mut self.values]
        {
            on_its_way.clear();
        }
    }

    fn has(fault: &Fault) -> bool {
        matches!(fault, Fault::BusOff { .. }) || Nodes::have(fault)
    }

    fn suffer(&mut self, fault: Fault, now_s: f64) {
        match fault {
            Fault::BusOff { duration_s } => {
                self.off_until_s = now_s + duration_s;
                self.adapter.set_status(StatusFlags::BUS_OFF);
            }
            _ => self.nodes.suffer(fault, now_s),
        }
    }
}
