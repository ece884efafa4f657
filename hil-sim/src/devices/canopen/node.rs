//! One node: network management, heartbeat, SDO, and TPDOs by SYNC and by event timer.

use super::NodeConfig;
use super::NodeKind;
use super::objects::{Objects, TPDOS};
use crate::devices::clock::DeviceClock;
use crate::devices::world::World;
use std::sync::Arc;
use trunnion_protocol::can::CanFrame;
use trunnion_protocol::canopen::{Emergency, Message, NmtCommand, NmtState, NodeId, SdoServer, Transmission};

pub(super) struct Node {
    config: NodeConfig,
    world: Arc<dyn World>,
    objects: Objects,
    sdo: SdoServer,
    state: NmtState,
    /// Times of the node's clock, s.
    heartbeat_at_s: f64,
    event_at_s: [f64; TPDOS as usize],
    syncs: [u8; TPDOS as usize],
    /// Frames to send at once.
    waiting: Vec<CanFrame>,
    /// Values are those of the first time until the second.
    stuck: Option<(f64, f64)>,
    out_of_range_until_s: Option<f64>,
}

/// Emergency of an encoder that cannot see its position: device hardware; generic and profile error.
const NO_POSITION: Emergency = Emergency { code: 0x5000, register: 0x21, detail: [0; 5] };
const ERROR_OVER: Emergency = Emergency { code: 0, register: 0, detail: [0; 5] };

impl Node {
    /// A node switched on at time 0. Its boot-up message goes out before anybody listens.
    pub fn new(config: NodeConfig, world: Arc<dyn World>) -> Self {
        let start_s = config.clock.device_s(0.0);
        let mut node = Self {
            config,
            objects: Objects::new(&config, Arc::clone(&world)),
            world,
            sdo: SdoServer::new(config.id),
            state: NmtState::PreOperational,
            heartbeat_at_s: start_s,
            event_at_s: [start_s; TPDOS as usize],
            syncs: [0; TPDOS as usize],
            waiting: Vec::new(),
            stuck: None,
            out_of_range_until_s: None,
        };
        node.heartbeat_at_s += node.objects.heartbeat_s().unwrap_or(0.0);
        node
    }

    /// Takes a frame from the bus and gives the node's frames in answer.
    pub fn on_frame(&mut self, frame: &CanFrame, now_s: f64) -> Vec<CanFrame> {
        match Message::from_frame(frame) {
            Some(Message::Nmt(command, target)) if target.is_none_or(|node| node == self.id()) => {
                self.obey(command, now_s)
            }
            Some(Message::Sync(_)) if self.state == NmtState::Operational => self.latch(now_s),
            Some(Message::SdoRequest(node)) if node == self.id() && self.state != NmtState::Stopped => {
                self.objects.now_s = now_s;
                let heartbeat_s = self.objects.heartbeat_s();
                let answer = self.sdo.on_frame(frame, &mut self.objects);
                if self.objects.heartbeat_s() != heartbeat_s {
                    self.heartbeat_at_s = self.clock().device_s(now_s);
                }
                answer.into_iter().collect()
            }
            _ => Vec::new(),
        }
    }

    /// When the node next sends on its own, time of the cell, s.
    pub fn next_due_s(&self) -> Option<f64> {
        if !self.waiting.is_empty() {
            return Some(0.0);
        }
        let heartbeat_s = self.objects.heartbeat_s().map(|_| self.heartbeat_at_s);
        let events =
            (0..TPDOS).filter_map(|pdo| self.event_period_s(pdo).map(|_| self.event_at_s[usize::from(pdo)]));
        let device_s = heartbeat_s.into_iter().chain(events);
        let cell_s = device_s.map(|device_s| self.clock().cell_s(device_s));
        cell_s.chain(self.out_of_range_until_s).min_by(f64::total_cmp)
    }

    /// What the node sends on its own up to now: the newest value of each event timer, as a bus that was asleep does
    /// not repeat what it missed.
    pub fn frames_due(&mut self, now_s: f64) -> Vec<CanFrame> {
        let now_device_s = self.clock().device_s(now_s);
        let mut frames = std::mem::take(&mut self.waiting);
        if self.out_of_range_until_s.is_some_and(|until_s| now_s >= until_s) {
            self.out_of_range_until_s = None;
            self.objects.out_of_range = false;
            frames.extend(self.emergency(ERROR_OVER));
        }
        for pdo in 0..TPDOS {
            let at_s = self.event_at_s[usize::from(pdo)];
            if let Some(period_s) = self.event_period_s(pdo)
                && let Some(last_s) = last_due(at_s, period_s, now_device_s)
            {
                frames.extend(self.tpdo(pdo, self.clock().cell_s(last_s)));
                self.event_at_s[usize::from(pdo)] = last_s + period_s;
            }
        }
        if let Some(period_s) = self.objects.heartbeat_s()
            && let Some(last_s) = last_due(self.heartbeat_at_s, period_s, now_device_s)
        {
            frames.push(self.state.heartbeat(self.id()));
            self.heartbeat_at_s = last_s + period_s;
        }
        frames
    }

