//! A CNC as an MTConnect agent over HTTP: `/probe`, `/current`, `/sample` with and without `interval`.
//!
//! The controller samples all axes at one instant of its own clock and hands them to the agent as one line with one
//! time stamp. Values that have not changed are not observed again, as agents filter them.
//! Source of the formats: [`trunnion_protocol::mtconnect`]; behaviour: MTConnect Standard part 1 §5 (buffer) and
//! §8 (requests and errors).

mod buffer;
mod config;
mod controller;
mod documents;
mod http;
mod request;
mod wall_clock;

pub use config::{AgentConfig, Shown};

use super::clock::TimeOrigin;
use super::faults::{Fault, FaultSource, ScheduledFault};
use super::handle::{Address, DeviceError, FAULT_QUEUE, Handle};
use super::world::World;
use buffer::Buffer;
use controller::Controller;
use documents::Documents;
use http::Shared;
use std::net::SocketAddr;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex};
use tokio::net::TcpListener;
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;

/// Starts controller and agent. Must be called within a tokio runtime.
pub async fn spawn(
    world: Arc<dyn World>,
    config: AgentConfig,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    config.check()?;
    if let Some(bad) = faults.iter().find(|scheduled| !can_have(&scheduled.fault)) {
        return Err(DeviceError::Fault { device: "MTConnect agent", fault: bad.fault });
    }
    let failed = |source| DeviceError::Listen { address: config.listen, source };
    let listener = TcpListener::bind(config.listen).await.map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let (commands, commanded) = mpsc::channel(FAULT_QUEUE);
    let faults = FaultSource::new(origin, faults, commanded);
    let stop = CancellationToken::new();
    let lost_bytes = Arc::new(AtomicU64::new(0));
    let floor = Floor { world, config, origin, address, stop: stop.clone() };
    let task = tokio::spawn(floor.run(listener, faults));
    let url = Address::Url(format!("http://{address}"));
    Ok(Handle::new(url, (commands, can_have), lost_bytes, stop, task))
}

fn can_have(fault: &Fault) -> bool {
    let own = matches!(
        fault,
        Fault::AgentRestart
            | Fault::WrongIdentity
            | Fault::StuckValue { .. }
            | Fault::CounterJump { .. }
            | Fault::ClockJump { .. }
    );
    fault.is_possible() && (fault.is_of_the_line() || own)
}

/// What outlives a restart of the agent.
struct Floor {
    world: Arc<dyn World>,
    config: AgentConfig,
    origin: TimeOrigin,
    address: SocketAddr,
    stop: CancellationToken,
}

/// Why an agent ended.
enum End {
    Stopped,
    Restart,
    /// Another machine of the same kind answers at this address.
    Another,
    Unplugged {
        duration_s: f64,
    },
}

impl Floor {
    async fn run(mut self, mut listener: TcpListener, mut faults: FaultSource) {
        let mut instance_id = 0;
        let mut controller =
            Controller::new(Arc::clone(&self.world), self.config.clone(), self.origin.now_s());
        let mut shared = self.fresh_agent(&mut instance_id, &controller);
        loop {
            let network = CancellationToken::new();
            let server = tokio::spawn(http::serve(listener, Arc::clone(&shared), network.clone()));
            let end = self.operate(&mut controller, &shared, &mut faults).await;
            network.cancel();
            if let Err(error) = server.await {
                return tracing::error!(%error, "the agent's server ended badly");
            }
            match end {
                End::Stopped => return,
                End::Restart => shared = self.fresh_agent(&mut instance_id, &controller),
                End::Another => {
                    self.config.device = "VMC-OTHER".into();
                    let (world, now_s) = (Arc::clone(&self.world), self.origin.now_s());
                    controller = Controller::new(world, self.config.clone(), now_s);
                    shared = self.fresh_agent(&mut instance_id, &controller);
                }
                End::Unplugged { duration_s } => {
                    let back_s = self.origin.now_s() + duration_s;
                    // Controller and agent go on while the network is away.
                    if self.without_network(&mut controller, &shared, back_s).await.is_none() {
                        return;
                    }
                }
            }
            listener = match TcpListener::bind(self.address).await {
                Ok(listener) => listener,
                Err(error) => {
                    return tracing::error!(%error, address = %self.address, "the agent cannot listen again");
                }
            };
        }
    }

    /// A restarted agent knows nothing yet. Its instance id is the second it was started in, and never an old one.
    fn fresh_agent(&self, instance_id: &mut u64, controller: &Controller) -> Arc<Shared> {
        let wall_ns = controller.wall_ns(self.origin.now_s());
        *instance_id = (*instance_id + 1).max((wall_ns / 1_000_000_000).max(0) as u64);
        let buffer = Buffer::new(*instance_id, &self.config, controller.items(), wall_ns);
        Arc::new(Shared {
            buffer: Mutex::new(buffer),
            news: watch::channel(0).0,
            devices: controller.devices(),
            device: self.config.device.clone(),
            login: self.config.login.clone(),
            garble: Mutex::new(0),
            documents: Documents::new(self.config.reply_fault),
            clock: controller.wall_clock(self.origin),
        })
    }

    /// Feeds the agent until something ends it.
    async fn operate(&self, controller: &mut Controller, agent: &Shared, faults: &mut FaultSource) -> End {
        loop {
            tokio::select! {
                () = self.stop.cancelled() => return End::Stopped,
                fault = faults.next() => {
                    tracing::info!(device = "MTConnect agent", ?fault, "fault");
                    match fault {
                        Fault::GarbleBytes { count } => agent.garble(count),
                        Fault::Silence { duration_s } => controller.lose_link(self.origin.now_s() + duration_s),
                        Fault::Unplug { duration_s } => return End::Unplugged { duration_s },
                        Fault::AgentRestart => return End::Restart,
                        Fault::WrongIdentity => return End::Another,
                        Fault::StuckValue { duration_s } => controller.stick(self.origin.now_s(), duration_s),
                        Fault::CounterJump { by } => agent.skip(by),
                        Fault::ClockJump { by_s } => controller.set_clock(by_s),
                        _ => {} // not among those it can have
                    }
                }
                () = tokio::time::sleep_until(self.origin.instant_of(controller.due_s())) => {
                    agent.feed(controller, self.origin.now_s());
                }
            }
        }
    }

    /// Feeds the agent until `back_s`; `None` when it is to stop.
    async fn without_network(&self, controller: &mut Controller, agent: &Shared, back_s: f64) -> Option<()> {
        loop {
            tokio::select! {
                () = self.stop.cancelled() => return None,
                () = tokio::time::sleep_until(self.origin.instant_of(back_s)) => return Some(()),
                () = tokio::time::sleep_until(self.origin.instant_of(controller.due_s())) => {
                    agent.feed(controller, self.origin.now_s());
                }
            }
        }
    }
}
