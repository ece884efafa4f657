//! Connections: so many at once, and none that says nothing.

use super::calls;
use super::guard::{Guard, guarded};
use super::shared::Shared;
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tracing::{debug, warn};

/// Connections at once: two browsers have twelve.
const MOST_CONNECTIONS: usize = 64;
/// A browser sends a head at once; one that dribbles, or says nothing, is let go.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// The largest call holds a name and an expression.
const MOST_BODY: usize = 16 * 1024;
/// When the system has no more files.
const BREATHER: Duration = Duration::from_millis(100);

/// Serves the page until `cancel`.
///
/// # Errors
/// When the listener has no address.
pub async fn serve(
    listener: TcpListener,
    shared: Arc<Shared>,
    cancel: CancellationToken,
) -> std::io::Result<()> {
    let guard = Arc::new(Guard::new(listener.local_addr()?));
    let app: Router = calls::routes(shared, cancel.clone())
        .layer(DefaultBodyLimit::max(MOST_BODY))
        .layer(from_fn_with_state(guard, guarded));
    let connections = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    loop {
        // The next one waits in the system's queue until there is room.
        let Ok(permit) = connections.clone().acquire_owned().await else { return Ok(()) };
        let accepted = tokio::select! {
            () = cancel.cancelled() => return Ok(()),
            accepted = listener.accept() => accepted,
        };
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(error) => {
                warn!(%error, "the page could not take a connection");
                tokio::time::sleep(BREATHER).await;
                continue;
            }
        };
        let (app, cancel) = (app.clone(), cancel.clone());
        tokio::spawn(async move {
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(HEAD_TIMEOUT)
                .serve_connection(TokioIo::new(stream), TowerToHyperService::new(app));
            let ended = tokio::select! {
                () = cancel.cancelled() => Ok(()),
                ended = connection => ended,
            };
            if let Err(error) = ended {
                debug!(%error, "a connection to the page ended");
            }
            drop(permit);
        });
    }
}
