//! What plants read of the service by protocols that connect to it: each is started where the configuration says so.

use super::listening::listening;
use crate::board::Board;
use crate::config::Config;
use crate::mtconnect;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use tracing::info;

/// Starts the adapter for agents of MTConnect.
pub fn adapter(config: &Config, board: &Board, cancel: &CancellationToken) -> Option<JoinHandle<()>> {
    let place = config.mtconnect.clone()?;
    let (board, cancel) = (board.clone(), cancel.clone());
    Some(tokio::spawn(async move {
        if let Some(listener) = listening("mtconnect", place.listen, &board, &cancel).await {
            info!(address = %place.listen, "agents of MTConnect are served");
            mtconnect::serve(listener, place, board, cancel).await;
        }
    }))
}

/// Starts the OPC UA server.
#[cfg(feature = "opcua")]
pub fn opcua_server(config: &Config, board: &Board, cancel: &CancellationToken) -> Option<JoinHandle<()>> {
    let address = config.opcua?.listen;
    let (board, cancel) = (board.clone(), cancel.clone());
    Some(tokio::spawn(async move {
        let Some(listener) = listening("opcua", address, &board, &cancel).await else { return };
        info!("the OPC UA server is at opc.tcp://{address}");
        if let Err(why) = crate::opcua::serve(listener, board.clone(), cancel).await {
            tracing::warn!(why, "the OPC UA server ended");
            board.set_connection("opcua", &format!("the server ended: {why}"));
        }
    }))
}

/// A configuration with `[opcua]` is refused.
#[cfg(not(feature = "opcua"))]
pub fn opcua_server(_config: &Config, _board: &Board, _cancel: &CancellationToken) -> Option<JoinHandle<()>> {
    None
}
