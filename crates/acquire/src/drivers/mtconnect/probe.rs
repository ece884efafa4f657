//! Is there an MTConnect agent at a URL? `/probe` describes its devices, where it asks for no password.

use super::answer::{parse, unexpected};
use crate::probe::{Answer, Found, Medium, Probe, Scheme};
use crate::session_end::SessionEnd;
use crate::transport::http;
use std::time::Duration;
use trunnion_protocol::mtconnect::Document;

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Network(Scheme { name: "http", port: 5000 }),
    asks: "MTConnect: GET /probe",
    run: |url| Box::pin(at(url)),
};

const ASKING: &str = "asking /probe";
const LIMIT: Duration = Duration::from_secs(5);

async fn at(url: &str) -> Answer {
    ask(url).await.unwrap_or_else(Answer::Trouble)
}

async fn ask(url: &str) -> Result<Answer, SessionEnd> {
    let refused = |why| SessionEnd::Refused { address: url.to_owned(), why };
    let base = http::parse_base(url).map_err(refused)?;
    let server = http::Server { base, login: None };
    let answer = http::get(&server, "/probe").await?;
    let status = answer.status;
    let body = answer.whole(LIMIT).await?;
    // An error document comes with a status of its own.
    let document = match parse(&body) {
        Ok(Document::Devices(document)) => document,
        Ok(other) => return Err(unexpected(ASKING, &other)),
        Err(_) if !status.is_success() => {
            return Err(SessionEnd::Protocol {
                doing: ASKING,
                fault: format!("the server answers {status}"),
            });
        }
        Err(refused) => return Err(refused),
    };
    let names: Vec<&str> = document.devices.iter().map(|device| device.name.as_str()).collect();
    let mut keys = vec![format!("url = \"{url}\"")];
    if let [first, _, ..] = names[..] {
        keys.push(format!("device = \"{first}\""));
    }
    let header = &document.header;
    let identity =
        format!("MTConnect agent {} {}, devices {}", header.sender, header.version, names.join(", "));
    Ok(Answer::Found(Found { identity, keys }))
}
