//! A controller and its agent, as asked for.

use super::super::clock::DeviceClock;
use super::super::faults::ReplyFault;
use super::super::handle::DeviceError;
use std::net::{Ipv4Addr, SocketAddr};
use trunnion_core::Joint;

/// A controller and its agent.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentConfig {
    /// Where to listen; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Name of the device.
    pub device: String,
    /// Axes shown.
    pub axes: Vec<Joint>,
    /// Lines per second of the controller's clock, 1..=1000.
    pub rate_hz: f64,
    /// Resolution of linear positions, mm.
    pub resolution_mm: f64,
    /// Resolution of angles, degrees.
    pub resolution_deg: f64,
    /// Observations the agent keeps.
    pub buffer_size: usize,
    /// Most agents drop samples that are the same as before; without the filter a standing axis is seen to stand at once.
    pub filters_duplicates: bool,
    /// The controller's wall clock: what it shows at time 0 of the cell, ns since 1970 UTC, in addition to the clock's
    /// offset.
    pub wall_ns_at_origin: i64,
    /// Offset, rate error and wander of the wall clock.
    pub clock: DeviceClock,
    /// What the controller says of its program instead of what the machine does.
    pub shown: Vec<Shown>,
    /// Programs with their numbers: a data item `cycle` has the number of the one that runs, 0 while none does. There is none without.
    pub numbers: Vec<(String, u32)>,
    /// User and password that the agent's web server asks for (Basic, RFC 7617); none without.
    pub login: Option<(String, String)>,
    /// Something that happens to the document of this number, counted from 0: answers, and parts of streams.
    pub reply_fault: Option<(u64, ReplyFault)>,
}

/// A state of the program, shown for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// From then, time of the cell, s.
    pub from_s: f64,
    /// Until then, s.
    pub to_s: f64,
    /// Word of the vocabulary.
    pub execution: &'static str,
}

impl AgentConfig {
    /// A five-axis machine with axes X, Y, Z, B, C at 125 lines per second, on a free port of this computer.
    pub fn new(wall_ns_at_origin: i64, clock: DeviceClock) -> Self {
        use trunnion_core::axis::iso::{B, C, X, Y, Z};
        Self {
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            device: "VMC-5Axis".into(),
            axes: vec![X, Y, Z, B, C],
            rate_hz: 125.0,
            resolution_mm: 1e-4,
            resolution_deg: 1e-5,
            buffer_size: 131_072,
            filters_duplicates: true,
            wall_ns_at_origin,
            clock,
            shown: Vec::new(),
            numbers: Vec::new(),
            login: None,
            reply_fault: None,
        }
    }

    pub(super) fn check(&self) -> Result<(), DeviceError> {
        let refuse = |setting, found, allowed| {
            Err(DeviceError::Setting { device: "MTConnect agent", setting, found, allowed })
        };
        if !(1.0..=1000.0).contains(&self.rate_hz) {
            return refuse("rate_hz", self.rate_hz, "1..=1000");
        }
        for (setting, found) in
            [("resolution_mm", self.resolution_mm), ("resolution_deg", self.resolution_deg)]
        {
            if !(1e-9..=1.0).contains(&found) {
                return refuse(setting, found, "1e-9..=1");
            }
        }
        if !(128..=1 << 22).contains(&self.buffer_size) {
            return refuse("buffer_size", self.buffer_size as f64, "128..=4194304");
        }
        Ok(())
    }
}
