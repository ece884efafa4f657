//! The calls of named methods of the literature (docs/use/page.md).

use super::answer::{json_of, report};
use super::context::{Answer, Page};
use axum::Router;
use axum::extract::{Path, State};
use axum::routing::get;
use trunnion::MethodOptions;
use trunnion::page::label;
use trunnion::report::findings_html;

/// Their routes.
pub(super) fn routes() -> Router<Page> {
    Router::new()
        .route("/api/runs/{name}/methods", get(methods))
        .route("/api/runs/{name}/method/{method}", get(method_page))
}

async fn methods(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    let open = page.runs.open(&name).await?;
    let list = page.runs.alone(move |_| Ok(open.compared.diagnosed().fit().experiment().methods())).await?;
    json_of(&list)
}

async fn method_page(State(page): State<Page>, Path((name, method)): Path<(String, String)>) -> Answer {
    let open = page.runs.open(&name).await?;
    let found = page.runs.alone(move |_| {
        let experiment = open.compared.diagnosed().fit().experiment().clone();
        Ok(experiment.by_method(&method, &MethodOptions::default())?)
    });
    Ok(report(findings_html(&found.await?, &label())))
}
