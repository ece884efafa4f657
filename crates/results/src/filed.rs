//! A report to be filed: what was found, of which machine, by whom, from which recording.

use crate::comparison::Comparison;
use crate::conformity::Conformity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_core::{Calibration, Day};

/// `trunnion-report/1`: a report to be filed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Report {
    /// Format and version.
    pub format: ReportFormat,
    /// Whose report this is.
    pub identity: Identity,
    /// Pass or fail; null without a tolerance, or where the runs were not judged.
    pub conformity: Option<Conformity>,
    /// What was found.
    pub comparison: Comparison,
    /// The page that was written.
    pub html: Option<String>,
    /// The PDF that was printed from it.
    pub pdf: Option<String>,
    /// What the PDF lacks: characters that the browser has no font for; null where it is complete.
    #[serde(default)]
    pub pdf_lacks: Option<String>,
    /// The digital calibration certificate that was written.
    pub dcc: Option<String>,
}

/// Format and version of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ReportFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-report/1")]
    V1,
}

/// `trunnion-filed/1`: a report that was filed next to its recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Filed {
    /// Format and version.
    pub format: FiledFormat,
    /// Name of the run.
    pub run: String,
    /// The page that was written.
    pub html: String,
    /// The PDF that was printed from it; null while there is none.
    pub pdf: Option<String>,
    /// What the PDF lacks: characters that the browser has no font for; null where it is complete.
    #[serde(default)]
    pub pdf_lacks: Option<String>,
}

/// Format and version of what was filed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FiledFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-filed/1")]
    V1,
}

/// Machine, people and recordings of a report. What is null or empty is not recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Identity {
    /// Name of the machine file.
    pub machine: String,
    /// Serial number of the machine.
    pub serial: Option<String>,
    /// Who measured.
    pub operator: Option<String>,
    /// Program and version that wrote the report.
    pub program: String,
    /// Day on which it was written, `YYYY-MM-DD`, UTC.
    pub written: String,
    /// The recordings.
    pub runs: Vec<RunIdentity>,
}

/// One recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunIdentity {
    /// Name of the run.
    pub run: String,
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// When it began, `YYYY-MM-DD hh:mm UTC`; null for imports and simulations, which have no moment.
    pub began: Option<String>,
    /// The first ten characters of the same: the day.
    pub day: Option<String>,
    /// Name of the cycle; empty for imports.
    pub cycle: String,
    /// True when it was measured while axes moved.
    pub on_the_fly: bool,
    /// Every setup: name, instrument, ball.
    pub setups: Vec<String>,
    /// The probe channels.
    pub probes: Vec<String>,
    /// Directions of the probes, one line each; empty when they are not recorded.
    pub probe_calibration: Vec<String>,
    /// What the certificates of the sensors say; empty when nobody said it.
    #[serde(default)]
    pub calibrations: Vec<SensorCalibration>,
    /// Every temperature channel.
    pub temperatures: Vec<TemperatureRange>,
    /// Version of the program that recorded.
    pub recorded_with: String,
}

/// What the certificate of a sensor says. What is null is not recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorCalibration {
    /// Name of the sensor.
    pub sensor: String,
    /// Its serial number.
    pub serial: Option<String>,
    /// Number of the certificate.
    pub certificate: Option<String>,
    /// Who calibrated it.
    pub laboratory: Option<String>,
    /// Day of the calibration, `YYYY-MM-DD`.
    pub date: Option<String>,
    /// Last day on which it holds, `YYYY-MM-DD`.
    pub valid_until: Option<String>,
}

impl From<&Calibration> for SensorCalibration {
    fn from(of: &Calibration) -> Self {
        let day = |day: Option<Day>| day.map(|day| day.to_string());
        Self {
            sensor: of.sensor.clone(),
            serial: of.serial.clone(),
            certificate: of.certificate.clone(),
            laboratory: of.laboratory.clone(),
            date: day(of.date),
            valid_until: day(of.valid_until),
        }
    }
}

/// What a temperature channel read while a run was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TemperatureRange {
    /// Its name.
    pub channel: String,
    /// Lowest value, °C.
    pub lowest_degc: f64,
    /// Mean value over the points, °C.
    pub mean_degc: f64,
    /// Highest value, °C.
    pub highest_degc: f64,
}
