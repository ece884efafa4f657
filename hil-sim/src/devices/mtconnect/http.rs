//! The agent's HTTP side: connections, documents, and the multipart stream of `/sample?interval=`.

use super::buffer::Buffer;
use super::controller::Controller;
use super::documents::{AnswerBody, Documents, Parts};
use super::request::{Request, Sample};
use super::wall_clock::WallClock;
use crate::devices::faults::damage;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hyper::body::{Bytes, Incoming};
use hyper::header::{AUTHORIZATION, HeaderValue, WWW_AUTHENTICATE};
use hyper::service::service_fn;
use hyper::{Method, Response, StatusCode};
use hyper_util::rt::TokioIo;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use trunnion_protocol::mtconnect::{
    Device, ErrorDocument, encode_part, write_devices, write_error, write_streams,
};

/// Connections served at a time; further ones wait in the kernel's queue.
const MAX_CONNECTIONS: usize = 32;
/// Documents that wait for a slow reader; then the agent waits, and the buffer runs on.
const QUEUED_PARTS: usize = 4;
const BOUNDARY: &str = "cell-7c1f52e0";

/// One life of the agent.
pub(super) struct Shared {
    pub buffer: Mutex<Buffer>,
    /// The next sequence number, reported at every change.
    pub news: watch::Sender<u64>,
    pub devices: Vec<Device>,
    /// Name of the device.
    pub device: String,
    /// User and password, where they are asked for.
    pub login: Option<(String, String)>,
    /// Bytes still to damage.
    pub garble: Mutex<usize>,
    pub documents: Documents,
    pub clock: WallClock,
}

impl Shared {
    /// Takes the controller's lines up to now.
    pub fn feed(&self, controller: &mut Controller, now_s: f64) {
        let next_sequence = {
            let mut buffer = lock(&self.buffer);
            controller.lines(now_s).into_iter().for_each(|line| buffer.take(line));
            buffer.next_sequence()
        };
        self.news.send_if_modified(|reported| std::mem::replace(reported, next_sequence) != next_sequence);
    }

    /// So many observations are lost, with all that were kept.
    pub fn skip(&self, by: u32) {
        let next_sequence = {
            let mut buffer = lock(&self.buffer);
            buffer.skip(by);
            buffer.next_sequence()
        };
        self.news.send_if_modified(|reported| std::mem::replace(reported, next_sequence) != next_sequence);
    }

    /// The next bytes sent are damaged.
    pub fn garble(&self, count: usize) {
        *lock(&self.garble) += count;
    }

    /// The body as it goes out.
    fn outgoing(&self, mut body: Vec<u8>) -> Bytes {
        damage(&mut body, &mut lock(&self.garble), 0);
        body.into()
    }

    /// Whether a request with this `Authorization` is let in: "Basic", then user ":" password in base64 (RFC 7617, section 2).
    fn lets_in(&self, authorization: Option<&HeaderValue>) -> bool {
        let Some(login) = &self.login else { return true };
        let given = || {
            let (kind, coded) = authorization?.to_str().ok()?.split_once(' ')?;
            let decoded = String::from_utf8(STANDARD.decode(coded).ok()?).ok()?;
            let (user, password) = decoded.split_once(':')?;
            Some(kind.eq_ignore_ascii_case("basic") && (user, password) == (&*login.0, &*login.1))
        };
        given().unwrap_or(false)
    }

    fn error(&self, code: &str, text: &str) -> ErrorDocument {
        lock(&self.buffer).refuse(code, text, self.clock.now_ns())
    }
}

/// Serves connections until the network goes; then all of them are dropped.
pub(super) async fn serve(listener: TcpListener, agent: Arc<Shared>, network: CancellationToken) {
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            () = network.cancelled() => break,
            Some(ended) = connections.join_next() => {
                if let Err(error) = ended {
                    tracing::error!(%error, "a connection ended badly");
                }
            }
            accepted = listener.accept(), if connections.len() < MAX_CONNECTIONS => match accepted {
                Ok((stream, _)) => {
                    let agent = Arc::clone(&agent);
                    connections.spawn(async move {
                        let service = service_fn(move |request| answer(Arc::clone(&agent), request));
                        let http = hyper::server::conn::http1::Builder::new();
                        if let Err(error) = http.serve_connection(TokioIo::new(stream), service).await {
                            tracing::debug!(%error, "connection closed");
                        }
                    });
                }
                Err(error) => {
                    tracing::warn!(%error, "a connection was not accepted");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
            },
        }
    }
    connections.shutdown().await;
}

