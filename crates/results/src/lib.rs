//! Every answer as a value: serde types with a JSON schema, made from what engine and methods found.
//!
//! Numbers are in screen units (mm, µm, degrees, µrad); a number that is not known is `null`. JSON is written from these
//! types and read back into them. Text and pages are made from them too ([`number`]), so that they show the same figures.

mod comparison;
mod compensation;
mod diagnosis;
mod findings;
mod identification;
mod ladder;
mod location;
pub mod number;
mod plan;
mod prediction;
mod preview;
mod schema;
pub mod sentences;
mod time_quality;
mod volumetric;

pub use comparison::{
    BeforeAfter, Comparison, ComparisonFormat, Place, PlacesBeforeAfter, Then, Trial, TrialFormat,
};
pub use compensation::{CompensationAxis, CompensationFormat, CompensationSummary, CompensationValues};
pub use diagnosis::{
    Candidate, Diagnosis, DiagnosisFormat, FormulaProposal, NextCycle, PlannedCycle, Residual, ShapeNumber,
    Verdict,
};
pub use findings::{
    AxisName, Cell, Chart, Column, Curve, Findings, FindingsFormat, FoundValue, MapPlace, Plot, Table,
};
pub use identification::{
    Combination, Identification, IdentificationFormat, LeftOut, NoiseOfRun, NoiseOrigin, NoisePart, Outlier,
    Parameter, Shape, Term, UncertaintyOrigin, Unobservable,
};
pub use ladder::{Added, Ladder, LadderEntry, LadderFormat, LadderRow, Moved, Removed};
pub use location::{LocationError, LocationErrors};
pub use plan::{Considered, Goal, LeftOpen, NextPlanned, Plan, PlanFormat};
pub use prediction::{Prediction, PredictionFormat, RunPrediction};
pub use preview::{Alias, OutOfReach, Preview, PreviewFormat, SeenBy, SeparatedBy};
pub use schema::{schema_text, schemas};
pub use time_quality::{Gesture, GestureChannel, Stream, TimeQuality};
pub use volumetric::{Datum, LeftOutEffect, Unseen, Volumetric, VolumetricFormat, VolumetricValue};

/// JSON as the program writes it: indented, with a final newline.
///
/// # Errors
/// A value that JSON cannot hold; the types of this crate are none.
pub fn to_json(answer: &impl serde::Serialize) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(answer).map(|text| text + "\n")
}
