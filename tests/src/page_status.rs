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
    let mut stream = std::net::TcpStream::connect(page).ok()?;
    let request = format!("GET /api/status HTTP/1.1\r\nHost: {page}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).ok()?;
    let mut text = String::new();
    stream.read_to_string(&mut text).ok()?;
    serde_json::from_str(text.split("\r\n\r\n").nth(1)?).ok()
}
