//! The files of the page, in the binary: nothing is fetched from elsewhere.

use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";

/// Name below `/assets/`, type, content.
const ASSETS: [(&str, &str, &str); 22] = [
    ("page.css", CSS, include_str!("assets/page.css")),
    ("report.css", CSS, trunnion::report::PAGE_CSS),
    ("main.js", SCRIPT, include_str!("assets/main.js")),
    ("canvas.js", SCRIPT, include_str!("assets/canvas.js")),
    ("chart.js", SCRIPT, include_str!("assets/chart.js")),
    ("dom.js", SCRIPT, include_str!("assets/dom.js")),
    ("calls.js", SCRIPT, include_str!("assets/calls.js")),
    ("result.js", SCRIPT, include_str!("assets/result.js")),
    ("measure.js", SCRIPT, include_str!("assets/measure.js")),
    ("login.js", SCRIPT, include_str!("assets/login.js")),
    ("live.js", SCRIPT, include_str!("assets/live.js")),
    ("set-up.js", SCRIPT, include_str!("assets/set-up.js")),
    ("poses.js", SCRIPT, include_str!("assets/poses.js")),
    ("pose-map.js", SCRIPT, include_str!("assets/pose-map.js")),
    ("what-if.js", SCRIPT, include_str!("assets/what-if.js")),
    ("joint.js", SCRIPT, include_str!("assets/joint.js")),
    ("residual-bars.js", SCRIPT, include_str!("assets/residual-bars.js")),
    ("overlay.js", SCRIPT, include_str!("assets/overlay.js")),
    ("history.js", SCRIPT, include_str!("assets/history.js")),
    ("heat-map.js", SCRIPT, include_str!("assets/heat-map.js")),
    ("uplot.js", SCRIPT, include_str!("assets/uplot/uPlot.iife.min.js")),
    ("uplot.css", CSS, include_str!("assets/uplot/uPlot.min.css")),
];

/// The page itself.
pub fn index() -> Response {
    answer(HTML, include_str!("assets/index.html"))
}

/// The file of this name.
pub fn asset(name: &str) -> Option<Response> {
    let (_, kind, content) = ASSETS.iter().find(|(known, ..)| *known == name)?;
    Some(answer(kind, content))
}

fn answer(kind: &'static str, content: &'static str) -> Response {
    // Another version of the program has other files under the same names.
    ([(CONTENT_TYPE, kind), (CACHE_CONTROL, "no-cache")], content).into_response()
}
