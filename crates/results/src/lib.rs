//! Every answer as a value: serde types with a JSON schema, made from what engine and methods found.
//!
//! Numbers are in screen units (mm, µm, degrees, µrad); a number that is not known is `null`. JSON is written from these
//! types and read back into them. Text and pages are made from them too ([`number`]), so that they show the same figures.

mod alarms;
mod axis_errors;
mod chain;
mod change;
mod comparison;
mod complete;
mod conformity;
mod correctable;
mod corrected;
mod correction;
mod cycle_topics;
mod demo;
mod devices;
mod diagnosis;
mod diagnosis_from_engine;
mod doubt;
mod filed;
mod findings;
mod forecast;
mod history;
mod identification;
mod identification_from_engine;
mod json;
mod ladder;
mod left_out;
mod linear;
mod live;
mod location;
mod method_list;
mod nc_program;
pub mod number;
mod of_the_present;
mod page_status;
mod plan;
mod plausibility;
mod prediction;
mod preview;
mod residuals;
mod run_record;
mod schema;
pub mod sentences;
mod service_status;
mod set_up_state;
mod setting_up;
mod spectrum;
mod story;
mod time_quality;
mod topics;
mod volumetric;
mod written;

pub use alarms::{Alarm, AlarmsNow};
pub use axis_errors::{AxisErrors, AxisErrorsFormat, AxisTable, ConfoundedErrors};
pub use chain::{Chain, ChainJoint};
pub use change::ChangedParameter;
pub use comparison::{
    AxisRange, BeforeAfter, Comparison, ComparisonFormat, Place, PlacesBeforeAfter, Region,
    ResidualsBeforeAfter, SpectraBeforeAfter, Then, Trial, TrialFormat,
};
pub use complete::{Complete, Excluded, ExcludedSamples, Missing, Samples};
pub use conformity::{Conformity, Decision, ExcludedPoints, Judged};
pub use correctable::Correctable;
pub use corrected::{AroundCorrection, CorrectionEntered};
pub use correction::{
    CorrectedAxis, Correction, CorrectionFormat, CorrectionJudged, CorrectionJudgedFormat, CorrectionValues,
    Expected, PositionShare, SelfTest, SelfTestPose, SignCheck, SignVerdict,
};
pub use cycle_topics::{CycleProgress, FailedState, ModelChanged, ModelStep, ReadyNow, ResultNow, RunFailed};
pub use demo::{Demo, DemoFormat, DemoStep};
pub use devices::{CheckedDevice, DevicePlace, DevicesChecked, DevicesFormat, DevicesFound};
pub use diagnosis::{
    Candidate, Diagnosis, DiagnosisFormat, FormulaProposal, LearnedNoise, NextCycle, OpenEffect,
    PlannedCycle, Residual, ShapeNumber, Together, Verdict,
};
pub use doubt::{Doubt, DoubtReason};
pub use filed::{
    Filed, FiledFormat, Identity, Report, ReportFormat, RunIdentity, SensorCalibration, TemperatureRange,
};
pub use findings::{
    AxisName, Cell, Chart, Column, Curve, Findings, FindingsFormat, FoundValue, MapPlace, NamedAmount, Plot,
    Table, ValueKind,
};
pub use forecast::{DayForecast, ForecastFormat, ForecastValue};
pub use history::{HistoryFormat, HistoryRun, MachineHistory, RunChange, Watched, WatchedPoint};
pub use identification::{
    Approach, Combination, Identification, IdentificationFormat, LeftOut, NoiseOfRun, NoiseOrigin, NoisePart,
    Outlier, Parameter, Shape, Term, UncertaintyOrigin, Unobservable,
};
pub use json::{to_json, to_json_line};
pub use ladder::{Added, Ladder, LadderEntry, LadderFormat, LadderRow, Moved, Removal, Removed};
pub use left_out::LeftOutEffect;
pub use linear::{FormulaChecked, FormulaFormat, Linear, LinearFormat, LinearPoint, LinearSolution};
pub use live::{
    BallOffset, Live, LiveAxis, LiveCycle, LiveDevice, LiveFormat, LiveProbe, LiveTemperature, Zone,
};
pub use location::{LocationError, LocationErrors};
pub use method_list::{MethodLine, MethodList, MethodListFormat};
pub use nc_program::{NcProgram, NcProgramFormat};
pub use of_the_present::{OF_THE_PRESENT, Offline, OfflineReason, OfflineState, OrOffline};
pub use page_status::{CycleGrid, GridPose, PageCycle, PageFormat, PageStatus, Serves};
pub use plan::{Considered, Goal, LeftOpen, NextPlanned, Plan, PlanFormat};
pub use plausibility::{Check, CheckFormat, FEWEST_POINTS, Plausibility, Question};
pub use prediction::{Prediction, PredictionFormat, RunPrediction, Taken};
pub use preview::{Alias, OutOfReach, Preview, PreviewFormat, SeenBy, SeparatedBy};
pub use residuals::{ResidualAxis, ResidualPoint, ResidualSetup, Residuals, ShiftedPlace};
pub use run_record::{RunAnswer, RunRecord, RunRecordFormat, RunResult, RunState};
pub use schema::{schema_text, schemas};
pub use service_status::{
    ChoiceRefused, Condition, CycleNow, CycleState, DeviceNow, Health, PartHealth, Presence, ServiceStatus,
};
pub use set_up_state::{SetUpFormat, SetUpState, SetUpStep};
pub use setting_up::{
    CalibratedProbe, Jog, NestCalibrated, NestFormat, SignFinding, SignTest, SignTestFormat,
};
pub use spectrum::{AxisSpectrum, Period, SpectrumWave};
pub use story::{
    Fact, RunFound, RunLine, RunList, RunListFormat, Story, StoryCandidate, StoryFormat, StorySection,
};
pub use time_quality::{Stream, SyncMove, SyncMoveChannel, TimeQuality};
pub use topics::{Published, SamplesRemoved, StorageNow, StorageState};
pub use volumetric::{
    Datum, ErrorAt, ErrorMap, ErrorMapFormat, Looked, Unseen, Volumetric, VolumetricFormat, VolumetricValue,
};
pub use written::{
    Imported, Joined, JoinedFormat, JoinedPart, Scrubbed, ScrubbedFormat, ScrubbedRecording, Simulation,
    SimulationFormat,
};
