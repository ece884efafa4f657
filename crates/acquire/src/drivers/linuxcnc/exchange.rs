//! One request at a time: two small requests in a row would wait for each other in the network's buffers (40 ms).
//!
//! linuxcncrsh takes requests apart in memory that all its connections share: with a second client it now and
//! then refuses a good request, or answers another's. Such a request is repeated.

use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::tcp;
use std::collections::VecDeque;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;
use trunnion_core::HostTime;
use trunnion_protocol::linuxcncrsh::{Item, Lines, Reply, Request, parse_reply, write_request};

/// Port and connection password of linuxcncrsh when nobody gave it others.
pub(super) const PORT: u16 = 5007;
pub(super) const PASSWORD: &str = "EMC";

/// An answer with the times around it.
pub(super) struct Answered {
    pub(super) reply: Reply,
    /// When it was asked for.
    pub(super) asked: HostTime,
    /// When it was there.
    pub(super) arrival: HostTime,
}

impl Answered {
    /// Half-way between request and answer.
    pub(super) fn middle(&self) -> HostTime {
        self.asked + (self.arrival - self.asked) / 2
    }
}

/// The end of a session that was answered something else than it asked for.
pub(super) fn unexpected(answered: &Answered) -> SessionEnd {
    SessionEnd::Protocol { doing: "asking LinuxCNC", fault: format!("it answered {:?}", answered.reply) }
}

/// What a line with the password is called in place of the line.
const REPEATS: &str = "something that repeats the password";
/// So many signs of a password in a row are not shown: a damaged line may have lost the others.
const LONGEST_PART: usize = 4;

/// A request is made so often before its answer is believed.
const ATTEMPTS: u32 = 5;

/// A connection.
pub(super) struct Exchange {
    stream: TcpStream,
    address: String,
    lines: Lines,
    waiting: VecDeque<String>,
    silence: Duration,
    repeated: u64,
    /// Is in no message; a server of another kind repeats it.
    password: String,
}

impl Exchange {
    pub(super) async fn open(
        host: &str,
        port: u16,
        address: &str,
        silence: Duration,
    ) -> Result<Self, SessionEnd> {
        let stream = tcp::connect(host, port, address).await?;
        let (lines, waiting) = (Lines::default(), VecDeque::new());
        let (repeated, password) = (0, String::new());
        Ok(Self { stream, address: address.into(), lines, waiting, silence, repeated, password })
    }

    /// Name and version of the server. Afterwards it no longer repeats what it is asked.
    pub(super) async fn hello(
        &mut self,
        password: &str,
        link: &Link,
    ) -> Result<(String, String), SessionEnd> {
        password.clone_into(&mut self.password);
        let hello = Request::Hello { password: password.into() };
        let answered = self.repeat(&hello, link, |reply| matches!(reply, Reply::Hello { .. })).await?;
        let (server, version) = match answered.reply {
            Reply::Hello { server, version } => (server, version),
            Reply::HelloRefused => {
                let why =
                    "the connection password is wrong; give `password` as after -w of linuxcncrsh".into();
                return Err(SessionEnd::Refused { address: self.address.clone(), why });
            }
            other => return Err(protocol(format!("hello was answered by {other:?}"))),
        };
        // `set` has no answer of its own.
        self.send(&Request::EchoOff).await?;
        match self.get(Item::Echo, link).await?.reply {
            Reply::Echo(false) => Ok((server, version)),
            other => Err(protocol(format!("set echo off was answered by {other:?}"))),
        }
    }

    /// Asks for a value.
    pub(super) async fn get(&mut self, item: Item, link: &Link) -> Result<Answered, SessionEnd> {
        self.repeat(&Request::Get(item), link, |reply| item.is_answered_by(reply)).await
    }

    /// Asks for the positions of at least `joints` joints: an answer mixed with another connection's has fewer.
    pub(super) async fn positions(&mut self, joints: usize, link: &Link) -> Result<Answered, SessionEnd> {
        let is_whole = |reply: &Reply| matches!(reply, Reply::JointPos(numbers) if numbers.len() >= joints);
        self.repeat(&Request::Get(Item::JointPos), link, is_whole).await
    }

