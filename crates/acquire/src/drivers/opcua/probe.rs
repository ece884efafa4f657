//! Is there an OPC UA server at a URL, and where are its axes? Its list of endpoints is asked without encryption, as the
//! standard allows; if a session without encryption and user is open to all, the nodes are looked for too.

use super::connect::{self, Connection};
use super::nodes::{self, Browser};
use super::settings::{Layout, Named, OpcUa};
use crate::probe;
use crate::probe::{Answer, Found, Probing};
use crate::session_end::SessionEnd;
use opcua::types::{NodeId, ObjectId};
use std::time::Duration;
use tokio::time::timeout;
use trunnion_core::AxisValues;

/// The probe of this driver.
pub(super) fn run(url: &str) -> Probing<'_> {
    Box::pin(at(url))
}

/// Machine axes of a SINUMERIK that are asked for.
const MOST_AXES: usize = 16;
const CLOSE_LIMIT: Duration = Duration::from_secs(1);
/// A server that wants to know who we are.
const USER: [&str; 2] = ["user = \"?\"", "password_file = \"opcua-password\""];

async fn at(url: &str) -> Answer {
    ask(url).await.map_or_else(Answer::Trouble, Answer::Found)
}

async fn ask(url: &str) -> Result<Found, SessionEnd> {
    let device = of_unknown_layout(url);
    let (_, endpoints) = connect::endpoints(&device).await?;
    let server = endpoints.first().map_or("", |endpoint| endpoint.server.application_name.text.as_ref());
    let found = |what: &str, lines: &[&str]| {
        let url = format!("url = \"{url}\"");
        let keys = std::iter::once(url).chain(lines.iter().map(|line| (*line).to_owned())).collect();
        Found { identity: format!("OPC UA server {server}, {what}"), keys }
    };
    let layout = "layout = \"?\"  # sinumerik, opc-40502 or nodes; it shows only to a user";
    if connect::choose(&device, &endpoints).is_err() {
        let encrypted = [
            "security = \"Basic256Sha256\"",
            "certificates = \"/var/lib/trunnion/opcua\"",
            USER[0],
            USER[1],
            layout,
        ];
        return Ok(found("encrypted only", &encrypted));
    }
    let connection = match connect::open(&device, &mut probe::link(CLOSE_LIMIT)).await {
        Ok(connection) => connection,
        Err(SessionEnd::Refused { .. }) => {
            return Ok(found("not open without a user", &[USER[0], USER[1], layout]));
        }
        Err(end) => return Err(end),
    };
    let place = axes(&Browser { device: &device, connection: &connection }).await;
    close(&connection).await;
    let place = place?;
    let lines: Vec<&str> = place.keys.iter().map(String::as_str).collect();
    Ok(found(&format!("no encryption, {}", place.identity), &lines))
}

/// A device of which nothing is known but its address.
fn of_unknown_layout(url: &str) -> OpcUa {
    OpcUa {
        url: url.to_owned(),
        layout: Layout::Nodes(AxisValues::from_fn(|_| None)),
        named: Named::default(),
        interval: Duration::ZERO,
        certificates: None,
        server_certificate: None,
        user: None,
    }
}

/// Where the server has its axes, in words and as keys.
async fn axes(browser: &Browser<'_>) -> Result<Found, SessionEnd> {
    if browser.search(nodes::AXIS_LIST).await?.is_some() {
        let (_, axes) = browser.axes(nodes::USUAL_POSITION).await?;
        let letters: Vec<&str> = axes.iter().map(|(letter, _)| letter.as_str()).collect();
        let identity = format!("OPC 40502 with axes {}", letters.join(" "));
        return Ok(Found { identity, keys: vec!["layout = \"opc-40502\"".into()] });
    }
    let measured: Vec<NodeId> = (1..=MOST_AXES).map(|n| nodes::machine_axis("u1", n)).collect();
    let values = browser.values(&measured).await?;
    let count = values.iter().take_while(|(status, _)| !nodes::is_missing(*status)).count();
    if count > 0 {
        let axes = format!(
            "axes = \"?\"  # the server does not report them: the letters of machine axes 1 to {count}, in their order"
        );
        let identity = format!("SINUMERIK with {count} machine axes");
        return Ok(Found { identity, keys: vec!["layout = \"sinumerik\"".into(), axes] });
    }
    let objects = nodes::list(&browser.names_below(&ObjectId::ObjectsFolder.into()).await?);
    let named =
        format!("nodes = {{ X = \"?\" }}  # the node id of every axis; below Objects there is {objects}");
    let identity = "axes neither as SINUMERIK nor as OPC 40502".into();
    Ok(Found { identity, keys: vec!["layout = \"nodes\"".into(), named] })
}

async fn close(connection: &Connection) {
    match timeout(CLOSE_LIMIT, connection.session.disconnect()).await {
        Ok(Ok(())) => {}
        other => tracing::debug!(?other, "the session is left to the server's limit"),
    }
}
