//! Who attacks the page: a process of its own, from many addresses of this computer, as fast and as slowly as it can.

use anyhow::Context;
use std::collections::BTreeMap;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, timeout, timeout_at};

/// What each attack got, by its words, and how often.
pub type Attempts = BTreeMap<String, BTreeMap<String, u64>>;

/// One kind of attempt.
#[derive(Clone, Copy, Debug)]
enum Attack {
    Silent,
    SlowHead,
    SlowBody,
    LargeBody,
    EndlessBody,
    Requests,
    Unread,
    Garbage,
}

/// Each with its words, and how many go on at once.
const ATTACKS: [(Attack, &str, usize); 8] = [
    (Attack::Silent, "connections that say nothing", 200),
    (Attack::SlowHead, "heads of a byte a second", 50),
    (Attack::SlowBody, "bodies of a byte a second", 50),
    (Attack::LargeBody, "bodies of 1 GB", 8),
    (Attack::EndlessBody, "bodies without an end, in chunks", 8),
    (Attack::Requests, "calls as fast as they go", 16),
    (Attack::Unread, "streams of events that nobody reads", 50),
    (Attack::Garbage, "bytes that are no HTTP", 8),
];
/// The attempts come from so many addresses: each counts as a computer of its own.
pub const ADDRESSES: usize = 24;
/// Calls over one connection.
const CALLS: usize = 100;
/// Longest wait for an answer or for the end of a connection.
const TIME_LIMIT: Duration = Duration::from_secs(20);
/// Between two bytes of who is slow.
const SLOWLY: Duration = Duration::from_secs(1);
/// One that was refused tries again.
const AGAIN: Duration = Duration::from_millis(20);

/// Waits, then attacks for so long, each kind alone and in the end all at once, for equal times; prints what each attempt got.
pub fn run(address: SocketAddr, after_s: f64, seconds: f64) -> anyhow::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let got = Arc::new(Mutex::new(Attempts::new()));
    runtime.context("cannot start the runtime")?.block_on(async {
        sleep(Duration::from_secs_f64(after_s)).await;
        let alone = ATTACKS.map(|(attack, words, at_once)| vec![(attack, words.to_owned(), at_once)]);
        let together =
            ATTACKS.map(|(attack, words, at_once)| (attack, format!("all at once: {words}"), at_once));
        let phases: Vec<Vec<_>> = alone.into_iter().chain([together.to_vec()]).collect();
        let length = Duration::from_secs_f64(seconds / phases.len() as f64);
        for phase in phases {
            let end = Instant::now() + length;
            let mut attackers = JoinSet::new();
            // By turns: who says nothing must not be there before all others.
            for number in 0..phase.iter().map(|(_, _, at_once)| *at_once).max().unwrap_or(0) {
                for (attack, words, _) in phase.iter().filter(|(_, _, at_once)| number < *at_once) {
                    let from = Ipv4Addr::new(127, 0, 1, (1 + number % ADDRESSES) as u8);
                    attackers.spawn(go_on(*attack, words.clone(), (from, address), end, Arc::clone(&got)));
                }
            }
            while attackers.join_next().await.is_some() {}
        }
    });
    let got = got.lock().unwrap_or_else(PoisonError::into_inner);
    println!("{}", serde_json::to_string(&*got)?);
    Ok(())
}

/// Tries again and again; what is not over at the end is let go.
async fn go_on(
    attack: Attack,
    words: String,
    (from, to): (Ipv4Addr, SocketAddr),
    end: Instant,
    got: Arc<Mutex<Attempts>>,
) {
    let took = |answer: String| {
        let mut got = got.lock().unwrap_or_else(PoisonError::into_inner);
        *got.entry(words.clone()).or_default().entry(answer).or_default() += 1;
    };
    while Instant::now() < end {
        let tried = async {
            match connected(from, to).await {
                Err(error) => took(format!("no connection: {error}")),
                Ok(mut stream) if matches!(attack, Attack::Requests) => {
                    for _ in 0..CALLS {
                        let answer = answer(&mut stream, &call("GET /api/runs", "", to), true).await;
                        let is_over = answer == CLOSED;
                        took(answer);
                        if is_over {
                            break;
                        }
                    }
                }
                Ok(mut stream) => took(attempt(attack, &mut stream, to).await),
            }
        };
        if timeout_at(end, tried).await.is_err() {
            took("held until the end".into());
        }
        sleep(AGAIN).await;
    }
}

const CLOSED: &str = "closed without an answer";

async fn connected(from: Ipv4Addr, to: SocketAddr) -> Result<TcpStream, io::ErrorKind> {
    let socket = TcpSocket::new_v4().map_err(|error| error.kind())?;
    socket.bind((from, 0).into()).map_err(|error| error.kind())?;
    match timeout(TIME_LIMIT, socket.connect(to)).await {
        Ok(connected) => connected.map_err(|error| error.kind()),
        Err(_) => Err(io::ErrorKind::TimedOut),
    }
}

