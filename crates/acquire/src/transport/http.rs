//! HTTP/1.1 GET over plain TCP, whole answers and streams, with limits on connecting, on each read, and on size.

use super::http_login::{HttpLogin, refusal};
use super::tcp::{self, CONNECT_LIMIT};
use crate::session_end::SessionEnd;
use http_body_util::{BodyExt, Empty};
use hyper::body::{Bytes, Incoming};
use hyper::{Request, StatusCode, Uri, header};
use hyper_util::rt::TokioIo;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout};
use trunnion_core::chain;
use trunnion_protocol::mtconnect::MAX_BODY_BYTES;

/// Whom to ask.
#[derive(Clone, Debug)]
pub struct Server {
    /// Its address.
    pub base: Uri,
    /// Who we are for it.
    pub login: Option<HttpLogin>,
}

/// An answer whose body is still coming.
pub struct Answer {
    /// Status.
    pub status: StatusCode,
    /// `Content-Type`, empty when missing.
    pub content_type: String,
    body: Incoming,
    base: Uri,
    connection: Connection,
}

/// The task that drives one connection; it ends with the answer.
struct Connection(JoinHandle<()>);

impl Drop for Connection {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Checks a base address `http://host[:port][/path]`.
pub fn parse_base(url: &str) -> Result<Uri, String> {
    let uri: Uri = url.parse().map_err(|error| format!("is no address ({error})"))?;
    if uri.scheme_str() != Some("http") || uri.host().is_none_or(str::is_empty) || uri.query().is_some() {
        return Err("does not begin with http://host (encrypted agents are not supported)".into());
    }
    Ok(uri)
}

/// Asks for the base address + `path`, for example `/probe`. Cancel safe: a dropped request closes its connection.
///
/// # Errors
/// `Absent` when nobody listens, `Silent` when the answer stays out, `Refused` when it does not let us in, `Disconnected`.
pub async fn get(Server { base, login }: &Server, path: &str) -> Result<Answer, SessionEnd> {
    let authorization = login.as_ref().map(|login| login.authorization(&base.to_string())).transpose()?;
    let host = base.host().unwrap_or_default();
    let port = base.port_u16().unwrap_or(80);
    let stream = tcp::connect(host.trim_matches(['[', ']']), port, &base.to_string()).await?;
    let lost = |error: hyper::Error| SessionEnd::Disconnected(format!("{base}: {}", chain(&error)));
    let (mut sender, connection) =
        hyper::client::conn::http1::handshake(TokioIo::new(stream)).await.map_err(lost)?;
    let device = base.to_string();
    let connection = Connection(tokio::spawn(async move {
        if let Err(error) = connection.await {
            tracing::debug!(device, "connection ended: {error}");
        }
    }));
    let target = format!("{}{path}", base.path().trim_end_matches('/'));
    let authority = base.authority().map_or(host, |authority| authority.as_str());
    let mut request = Request::get(target)
        .header(header::HOST, authority)
        .header(header::USER_AGENT, concat!("trunnion/", env!("CARGO_PKG_VERSION")))
        .body(Empty::<Bytes>::new())
        .map_err(|error| SessionEnd::Protocol { doing: "building a request", fault: error.to_string() })?;
    request.headers_mut().extend(authorization.map(|value| (header::AUTHORIZATION, value)));
    let response = timeout(CONNECT_LIMIT, sender.send_request(request)).await;
    let response = response.map_err(|_| silent(base, CONNECT_LIMIT))?.map_err(lost)?;
    if let Some(why) = refusal(login.as_ref(), response.status(), response.headers()) {
        return Err(SessionEnd::Refused { address: base.to_string(), why });
    }
    let content_type = response.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    Ok(Answer {
        status: response.status(),
        content_type: content_type.unwrap_or_default().to_owned(),
        body: response.into_body(),
        base: base.clone(),
        connection,
    })
}

impl Answer {
    /// The next bytes of the body; `None` at its end. Cancel safe.
    ///
    /// # Errors
    /// `Silent` when nothing comes within `limit`, `Disconnected`.
    pub async fn chunk(&mut self, limit: Duration) -> Result<Option<Bytes>, SessionEnd> {
        loop {
            let frame = timeout(limit, self.body.frame()).await;
            match frame.map_err(|_| silent(&self.base, limit))? {
                None => return Ok(None),
                Some(Err(error)) => {
                    return Err(SessionEnd::Disconnected(format!("{}: {}", self.base, chain(&error))));
                }
                Some(Ok(frame)) => {
                    if let Ok(data) = frame.into_data() {
                        return Ok(Some(data));
                    }
                }
            }
        }
    }

    /// The whole body.
    ///
    /// # Errors
    /// `Silent` when nothing comes within `limit`, `Protocol` when its end does not or it is too large, `Disconnected`.
    pub async fn whole(mut self, limit: Duration) -> Result<Vec<u8>, SessionEnd> {
        let mut body = Vec::new();
        let end = Instant::now() + limit;
        loop {
            // An agent that sends a byte now and then would hold a limit on each read for ever.
            let chunk = match self.chunk(end.saturating_duration_since(Instant::now())).await {
                Ok(Some(chunk)) => chunk,
                Ok(None) => break,
                Err(SessionEnd::Silent { .. }) if body.is_empty() => return Err(silent(&self.base, limit)),
                Err(SessionEnd::Silent { .. }) => {
                    let fault = format!(
                        "its end did not come within {} s, only {} bytes",
                        limit.as_secs_f64(),
                        body.len()
                    );
                    return Err(SessionEnd::Protocol { doing: "reading a document", fault });
                }
                Err(other) => return Err(other),
            };
            body.extend_from_slice(&chunk);
            if body.len() > MAX_BODY_BYTES {
                let fault = format!("more than {MAX_BODY_BYTES} bytes");
                return Err(SessionEnd::Protocol { doing: "reading a document", fault });
            }
        }
        drop(self.connection);
        Ok(body)
    }
}

fn silent(base: &Uri, waited: Duration) -> SessionEnd {
    let who = format!("{base} does not answer; check that the agent runs, and the network between");
    SessionEnd::Silent { who, waited }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::AsyncWriteExt;

    /// A byte every 20 ms, without end.
    async fn drips() -> Server {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base = parse_base(&format!("http://{}", listener.local_addr().unwrap())).unwrap();
        tokio::spawn(async move {
            let (mut socket, _) = listener.accept().await.unwrap();
            socket.write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 1000000\r\n\r\n").await.unwrap();
            while socket.write_all(b"x").await.is_ok() {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        });
        Server { base, login: None }
    }

    #[tokio::test]
    async fn a_body_that_never_ends_is_given_up() {
        let answer = get(&drips().await, "/probe").await.unwrap();
        let end = timeout(Duration::from_secs(60), answer.whole(Duration::from_millis(300))).await;
        let end = end.expect("it is given up").unwrap_err();
        assert!(end.to_string().contains("its end did not come within 0.3 s"), "{end}");
    }
}
