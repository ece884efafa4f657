//! The JSON schemas, generated from the types.

use crate::{
    Added, AlarmsNow, AxisErrors, Check, Comparison, Correction, CorrectionJudged, CycleProgress,
    DayForecast, Demo, DevicesChecked, DevicesFound, Diagnosis, ErrorMap, Findings, FormulaChecked,
    Identification, Imported, Joined, Ladder, Linear, Live, MachineHistory, MethodList, ModelChanged,
    NcProgram, NestCalibrated, PageStatus, Plan, Prediction, Preview, ReadyNow, Removed, Report, ResultNow,
    RunList, RunRecord, SamplesRemoved, Scrubbed, ServiceStatus, SetUpState, SignTest, Simulation,
    StorageNow, Story, TimeQuality, Trial, Volumetric, to_json,
};
use schemars::{Schema, schema_for};

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
        ("time-quality", schema_for!(TimeQuality)),
        ("nc-program", schema_for!(NcProgram)),
        ("simulation", schema_for!(Simulation)),
        ("imported", schema_for!(Imported)),
        ("joined", schema_for!(Joined)),
        ("scrubbed", schema_for!(Scrubbed)),
        ("demo", schema_for!(Demo)),
        ("devices-found", schema_for!(DevicesFound)),
        ("devices-checked", schema_for!(DevicesChecked)),
        ("live", schema_for!(Live)),
        ("page", schema_for!(PageStatus)),
        ("story", schema_for!(Story)),
        ("runs", schema_for!(RunList)),
        ("run", schema_for!(RunRecord)),
        ("linear", schema_for!(Linear)),
        ("formula", schema_for!(FormulaChecked)),
        ("nest", schema_for!(NestCalibrated)),
        ("report", schema_for!(Report)),
        ("forecast", schema_for!(DayForecast)),
        ("history", schema_for!(MachineHistory)),
        ("status", schema_for!(ServiceStatus)),
        ("storage", schema_for!(StorageNow)),
        ("alarms", schema_for!(AlarmsNow)),
        ("cycle", schema_for!(CycleProgress)),
        ("ready", schema_for!(ReadyNow)),
        ("result", schema_for!(ResultNow)),
        ("model-changed", schema_for!(ModelChanged)),
        ("samples-removed", schema_for!(SamplesRemoved)),
        ("sign-test", schema_for!(SignTest)),
        ("set-up", schema_for!(SetUpState)),
        ("methods", schema_for!(MethodList)),
    ]
}

/// A schema as its file holds it.
///
/// # Errors
/// None that a schema of this crate can have.
pub fn schema_text(schema: &Schema) -> Result<String, serde_json::Error> {
    to_json(schema)
}
