//! What the page of a service says. Tests of other crates take this file in by its path.

use std::io::{Read, Write};

/// A port of this computer where nothing listens.
///
/// # Panics
/// When there is none.
pub fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    listener.local_addr().expect("bound").port()
}

/// An address of this computer where nothing listens.
///
/// # Panics
/// When there is none.
pub fn free_address() -> String {
    format!("127.0.0.1:{}", free_port())
}

/// The present of a service by its page; `None` while there is none.
pub fn status(page: &str) -> Option<serde_json::Value> {
    let (_, answer) = ask(page, "GET /api/status", "")?;
    serde_json::from_str(&answer).ok()
}

/// A call as the page itself makes it: the HTTP status and the answer; `None` where nobody answers.
pub fn ask(page: &str, call: &str, body: &str) -> Option<(u16, String)> {
    let mut stream = std::net::TcpStream::connect(page).ok()?;
    let request = format!(
        "{call} HTTP/1.1\r\nHost: {page}\r\nConnection: close\r\nx-trunnion: page\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(request.as_bytes()).ok()?;
    let mut text = String::new();
    stream.read_to_string(&mut text).ok()?;
    let (head, answer) = text.split_once("\r\n\r\n")?;
    Some((head.split(' ').nth(1)?.parse().ok()?, answer.into()))
}
