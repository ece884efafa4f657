//! A broker that lets us in and then reads nothing: it is no broker, and the log says so once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio_util::sync::CancellationToken;
use tracing::level_filters::LevelFilter;
use trunnion_service::board::Board;
use trunnion_service::mqtt::{Broker, MqttConfig, run};
use trunnion_tests::log::Log;

/// MQTT 3.1.1 (sections 3.1 to 3.13): every CONNECT is taken, everything else is answered while `answers`.
async fn serve(mut stream: TcpStream, answers: Arc<AtomicBool>) -> std::io::Result<()> {
    loop {
        let kind = stream.read_u8().await?;
        let mut length = 0;
        for place in 0..4 {
            let part = stream.read_u8().await?;
            length |= usize::from(part & 0x7f) << (7 * place);
            if part & 0x80 == 0 {
                break;
            }
        }
        let mut body = vec![0; length];
        stream.read_exact(&mut body).await?;
        let answer = match kind >> 4 {
            1 => vec![0x20, 2, 0, 0],
            3 => {
                let topic = usize::from(u16::from_be_bytes([body[0], body[1]]));
                vec![0x40, 2, body[2 + topic], body[3 + topic]]
            }
            8 => vec![0x90, 3, body[0], body[1], 1],
            12 => vec![0xd0, 0],
            _ => return Ok(()),
        };
        if kind >> 4 != 1 && !answers.load(Ordering::SeqCst) {
            return std::future::pending().await;
        }
        stream.write_all(&answer).await?;
    }
}

async fn accept(listener: TcpListener, answers: Arc<AtomicBool>, accepted: UnboundedSender<Instant>) {
    while let Ok((stream, _)) = listener.accept().await {
        tokio::spawn(serve(stream, Arc::clone(&answers)));
        if accepted.send(Instant::now()).is_err() {
            return;
        }
    }
}

async fn next(accepted: &mut UnboundedReceiver<Instant>) -> Instant {
    tokio::time::timeout(Duration::from_secs(30), accepted.recv()).await.unwrap().unwrap()
}

#[tokio::test]
async fn a_broker_counts_as_connected_once_it_acknowledges_a_value() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let (answers, (send, mut accepted)) = (Arc::<AtomicBool>::default(), unbounded_channel());
    tokio::spawn(accept(listener, Arc::clone(&answers), send));
    let (log, _logging) = Log::begin(LevelFilter::INFO);
    let broker = Broker { keep_alive: Duration::from_secs(1), ..Broker::local(port) };
    let config = MqttConfig { broker, machine: "m1".into(), sparkplug: None };
    let (board, cancel) = (Board::default(), CancellationToken::new());
    board.set("status", &serde_json::json!({ "state": "online" }));
    let service = tokio::spawn(run(config, board.clone(), cancel.clone()));

    let mut times = Vec::new();
    for _ in 0..4 {
        times.push(next(&mut accepted).await);
        assert!(!board.connections()["broker"].is_empty(), "it has acknowledged nothing");
    }
    let said = log.text();
    assert!(!said.contains("connected to the MQTT broker"), "{said}");
    let stalled = "it takes the connection, but answers nothing after that";
    assert_eq!(said.matches(stalled).count(), 1, "{said}");
    assert_eq!(said.matches("WARN").count(), 1, "{said}");
    // The waits double: 0.25 s, 0.5 s, 1 s after the same time without an answer.
    let waits: Vec<Duration> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(waits[2] > waits[0] + Duration::from_millis(400), "{waits:?}");

    answers.store(true, Ordering::SeqCst);
    log.until("connected to the MQTT broker").await;
    assert_eq!(board.connections()["broker"], "");
    answers.store(false, Ordering::SeqCst);
    log.until("lost the MQTT broker: it answers no more").await;
    assert!(!board.connections()["broker"].is_empty());
    cancel.cancel();
    service.await.unwrap();
}
