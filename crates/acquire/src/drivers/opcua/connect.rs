//! From a URL to a session: endpoint, security, user, and the words for what goes wrong.

use super::settings::{OpcUa, PORT};
use crate::credentials;
use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::tcp;
use opcua::client::{Client, ClientBuilder, IdentityToken, Session};
use opcua::crypto::{SecurityPolicy, X509};
use opcua::types::{ByteString, EndpointDescription, Error, MessageSecurityMode, StatusCode};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio::time::timeout;

/// Finding endpoints, and opening a session, must not take longer.
const LIMIT: Duration = Duration::from_secs(10);

/// A session with the task that drives it; the task ends with it.
pub(super) struct Connection {
    pub(super) session: Arc<Session>,
    pub(super) events: JoinHandle<StatusCode>,
    /// Name of the server.
    pub(super) server: String,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.events.abort();
    }
}

/// Opens a session. Cancel safe.
pub(super) async fn open(device: &OpcUa, link: &mut Link) -> Result<Connection, SessionEnd> {
    let identity = identity(device)?;
    let (mut client, endpoints) = endpoints(device).await?;
    let mut endpoint = choose(device, &endpoints)?;
    if device.certificates.is_some() {
        check_certificate(device, &endpoint.server_certificate, link)?;
    }
    let server = endpoint.server.application_name.text.as_ref().to_owned();
    // Servers behind another network name themselves by addresses that are not reached from here.
    endpoint.endpoint_url = device.url.as_str().into();
    let opened = client.connect_to_endpoint_directly(endpoint, identity);
    let (session, events) = opened.map_err(|error| end_of(device, error.status(), &error.to_string()))?;
    let mut connection = Connection { session, events: events.spawn(), server };
    let connected = connection.session.clone();
    tokio::select! {
        ended = &mut connection.events => {
            let status = ended.unwrap_or(StatusCode::BadUnexpectedError);
            Err(end_of(device, status, "the session was not opened"))
        }
        connected = timeout(LIMIT, connected.wait_for_connection()) => match connected {
            Ok(true) => {
                // The supervisor decides about a second attempt.
                connection.session.disable_reconnects();
                Ok(connection)
            }
            _ => Err(SessionEnd::Silent { who: format!("{} opens no session", device.url), waited: LIMIT }),
        },
    }
}

/// What the server offers, and the client that asked. Cancel safe.
pub(super) async fn endpoints(device: &OpcUa) -> Result<(Client, Vec<EndpointDescription>), SessionEnd> {
    let (host, port) = tcp::host_and_port(&device.url, PORT);
    // The library has one word for all failures of TCP.
    drop(tcp::connect(&host, port, &device.url).await?);
    let client = client(device).await?;
    let endpoints = limited(device, client.get_endpoints(device.url.as_str(), &[], &[])).await?;
    Ok((client, endpoints))
}

fn identity(device: &OpcUa) -> Result<IdentityToken, SessionEnd> {
    let Some((user, password)) = &device.user else { return Ok(IdentityToken::Anonymous) };
    let refused = |why| SessionEnd::Refused { address: device.url.clone(), why };
    let password = credentials::value(password).map_err(refused)?;
    Ok(IdentityToken::new_user_name(user.clone(), password))
}

/// Making the first certificate takes a while.
async fn client(device: &OpcUa) -> Result<Client, SessionEnd> {
    let refused = |why: String| SessionEnd::Refused { address: device.url.clone(), why };
    let folder = device.certificates.clone();
    let encrypted = folder.is_some();
    let builder = ClientBuilder::new()
        .application_name("Trunnion")
        .application_uri("urn:trunnion")
        .product_uri("urn:trunnion")
        .session_name("trunnion")
        .create_sample_keypair(encrypted)
        // A folder that cannot be: without encryption there are no certificates to keep.
        .pki_dir(folder.clone().unwrap_or_else(|| "/dev/null/none".into()))
        // Servers are checked here, by the certificate they had at first.
        .verify_server_certs(false)
        .trust_server_certs(true)
        .session_retry_limit(0)
        .recreate_subscriptions(false)
        .request_timeout(Duration::from_secs(2))
        .session_timeout(20_000);
    let made = tokio::task::spawn_blocking(move || {
        // Without encryption the library reports missing certificates as an error.
        let make = || builder.client();
        if encrypted {
            make()
        } else {
            tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), make)
        }
    });
    let client = made.await.map_err(|error| refused(error.to_string()))?;
    let client = client.map_err(|problems| refused(problems.join("; ")))?;
    if let Some(folder) = folder.filter(|folder| !folder.join("own/cert.der").exists()) {
        let why = format!(
            "no certificate of ours could be made in {}; let the service write there (`certificates`)",
            folder.display()
        );
        return Err(refused(why));
    }
    Ok(client)
}

