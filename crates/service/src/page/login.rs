//! The token, once: the browser keeps a cookie then.

use super::answer::{Refusal, json};
use super::context::{Answer, Page};
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use axum::http::header::SET_COOKIE;
use axum::response::IntoResponse;
use axum::routing::post;
use axum::{Json, Router};
use serde::Deserialize;

/// The call that needs no token yet.
pub(super) const LOGIN: &str = "/api/login";

/// Its route.
pub(super) fn routes() -> Router<Page> {
    Router::new().route(LOGIN, post(login))
}

/// What a person types.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Typed {
    token: String,
}

async fn login(State(page): State<Page>, body: Result<Json<Typed>, JsonRejection>) -> Answer {
    // What was sent is not said again: it may be the token in another shape.
    let shape = |_| Refusal::Wrong("the body is no {\"token\": \"…\"}".into());
    let typed = body.map_err(shape)?.0.token;
    if !page.access.is_token(&typed) {
        tracing::warn!("somebody gave a wrong token to the page");
        return Err(Refusal::WrongToken);
    }
    Ok(([(SET_COOKIE, page.access.cookie())], json("{}".into())).into_response())
}
