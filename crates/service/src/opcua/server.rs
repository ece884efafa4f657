//! The server, and how its values follow the board.

use super::nodes;
use crate::board::Board;
use crate::plant::PlantView;
use opcua_server::{Server, ServerBuilder, ServerEndpoint, ServerHandle};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use tracing::warn;

/// Clients at once.
const MOST_SESSIONS: usize = 8;
/// Values of an item that wait for a client that is slow to fetch them.
const QUEUE: usize = 10;
/// A server that is asked to stop closes its connections in this time.
const STOP_LIMIT: Duration = Duration::from_secs(5);

/// Serves clients until `cancel`.
///
/// # Errors
/// In words: a server that cannot be built, or that ended by itself.
pub async fn serve(listener: TcpListener, board: Board, cancel: CancellationToken) -> Result<(), String> {
    let address = listener.local_addr().map_err(|error| error.to_string())?;
    let (server, handle) = built(address)?;
    let mut shown = PlantView::of(&board);
    let values = nodes::Nodes::add(&handle)?;
    values.set(&handle, &shown)?;
    let mut changes = board.changes();
    let mut running = tokio::spawn(server.run_with(listener));
    loop {
        tokio::select! {
            () = cancel.cancelled() => break,
            ended = &mut running => return Err(format!("the server ended by itself: {ended:?}")),
            changed = changes.changed() => if changed.is_err() {
                break;
            },
        }
        let now = PlantView::of(&board);
        if now != shown {
            values.set(&handle, &now)?;
            shown = now;
        }
    }
    handle.cancel();
    if timeout(STOP_LIMIT, &mut running).await.is_err() {
        running.abort();
        warn!("the OPC UA server did not close its connections in time");
    }
    Ok(())
}

fn built(address: SocketAddr) -> Result<(Server, ServerHandle), String> {
    let mut builder = ServerBuilder::new()
        .application_name("Trunnion")
        .application_uri(nodes::OWN_NAMESPACE)
        .product_uri(nodes::OWN_NAMESPACE)
        .host(address.ip().to_string())
        .port(address.port())
        // Without encryption there are no certificates to keep.
        .pki_dir("/dev/null/none")
        .add_endpoint("none", ServerEndpoint::new_none("/", &["ANONYMOUS".to_owned()]))
        .discovery_urls(vec!["/".to_owned()])
        .max_sessions(MOST_SESSIONS)
        .with_node_manager(nodes::manager());
    let limits = &mut builder.limits_mut().subscriptions;
    limits.max_monitored_item_queue_size = QUEUE;
    limits.max_queued_notifications = QUEUE;
    // Without encryption the library reports missing certificates as an error.
    let silent = tracing::subscriber::NoSubscriber::new();
    tracing::subscriber::with_default(silent, || builder.build())
}
