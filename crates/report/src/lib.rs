//! Reports: one self-contained HTML page with its plots, and tables for the terminal.
//!
//! Compensation tables ([`compensation`]) in the formats of the controllers.
//!
//! Everything takes plain data ([`CompareInput`]) and returns a string; nothing opens a file or asks a clock. Screens
//! show mm, µm, degrees and µrad; `residual = measured − predicted` everywhere.

pub mod compensation;
mod findings;
mod from_results;
mod html;
mod input;
mod markup;

mod svg;
mod text;
mod time_quality;
mod views;
mod volumetric;
mod words;

use trunnion_results::number;

pub use from_results::{ladder_of, points_of};
pub use html::{compare_html, findings_html, ladder_html, trial_html, volumetric_html};
pub use input::{CompareInput, LadderRow, Noise, Place, PointView, SetupView, Trial};
pub use text::{
    compare_text, diagnosis_text, findings_text, identification_text, ladder_text, location_text,
    prediction_text, timing_text, trial_text, volumetric_text,
};
pub use time_quality::duration;
pub use volumetric::error_map_csv;
pub use words::repeatability;