    /// Asks until the answer belongs to the question; gives the last answer in any case.
    async fn repeat(
        &mut self,
        request: &Request,
        link: &Link,
        fits: impl Fn(&Reply) -> bool,
    ) -> Result<Answered, SessionEnd> {
        for _ in 1..ATTEMPTS {
            let answered = self.ask(request, link).await?;
            if fits(&answered.reply) {
                return Ok(answered);
            }
            self.repeated += 1;
        }
        self.ask(request, link).await
    }

    /// Requests that were made again, and answers that nobody had asked for.
    pub(super) fn repeated(&self) -> u64 {
        self.repeated
    }

    /// Bytes that belonged to no line.
    pub(super) fn dropped_bytes(&self) -> u64 {
        self.lines.dropped_bytes()
    }

    async fn ask(&mut self, request: &Request, link: &Link) -> Result<Answered, SessionEnd> {
        let asked = link.now();
        self.send(request).await?;
        loop {
            let line = self.line().await?;
            match parse_reply(&line) {
                Ok(None) => {}
                Ok(Some(Reply::Refused(_))) if self.has_password(&line) => {
                    return Err(protocol(REPEATS.into()));
                }
                Ok(Some(reply)) => return Ok(Answered { reply, asked, arrival: link.now() }),
                Err(error) if matches!(request, Request::Hello { .. }) && line.is_ascii() => {
                    let found = match self.has_password(&line) {
                        true => REPEATS.into(),
                        false => format!("something that says \"{}\"", error.line),
                    };
                    let expected = "linuxcncrsh; give the port after -p of linuxcncrsh".into();
                    return Err(SessionEnd::WrongDevice { found, expected });
                }
                Err(_) if self.has_password(&line) => return Err(protocol(REPEATS.into())),
                // The answers no longer belong to their questions: begin again.
                Err(error) => return Err(protocol(error.to_string())),
            }
        }
    }

    /// Whether a line has the password or a part of it that gives it away. The password that everybody knows is none.
    fn has_password(&self, line: &str) -> bool {
        let letters: Vec<char> = self.password.chars().collect();
        let part = letters.len().min(LONGEST_PART);
        self.password != PASSWORD
            && part > 0
            && letters.windows(part).any(|part| line.contains(&part.iter().collect::<String>()))
    }

    /// Answers that came without a question would pass for those of the next one, and every later answer for that of the
    /// question before.
    fn drop_unasked(&mut self) {
        let mut bytes = [0; 2048];
        while let Ok(count @ 1..) = self.stream.try_read(&mut bytes) {
            self.waiting.extend(self.lines.push(&bytes[..count]));
        }
        let is_reply = |line: &String| matches!(parse_reply(line), Ok(Some(_)));
        self.repeated += self.waiting.drain(..).filter(is_reply).count() as u64;
    }

    async fn send(&mut self, request: &Request) -> Result<(), SessionEnd> {
        self.drop_unasked();
        let line = write_request(request);
        match timeout(self.silence, self.stream.write_all(line.as_bytes())).await {
            Err(_) => Err(self.silent()),
            Ok(Err(error)) => Err(self.lost(&error.to_string())),
            Ok(Ok(())) => Ok(()),
        }
    }

    async fn line(&mut self) -> Result<String, SessionEnd> {
        // Garbage that never ends a line must not keep us here for ever.
        let deadline = tokio::time::Instant::now() + self.silence;
        let mut bytes = [0; 2048];
        loop {
            if let Some(line) = self.waiting.pop_front() {
                return Ok(line);
            }
            match tokio::time::timeout_at(deadline, self.stream.read(&mut bytes)).await {
                Err(_) => return Err(self.silent()),
                Ok(Err(error)) => return Err(self.lost(&error.to_string())),
                Ok(Ok(0)) => return Err(self.lost("LinuxCNC closed the connection")),
                Ok(Ok(count)) => self.waiting.extend(self.lines.push(&bytes[..count])),
            }
        }
    }

    fn silent(&self) -> SessionEnd {
        let who = format!(
            "{} does not answer as linuxcncrsh; check that LinuxCNC runs, and the network between",
            self.address
        );
        SessionEnd::Silent { who, waited: self.silence }
    }

    fn lost(&self, why: &str) -> SessionEnd {
        SessionEnd::Disconnected(format!("{}: {why}", self.address))
    }
}

fn protocol(fault: String) -> SessionEnd {
    SessionEnd::Protocol { doing: "asking LinuxCNC", fault }
}