async fn answer(agent: Arc<Shared>, request: hyper::Request<Incoming>) -> io::Result<Response<AnswerBody>> {
    if !agent.lets_in(request.headers().get(AUTHORIZATION)) {
        let body = AnswerBody::Whole([Bytes::from_static(b"401")].into());
        let mut refused = response(StatusCode::UNAUTHORIZED, "text/plain", body);
        refused
            .headers_mut()
            .insert(WWW_AUTHENTICATE, HeaderValue::from_static("Basic realm=\"cell\", charset=\"UTF-8\""));
        return Ok(refused);
    }
    if request.method() != Method::GET {
        let error = agent.error("UNSUPPORTED", "Only the HTTP GET method is supported");
        return refusal(&agent, &error).await;
    }
    let (path, query) = (request.uri().path(), request.uri().query().unwrap_or(""));
    let now_ns = agent.clock.now_ns();
    match Request::parse(path, query, &agent.device) {
        Err((code, text)) => refusal(&agent, &agent.error(code, &text)).await,
        Ok(Request::Probe) => {
            let document = lock(&agent.buffer).probe(agent.devices.clone(), now_ns);
            document_response(&agent, StatusCode::OK, write_devices(&document)).await
        }
        Ok(Request::Current) => {
            let document = lock(&agent.buffer).current(now_ns);
            document_response(&agent, StatusCode::OK, write_streams(&document)).await
        }
        Ok(Request::Sample(sample)) => {
            let document = {
                let buffer = lock(&agent.buffer);
                buffer.sample(sample.from.unwrap_or(buffer.first_sequence()), sample.count, now_ns)
            };
            match (document, sample.interval) {
                (Err(error), _) => refusal(&agent, &error).await,
                (Ok(document), None) => {
                    document_response(&agent, StatusCode::OK, write_streams(&document)).await
                }
                (Ok(document), Some(interval)) => {
                    let (parts, queue) = mpsc::channel(QUEUED_PARTS);
                    let from = sample.from.unwrap_or(document.first_sequence);
                    // Ends when the reader goes: a part cannot be queued then.
                    tokio::spawn(stream(agent, sample, interval, from, Parts::new(parts)));
                    let kind = format!("multipart/x-mixed-replace;boundary={BOUNDARY}");
                    Ok(response(StatusCode::OK, &kind, AnswerBody::Stream(queue)))
                }
            }
        }
    }
}

/// Sends documents until the reader goes or falls out of the buffer.
async fn stream(agent: Arc<Shared>, sample: Sample, interval: Duration, mut from: u64, mut parts: Parts) {
    let mut news = agent.news.subscribe();
    let mut sent_at = Instant::now();
    loop {
        let (document, more) = {
            let buffer = lock(&agent.buffer);
            let document = buffer.sample(from, sample.count, agent.clock.now_ns());
            (document, buffer.next_sequence())
        };
        let (text, ends) = match document {
            Ok(document) => {
                from = document.next_sequence;
                (write_streams(&document), false)
            }
            Err(error) => (write_error(&error), true),
        };
        let part = agent.outgoing(encode_part(BOUNDARY, "text/xml", text.as_bytes()));
        if parts.send(part, &agent.documents).await.is_none() || ends {
            return;
        }
        sent_at = sent_at.max(Instant::now());
        if from >= more {
            // The next document when there is news, but an empty one after the heartbeat.
            let wait_for_news = news.wait_for(|&next| next > from);
            tokio::select! {
                news = wait_for_news => if news.is_err() { return },
                () = tokio::time::sleep_until(sent_at + sample.heartbeat) => {}
                () = parts.closed() => return,
            }
        }
        tokio::select! {
            () = tokio::time::sleep_until(sent_at + interval) => {}
            () = parts.closed() => return,
        }
    }
}

/// HTTP status of an agent's error (MTConnect Standard part 1, table of status codes).
async fn refusal(agent: &Shared, error: &ErrorDocument) -> io::Result<Response<AnswerBody>> {
    let status = match error.errors.first().map(|error| error.code.as_str()) {
        Some("OUT_OF_RANGE" | "NO_DEVICE") => StatusCode::NOT_FOUND,
        Some("UNSUPPORTED") => StatusCode::NOT_IMPLEMENTED,
        _ => StatusCode::BAD_REQUEST,
    };
    document_response(agent, status, write_error(error)).await
}

async fn document_response(
    agent: &Shared,
    status: StatusCode,
    text: String,
) -> io::Result<Response<AnswerBody>> {
    let body = agent.outgoing(text.into_bytes());
    let next = || write_streams(&lock(&agent.buffer).current(agent.clock.now_ns())).into();
    Ok(response(status, "text/xml", agent.documents.answer(body, next).await?))
}

fn response(status: StatusCode, kind: &str, body: AnswerBody) -> Response<AnswerBody> {
    let builder = Response::builder().status(status).header("Content-Type", kind);
    let builder = builder.header("Cache-Control", "no-cache").header("Server", "cell");
    builder.body(body).expect("the headers are plain text")
}

/// The data behind a lock is whole even when a task died holding it: every change is a single step.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
