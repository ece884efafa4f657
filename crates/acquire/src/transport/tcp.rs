//! A TCP connection to `host:port`, with the system's words turned into reasons.

use crate::session_end::SessionEnd;
use std::io::ErrorKind;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::time::timeout;

/// Connecting must not take longer.
pub const CONNECT_LIMIT: Duration = Duration::from_secs(3);
const REMEDY: &str = "check that it is switched on and its server runs, cable and network, and the address in the configuration";

/// Host and port of a URL, or of what stands in one; `usual` when it names no port.
pub fn host_and_port(url: &str, usual: u16) -> (String, u16) {
    let rest = url.split_once("://").map_or(url, |(_, rest)| rest);
    let authority = rest.split('/').next().unwrap_or(rest);
    let named = authority.rsplit_once(':').filter(|(host, _)| !host.contains(':') || host.ends_with(']'));
    let (host, port) = match named.and_then(|(host, port)| Some((host, port.parse().ok()?))) {
        Some((host, port)) => (host, port),
        None => (authority, usual),
    };
    (host.trim_matches(['[', ']']).into(), port)
}

/// Connects; small packets are sent at once. `shown` is the address in messages. Cancel safe.
///
/// # Errors
/// `Absent` when nobody listens, `Silent` when the host does not answer, `Refused` when the system does not let us.
pub async fn connect(host: &str, port: u16, shown: &str) -> Result<TcpStream, SessionEnd> {
    let stream = match timeout(CONNECT_LIMIT, TcpStream::connect((host, port))).await {
        Err(_) => return Err(SessionEnd::Silent { who: shown.into(), waited: CONNECT_LIMIT }),
        Ok(Err(error)) if error.kind() == ErrorKind::PermissionDenied => {
            return Err(SessionEnd::Refused { address: shown.into(), why: error.to_string() });
        }
        Ok(Err(error)) => {
            return Err(SessionEnd::Absent { address: format!("{shown} ({error})"), remedy: REMEDY });
        }
        Ok(Ok(stream)) => stream,
    };
    stream.set_nodelay(true).map_err(|error| SessionEnd::Disconnected(format!("{shown}: {error}")))?;
    Ok(stream)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_is_taken_from_the_url_or_is_the_usual_one() {
        let check = |url: &str, host: &str, port: u16| {
            assert_eq!(host_and_port(url, 4840), (host.into(), port), "{url}");
        };
        check("opc.tcp://cnc", "cnc", 4840);
        check("opc.tcp://10.0.0.5:48010/UA/Server", "10.0.0.5", 48010);
        check("linuxcnc://[fe80::1:2]", "fe80::1:2", 4840);
        check("[fe80::1]:5007", "fe80::1", 5007);
        check("cnc:99999", "cnc:99999", 4840);
    }
}