    /// The node is exchanged for one that measures nothing (CiA 401).
    pub fn replace_by_another(&mut self) {
        self.objects.become_another();
        self.state = NmtState::PreOperational;
        self.waiting.push(NmtState::BootUp.heartbeat(self.id()));
    }

    pub fn stick(&mut self, at_s: f64, until_s: f64) {
        self.stuck = Some((at_s, until_s));
    }

    pub fn leave_range(&mut self, until_s: f64) {
        self.objects.out_of_range = true;
        self.out_of_range_until_s = Some(until_s);
        let reported = self.emergency(NO_POSITION);
        self.waiting.extend(reported);
    }

    /// An encoder has no status next to its position: it reports by an emergency.
    fn emergency(&self, emergency: Emergency) -> Option<CanFrame> {
        matches!(self.config.kind, NodeKind::BallBar { .. }).then(|| emergency.frame(self.id()))
    }

    fn obey(&mut self, command: NmtCommand, now_s: f64) -> Vec<CanFrame> {
        match command {
            NmtCommand::Start => {
                if self.state != NmtState::Operational {
                    self.event_at_s = [self.clock().device_s(now_s); TPDOS as usize];
                    self.syncs = [0; TPDOS as usize];
                }
                self.state = NmtState::Operational;
            }
            NmtCommand::Stop => self.state = NmtState::Stopped,
            NmtCommand::EnterPreOperational => self.state = NmtState::PreOperational,
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => {
                // Nothing is stored: communication parameters fall back to those of the configuration.
                let mut fresh = Self::new(self.config, Arc::clone(&self.world));
                fresh.heartbeat_at_s =
                    self.clock().device_s(now_s) + self.objects.heartbeat_s().unwrap_or(0.0);
                *self = fresh;
                return vec![NmtState::BootUp.heartbeat(self.id())];
            }
        }
        Vec::new()
    }

    fn latch(&mut self, now_s: f64) -> Vec<CanFrame> {
        let mut frames = Vec::new();
        for pdo in 0..TPDOS {
            if let Transmission::EverySync(every) = self.objects.communication(pdo).transmission {
                let syncs = &mut self.syncs[usize::from(pdo)];
                *syncs = (*syncs + 1) % every;
                if *syncs == 0 {
                    frames.extend(self.tpdo(pdo, now_s));
                }
            }
        }
        frames
    }

    /// The frame of a TPDO with the values of `t_s`, unless the TPDO is switched off.
    fn tpdo(&self, pdo: u16, t_s: f64) -> Option<CanFrame> {
        let communication = self.objects.communication(pdo);
        let seen_s = self.stuck.filter(|&(_, until_s)| t_s < until_s).map_or(t_s, |(at_s, _)| at_s);
        let data = self.objects.pdo_data(pdo, seen_s);
        let frame =
            communication.is_enabled().then(|| CanFrame::data_frame(communication.can_id(), &data))?;
        Some(frame.expect("a mapping has at most 64 bits and an identifier at most 29"))
    }

    /// Period of the event timer of a TPDO that runs.
    fn event_period_s(&self, pdo: u16) -> Option<f64> {
        let communication = self.objects.communication(pdo);
        let runs = self.state == NmtState::Operational
            && communication.is_enabled()
            && communication.transmission == Transmission::Event
            && communication.event_timer_ms > 0;
        runs.then(|| f64::from(communication.event_timer_ms) * 1e-3)
    }

    pub fn id(&self) -> NodeId {
        self.config.id
    }

    fn clock(&self) -> DeviceClock {
        self.config.clock
    }
}

/// The last of the instants `at_s`, `at_s` + period, … that is not after `now_s`.
fn last_due(at_s: f64, period_s: f64, now_s: f64) -> Option<f64> {
    // A timer may fire a hair early by rounding.
    let passed = ((now_s + 1e-9 - at_s) / period_s).floor();
    (passed >= 0.0).then_some(at_s + passed * period_s)
}
