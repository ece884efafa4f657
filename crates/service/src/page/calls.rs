//! The calls (docs/use/page.md), each with the command that does the same.

use super::access::Access;
use super::answer::{Refusal, json, json_of, report};
use super::context::{Answer, Page, person, status_of, wrong};
use super::question::{Asks, Step, Typed};
use super::runs::Runs;
use super::shared::Shared;
use super::{assets, cycle_calls, filed_calls, live, login, method_calls, set_up_calls};
use crate::clock::minute;
use axum::extract::rejection::JsonRejection;
use axum::extract::{Path, State};
use axum::http::{Method, Uri};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use std::sync::Arc;
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use trunnion::history::{of_found, without};
use trunnion::results::{ModelChanged, ModelStep};

/// Every call.
pub fn routes(shared: Arc<Shared>, access: Access, cancel: CancellationToken) -> Router {
    let printer = Arc::new(Semaphore::new(1));
    let (watchers, filing) = (live::places(), Arc::default());
    let page = Page { runs: shared.runs.clone(), shared, access, watchers, printer, filing, cancel };
    Router::new()
        .route("/", get(|| async { assets::index() }))
        .route("/assets/{name}", get(asset))
        .route("/api/status", get(status))
        .route("/api/live", get(watch))
        .route("/api/runs", get(runs))
        .route("/api/history", get(history))
        .route("/api/history/corrections", post(corrected))
        .route("/api/history/next-day", get(next_day))
        .route("/api/history/change", get(change))
        .route("/api/runs/{name}", get(story))
        .route("/api/runs/{name}/identification", get(identification))
        .route("/api/runs/{name}/diagnosis", get(diagnosis))
        .route("/api/runs/{name}/comparison", get(comparison))
        .route("/api/runs/{name}/ladder", get(ladder))
        .route("/api/runs/{name}/report", get(compare_page))
        .route("/api/runs/{name}/trial/{effect}", get(trial_page))
        .route("/api/runs/{name}/linear", get(linear).post(linear_with))
        .route("/api/runs/{name}/model/{effect}", post(add).delete(remove))
        .route("/api/formula", post(formula))
        .merge(filed_calls::routes())
        .merge(cycle_calls::routes())
        .merge(set_up_calls::routes())
        .merge(login::routes())
        .merge(method_calls::routes())
        .method_not_allowed_fallback(|method: Method, uri: Uri| async move {
            Refusal::Method { method: method.to_string(), path: uri.path().into() }
        })
        .fallback(|uri: Uri| async move { Refusal::Unknown { what: "call", name: uri.path().into() } })
        .with_state(page)
}

async fn asset(Path(name): Path<String>) -> Answer {
    assets::asset(&name).ok_or(Refusal::Unknown { what: "file", name })
}

async fn status(State(page): State<Page>) -> Answer {
    status_of(&page)
}

async fn watch(State(page): State<Page>) -> Answer {
    let place = page.watchers.clone().try_acquire_owned().map_err(|_| Refusal::Busy)?;
    Ok(live::events(&page.shared.board, page.cancel.clone(), place))
}

async fn runs(State(page): State<Page>) -> Answer {
    let runs = page.runs.clone();
    let list = tokio::task::spawn_blocking(move || runs.list()).await;
    json_of(&list.map_err(|_| Refusal::Broken("list of the recordings"))?)
}

async fn history(State(page): State<Page>) -> Answer {
    history_of(page.runs, |_| Ok(())).await
}

/// The history, after `first` did what it does with it.
async fn history_of(
    runs: Arc<Runs>,
    first: impl FnOnce(&Runs) -> Result<(), Refusal> + Send + 'static,
) -> Answer {
    let history = move || {
        first(&runs)?;
        Ok::<_, Refusal>(of_found(&runs.list().runs, &runs.corrections()?))
    };
    let history = tokio::task::spawn_blocking(history).await;
    json_of(&history.map_err(|_| Refusal::Broken("history of the machine"))??)
}

/// A correction that was entered into the control at this moment.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Corrected {
    by: String,
    what: String,
}

