//! Reports: one self-contained HTML page with its plots, and tables for the terminal.
//!
//! Compensation tables ([`compensation`]) in the formats of the controllers.
//!
//! Everything takes an answer (`trunnion-results`) and returns a string; nothing opens a file or asks a clock. Screens
//! show mm, µm, degrees and µrad; `residual = measured − predicted` everywhere.

mod added;
mod certainty;
pub mod compensation;
mod dcc;
mod filed;
mod findings;
mod html;
mod language;
mod markup;

mod parameters;
mod residuals;
mod story;
mod svg;
mod text;
mod time_quality;
mod to_do;
mod views;
mod volumetric;
mod words;

use trunnion_results::number;

pub use dcc::{DccError, Issuer, dcc_xml};
pub use filed::report_html;
pub use html::{
    PAGE_CSS, compare_html, findings_html, ladder_html, magnification, trial_html, volumetric_html,
};
pub use language::Language;
pub use parameters::{parameters_csv, run_csv};
pub use residuals::{by_effect_csv, residuals_csv};
pub use story::story;
pub use text::{
    check_text, compare_text, correction_judged_text, correction_text, diagnosis_text, findings_text,
    history_text, identification_text, ladder_text, live_line, live_screen, location_text, nest_text,
    plan_text, prediction_text, preview_text, report_text, sign_test_text, timing_text, trial_text,
    volumetric_text,
};
pub use time_quality::duration_and_u;
pub use volumetric::error_map_csv;
pub use words::repeatability;
