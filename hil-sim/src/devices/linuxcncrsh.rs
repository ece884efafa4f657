//! LinuxCNC's text interface over TCP.
//!
//! Positions are those of the last task cycle, as LinuxCNC's displays see them; six joints are reported whatever the
//! machine has. Source of the words: [`trunnion_protocol::linuxcncrsh`].

use super::clock::TimeOrigin;
use super::faults::{Fault, FaultSource, ReplyFault, ScheduledFault, damage};
use super::handle::{Address, DeviceError, FAULT_QUEUE, Handle};
use super::world::World;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use trunnion_core::Joint;
use trunnion_protocol::linuxcncrsh::{
    Item, JointUnit, Lines, ProgramStatus, Reply, Request, parse_request, write_reply,
};

/// Joints in every answer of LinuxCNC 2.9.
const JOINTS_REPORTED: usize = 6;
const DEVICE: &str = "linuxcncrsh";

/// A LinuxCNC.
#[derive(Debug, Clone, PartialEq)]
pub struct ServerConfig {
    /// Where to listen; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Name of the server.
    pub server: String,
    /// Connection password.
    pub password: String,
    /// Axes in the order of the joints, at most six.
    pub joints: Vec<Joint>,
    /// Positions are renewed so often, s.
    pub cycle_s: f64,
    /// Every so many answers to positions is cut to two joints, as the real one does when two connections ask at once;
    /// 0 for none.
    pub mixed_every: u64,
    /// What happens to the reply of this number, counted from 0 over all connections.
    pub reply_fault: Option<(u64, ReplyFault)>,
}

impl Default for ServerConfig {
    fn default() -> Self {
        use trunnion_core::axis::iso::{B, C, X, Y, Z};
        Self {
            listen: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            server: "EMCNETSVR".into(),
            password: "EMC".into(),
            joints: vec![X, Y, Z, B, C],
            cycle_s: 0.01,
            mixed_every: 0,
            reply_fault: None,
        }
    }
}

/// Starts the server. Must be called within a tokio runtime.
///
/// # Errors
/// An impossible setting or fault, or an address that cannot be listened on.
pub async fn spawn(
    world: Arc<dyn World>,
    config: ServerConfig,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    if !(1e-4..=1.0).contains(&config.cycle_s) {
        let (found, allowed) = (config.cycle_s, "0.0001..=1");
        return Err(DeviceError::Setting { device: DEVICE, setting: "cycle_s", found, allowed });
    }
    if let Some(bad) = faults.iter().find(|scheduled| !can_have(&scheduled.fault)) {
        return Err(DeviceError::Fault { device: DEVICE, fault: bad.fault });
    }
    let failed = |source| DeviceError::Listen { address: config.listen, source };
    let listener = TcpListener::bind(config.listen).await.map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let (commands, commanded) = mpsc::channel(FAULT_QUEUE);
    let faults = FaultSource::new(origin, faults, commanded);
    let stop = CancellationToken::new();
    let server = Arc::new(Server {
        world,
        config,
        origin,
        ills: Mutex::default(),
        positions_answered: AtomicU64::default(),
        replied: AtomicU64::default(),
    });
    let task = tokio::spawn(run(server, listener, address, faults, stop.clone()));
    let lost_bytes = Arc::new(AtomicU64::new(0));
    Ok(Handle::new(Address::Tcp(address), (commands, can_have), lost_bytes, stop, task))
}

fn can_have(fault: &Fault) -> bool {
    let own = matches!(fault, Fault::AgentRestart | Fault::WrongIdentity | Fault::StuckValue { .. });
    fault.is_possible() && (fault.is_of_the_line() || own)
}

struct Server {
    world: Arc<dyn World>,
    config: ServerConfig,
    origin: TimeOrigin,
    ills: Mutex<Ills>,
    positions_answered: AtomicU64,
    replied: AtomicU64,
}

/// Faults under way; times of the cell, s.
#[derive(Default)]
struct Ills {
    silent_until_s: f64,
    /// Positions are those of the first time until the second.
    stuck_s: Option<(f64, f64)>,
    garble: usize,
    is_another: bool,
}

/// Serves until stopped; a pulled cable or a restart drops all connections.
async fn run(
    server: Arc<Server>,
    mut listener: TcpListener,
    address: SocketAddr,
    mut faults: FaultSource,
    stop: CancellationToken,
) {
    loop {
        let Some(away_s) = serve(&server, &listener, &mut faults, &stop).await else { return };
        drop(listener);
        let back = server.origin.instant_of(server.origin.now_s() + away_s);
        tokio::select! {
            () = stop.cancelled() => return,
            () = tokio::time::sleep_until(back) => {}
        }
        listener = match TcpListener::bind(address).await {
            Ok(listener) => listener,
            Err(error) => return tracing::error!(%error, %address, "{DEVICE} cannot listen again"),
        };
    }
}

/// Serves until the network goes: for how long, s. `None` when stopped.
async fn serve(
    server: &Arc<Server>,
    listener: &TcpListener,
    faults: &mut FaultSource,
    stop: &CancellationToken,
) -> Option<f64> {
    // Dropping the set closes its connections.
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            () = stop.cancelled() => return None,
            fault = faults.next() => {
                tracing::info!(device = DEVICE, ?fault, "fault");
                let now_s = server.origin.now_s();
                let mut ills = server.ills();
                match fault {
                    Fault::GarbleBytes { count } => ills.garble += count,
                    Fault::Silence { duration_s } => ills.silent_until_s = now_s + duration_s,
                    Fault::StuckValue { duration_s } => ills.stuck_s = Some((now_s, now_s + duration_s)),
                    Fault::WrongIdentity => {
                        ills.is_another = true;
                        return Some(0.0);
                    }
                    Fault::AgentRestart => return Some(0.0),
                    Fault::Unplug { duration_s } => return Some(duration_s),
                    _ => {} // not among those it can have
                }
            }
            Some(ended) = connections.join_next() => {
                if let Err(error) = ended {
                    tracing::error!(%error, "a connection ended badly");
                }
            }
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) => {
                    let server = Arc::clone(server);
                    connections.spawn(async move {
                        if let Err(error) = server.converse(stream).await {
                            tracing::debug!(%error, "connection closed");
                        }
                    });
                }
                Err(error) => tracing::warn!(%error, "a connection was not accepted"),
            },
        }
    }
}

