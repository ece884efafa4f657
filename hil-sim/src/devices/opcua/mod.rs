//! A controller with an OPC UA server, as a SINUMERIK shows itself: string node ids in namespace 2, machine axes by their
//! numbers, every value with the source time stamp of the moment it was sampled.
//!
//! The controller samples its axes one after another in each cycle of its own clock; the server keeps every sample in the
//! queue of the item until it is published. The server is async-opcua's, behind a [`super::relay`].
//! Its library replaces stamps that follow each other faster than a client asked for: clients must not ask for a
//! slower sampling than the cycle. For the same reason its clock is never set back.

mod messages;
mod nodes;
mod without_link;

pub use messages::Disturbed;
pub use without_link::WithoutLink;

use super::clock::{DeviceClock, TimeOrigin};
use super::cycles::Cycles;
use super::faults::{Fault, FaultSource, ScheduledFault};
use super::handle::{Address, DeviceError, FAULT_QUEUE, Handle};
use super::relay;
use super::value_faults::ValueFaults;
use super::world::World;
use nodes::{Nodes, Sampled};
use opcua_server::{ServerBuilder, ServerEndpoint, ServerHandle, ServerUserToken};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use trunnion_core::Joint;

const DEVICE: &str = "OPC UA controller";
/// The server looks so often whether something is to be published, ms.
const PUBLISHING_MS: u64 = 5;
/// Values of an item, and notifications, kept for a client that is slow to fetch them.
const QUEUE: usize = 1000;
/// What the server calls its one user in its own settings.
const USER: &str = "user";
/// A server that is asked to stop closes its connections in this time.
const STOP_LIMIT: Duration = Duration::from_secs(5);

/// A controller and its server.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerConfig {
    /// Where to listen; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Name of the server.
    pub server: String,
    /// Machine axes 1, 2, 3 … of the unit `u1`.
    pub axes: Vec<Joint>,
    /// Samples per second of the controller's clock, 1..=1000.
    pub rate_hz: f64,
    /// An axis is sampled so much later than the one before it, s.
    pub stagger_s: f64,
    /// The controller's wall clock: what it shows at time 0 of the cell, ns since 1970 UTC, in addition to the clock's
    /// offset.
    pub wall_ns_at_origin: i64,
    /// Offset, rate error and wander of the wall clock.
    pub clock: DeviceClock,
    /// User and password that the server asks for; everybody is let in without.
    pub login: Option<(String, String)>,
    /// What the server sends of an axis while its link to the controller is lost.
    pub without_link: WithoutLink,
}

impl ControllerConfig {
    /// A five-axis machine with axes X, Y, Z, B, C, sampled 1 ms apart every 10 ms, on a free port of this computer.
    pub fn new(wall_ns_at_origin: i64, clock: DeviceClock) -> Self {
        use trunnion_core::axis::iso::{B, C, X, Y, Z};
        Self {
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            server: "SINUMERIK".into(),
            axes: vec![X, Y, Z, B, C],
            rate_hz: 100.0,
            stagger_s: 1e-3,
            wall_ns_at_origin,
            clock,
            login: None,
            without_link: WithoutLink::default(),
        }
    }

    fn check(&self) -> Result<(), DeviceError> {
        let refuse =
            |setting, found, allowed| Err(DeviceError::Setting { device: DEVICE, setting, found, allowed });
        if !(1.0..=1000.0).contains(&self.rate_hz) {
            return refuse("rate_hz", self.rate_hz, "1..=1000");
        }
        if !(0.0..1.0 / (self.rate_hz * self.axes.len() as f64)).contains(&self.stagger_s) {
            return refuse("stagger_s", self.stagger_s, "0 to a cycle over the number of axes");
        }
        Ok(())
    }
}

/// Starts controller and server. Must be called within a tokio runtime.
///
/// # Errors
/// An impossible setting or fault, or an address that cannot be listened on.
pub async fn spawn(
    world: Arc<dyn World>,
    config: ControllerConfig,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    config.check()?;
    let (own, of_the_network): (Vec<ScheduledFault>, Vec<ScheduledFault>) =
        faults.iter().copied().partition(|scheduled| can_have(&scheduled.fault));
    let failed = |source| DeviceError::Listen { address: config.listen, source };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let (commands, commanded) = mpsc::channel(FAULT_QUEUE);
    let faults = FaultSource::new(origin, &own, commanded);
    let stop = CancellationToken::new();
    let listen = config.listen;
    let cycles = Cycles::new(config.clock, config.rate_hz, origin.now_s());
    let ills = ValueFaults::default();
    let floor = Floor { world, config, origin, cycles, ills, link_lost_until_s: 0.0, stop: stop.clone() };
    let task = tokio::spawn(floor.run(listener, address, faults));
    let url = Address::Url(format!("opc.tcp://{address}"));
    let device = Handle::new(url, (commands, can_have), Arc::new(AtomicU64::new(0)), stop, task);
    relay::in_front_of(device, listen, origin, &of_the_network).await
}

/// Faults of the controller and its server; the rest are faults of the network.
fn can_have(fault: &Fault) -> bool {
    let own = match fault {
        Fault::AgentRestart | Fault::WrongIdentity | Fault::StuckValue { .. } | Fault::Silence { .. } => true,
        Fault::ClockJump { by_s } => *by_s > 0.0,
        _ => false,
    };
    own && fault.is_possible()
}

/// What outlives a restart of the server.
struct Floor {
    world: Arc<dyn World>,
    config: ControllerConfig,
    origin: TimeOrigin,
    cycles: Cycles,
    ills: ValueFaults,
    link_lost_until_s: f64,
    stop: CancellationToken,
}

