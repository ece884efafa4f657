//! Is there an indicator at a port? Each preset whose request a manual confirms is asked for one value; a preset that
//! shares its request with another is distinguished by its name. Then it is listened whether one talks on its own.

use super::settings::framing_named;
use crate::probe::{Answer, Found, Medium, Probe, Probing, ask_at};
use std::time::Duration;
use trunnion_protocol::ascii::{Decoder, Line, PRESETS, Preset};

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Serial,
    asks: "indicators: STX and M1? and GA00 at 9600 7E2, ? at 4800 7E2, listening at 9600 8N1",
    run: |port| {
        Box::pin(Answer::first(
            PRESETS.iter().filter(|preset| preset.may_be_asked).map(|preset| at(port, preset)),
        ))
    },
};

/// The slowest takes 80 ms.
const ANSWER_LIMIT: Duration = Duration::from_millis(400);
/// An input tool that repeats its value does so about so often.
const LISTEN_LIMIT: Duration = Duration::from_millis(1200);

fn at<'a>(port: &'a str, preset: &'static Preset) -> Probing<'a> {
    Box::pin(async move {
        let framing = framing_named(preset.framing);
        let limit = if preset.request.is_empty() { LISTEN_LIMIT } else { ANSWER_LIMIT };
        let bytes = match ask_at(port, preset.baud, framing, preset.request.as_bytes(), limit).await {
            Ok(bytes) => bytes,
            Err(end) => return Answer::Trouble(end),
        };
        let lines = Decoder::new(preset.format()).push(&bytes);
        let shown = lines.iter().find_map(|line| match line {
            Line::Value(measured) => {
                Some(format!("reads {} {}", measured.number.value(), measured.unit.name()))
            }
            // Other words for an error are too short to prove anything.
            Line::Error { text, .. } if text.contains("ERR") => Some(format!("says \"{text}\"")),
            Line::Error { .. } | Line::Unit(_) | Line::Strange(_) => None,
        });
        let Some(shown) = shown else { return Answer::none_in(&bytes) };
        let (preset, name) = match by_name(port, preset).await {
            Some((preset, name)) => (preset, format!(" \"{name}\"")),
            None => (preset, String::new()),
        };
        Answer::Found(Found {
            identity: format!("{}{name}; it {shown}", preset.about),
            keys: vec![
                format!("port = \"{port}\""),
                format!("preset = \"{}\"", preset.name),
                "role = {role}".into(),
            ],
        })
    })
}

/// The preset whose name the device reports, of those it could be.
async fn by_name(port: &str, answered: &'static Preset) -> Option<(&'static Preset, String)> {
    let (question, _) = answered.identity;
    if question.is_empty() {
        return None;
    }
    let framing = framing_named(answered.framing);
    let bytes = ask_at(port, answered.baud, framing, question.as_bytes(), ANSWER_LIMIT).await.ok()?;
    let text: String = bytes.iter().map(|byte| char::from(byte & 0x7F)).collect();
    let name = text
        .lines()
        .map(|line| line.trim_matches(|c: char| c.is_ascii_control() || c == ' '))
        .find(|line| !line.is_empty() && !line.starts_with("ERR") && *line != question.trim())?;
    let mut candidates = PRESETS
        .iter()
        .copied()
        .filter(|preset| (preset.request, preset.baud) == (answered.request, answered.baud));
    let fits = |preset: &&Preset| preset.identity.1.iter().any(|begin| name.starts_with(begin));
    Some((candidates.find(fits).unwrap_or(answered), name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_of_what_is_asked_holds_every_request() {
        for preset in PRESETS.iter().filter(|preset| preset.may_be_asked) {
            let request = match preset.request.trim_end() {
                "" => "listening",
                "\x02" => "STX",
                request => request,
            };
            for part in [request, &format!("{} {}", preset.baud, preset.framing)] {
                assert!(PROBE.asks.contains(part), "{}: `asks` of this file lacks \"{part}\"", preset.name);
            }
        }
    }
}