async fn attempt(attack: Attack, stream: &mut TcpStream, to: SocketAddr) -> String {
    let post = |headers: &str| {
        call(
            "POST /api/runs/none/model/gravity-sag:B",
            &format!("x-trunnion: 1\r\ncontent-type: application/json\r\n{headers}"),
            to,
        )
    };
    match attack {
        Attack::Silent => answer(stream, "", false).await,
        Attack::SlowHead => slowly(stream, call("GET /api/runs", "", to).as_bytes()).await,
        Attack::SlowBody => {
            let head = post("content-length: 16000\r\n");
            match stream.write_all(head.as_bytes()).await {
                Ok(()) => slowly(stream, &[b' '; 16_000]).await,
                Err(_) => CLOSED.into(),
            }
        }
        Attack::LargeBody => filled(stream, &post("content-length: 1000000000\r\n"), &[b' '; 65_536]).await,
        Attack::EndlessBody => {
            let chunk = format!("{:x}\r\n{}\r\n", 65_536, " ".repeat(65_536));
            filled(stream, &post("transfer-encoding: chunked\r\n"), chunk.as_bytes()).await
        }
        Attack::Unread => {
            let first = answer(stream, &call("GET /api/live", "", to), false).await;
            sleep(TIME_LIMIT).await;
            first
        }
        Attack::Garbage => {
            let bytes: String = (0..4096_u32).map(|k| char::from((k * 7919 % 94 + 33) as u8)).collect();
            answer(stream, &bytes, false).await
        }
        Attack::Requests => answer(stream, &call("GET /api/runs", "", to), true).await,
    }
}

fn call(line: &str, headers: &str, to: SocketAddr) -> String {
    format!("{line} HTTP/1.1\r\nhost: {to}\r\n{headers}\r\n")
}

/// Sends, and reads the first line of an answer; all of it where more calls follow.
async fn answer(stream: &mut TcpStream, request: &str, goes_on: bool) -> String {
    if stream.write_all(request.as_bytes()).await.is_err() {
        return CLOSED.into();
    }
    read(stream, goes_on).await
}

async fn read(stream: &mut TcpStream, goes_on: bool) -> String {
    let mut bytes = [0; 16_384];
    let mut read = 0;
    let whole = async {
        loop {
            match stream.read(&mut bytes[read..]).await {
                Ok(0) | Err(_) => break,
                Ok(more) => read += more,
            }
            let text = String::from_utf8_lossy(&bytes[..read]);
            if (!goes_on && text.contains("\r\n")) || is_whole(&text) || read == bytes.len() {
                break;
            }
        }
    };
    if timeout(TIME_LIMIT, whole).await.is_err() && read == 0 {
        return format!("nothing for {} s", TIME_LIMIT.as_secs());
    }
    status(&bytes[..read])
}

/// The status of an answer that begins so.
fn status(first: &[u8]) -> String {
    let text = String::from_utf8_lossy(first);
    match text.split(' ').nth(1) {
        Some(status) if text.starts_with("HTTP/") => status.into(),
        _ => CLOSED.into(),
    }
}

/// True where an answer has its head and the length that it states.
fn is_whole(text: &str) -> bool {
    let Some((head, body)) = text.split_once("\r\n\r\n") else { return false };
    let head = head.to_lowercase();
    let length = head.lines().find_map(|line| line.strip_prefix("content-length: ")?.parse().ok());
    length.is_some_and(|length: usize| body.len() >= length)
}

/// Sends a byte a second until there is an answer.
async fn slowly(stream: &mut TcpStream, bytes: &[u8]) -> String {
    let begun = Instant::now();
    for byte in bytes {
        if stream.write_all(&[*byte]).await.is_err() {
            return CLOSED.into();
        }
        let mut seen = [0; 1];
        match timeout(SLOWLY, stream.peek(&mut seen)).await {
            Ok(Ok(0) | Err(_)) => return CLOSED.into(),
            Ok(Ok(_)) => return read(stream, false).await,
            Err(_) if begun.elapsed() >= TIME_LIMIT => {
                return format!("taken for {} s", TIME_LIMIT.as_secs());
            }
            Err(_) => {}
        }
    }
    read(stream, false).await
}

/// Sends without an end until there is an answer, or nobody takes it.
async fn filled(stream: &mut TcpStream, head: &str, part: &[u8]) -> String {
    if stream.write_all(head.as_bytes()).await.is_err() {
        return CLOSED.into();
    }
    let (mut reading, mut writing) = stream.split();
    let fill = async { while writing.write_all(part).await.is_ok() {} };
    let mut first = [0; 64];
    tokio::select! {
        read = timeout(TIME_LIMIT, reading.read(&mut first)) => match read {
            Err(_) => format!("taken for {} s", TIME_LIMIT.as_secs()),
            Ok(Ok(read)) => status(&first[..read]),
            Ok(Err(_)) => CLOSED.into(),
        },
        () = fill => read_rest(&mut reading).await,
    }
}

/// The answer of who takes no more.
async fn read_rest(reading: &mut (impl AsyncReadExt + Unpin)) -> String {
    let mut first = [0; 64];
    match timeout(TIME_LIMIT, reading.read(&mut first)).await {
        Ok(Ok(read)) => status(&first[..read]),
        _ => CLOSED.into(),
    }
}
