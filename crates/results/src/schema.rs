//! The JSON schemas, generated from the types.

use crate::{
    Added, AlarmsNow, AxisErrors, Check, Comparison, Correction, CorrectionJudged, CycleProgress,
    DayForecast, Demo, DevicesChecked, DevicesFound, Diagnosis, ErrorMap, Filed, Findings, FormulaChecked,
    Identification, Imported, Joined, Ladder, Linear, Live, MachineHistory, MethodList, ModelChanged,
    NcProgram, NestCalibrated, OF_THE_PRESENT, OrOffline, PageStatus, Plan, Prediction, Preview, Published,
    ReadyNow, Removed, Report, ResultNow, RunList, RunRecord, SamplesRemoved, Scrubbed, ServiceStatus,
    SetUpState, SignTest, Simulation, StorageNow, Story, TimeQuality, Trial, Volumetric, to_json,
};
use schemars::{JsonSchema, Schema, schema_for};

/// Every schema with the name of its file in `docs/schemas`, without `.schema.json`.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("identification", schema_for!(Identification)),
        ("check", schema_for!(Check)),
        ("diagnosis", schema_for!(Diagnosis)),
        ("comparison", schema_for!(Comparison)),
        ("trial", schema_for!(Trial)),
        ("ladder", schema_for!(Ladder)),
        ("added", schema_for!(Added)),
        ("removed", schema_for!(Removed)),
        ("plan", schema_for!(Plan)),
        ("preview", schema_for!(Preview)),
        ("prediction", schema_for!(Prediction)),
        ("findings", schema_for!(Findings)),
        ("volumetric", schema_for!(Volumetric)),
        ("error-map", schema_for!(ErrorMap)),
        ("axis-errors", schema_for!(AxisErrors)),
        ("correction", schema_for!(Correction)),
        ("correction-judged", schema_for!(CorrectionJudged)),
        of_topic::<TimeQuality>(),
        ("nc-program", schema_for!(NcProgram)),
        ("simulation", schema_for!(Simulation)),
        ("imported", schema_for!(Imported)),
        ("joined", schema_for!(Joined)),
        ("scrubbed", schema_for!(Scrubbed)),
        ("demo", schema_for!(Demo)),
        ("devices-found", schema_for!(DevicesFound)),
        ("devices-checked", schema_for!(DevicesChecked)),
        of_topic::<Live>(),
        ("page", schema_for!(PageStatus)),
        ("story", schema_for!(Story)),
        ("runs", schema_for!(RunList)),
        ("run", schema_for!(RunRecord)),
        ("linear", schema_for!(Linear)),
        ("formula", schema_for!(FormulaChecked)),
        ("nest", schema_for!(NestCalibrated)),
        ("report", schema_for!(Report)),
        ("filed", schema_for!(Filed)),
        ("forecast", schema_for!(DayForecast)),
        ("history", schema_for!(MachineHistory)),
        of_topic::<ServiceStatus>(),
        of_topic::<StorageNow>(),
        of_topic::<AlarmsNow>(),
        of_topic::<CycleProgress>(),
        of_topic::<ReadyNow>(),
        of_topic::<ResultNow>(),
        of_topic::<ModelChanged>(),
        of_topic::<SamplesRemoved>(),
        ("sign-test", schema_for!(SignTest)),
        of_topic::<SetUpState>(),
        ("methods", schema_for!(MethodList)),
    ]
}

/// The schema of a topic, under the name that the topic gives it.
fn of_topic<T: Published + JsonSchema>() -> (&'static str, Schema) {
    let now = schema_for!(T);
    if !OF_THE_PRESENT.contains(&T::TOPIC) {
        return (T::SCHEMA, now);
    }
    let mut either = schema_for!(OrOffline<T>);
    for key in ["title", "description"] {
        either.insert(key.into(), now.get(key).cloned().unwrap_or_default());
    }
    (T::SCHEMA, either)
}

/// A schema as its file holds it.
///
/// # Errors
/// None that a schema of this crate can have.
pub fn schema_text(schema: &Schema) -> Result<String, serde_json::Error> {
    to_json(schema)
}