/// The endpoint with the security that is configured.
pub(super) fn choose(
    device: &OpcUa,
    endpoints: &[EndpointDescription],
) -> Result<EndpointDescription, SessionEnd> {
    let (policy, mode) = match device.certificates {
        Some(_) => (SecurityPolicy::Basic256Sha256, MessageSecurityMode::SignAndEncrypt),
        None => (SecurityPolicy::None, MessageSecurityMode::None),
    };
    let policy_of =
        |endpoint: &EndpointDescription| SecurityPolicy::from_uri(endpoint.security_policy_uri.as_ref());
    let fits =
        |endpoint: &&EndpointDescription| policy_of(endpoint) == policy && endpoint.security_mode == mode;
    endpoints.iter().find(fits).cloned().ok_or_else(|| {
        let mut offered: Vec<String> = endpoints
            .iter()
            .map(|endpoint| format!("{} {:?}", policy_of(endpoint), endpoint.security_mode))
            .collect();
        offered.dedup();
        let why = format!(
            "the server offers {}, not {policy} {mode:?}; set `security`, or allow it at the controller",
            if offered.is_empty() { "nothing".into() } else { offered.join(", ") }
        );
        SessionEnd::Refused { address: device.url.clone(), why }
    })
}

/// The server must have the certificate given, or the one it had at first.
fn check_certificate(device: &OpcUa, found: &ByteString, link: &mut Link) -> Result<(), SessionEnd> {
    let refused = |why: String| SessionEnd::Refused { address: device.url.clone(), why };
    let certificate = X509::from_byte_string(found)
        .map_err(|error| refused(format!("the server's certificate: {error}")))?;
    let thumbprint = certificate.thumbprint().as_hex_string();
    let folder = device.certificates.clone().unwrap_or_default();
    let (host, port) = tcp::host_and_port(&device.url, PORT);
    let pinned = folder.join(format!("server-{host}-{port}.der"));
    let expected = device.server_certificate.clone().unwrap_or_else(|| pinned.clone());
    if !expected.exists() && device.server_certificate.is_none() {
        let bytes = found.as_ref();
        std::fs::write(&expected, bytes)
            .map_err(|error| refused(format!("{} cannot be written: {error}", expected.display())))?;
        link.log(
            true,
            format!(
                "first connection: the server's certificate {thumbprint} is trusted from now on ({}); compare it with \
                 the one shown at the controller",
                expected.display()
            ),
        );
        return Ok(());
    }
    let bytes = std::fs::read(&expected)
        .map_err(|error| refused(format!("{} cannot be read: {error}", expected.display())))?;
    let known = X509::from_der(&bytes)
        .or_else(|_| X509::from_pem(&bytes))
        .map_err(|_| refused(format!("{} is no certificate (DER or PEM)", expected.display())))?;
    if known.thumbprint().as_hex_string() == thumbprint {
        return Ok(());
    }
    Err(SessionEnd::WrongDevice {
        found: format!("a server with the certificate {thumbprint}"),
        expected: format!(
            "the one in {}; if the controller was given a new one, remove that file and start again",
            expected.display()
        ),
    })
}

/// Waits for an answer of the server.
pub(super) async fn limited<T>(
    device: &OpcUa,
    asked: impl Future<Output = Result<T, Error>>,
) -> Result<T, SessionEnd> {
    match timeout(LIMIT, asked).await {
        Err(_) => Err(silent(device, LIMIT)),
        Ok(Err(error)) => Err(end_of(device, error.status(), &error.to_string())),
        Ok(Ok(value)) => Ok(value),
    }
}

pub(super) fn silent(device: &OpcUa, waited: Duration) -> SessionEnd {
    let who =
        format!("{} does not answer; check that the controller runs, and the network between", device.url);
    SessionEnd::Silent { who, waited }
}

/// What a status means for a technician.
pub(super) fn end_of(device: &OpcUa, status: StatusCode, said: &str) -> SessionEnd {
    let refused = |why: String| SessionEnd::Refused { address: device.url.clone(), why };
    let who = || device.user.as_ref().map_or("nobody in particular (no `user`)", |(user, _)| user.as_str());
    let own = || {
        let folder = device.certificates.as_deref().unwrap_or(Path::new(""));
        folder.join("own/cert.der").display().to_string()
    };
    match status {
        StatusCode::BadIdentityTokenRejected
        | StatusCode::BadIdentityTokenInvalid
        | StatusCode::BadUserAccessDenied => {
            refused(format!("the server does not let {} in ({status}); check user and password", who()))
        }
        StatusCode::BadSecurityChecksFailed
        | StatusCode::BadCertificateUntrusted
        | StatusCode::BadCertificateInvalid
        | StatusCode::BadSecurityPolicyRejected => refused(format!(
            "the server refuses our certificate ({status}); trust {} at the controller, or correct user and password",
            own()
        )),
        StatusCode::BadTimeout => silent(device, LIMIT),
        StatusCode::BadConnectionClosed
        | StatusCode::BadNotConnected
        | StatusCode::BadServerHalted
        | StatusCode::BadSecureChannelClosed
        | StatusCode::BadSessionClosed
        | StatusCode::BadCommunicationError => {
            SessionEnd::Disconnected(format!("{}: {said} ({status})", device.url))
        }
        StatusCode::Good => SessionEnd::Disconnected(format!("{}: {said}", device.url)),
        _ => SessionEnd::Protocol {
            doing: "talking to the OPC UA server",
            fault: format!("{said} ({status})"),
        },
    }
}
