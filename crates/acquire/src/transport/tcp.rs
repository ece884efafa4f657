//! A TCP connection to `host:port`, with the system's words turned into reasons.

use crate::supervisor::SessionEnd;
use std::io::ErrorKind;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::time::timeout;

/// Connecting must not take longer.
pub const CONNECT_LIMIT: Duration = Duration::from_secs(3);
const REMEDY: &str = "check that it is switched on and its server runs, cable and network, and the address in the configuration";

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
