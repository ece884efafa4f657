//! Who reads along in a long run: a browser at the page, and somebody at the broker.

use anyhow::Context;
use rumqttc::{AsyncClient, Event, MqttOptions, Packet, QoS};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;

/// From losing what is read to asking again.
const AGAIN: Duration = Duration::from_secs(1);

/// The answer of a run is larger than the library takes by itself, bytes.
const LARGEST_MESSAGE: usize = 1 << 20;

/// What one of them got.
#[derive(Default)]
pub struct Received {
    messages: AtomicU64,
    connections: AtomicU64,
    longest_wait_ms: AtomicU64,
}

impl Received {
    /// Messages so far.
    pub fn messages(&self) -> u64 {
        self.messages.load(Ordering::Relaxed)
    }

    /// Connections made; one when none was lost.
    pub fn connections(&self) -> u64 {
        self.connections.load(Ordering::Relaxed)
    }

    /// The longest time without a message while connected, ms.
    pub fn longest_wait_ms(&self) -> u64 {
        self.longest_wait_ms.load(Ordering::Relaxed)
    }

    fn connected(&self) -> Instant {
        self.connections.fetch_add(1, Ordering::Relaxed);
        Instant::now()
    }

    fn took(&self, last: &mut Instant) {
        self.messages.fetch_add(1, Ordering::Relaxed);
        self.longest_wait_ms.fetch_max(last.elapsed().as_millis() as u64, Ordering::Relaxed);
        *last = Instant::now();
    }
}

/// Reads the events of the page at this address for ever.
pub async fn page(address: String, received: Arc<Received>) {
    loop {
        if let Err(error) = events(&address, &received).await {
            eprintln!("page: {error:#}");
        }
        tokio::time::sleep(AGAIN).await;
    }
}

async fn events(address: &str, received: &Received) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect(address).await.context("cannot connect")?;
    let request = format!("GET /api/live HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await?;
    let mut last = received.connected();
    let mut lines = BufReader::new(stream).lines();
    while let Some(line) = lines.next_line().await? {
        if line.starts_with("event:") {
            received.took(&mut last);
        }
    }
    anyhow::bail!("the page ended the connection")
}

/// Reads every topic of the broker at this port for ever.
pub async fn broker(port: u16, received: Arc<Received>) {
    loop {
        let mut options = MqttOptions::new("soak", "127.0.0.1", port);
        options.set_keep_alive(Duration::from_secs(5));
        options.set_max_packet_size(LARGEST_MESSAGE, LARGEST_MESSAGE);
        let (client, mut polled) = AsyncClient::new(options, 16);
        if let Err(error) = client.subscribe("trunnion/#", QoS::AtMostOnce).await {
            eprintln!("broker: {error}");
        }
        let mut last = Instant::now();
        loop {
            match polled.poll().await {
                Ok(Event::Incoming(Packet::ConnAck(_))) => last = received.connected(),
                Ok(Event::Incoming(Packet::Publish(_))) => received.took(&mut last),
                Ok(_) => {}
                Err(error) => break eprintln!("broker: {error}"),
            }
        }
        tokio::time::sleep(AGAIN).await;
    }
}
