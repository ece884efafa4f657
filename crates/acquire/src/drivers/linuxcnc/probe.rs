//! Does linuxcncrsh answer at an address? It reports its name and the units of its joints, not which axis each joint moves.

use super::exchange::{Exchange, PASSWORD, PORT, unexpected};
use crate::probe;
use crate::probe::{Answer, Found, Medium, Probe, Scheme};
use crate::session_end::SessionEnd;
use crate::transport::tcp;
use std::time::Duration;
use trunnion_protocol::linuxcncrsh::{Item, Reply};

pub(super) const PROBE: Probe = Probe {
    medium: Medium::Network(Scheme { name: "linuxcnc", port: PORT }),
    asks: "LinuxCNC: hello, get joint_units",
    run: |url| Box::pin(at(url)),
};

const LIMIT: Duration = Duration::from_secs(2);

async fn at(url: &str) -> Answer {
    ask(url).await.unwrap_or_else(Answer::Trouble)
}

async fn ask(url: &str) -> Result<Answer, SessionEnd> {
    let (host, port) = tcp::host_and_port(url, PORT);
    let link = probe::link(LIMIT);
    let mut exchange = Exchange::open(&host, port, url, LIMIT).await?;
    let (server, version) = exchange.hello(PASSWORD, &link).await?;
    let answered = exchange.get(Item::JointUnits, &link).await?;
    let Reply::JointUnits(units) = &answered.reply else { return Err(unexpected(&answered)) };
    let units: Vec<&str> = units.iter().map(|unit| unit.word()).collect();
    let last = units.len().saturating_sub(1);
    let units = units.join(" ");
    let mut keys = vec![format!("host = \"{host}\"")];
    if port != PORT {
        keys.push(format!("port = {port}"));
    }
    keys.push(format!(
        "joints = \"?\"  # the server does not report them: copy COORDINATES of [TRAJ] in its INI file. Joints 0 to {last} are in \
         {units}; the machine may have fewer"
    ));
    Ok(Answer::Found(Found { identity: format!("linuxcncrsh {server} {version}, joints in {units}"), keys }))
}
