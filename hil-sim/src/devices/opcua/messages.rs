//! A stretch of network in front of an OPC UA server that disturbs one of the server's messages.
//!
//! A message is a chunk of the connection protocol: eight bytes of header, of which the last four are its length, little-endian.

use crate::devices::ReplyFault;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::{JoinHandle, JoinSet};

const HEADER_BYTES: usize = 8;
/// The server of the simulated controller sends far smaller ones.
const MOST_BYTES: usize = 1 << 24;

/// The network; it goes with its value.
pub struct Disturbed {
    /// Where the server is reached.
    pub address: SocketAddr,
    passed: Arc<AtomicU64>,
    task: JoinHandle<()>,
}

impl Disturbed {
    /// In front of this server; the message of this number suffers, counted from 0 over all connections. Must be called within a tokio
    /// runtime.
    ///
    /// # Errors
    /// No free port.
    pub async fn start(server: SocketAddr, fault: (u64, ReplyFault)) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        let address = listener.local_addr()?;
        let passed = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&passed);
        let task = tokio::spawn(async move {
            let mut connections = JoinSet::new();
            while let Ok((client, _)) = listener.accept().await {
                let passed = Arc::clone(&counted);
                connections.spawn(async move {
                    if let Err(error) = connect(client, server, fault, &passed).await {
                        tracing::debug!(%error, "connection closed");
                    }
                });
            }
        });
        Ok(Self { address, passed, task })
    }

    /// Messages of the server so far.
    pub fn passed(&self) -> u64 {
        self.passed.load(Ordering::Relaxed)
    }
}

impl Drop for Disturbed {
    fn drop(&mut self) {
        self.task.abort();
    }
}

async fn connect(
    client: TcpStream,
    server: SocketAddr,
    fault: (u64, ReplyFault),
    passed: &AtomicU64,
) -> io::Result<()> {
    let server = TcpStream::connect(server).await?;
    client.set_nodelay(true)?;
    server.set_nodelay(true)?;
    let (mut from_client, to_client) = client.into_split();
    let (from_server, mut to_server) = server.into_split();
    tokio::select! {
        ended = tokio::io::copy(&mut from_client, &mut to_server) => ended.map(|_| ()),
        ended = messages(from_server, to_client, fault, passed) => ended,
    }
}

async fn messages(
    mut from: OwnedReadHalf,
    mut to: OwnedWriteHalf,
    (disturbed, fault): (u64, ReplyFault),
    passed: &AtomicU64,
) -> io::Result<()> {
    let mut held = Vec::new();
    loop {
        let mut message = vec![0; HEADER_BYTES];
        from.read_exact(&mut message).await?;
        let length = u32::from_le_bytes([message[4], message[5], message[6], message[7]]) as usize;
        if !(HEADER_BYTES..=MOST_BYTES).contains(&length) {
            return Err(io::ErrorKind::InvalidData.into());
        }
        message.resize(length, 0);
        from.read_exact(&mut message[HEADER_BYTES..]).await?;
        if passed.fetch_add(1, Ordering::Relaxed) == disturbed {
            match fault {
                ReplyFault::Late(by_s) => tokio::time::sleep(Duration::from_secs_f64(by_s)).await,
                ReplyFault::Doubled => message = message.repeat(2),
                ReplyFault::Dropped => return Ok(()),
                ReplyFault::Cut => return to.write_all(&message[..length / 2]).await,
                ReplyFault::Merged => {
                    held = message;
                    continue;
                }
            }
        }
        held.append(&mut message);
        to.write_all(&std::mem::take(&mut held)).await?;
    }
}
