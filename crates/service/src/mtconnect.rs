//! State and results for an agent of MTConnect: an adapter that serves lines of SHDR over TCP.
//!
//! The agent connects, gets every item once and then what changes. A line is `time|item|value` (MTConnect Part 1, adapter protocol of the
//! reference agent); `* PING` is answered with `* PONG` and the time in ms within which the agent may ask again. Nothing that an agent
//! sends has another effect. Items are kept as their latest value, not queued: a slow agent misses what was replaced meanwhile, never
//! the present.

mod items;

use crate::board::Board;
use crate::clock::{SystemClock, moment};
use crate::plant::PlantView;
pub use items::{Items, items};
use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use tracing::{info, warn};
use trunnion_core::Clock;
use trunnion_core::input::Table;

/// Where it listens without a word in the configuration: the usual port of an adapter.
pub const USUAL_ADDRESS: &str = "127.0.0.1:7878";
/// Agents at once: one that works, one that is set up, and their old connections.
const MOST_AGENTS: usize = 4;
/// Longest line of an agent, bytes: it sends `* PING`.
const LONGEST_LINE: usize = 256;
/// An agent that does not take a line for so long is let go.
const WRITE_LIMIT: Duration = Duration::from_secs(10);
/// Within what the agent may ask again, ms: the usual value of the reference agent.
const HEARTBEAT_MS: u32 = 10_000;

/// `[mtconnect]`: where agents reach us, and which.
#[derive(Clone, Debug, PartialEq)]
pub struct MtConnectConfig {
    /// Where it listens.
    pub listen: SocketAddr,
    /// Computers of the agents; this one alone where the list is empty.
    pub agents: Vec<IpAddr>,
}

impl MtConnectConfig {
    /// Reads the table.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let listen = table.optional_string("listen").unwrap_or_else(|| USUAL_ADDRESS.into());
        let names = table.optional_strings("agents").unwrap_or_default();
        table.no_other_keys();
        let Ok(listen) = listen.parse::<SocketAddr>() else {
            table.problem("listen", format!("\"{listen}\" is no address"), "such as 127.0.0.1:7878", "");
            return None;
        };
        let agents: Result<Vec<IpAddr>, _> = names.iter().map(|name| name.parse()).collect();
        let Ok(agents) = agents else {
            table.problem("agents", "holds what is no address", "such as [\"192.168.1.20\"]", "");
            return None;
        };
        if !listen.ip().is_loopback() && agents.is_empty() {
            let found = format!("{listen} can be reached from other computers");
            let advice = "The protocol has no password: name the computers of the agents.";
            table.problem("listen", found, "an address of this computer, or agents = [\"address\"]", advice);
            return None;
        }
        Some(Self { listen, agents })
    }

    fn lets_in(&self, peer: IpAddr) -> bool {
        peer.is_loopback() || self.agents.contains(&peer.to_canonical())
    }
}

/// Serves agents until `cancel`.
pub async fn serve(listener: TcpListener, config: MtConnectConfig, board: Board, cancel: CancellationToken) {
    let (now, items_now) = watch::channel(Arc::new(items(&PlantView::of(&board))));
    let mut agents = JoinSet::new();
    tokio::select! {
        () = cancel.cancelled() => {}
        () = follow(board, now) => {}
        () = accept(listener, config, items_now, &cancel, &mut agents) => {}
    }
    // Each says that nothing is available any more, within its limit.
    while agents.join_next().await.is_some() {}
}

/// Keeps the items as the board has them.
async fn follow(board: Board, now: watch::Sender<Arc<Items>>) {
    let mut changes = board.changes();
    while changes.changed().await.is_ok() {
        let items = items(&PlantView::of(&board));
        now.send_if_modified(|known| {
            let is_new = **known != items;
            if is_new {
                *known = Arc::new(items);
            }
            is_new
        });
    }
}

async fn accept(
    listener: TcpListener,
    config: MtConnectConfig,
    now: watch::Receiver<Arc<Items>>,
    cancel: &CancellationToken,
    agents: &mut JoinSet<()>,
) {
    let places = Arc::new(Semaphore::new(MOST_AGENTS));
    loop {
        let (stream, peer) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                warn!(%error, "no MTConnect agent can connect at present");
                tokio::time::sleep(Duration::from_millis(100)).await;
                continue;
            }
        };
        if !config.lets_in(peer.ip()) {
            warn!(%peer, "refused: not among the agents of [mtconnect]");
            continue;
        }
        let Ok(place) = places.clone().try_acquire_owned() else {
            warn!(%peer, "refused: {MOST_AGENTS} MTConnect agents are connected");
            continue;
        };
        let (now, cancel) = (now.clone(), cancel.child_token());
        while agents.try_join_next().is_some() {}
        agents.spawn(async move {
            info!(%peer, "an MTConnect agent is connected");
            match converse(stream, now, cancel).await {
                Ok(()) => info!(%peer, "the MTConnect agent is gone"),
                Err(error) => warn!(%peer, %error, "the MTConnect agent is let go"),
            }
            drop(place);
        });
    }
}

/// Sends what is new, answers pings, and says at the end that nothing is available any more.
async fn converse(
    mut stream: TcpStream,
    mut now: watch::Receiver<Arc<Items>>,
    cancel: CancellationToken,
) -> io::Result<()> {
    let mut sent = BTreeMap::new();
    let (mut line, mut buffer) = (Vec::new(), [0; LONGEST_LINE]);
    loop {
        let items = now.borrow_and_update().clone();
        send(&mut stream, &items, &mut sent).await?;
        tokio::select! {
            () = cancel.cancelled() => return send(&mut stream, &items::gone(), &mut sent).await,
            changed = now.changed() => if changed.is_err() {
                return send(&mut stream, &items::gone(), &mut sent).await;
            },
            read = stream.read(&mut buffer) => match read? {
                0 => return Ok(()),
                bytes => for byte in &buffer[..bytes] {
                    match byte {
                        b'\n' => if std::mem::take(&mut line).starts_with(b"* PING") {
                            write(&mut stream, &format!("* PONG {HEARTBEAT_MS}\n")).await?;
                        },
                        _ if line.len() == LONGEST_LINE => {
                            return Err(io::Error::new(io::ErrorKind::InvalidData, "it sends more than pings"));
                        }
                        byte => line.push(*byte),
                    }
                },
            },
        }
    }
}

async fn send(
    stream: &mut TcpStream,
    items: &Items,
    sent: &mut BTreeMap<&'static str, String>,
) -> io::Result<()> {
    let time = moment(SystemClock::start().wall_ns());
    for (item, value) in items {
        if sent.get(item) != Some(value) {
            write(stream, &format!("{time}|{item}|{value}\n")).await?;
            sent.insert(item, value.clone());
        }
    }
    Ok(())
}

async fn write(stream: &mut TcpStream, text: &str) -> io::Result<()> {
    timeout(WRITE_LIMIT, stream.write_all(text.as_bytes()))
        .await
        .unwrap_or_else(|_| Err(io::Error::new(io::ErrorKind::TimedOut, "it does not take what is sent")))
}
