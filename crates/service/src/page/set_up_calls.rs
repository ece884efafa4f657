//! The calls of setting up at the machine (docs/use/page.md).

use super::answer::Refusal;
use super::context::{Answer, Page, status_of};
use crate::set_up::{NoSetUp, SetUp};
use axum::Router;
use axum::extract::State;
use axum::routing::post;
use trunnion::results::SetUpStep;

/// Their routes.
pub(super) fn routes() -> Router<Page> {
    Router::new()
        .route("/api/set-up/nest", post(nest))
        .route("/api/set-up/nest/finish", post(finish_nest))
        .route("/api/set-up/nest/write", post(write_nest))
        .route("/api/set-up/sign-test", post(sign_test))
        .route("/api/set-up/stop", post(stop))
}

async fn nest(State(page): State<Page>) -> Answer {
    done(&page, |set_up| set_up.begin(SetUpStep::Nest))
}

async fn sign_test(State(page): State<Page>) -> Answer {
    done(&page, |set_up| set_up.begin(SetUpStep::SignTest))
}

async fn finish_nest(State(page): State<Page>) -> Answer {
    done(&page, SetUp::finish_nest)
}

async fn write_nest(State(page): State<Page>) -> Answer {
    // A disk may be slow; other calls go on.
    tokio::task::spawn_blocking(move || done(&page, SetUp::write_nest))
        .await
        .map_err(|_| Refusal::Broken("writing of the configuration"))?
}

async fn stop(State(page): State<Page>) -> Answer {
    done(&page, |set_up| {
        set_up.stop();
        Ok(())
    })
}

fn done(page: &Page, work: impl FnOnce(&SetUp) -> Result<(), NoSetUp>) -> Answer {
    let set_up = page.shared.set_up.as_ref();
    let set_up = set_up.ok_or(Refusal::NotNow("nothing is measured behind this page"))?;
    work(set_up).map_err(|refused| Refusal::Wrong(refused.to_string()))?;
    status_of(page)
}
