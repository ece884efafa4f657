//! A stretch of network in front of a server on TCP. It can be cut (connections are dropped, new ones refused), freeze
//! (connections stay and carry nothing, new ones are taken and hear nothing), and damage what the server says.

use super::clock::TimeOrigin;
use super::faults::{Fault, FaultSource, ScheduledFault, damage};
use super::handle::{DeviceError, FAULT_QUEUE, Handle};
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

/// Connections carried at a time; further ones wait in the kernel's queue.
const MAX_CONNECTIONS: usize = 32;
/// The server is on this computer.
const CONNECT_LIMIT: Duration = Duration::from_secs(2);
const DEVICE: &str = "network";

/// Puts a network in front of the device, which is reached at `listen` from now on; the handle is that of both. Must be
/// called within a tokio runtime.
///
/// # Errors
/// A device that is not on TCP, a fault that neither can have, or an address that cannot be listened on.
pub async fn in_front_of(
    device: Handle,
    listen: SocketAddr,
    origin: TimeOrigin,
    faults: &[ScheduledFault],
) -> Result<Handle, DeviceError> {
    if let Some(bad) = faults.iter().find(|scheduled| !can_have(&scheduled.fault)) {
        return Err(DeviceError::Fault { device: DEVICE, fault: bad.fault });
    }
    let failed = |source| DeviceError::Listen { address: listen, source };
    let not_on_tcp = || failed(io::Error::other("the device behind it is not on TCP"));
    let server = device.address().socket().ok_or_else(not_on_tcp)?;
    let listener = TcpListener::bind(listen).await.map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let (commands, commanded) = mpsc::channel(FAULT_QUEUE);
    let stop = CancellationToken::new();
    let relay = Relay { address, server, origin, stop: stop.clone(), damage_left: Arc::default() };
    let task = tokio::spawn(relay.run(listener, FaultSource::new(origin, faults, commanded)));
    let shown = device.address().at(address);
    let lost_bytes = Arc::new(AtomicU64::new(0));
    Ok(Handle::new(shown, (commands, can_have), lost_bytes, stop, task).in_front_of(device))
}

pub(super) fn can_have(fault: &Fault) -> bool {
    let own = matches!(fault, Fault::Freeze { .. } | Fault::Unplug { .. } | Fault::GarbleBytes { .. });
    fault.is_possible() && own
}

struct Relay {
    address: SocketAddr,
    server: SocketAddr,
    origin: TimeOrigin,
    stop: CancellationToken,
    /// Bytes of the server still to damage.
    damage_left: Arc<AtomicUsize>,
}

impl Relay {
    async fn run(self, mut listener: TcpListener, mut faults: FaultSource) {
        let frozen = watch::Sender::new(false);
        let mut thaw_s = 0.0;
        let mut connections = JoinSet::new();
        loop {
            let is_frozen = *frozen.borrow();
            tokio::select! {
                () = self.stop.cancelled() => return,
                fault = faults.next() => {
                    tracing::info!(device = DEVICE, ?fault, "fault");
                    match fault {
                        Fault::GarbleBytes { count } => {
                            self.damage_left.fetch_add(count, Ordering::Relaxed);
                        }
                        Fault::Freeze { duration_s } => {
                            thaw_s = self.origin.now_s() + duration_s;
                            frozen.send_replace(true);
                        }
                        Fault::Unplug { duration_s } => {
                            drop(listener);
                            connections.shutdown().await;
                            listener = match self.back_after(duration_s).await {
                                Some(listener) => listener,
                                None => return,
                            };
                        }
                        _ => {} // not among those it can have
                    }
                }
                () = tokio::time::sleep_until(self.origin.instant_of(thaw_s)), if is_frozen => {
                    frozen.send_replace(false);
                }
                Some(ended) = connections.join_next() => {
                    if let Err(error) = ended {
                        tracing::error!(%error, "a connection ended badly");
                    }
                }
                accepted = listener.accept(), if connections.len() < MAX_CONNECTIONS => match accepted {
                    Ok((client, _)) => {
                        let (server, left) = (self.server, Arc::clone(&self.damage_left));
                        let frozen = frozen.subscribe();
                        connections.spawn(async move {
                            if let Err(error) = connect(client, server, frozen, &left).await {
                                tracing::debug!(%error, "connection closed");
                            }
                        });
                    }
                    Err(error) => tracing::warn!(%error, "a connection was not accepted"),
                },
            }
        }
    }

    /// The cable is put back; `None` when stopped before.
    async fn back_after(&self, duration_s: f64) -> Option<TcpListener> {
        let back = self.origin.instant_of(self.origin.now_s() + duration_s);
        tokio::select! {
            () = self.stop.cancelled() => return None,
            () = tokio::time::sleep_until(back) => {}
        }
        match TcpListener::bind(self.address).await {
            Ok(listener) => Some(listener),
            Err(error) => {
                tracing::error!(%error, address = %self.address, "the network cannot be put back");
                None
            }
        }
    }
}

/// One connection, until either end closes it.
async fn connect(
    client: TcpStream,
    server: SocketAddr,
    mut frozen: watch::Receiver<bool>,
    damage_left: &AtomicUsize,
) -> io::Result<()> {
    flows(&mut frozen).await?;
    let server = timeout(CONNECT_LIMIT, TcpStream::connect(server)).await??;
    client.set_nodelay(true)?;
    server.set_nodelay(true)?;
    let (from_client, to_client) = client.into_split();
    let (from_server, to_server) = server.into_split();
    let nothing = AtomicUsize::new(0);
    tokio::select! {
        ended = carry(from_client, to_server, frozen.clone(), &nothing) => ended,
        ended = carry(from_server, to_client, frozen, damage_left) => ended,
    }
}

/// One direction, until its sender closes it.
async fn carry(
    mut from: impl AsyncRead + Unpin,
    mut to: impl AsyncWrite + Unpin,
    mut frozen: watch::Receiver<bool>,
    damage_left: &AtomicUsize,
) -> io::Result<()> {
    let mut bytes = [0; 8192];
    loop {
        let count = from.read(&mut bytes).await?;
        if count == 0 {
            return Ok(());
        }
        flows(&mut frozen).await?;
        let take = |left: usize| Some(left - left.min(count));
        let left = damage_left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take);
        damage(&mut bytes[..count], &mut left.unwrap_or_default(), 0);
        to.write_all(&bytes[..count]).await?;
    }
}

async fn flows(frozen: &mut watch::Receiver<bool>) -> io::Result<()> {
    frozen.wait_for(|frozen| !frozen).await.map_err(io::Error::other)?;
    Ok(())
}
