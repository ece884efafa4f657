//! What a call gets: JSON of an answer, or the reason why not.

use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use hyper::body::Bytes;
use serde::Serialize;
use serde_json::json;

/// Why a call got no answer.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// A name that is not in the list.
    #[error("there is no {what} \"{name}\"")]
    Unknown {
        /// What was asked for.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// A call by another method than those that it has.
    #[error("{path} is not called by {method}; the header Allow says how")]
    Method {
        /// By which.
        method: String,
        /// What.
        path: String,
    },
    /// A call that is not made well.
    #[error("{0}")]
    Wrong(String),
    /// Nothing is done with runs that cannot be judged.
    #[error("nothing was done, because the runs are not plausible or not whole: {0}")]
    NotTrusted(String),
    /// A run whose samples are gone.
    #[error("its samples were removed ({why}); its report stays")]
    Removed {
        /// When and why.
        why: String,
    },
    /// A run whose samples are gone, which would be compared with another.
    #[error("the samples of {name} were removed; only runs with samples are compared")]
    NotCompared {
        /// Its name.
        name: String,
    },
    /// Not who may call.
    #[error("this is not the token of the page")]
    WrongToken,
    /// Nothing to be done at this moment.
    #[error("{0}")]
    NotNow(&'static str),
    /// The analysis failed.
    #[error("the analysis failed: {0}")]
    Failed(String),
    /// A file that cannot be written or printed.
    #[error("{0}")]
    NotWritten(String),
    /// Too much is asked at once.
    #[error("too many analyses are waiting; ask again in a moment")]
    Busy,
    /// A defect.
    #[error("the {0} ended badly; this is a defect of the program")]
    Broken(&'static str),
}

impl Refusal {
    fn status(&self) -> StatusCode {
        match self {
            Self::Unknown { .. } => StatusCode::NOT_FOUND,
            Self::Method { .. } => StatusCode::METHOD_NOT_ALLOWED,
            Self::Wrong(_) => StatusCode::BAD_REQUEST,
            Self::Removed { .. } | Self::NotCompared { .. } => StatusCode::GONE,
            Self::WrongToken => StatusCode::UNAUTHORIZED,
            Self::NotTrusted(_) | Self::NotNow(_) => StatusCode::CONFLICT,
            Self::Failed(_) | Self::NotWritten(_) => StatusCode::UNPROCESSABLE_ENTITY,
            Self::Busy => StatusCode::SERVICE_UNAVAILABLE,
            Self::Broken(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        refused(self.status(), &trunnion_core::chain(&self))
    }
}

/// A refusal as JSON.
pub fn refused(status: StatusCode, why: &str) -> Response {
    (status, [(CONTENT_TYPE, "application/json")], json!({ "error": why }).to_string()).into_response()
}

/// An answer as JSON.
pub fn json_of(answer: &impl Serialize) -> Result<Response, Refusal> {
    let text = serde_json::to_string(answer).map_err(|_| Refusal::Broken("writing of an answer"))?;
    Ok(json(text.into()))
}

/// An answer that is JSON already.
pub fn json(text: Bytes) -> Response {
    ([(CONTENT_TYPE, "application/json"), (CACHE_CONTROL, "no-store")], text).into_response()
}

/// A page as it is printed.
pub fn pdf(page: Bytes) -> Response {
    ([(CONTENT_TYPE, "application/pdf"), (CACHE_CONTROL, "no-store")], page).into_response()
}

/// A report of its own: it brings its style and has no script.
pub fn report(page: Bytes) -> Response {
    const ALLOWED: &str =
        "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; sandbox";
    let headers = [
        (CONTENT_TYPE, "text/html; charset=utf-8"),
        (CONTENT_SECURITY_POLICY, ALLOWED),
        (CACHE_CONTROL, "no-store"),
    ];
    (headers, page).into_response()
}