async fn corrected(State(page): State<Page>, body: Result<Json<Corrected>, JsonRejection>) -> Answer {
    let Corrected { by, what } = body.map_err(wrong)?.0;
    let wall_ns = page.shared.clock.wall_ns();
    let board = page.shared.board.clone();
    let enter = move |runs: &Runs| {
        runs.enter_correction(wall_ns, &by, &what)?;
        // Limits begin again.
        runs.publish_alarms(&board)
    };
    history_of(page.runs, enter).await
}

async fn next_day(State(page): State<Page>) -> Answer {
    let runs = page.runs.clone();
    let days = tokio::task::spawn_blocking(move || runs.days()).await;
    match days.map_err(|_| Refusal::Broken("history of the machine"))?? {
        Ok((name, recordings)) => Ok(json(page.runs.ask(&name, Asks::NextDay { recordings }).await?)),
        Err(why_not) => json_of(&without(why_not)),
    }
}

async fn change(State(page): State<Page>) -> Answer {
    let runs = page.runs.clone();
    let last_two = tokio::task::spawn_blocking(move || runs.last_two()).await;
    match last_two.map_err(|_| Refusal::Broken("history of the machine"))?? {
        Some((later, earlier)) => Ok(json(page.runs.ask(&later, Asks::Change { earlier }).await?)),
        None => Err(Refusal::NotNow("two analysed runs are compared, and there are fewer")),
    }
}

async fn story(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Story).await?))
}

async fn identification(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Identification).await?))
}

async fn diagnosis(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Diagnosis).await?))
}

async fn comparison(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Comparison).await?))
}

async fn ladder(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Ladder).await?))
}

async fn linear(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::Linear).await?))
}

async fn linear_with(
    State(page): State<Page>,
    Path(name): Path<String>,
    body: Result<Json<Typed>, JsonRejection>,
) -> Answer {
    Ok(json(page.runs.ask(&name, Asks::LinearWith(body.map_err(wrong)?.0)).await?))
}

async fn compare_page(State(page): State<Page>, Path(name): Path<String>) -> Answer {
    if let Some(left) = page.runs.left_report(&name) {
        return Ok(report(left.into()));
    }
    Ok(report(page.runs.ask(&name, Asks::Report).await?))
}

async fn trial_page(State(page): State<Page>, Path((name, effect)): Path<(String, String)>) -> Answer {
    Ok(report(page.runs.ask(&name, Asks::Trial { effect }).await?))
}

/// Who adds or removes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Who {
    by: String,
}

async fn add(
    State(page): State<Page>,
    Path((name, effect)): Path<(String, String)>,
    body: Result<Json<Who>, JsonRejection>,
) -> Answer {
    let by = person(&body.map_err(wrong)?.0.by, "who adds it?")?;
    let date = minute(page.shared.clock.wall_ns());
    let story = page.runs.ask(&name, Asks::Add(Step { effect: effect.clone(), by, date })).await?;
    changed(&page, &name, &effect, ModelStep::Added);
    Ok(json(story))
}

async fn remove(
    State(page): State<Page>,
    Path((name, effect)): Path<(String, String)>,
    body: Result<Json<Who>, JsonRejection>,
) -> Answer {
    let by = person(&body.map_err(wrong)?.0.by, "who removes it?")?;
    let date = minute(page.shared.clock.wall_ns());
    let story = page.runs.ask(&name, Asks::Remove(Step { effect: effect.clone(), by, date })).await?;
    changed(&page, &name, &effect, ModelStep::Removed);
    Ok(json(story))
}

/// Other browsers show it at once.
fn changed(page: &Page, run: &str, effect: &str, state: ModelStep) {
    let at_ns = page.shared.clock.now().0;
    page.shared.board.publish(&ModelChanged { run: run.into(), effect: effect.into(), state, at_ns });
}

/// An expression as far as it is typed, and the run that it is for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedFor {
    run: String,
    site: String,
    component: String,
    expression: String,
}

async fn formula(State(page): State<Page>, body: Result<Json<TypedFor>, JsonRejection>) -> Answer {
    let TypedFor { run, site, component, expression } = body.map_err(wrong)?.0;
    Ok(json(page.runs.ask(&run, Asks::Formula(Typed { site, component, expression })).await?))
}
