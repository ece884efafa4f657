//! Connections: so many at once, and none that says nothing.

use super::access::Access;
use super::calls;
use super::guard::{Guard, Peer, guarded};
use super::places::{MOST_CONNECTIONS, Places};
use super::shared::Shared;
use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::error::Error;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio_rustls::TlsAcceptor;
use tokio_util::sync::CancellationToken;
use tracing::{debug, warn};

/// A browser sends a head at once; one that dribbles, or says nothing, is let go.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// The largest call holds a name and an expression.
const MOST_BODY: usize = 16 * 1024;
/// When the system has no more files.
const BREATHER: Duration = Duration::from_millis(100);

/// Serves the page until `cancel`, to whom `access` lets in.
///
/// # Errors
/// When the listener has no address.
pub async fn serve(
    listener: TcpListener,
    shared: Arc<Shared>,
    access: Access,
    cancel: CancellationToken,
) -> std::io::Result<()> {
    let runs = shared.runs.clone();
    let served = accept(listener, shared, access, cancel).await;
    // An analysis that nobody waits for ends with the page.
    runs.stop();
    served
}

async fn accept(
    listener: TcpListener,
    shared: Arc<Shared>,
    access: Access,
    cancel: CancellationToken,
) -> std::io::Result<()> {
    let guard = Arc::new(Guard::new(listener.local_addr()?, access.clone()));
    let app: Router = calls::routes(shared, access.clone(), cancel.clone())
        .layer(DefaultBodyLimit::max(MOST_BODY))
        .layer(from_fn_with_state(guard, guarded));
    let connections = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    let places = Places::default();
    loop {
        // The next one waits in the system's queue until there is room.
        let Ok(permit) = connections.clone().acquire_owned().await else { return Ok(()) };
        let accepted = tokio::select! {
            () = cancel.cancelled() => return Ok(()),
            accepted = listener.accept() => accepted,
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                warn!(%error, "the page could not take a connection");
                tokio::time::sleep(BREATHER).await;
                continue;
            }
        };
        let Some(place) = places.take(peer.ip()) else { continue };
        let app = app.clone().layer(Extension(Peer(peer.ip())));
        let (tls, cancel) = (access.tls.clone(), cancel.clone());
        tokio::spawn(async move {
            let ended = tokio::select! {
                () = cancel.cancelled() => Ok(()),
                ended = connection(stream, tls, app) => ended,
            };
            if let Err(error) = ended {
                debug!(%error, "a connection to the page ended");
            }
            drop((permit, place));
        });
    }
}

/// One connection, encrypted where others could read it.
async fn connection(
    stream: TcpStream,
    tls: Option<TlsAcceptor>,
    app: Router,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    match tls {
        None => speak(stream, app).await?,
        Some(tls) => speak(tokio::time::timeout(HEAD_TIMEOUT, tls.accept(stream)).await??, app).await?,
    }
    Ok(())
}

async fn speak<S: AsyncRead + AsyncWrite + Unpin>(stream: S, app: Router) -> hyper::Result<()> {
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(app))
        .await
}
