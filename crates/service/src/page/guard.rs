//! Who may call: this page, in a browser on this computer, and programs that name this computer.
//!
//! - *Host* must be an address of this computer with our port: a name of an attacker's that resolves to it (DNS rebinding) is refused.
//! - *Origin* and *Sec-Fetch-Site*, where a browser sends them, must be ours: no other page reads or writes.
//! - What changes something needs the header `x-trunnion`: a form of another page cannot send it, and a script of one is asked first
//!   (CORS), which nothing here answers.
//! - From other computers only who knows the token (`access`).
//! - Scripts and styles come from our own files alone.

use super::access::Access;
use super::answer::refused;
use super::login::LOGIN;
use super::places::MOST_CONNECTIONS;
use axum::extract::{Request, State};
use axum::http::header::{
    AUTHORIZATION, CONTENT_SECURITY_POLICY, COOKIE, HOST, ORIGIN, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::Response;
use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tokio::time::Instant;

/// The header that what changes something must carry; any value.
pub const OWN_HEADER: &str = "x-trunnion";
/// Longest wait for an answer; the analysis of a large run goes on and is there when it is asked for again.
const LONGEST: Duration = Duration::from_secs(120);
/// Calls of one computer a second, and at once: a page makes about ten when it is opened, and a person clicks once a second.
const CALLS_PER_S: f64 = 40.0;
const CALLS_AT_ONCE: f64 = 200.0;
/// Logins of one address a second, and at once: a person needs seconds for a token, and behind one address may be everybody of a shop.
const LOGINS_PER_S: f64 = 1.0;
const LOGINS_AT_ONCE: f64 = 20.0;

const CONTENT_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
                              base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What a call is judged by.
pub struct Guard {
    /// `localhost:8460`, `127.0.0.1:8460` and the like.
    hosts: Vec<String>,
    access: Access,
    calls: Counted,
    /// Calls without the token: their own count, for who has none must lock nobody out.
    guesses: Counted,
    /// Logins, which those calls must not hold up, and of which none may follow another at will.
    logins: Counted,
}

/// Calls of each computer. As many computers are known as can have connections; the one that was silent longest makes room.
struct Counted {
    per_s: f64,
    at_once: f64,
    known: Mutex<BTreeMap<IpAddr, Calls>>,
}

/// Where a call comes from.
#[derive(Clone, Copy, Debug)]
pub struct Peer(pub IpAddr);

/// Calls of one computer that may come at once, and when that was last known.
struct Calls {
    left: f64,
    at: Instant,
}

impl Counted {
    fn new(per_s: f64, at_once: f64) -> Self {
        Self { per_s, at_once, known: Mutex::default() }
    }

    /// One call more of a computer; false when it has too many.
    fn count(&self, Peer(of): Peer, now: Instant) -> bool {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MOST_CONNECTIONS && !known.contains_key(&of) {
            let silent = known.iter().min_by_key(|(_, calls)| calls.at).map(|(of, _)| *of);
            silent.and_then(|of| known.remove(&of));
        }
        let calls = known.entry(of).or_insert(Calls { left: self.at_once, at: now });
        let since_s = now.duration_since(calls.at).as_secs_f64();
        *calls = Calls { left: (calls.left + since_s * self.per_s).min(self.at_once), at: now };
        let allowed = calls.left >= 1.0;
        if allowed {
            calls.left -= 1.0;
        }
        allowed
    }
}

impl Guard {
    /// For a page on this address.
    pub fn new(address: SocketAddr, access: Access) -> Self {
        let calls = || Counted::new(CALLS_PER_S, CALLS_AT_ONCE);
        let logins = Counted::new(LOGINS_PER_S, LOGINS_AT_ONCE);
        Self { hosts: access.hosts(address), access, calls: calls(), guesses: calls(), logins }
    }

    /// Why the call is refused; `None` when it is not.
    fn refusal(
        &self,
        method: &Method,
        path: &str,
        headers: &HeaderMap,
    ) -> Option<(StatusCode, &'static str)> {
        let text = |name: &HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or_default());
        if !text(&HOST).is_some_and(|host| self.hosts.iter().any(|known| known == host)) {
            return Some((StatusCode::MISDIRECTED_REQUEST, "Host is no address of this page"));
        }
        let ours = |origin: &str| {
            let host = origin.split_once("://").filter(|(scheme, _)| *scheme == self.access.scheme());
            host.is_some_and(|(_, host)| self.hosts.iter().any(|known| known == host))
        };
        if text(&ORIGIN).is_some_and(|origin| !ours(origin)) {
            return Some((StatusCode::FORBIDDEN, "Origin is another page"));
        }
        // A link of another page may open this one; it may not call.
        let site = text(&HeaderName::from_static("sec-fetch-site")).unwrap_or("none");
        if !matches!(site, "same-origin" | "none") && path != "/" {
            return Some((StatusCode::FORBIDDEN, "Sec-Fetch-Site is another page"));
        }
        let reads = matches!(*method, Method::GET | Method::HEAD);
        if !reads && !headers.contains_key(OWN_HEADER) {
            return Some((StatusCode::FORBIDDEN, "what changes something needs the header x-trunnion"));
        }
        let (authorization, cookie) = (text(&AUTHORIZATION), text(&COOKIE));
        let is_open = path == "/" || path.starts_with("/assets/") || path == LOGIN;
        if !is_open && !self.access.lets_in(authorization.unwrap_or_default(), cookie.unwrap_or_default()) {
            return Some((StatusCode::UNAUTHORIZED, "the token of the page is asked for"));
        }
        None
    }
}

