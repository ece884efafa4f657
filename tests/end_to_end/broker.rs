//! A broker (MQTT 3.1.1) that lets in who knows the password, and keeps all that others would see.

use rustls::{ServerConfig, ServerConnection, StreamOwned};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};

/// The broker; it runs as long as the test.
pub struct Broker {
    pub port: u16,
    seen: Arc<Mutex<Seen>>,
}

/// CONNACK: not authorised (section 3.2.2.3).
const REFUSED: [u8; 4] = [0x20, 2, 0, 5];

#[derive(Default)]
struct Seen {
    /// It ended: connections close, and new ones are not taken.
    is_away: bool,
    /// Connections, to be closed.
    streams: Vec<TcpStream>,
    let_in: usize,
    refused: usize,
    /// Everything sent, without user and password.
    sent: Vec<u8>,
}

impl Broker {
    /// Starts it for one user.
    pub fn start(user: &'static str, password: String) -> Self {
        Self::start_with(user, password, None)
    }

    /// The same, with whom it speaks as this says.
    pub fn start_encrypted(user: &'static str, password: String, encryption: Arc<ServerConfig>) -> Self {
        Self::start_with(user, password, Some(encryption))
    }

    fn start_with(user: &'static str, password: String, encryption: Option<Arc<ServerConfig>>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let seen = Arc::<Mutex<Seen>>::default();
        let shared = Arc::clone(&seen);
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let (seen, password) = (Arc::clone(&shared), password.clone());
                if seen.lock().unwrap().is_away {
                    continue;
                }
                let encryption = encryption.clone();
                // A client that goes is none of the broker's business.
                std::thread::spawn(move || {
                    let stream = stream.ok()?;
                    seen.lock().unwrap().streams.push(stream.try_clone().ok()?);
                    match encryption {
                        Some(config) => {
                            let connection = ServerConnection::new(config).ok()?;
                            serve(StreamOwned::new(connection, stream), user, &password, &seen)
                        }
                        None => serve(stream, user, &password, &seen),
                    }
                });
            }
        });
        Self { port, seen }
    }

    /// Ends, as far as its clients see.
    pub fn go(&self) {
        let mut seen = self.seen.lock().unwrap();
        seen.is_away = true;
        // One that its client has closed is gone as well.
        seen.streams.drain(..).for_each(|stream| drop(stream.shutdown(Shutdown::Both)));
    }

    /// Is there again.
    pub fn come_back(&self) {
        self.seen.lock().unwrap().is_away = false;
    }

    /// How many connections were let in, and how many refused.
    pub fn counts(&self) -> (usize, usize) {
        let seen = self.seen.lock().unwrap();
        (seen.let_in, seen.refused)
    }

    /// Everything that was sent, but users and passwords.
    pub fn sent(&self) -> Vec<u8> {
        self.seen.lock().unwrap().sent.clone()
    }
}

/// MQTT 3.1.1: section 2.2 (header), 3.1 to 3.14 (packets).
fn serve(mut stream: impl Read + Write, user: &str, password: &str, seen: &Mutex<Seen>) -> Option<()> {
    loop {
        let (kind, body) = packet(&mut stream)?;
        let answer: Vec<u8> = match kind >> 4 {
            1 => {
                let (is_right, rest) = connect(&body, user, password)?;
                let mut seen = seen.lock().unwrap();
                seen.sent.extend(rest);
                let count = if is_right { &mut seen.let_in } else { &mut seen.refused };
                *count += 1;
                if is_right { vec![0x20, 2, 0, 0] } else { REFUSED.into() }
            }
            3 => {
                seen.lock().unwrap().sent.extend(&body);
                let topic = usize::from(u16::from_be_bytes([body[0], body[1]]));
                match kind & 0b110 {
                    0 => continue,
                    _ => vec![0x40, 2, body[2 + topic], body[3 + topic]],
                }
            }
            8 => {
                seen.lock().unwrap().sent.extend(&body);
                // The service subscribes to one topic at a time.
                vec![0x90, 3, body[0], body[1], 1]
            }
            12 => vec![0xd0, 0],
            _ => return None,
        };
        stream.write_all(&answer).ok()?;
        if answer == REFUSED {
            return None;
        }
    }
}

fn packet(stream: &mut impl Read) -> Option<(u8, Vec<u8>)> {
    let mut byte = [0];
    let mut next = || stream.read_exact(&mut byte).ok().map(|()| byte[0]);
    let kind = next()?;
    let mut length = 0;
    for place in 0..4 {
        let part = next()?;
        length |= usize::from(part & 0x7f) << (7 * place);
        if part & 0x80 == 0 {
            break;
        }
    }
    let mut body = vec![0; length];
    stream.read_exact(&mut body).ok().map(|()| (kind, body))
}

/// Whether user and password are right, and the rest of a CONNECT: client and last will.
fn connect(body: &[u8], user: &str, password: &str) -> Option<(bool, Vec<u8>)> {
    let flags = *body.get(7)?;
    let mut at = 10;
    let mut text = || {
        let length = usize::from(u16::from_be_bytes([*body.get(at)?, *body.get(at + 1)?]));
        let text = body.get(at + 2..at + 2 + length)?;
        at += 2 + length;
        Some(text.to_vec())
    };
    let mut rest = text()?;
    if flags & 0x04 != 0 {
        rest.extend(text()?);
        rest.extend(text()?);
    }
    let given_user = if flags & 0x80 != 0 { text()? } else { Vec::new() };
    let given = if flags & 0x40 != 0 { text()? } else { Vec::new() };
    Some((given_user == user.as_bytes() && given == password.as_bytes(), rest))
}
