//! What plants read of the service by protocols that connect to it: each is started where the configuration says so.

use crate::board::Board;
use crate::config::Config;
use crate::mtconnect;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use tracing::{info, warn};

/// Starts the adapter for agents of MTConnect; measuring goes on without it where it cannot listen.
pub async fn adapter(config: &Config, board: &Board, cancel: &CancellationToken) -> Option<JoinHandle<()>> {
    let place = config.mtconnect.as_ref()?;
    match tokio::net::TcpListener::bind(place.listen).await {
        Ok(listener) => {
            info!(address = %place.listen, "agents of MTConnect are served");
            Some(tokio::spawn(mtconnect::serve(listener, place.clone(), board.clone(), cancel.clone())))
        }
        Err(error) => {
            warn!(%error, address = %place.listen, "agents of MTConnect are not served: the address cannot be listened on");
            None
        }
    }
}

/// Starts the OPC UA server; measuring goes on without it where it cannot listen.
#[cfg(feature = "opcua")]
pub async fn opcua_server(
    config: &Config,
    board: &Board,
    cancel: &CancellationToken,
) -> Option<JoinHandle<()>> {
    let address = config.opcua?.listen;
    let listener = match tokio::net::TcpListener::bind(address).await {
        Ok(listener) => listener,
        Err(error) => {
            warn!(%error, %address, "there is no OPC UA server: the address cannot be listened on");
            return None;
        }
    };
    info!("the OPC UA server is at opc.tcp://{address}");
    let (board, cancel) = (board.clone(), cancel.clone());
    Some(tokio::spawn(async move {
        if let Err(why) = crate::opcua::serve(listener, board, cancel).await {
            warn!(why, "the OPC UA server ended");
        }
    }))
}

/// A configuration with `[opcua]` is refused.
#[cfg(not(feature = "opcua"))]
pub async fn opcua_server(
    _config: &Config,
    _board: &Board,
    _cancel: &CancellationToken,
) -> Option<JoinHandle<()>> {
    None
}