/// Refuses, or answers in time and with the headers that browsers need.
pub async fn guarded(State(guard): State<std::sync::Arc<Guard>>, request: Request, next: Next) -> Response {
    // What is refused takes no place of a call that is not: who has no token locks nobody out.
    let refusal = guard.refusal(request.method(), request.uri().path(), request.headers());
    let peer = request.extensions().get::<Peer>().copied().unwrap_or(Peer(Ipv4Addr::UNSPECIFIED.into()));
    let now = Instant::now();
    let counted = if request.uri().path() == LOGIN { &guard.logins } else { &guard.calls };
    let too_many = || refused(StatusCode::TOO_MANY_REQUESTS, "too many calls; wait a second");
    let mut response = match refusal {
        Some((StatusCode::UNAUTHORIZED, _)) if !guard.guesses.count(peer, now) => too_many(),
        Some((status, why)) => refused(status, why),
        None if !counted.count(peer, now) => too_many(),
        None => match tokio::time::timeout(LONGEST, next.run(request)).await {
            Ok(response) => response,
            Err(_) => refused(StatusCode::GATEWAY_TIMEOUT, "this takes long; ask again in a minute"),
        },
    };
    let headers = response.headers_mut();
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(HeaderValue::from_static(CONTENT_POLICY));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    let same = HeaderValue::from_static("same-origin");
    headers.insert(HeaderName::from_static("cross-origin-resource-policy"), same.clone());
    headers.insert(HeaderName::from_static("cross-origin-opener-policy"), same);
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_computer_has_so_many_calls_at_once_and_so_many_a_second() {
        let counted = Counted::new(CALLS_PER_S, CALLS_AT_ONCE);
        let [one, other] = [1, 2].map(|last| Peer(Ipv4Addr::new(127, 0, 0, last).into()));
        let allowed = |peer: Peer, at: Instant| (0..1000).filter(|_| counted.count(peer, at)).count() as f64;
        let now = Instant::now();
        assert_eq!((allowed(one, now), allowed(one, now)), (CALLS_AT_ONCE, 0.0));
        assert_eq!(allowed(other, now), CALLS_AT_ONCE);
        assert_eq!(allowed(one, now + Duration::from_secs(1)), CALLS_PER_S);
    }
}
