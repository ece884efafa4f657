//! The calls of named methods of the literature (docs/use/page.md).

use super::answer::{json, report};
use super::context::{Answer, Page};
use super::question::Asks;
use axum::Router;
use axum::extract::{Path, State};
use axum::routing::get;

/// Their routes.
pub(super) fn routes() -> Router<Page> {
    Router::new()
        .route("/api/runs/{name}/methods", get(methods))
        .route("/api/runs/{name}/method/{method}", get(method_page))
}

async fn methods(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Methods).await?))
}

async fn method_page(State(page): State<Page>, Path((name, method)): Path<(String, String)>) -> Answer {
    Ok(report(page.runs.ask(&name, Asks::Method { name: method }).await?))
}
