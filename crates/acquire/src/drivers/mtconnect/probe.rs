//! Is there an MTConnect agent at a URL? `/probe` describes its devices, where it asks for no password.

use crate::probe::{Answer, Found, Medium, Probe, Scheme};
use crate::session_end::SessionEnd;
use crate::transport::http;
use std::time::Duration;
use trunnion_protocol::mtconnect::{Document, parse};

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Network(Scheme { name: "http", port: 5000 }),
    asks: "MTConnect: GET /probe",
    run: |url| Box::pin(at(url)),
};

const LIMIT: Duration = Duration::from_secs(5);

async fn at(url: &str) -> Answer {
    ask(url).await.unwrap_or_else(Answer::Trouble)
}

async fn ask(url: &str) -> Result<Answer, SessionEnd> {
    let refused = |why| SessionEnd::Refused { address: url.to_owned(), why };
    let base = http::parse_base(url).map_err(refused)?;
    let server = http::Server { base, login: None };
    let body = http::get(&server, "/probe").await?.whole(LIMIT).await?;
    let Ok(Document::Devices(document)) = parse(&body) else {
        return Ok(Answer::none_in(&body));
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
