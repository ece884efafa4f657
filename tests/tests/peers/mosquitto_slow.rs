//! A real broker behind a slow line: it is not lost, every topic comes to its latest value, and no sample is missing.

use crate::mosquitto::{broker, standing_service, wait_for};
use std::io;
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tracing::level_filters::LevelFilter;
use trunnion::results::{Condition, ServiceStatus};
use trunnion_service::board::Board;
use trunnion_tests::log::Log;
use trunnion_tests::page_status::free_port;

/// A poor modem. What a service says once, some 10 kB, takes 3 s of it, and the topics below are 25 times as much as it carries.
const BYTES_PER_S: u64 = 3000;
/// Long enough for the broker to be missed twice: it is asked every 10 s, and missed after 20 s without an answer.
const BUSY: Duration = Duration::from_secs(45);

async fn slowly(mut from: impl AsyncRead + Unpin, mut to: impl AsyncWrite + Unpin) -> io::Result<()> {
    let mut bytes = [0; 300];
    loop {
        match from.read(&mut bytes).await? {
            0 => return to.shutdown().await,
            count => to.write_all(&bytes[..count]).await?,
        }
        tokio::time::sleep(Duration::from_millis(1000 * bytes.len() as u64 / BYTES_PER_S)).await;
    }
}

async fn line(listener: TcpListener, port: u16) -> io::Result<()> {
    loop {
        let (near, _) = listener.accept().await?;
        let far = TcpStream::connect(("127.0.0.1", port)).await?;
        let ((from_near, to_near), (from_far, to_far)) = (near.into_split(), far.into_split());
        tokio::spawn(slowly(from_near, to_far));
        tokio::spawn(slowly(from_far, to_near));
    }
}

#[tokio::test]
#[ignore = "a peer test: tests/peers/run"]
async fn a_broker_behind_a_slow_line_gets_the_latest_of_every_topic() {
    let port = free_port();
    let _broker = broker(port);
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let near = listener.local_addr().unwrap().port();
    tokio::spawn(line(listener, port));
    let (log, _logging) = Log::begin(LevelFilter::INFO);
    let (folder, board) = (tempfile::tempdir().unwrap(), Board::default());
    let (cell, cancel, service) = standing_service(near, folder.path(), [0.0; 3], board.clone()).await;

    // Four topics of 1 kB, each set twenty times a second.
    let filler = "x".repeat(1000);
    let (began, mut count) = (Instant::now(), 0);
    let mut ticks = tokio::time::interval(Duration::from_millis(50));
    while began.elapsed() < BUSY {
        ticks.tick().await;
        count += 1;
        for topic in ["a", "b", "c", "d"] {
            board.set(topic, &serde_json::json!({ "count": count, "filler": filler }));
        }
    }
    wait_for(port, "latest", |topics| {
        let is_latest = |name: &&str| {
            topics.get(&format!("trunnion/m/{name}")).is_some_and(|topic| topic["count"] == count)
        };
        let is_well = |status: &serde_json::Value| {
            let status: ServiceStatus = serde_json::from_value(status.clone()).unwrap();
            assert!(status.devices.values().all(|device| device.lost_messages == 0), "{:?}", status.devices);
            status.health.unwrap().parts["broker"].state == Condition::Good && status.devices.len() == 3
        };
        ["a", "b", "c", "d"].iter().all(is_latest) && topics.get("trunnion/m/status").is_some_and(is_well)
    })
    .await;
    let said = log.text();
    assert_eq!(said.matches("connected to the MQTT broker").count(), 1, "{said}");
    assert!(!said.contains("lost the MQTT broker"), "{said}");
    cancel.cancel();
    service.await.unwrap().unwrap();
    cell.shutdown().await;
}