/// One life of the server.
struct Life {
    handle: ServerHandle,
    nodes: Nodes,
    task: JoinHandle<Result<(), String>>,
}

impl Floor {
    async fn run(mut self, mut listener: TcpListener, address: SocketAddr, mut faults: FaultSource) {
        loop {
            let mut life = match self.start(listener, address) {
                Ok(life) => life,
                Err(why) => return tracing::error!(why, "{DEVICE} cannot start"),
            };
            let ended = self.operate(&mut life, &mut faults).await;
            life.handle.cancel();
            match timeout(STOP_LIMIT, &mut life.task).await {
                Ok(Ok(Ok(()))) => {}
                other => {
                    life.task.abort();
                    tracing::warn!(?other, "{DEVICE} did not stop well");
                }
            }
            if ended.is_none() {
                return;
            }
            listener = match TcpListener::bind(address).await {
                Ok(listener) => listener,
                Err(error) => return tracing::error!(%error, %address, "{DEVICE} cannot listen again"),
            };
        }
    }

    fn start(&mut self, listener: TcpListener, address: SocketAddr) -> Result<Life, String> {
        // Another controller: a lathe.
        let lathe = [Joint::X, Joint::Z];
        let (server, axes) = if self.ills.wrong_identity {
            ("LATHE", &lathe[..])
        } else {
            (self.config.server.as_str(), &self.config.axes[..])
        };
        let who = if self.config.login.is_some() { USER } else { "ANONYMOUS" };
        let mut builder = ServerBuilder::new()
            .application_name(server)
            .application_uri("urn:trunnion:virtual-controller")
            .product_uri("urn:trunnion:virtual-controller")
            .host(address.ip().to_string())
            .port(address.port())
            // Without encryption there are no certificates to keep.
            .pki_dir("/dev/null/none")
            .add_endpoint("none", ServerEndpoint::new_none("/", &[who.to_owned()]))
            .discovery_urls(vec!["/".to_owned()])
            .subscription_poll_interval_ms(PUBLISHING_MS)
            .with_node_manager(nodes::manager());
        if let Some((user, password)) = &self.config.login {
            builder = builder.add_user_token(USER, ServerUserToken::user_pass(user, password));
        }
        let limits = &mut builder.limits_mut().subscriptions;
        limits.min_sampling_interval_ms = 1e3 / self.config.rate_hz;
        limits.min_publishing_interval_ms = PUBLISHING_MS as f64;
        limits.max_monitored_item_queue_size = QUEUE;
        limits.max_queued_notifications = QUEUE;
        // Without encryption the library reports missing certificates as an error.
        let (server, handle) =
            tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), || builder.build())?;
        let nodes = Nodes::add(&handle, axes)?;
        // What a client finds before the next cycle; the library would give it a stamp of its own.
        nodes.set(&handle, &self.sample(self.cycles.last()))?;
        Ok(Life { task: tokio::spawn(server.run_with(listener)), handle, nodes })
    }

    /// Samples until the server is to restart, or `None`: to stop.
    async fn operate(&mut self, life: &mut Life, faults: &mut FaultSource) -> Option<()> {
        loop {
            tokio::select! {
                () = self.stop.cancelled() => return None,
                fault = faults.next() => {
                    tracing::info!(device = DEVICE, ?fault, "fault");
                    let now_s = self.origin.now_s();
                    match fault {
                        Fault::AgentRestart => return Some(()),
                        Fault::ClockJump { by_s } => self.config.clock.offset_s += by_s,
                        Fault::Silence { duration_s } => self.link_lost_until_s = now_s + duration_s,
                        other => self.ills.suffer(other, now_s),
                    }
                    if fault == Fault::WrongIdentity {
                        return Some(());
                    }
                }
                () = tokio::time::sleep_until(self.origin.instant_of(self.last_axis_s())) => {
                    let ripe_s = self.origin.now_s() - self.sweep_s();
                    for cycle in self.cycles.take(ripe_s) {
                        if let Err(why) = life.nodes.set(&life.handle, &self.sample(cycle)) {
                            tracing::error!(why, "{DEVICE} cannot publish its values");
                        }
                    }
                }
            }
        }
    }

    /// When the last axis of the next cycle is sampled, s.
    fn last_axis_s(&self) -> f64 {
        self.cycles.due_s() + self.sweep_s()
    }

    /// From the first axis to the last, s.
    fn sweep_s(&self) -> f64 {
        self.config.stagger_s * self.config.axes.len().saturating_sub(1) as f64
    }

    /// What the controller knows from a cycle. Stamps are counted in cycles: rounding must not bring two nearer than that.
    fn sample(&self, cycle: u64) -> Sampled {
        let shown_s = self.config.clock.offset_s + cycle as f64 / self.config.rate_hz;
        let stamp_ns = self.config.wall_ns_at_origin + (shown_s * 1e9).round() as i64;
        let begin_s = self.cycles.at_s(cycle as f64);
        let link_is_up = begin_s >= self.link_lost_until_s;
        let axes = self.config.axes.iter().enumerate().map(|(k, &letter)| {
            let later_s = k as f64 * self.config.stagger_s;
            let t_s = self.cycles.at_s(cycle as f64 + later_s * self.config.rate_hz);
            let position = self.world.axes(self.ills.seen_s(t_s))[letter];
            let shown = if letter.is_rotary() { position.to_degrees() } else { position };
            (link_is_up.then_some(shown), stamp_ns + (later_s * 1e9).round() as i64)
        });
        let state = link_is_up.then(|| self.world.cycle(begin_s));
        Sampled { axes: axes.collect(), without_link: self.config.without_link, state, stamp_ns }
    }
}