impl Server {
    async fn converse(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_nodelay(true)?;
        let (mut lines, mut bytes) = (Lines::default(), [0; 1024]);
        // Requests are repeated after hello, unless that is switched off.
        let (mut known, mut echo) = (false, true);
        let mut held = Vec::new();
        loop {
            let count = stream.read(&mut bytes).await?;
            if count == 0 {
                return Ok(());
            }
            for line in lines.push(&bytes[..count]) {
                if self.origin.now_s() < self.ills().silent_until_s {
                    continue;
                }
                let repeated = if known && echo { line.clone() + "\r\n" } else { String::new() };
                let request = parse_request(&line);
                known |= matches!(request, Some(Request::Hello { .. }));
                echo &= request != Some(Request::EchoOff);
                let reply = self.reply(request, echo, &line).map(|reply| write_reply(&reply));
                let mut answer = std::mem::take(&mut held);
                answer.extend(repeated.into_bytes());
                if let Some(reply) = reply {
                    match self.reply_fault() {
                        None => answer.extend(reply.into_bytes()),
                        Some(ReplyFault::Doubled) => answer.extend(reply.repeat(2).into_bytes()),
                        Some(ReplyFault::Dropped) => {}
                        Some(ReplyFault::Cut) => answer.extend(&reply.as_bytes()[..reply.len() / 2]),
                        Some(ReplyFault::Merged) => held = reply.into_bytes(),
                        Some(ReplyFault::Late(by_s)) => {
                            answer.extend(reply.into_bytes());
                            tokio::time::sleep(Duration::from_secs_f64(by_s)).await;
                        }
                    }
                }
                stream.write_all(&self.outgoing(answer)).await?;
            }
        }
    }

    /// What happens to the reply that is written now.
    fn reply_fault(&self) -> Option<ReplyFault> {
        let number = self.replied.fetch_add(1, Ordering::Relaxed);
        self.config.reply_fault.filter(|(of, _)| *of == number).map(|(_, fault)| fault)
    }

    fn reply(&self, request: Option<Request>, echo: bool, line: &str) -> Option<Reply> {
        let now_s = self.origin.now_s();
        let (stuck_s, is_another) = {
            let ills = self.ills();
            (ills.stuck_s.filter(|(_, until_s)| now_s < *until_s), ills.is_another)
        };
        let joints = if is_another { &[Joint::X, Joint::Z][..] } else { &self.config.joints };
        // A joint that the machine has not got is reported as a linear one at zero.
        let joint = |k: usize| joints.get(k).copied();
        let cycle = self.world.cycle(now_s);
        let Some(request) = request else {
            return Some(Reply::Refused(format!("{} NAK", line.to_uppercase())));
        };
        Some(match request {
            Request::EchoOff => return None,
            Request::Hello { password } if password != self.config.password => Reply::HelloRefused,
            Request::Hello { .. } => Reply::Hello {
                server: if is_another { "LATHE".into() } else { self.config.server.clone() },
                version: "1.1".into(),
            },
            Request::Get(Item::Echo) => Reply::Echo(echo),
            Request::Get(Item::JointPos) => {
                let t_s = stuck_s.map_or(now_s, |(since_s, _)| since_s);
                let axes = self.world.axes((t_s / self.config.cycle_s).floor() * self.config.cycle_s);
                let shown = |letter: Joint| {
                    if letter.is_rotary() { axes[letter].to_degrees() } else { axes[letter] }
                };
                let answered = self.positions_answered.fetch_add(1, Ordering::Relaxed) + 1;
                let is_mixed =
                    self.config.mixed_every > 0 && answered.is_multiple_of(self.config.mixed_every);
                let reported = if is_mixed { 2 } else { JOINTS_REPORTED };
                Reply::JointPos((0..reported).map(|k| joint(k).map_or(0.0, shown)).collect())
            }
            Request::Get(Item::JointUnits) => {
                let unit = |k| match joint(k) {
                    Some(letter) if letter.is_rotary() => JointUnit::Degree,
                    _ => JointUnit::Mm,
                };
                Reply::JointUnits((0..JOINTS_REPORTED).map(unit).collect())
            }
            Request::Get(Item::ProgramStatus) => {
                Reply::ProgramStatus(if cycle.running { ProgramStatus::Running } else { ProgramStatus::Idle })
            }
            Request::Get(Item::Program) => {
                Reply::Program(Some(cycle.program).filter(|name| !name.is_empty()))
            }
            Request::Get(Item::ProgramLine) => Reply::ProgramLine(cycle.block as u32),
        })
    }

    fn outgoing(&self, mut bytes: Vec<u8>) -> Vec<u8> {
        damage(&mut bytes, &mut self.ills().garble, 0);
        bytes
    }

    /// The data behind the lock is whole even when a task died holding it: every change is a single step.
    fn ills(&self) -> MutexGuard<'_, Ills> {
        self.ills.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
