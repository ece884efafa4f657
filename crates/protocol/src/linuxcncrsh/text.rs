//! Lines to requests and replies, and back.

use super::{Item, JointUnit, ProgramStatus, Reply, Request};
use std::fmt::Write;

/// Name under which we say hello.
const CLIENT: &str = "trunnion";
/// Version of the protocol.
const VERSION: &str = "1.1";

/// A line that is no reply.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{line}\" is no answer of linuxcncrsh ({why})")]
pub struct LineError {
    /// The line, shortened.
    pub line: String,
    /// What is wrong.
    pub why: &'static str,
}

/// The line of a request, with its end.
pub fn write_request(request: &Request) -> String {
    match request {
        Request::Hello { password } => format!("hello {password} {CLIENT} {VERSION}\r\n"),
        Request::EchoOff => "set echo off\r\n".into(),
        Request::Get(item) => format!("get {}\r\n", item.word()),
    }
}

/// The reply in a line; `None` for a repeated request.
///
/// # Errors
/// When the line is none of the replies known here.
pub fn parse_reply(line: &str) -> Result<Option<Reply>, LineError> {
    let line = line.trim();
    let (word, rest) = line.split_once([' ', '\t']).unwrap_or((line, ""));
    // We ask in small letters, so repeated requests begin with them.
    if matches!(word, "hello" | "get" | "set") {
        return Ok(None);
    }
    let error = |why| LineError { line: line.chars().take(60).collect(), why };
    let words: Vec<&str> = rest.split_whitespace().collect();
    if words.last() == Some(&"NAK") {
        return Ok(Some(if word == "HELLO" { Reply::HelloRefused } else { Reply::Refused(line.into()) }));
    }
    let one = || words.first().copied().ok_or(error("a word is missing"));
    Ok(Some(match word {
        "HELLO" => match words[..] {
            ["ACK", server, version] => {
                Reply::Hello { server: server.to_owned(), version: version.to_owned() }
            }
            _ => return Err(error("not ACK, name, version")),
        },
        "ECHO" => Reply::Echo(one()? == "ON"),
        "JOINT_POS" => {
            let numbers: Result<Vec<f64>, _> = words.iter().map(|word| word.parse()).collect();
            match numbers {
                Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => Reply::JointPos(numbers),
                _ => return Err(error("not a number")),
            }
        }
        "JOINT_UNITS" => {
            let units: Option<Vec<_>> = words.iter().map(|word| find(&JointUnit::WORDS, word)).collect();
            Reply::JointUnits(units.ok_or(error("not a unit"))?)
        }
        "PROGRAM_STATUS" => {
            Reply::ProgramStatus(find(&ProgramStatus::WORDS, one()?).ok_or(error("not a status"))?)
        }
        "PROGRAM" => Reply::Program(Some(rest.trim().to_owned()).filter(|name| name != "NONE")),
        "PROGRAM_LINE" => Reply::ProgramLine(one()?.parse().map_err(|_| error("not a line number"))?),
        _ => return Err(error("not a word asked for")),
    }))
}

/// The request in a line; `None` for what is not known here.
pub fn parse_request(line: &str) -> Option<Request> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let is = |word: &str, expected: &str| word.eq_ignore_ascii_case(expected);
    match words[..] {
        [hello, password, _, _] if is(hello, "hello") => {
            Some(Request::Hello { password: password.to_owned() })
        }
        [set, echo, off] if is(set, "set") && is(echo, "echo") && is(off, "off") => Some(Request::EchoOff),
        [get, word, ..] if is(get, "get") => {
            Item::WORDS.iter().find(|(known, _)| is(word, known)).map(|(_, item)| Request::Get(*item))
        }
        _ => None,
    }
}

/// The line of a reply, with its end.
pub fn write_reply(reply: &Reply) -> String {
    let mut line = match reply {
        Reply::Hello { server, version } => format!("HELLO ACK {server} {version}"),
        Reply::HelloRefused => "HELLO NAK".into(),
        Reply::Echo(on) => format!("ECHO {}", if *on { "ON" } else { "OFF" }),
        Reply::JointPos(positions) => positions.iter().fold("JOINT_POS".to_owned(), |mut line, position| {
            write!(line, " {position:.6}").expect("text takes text");
            line
        }),
        Reply::JointUnits(units) => {
            units.iter().fold("JOINT_UNITS".to_owned(), |line, unit| line + " " + unit.word())
        }
        Reply::ProgramStatus(status) => format!("PROGRAM_STATUS {}", status.word()),
        Reply::Program(name) => format!("PROGRAM {}", name.as_deref().unwrap_or("NONE")),
        Reply::ProgramLine(line) => format!("PROGRAM_LINE {line}"),
        Reply::Refused(words) => words.clone(),
    };
    line.push_str("\r\n");
    line
}

fn find<T: Copy>(words: &[(&str, T)], word: &str) -> Option<T> {
    words.iter().find(|(known, _)| known.eq_ignore_ascii_case(word)).map(|(_, value)| *value)
}
