//! A report as a digital calibration certificate: DCC 3.3.0 of the Physikalisch-Technische Bundesanstalt, quantities in D-SI
//! [DCC 3.3.0].
//!
//! What the schema asks for and nobody recorded says so in words; a country that is not known is `ZZ`, which ISO 3166-1 leaves to
//! users. Settings of ball and nest are of the measurement and not of the machine: they are left out.

mod administrative;
mod quantity;
mod results;
mod xml;

use trunnion_results::Report;
use xml::{holding, with_attributes};

/// Who issues a certificate, and for whom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Issuer {
    /// Who calibrates.
    pub laboratory: Option<String>,
    /// Whose machine it is.
    pub customer: Option<String>,
    /// Two letters [ISO 3166-1].
    pub country: Option<String>,
    /// Day of the measurement, `YYYY-MM-DD`, where the recording has none.
    pub measured: Option<String>,
}

/// Why there is no certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DccError {
    /// No day of measurement.
    #[error(
        "the recording does not say when it was measured, and a certificate must; give --measured YYYY-MM-DD"
    )]
    NoDay,
    /// Nothing to certify.
    #[error("no parameter of the machine is observable in these runs, so there is nothing to certify")]
    NoResult,
    /// The runs are not plausible or not whole.
    #[error("the runs were not judged, and what was not judged is not certified")]
    NotJudged,
}

/// The certificate as XML.
///
/// # Errors
/// A report that cannot be one.
pub fn dcc_xml(report: &Report, issuer: &Issuer) -> Result<String, DccError> {
    let body = administrative::data(report, issuer)? + &results::data(report)?;
    let root = with_attributes(
        "dcc:digitalCalibrationCertificate",
        &[
            ("xmlns:dcc", "https://ptb.de/dcc"),
            ("xmlns:si", "https://ptb.de/si"),
            ("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"),
            ("xsi:schemaLocation", "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd"),
            ("schemaVersion", "3.3.0"),
        ],
        &body,
    );
    Ok(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{root}\n"))
}

/// A text that the schema takes: some, without blanks at its ends.
fn stated(text: Option<&str>) -> String {
    let words: Vec<&str> = text.unwrap_or_default().split_whitespace().collect();
    if words.is_empty() { "not recorded".into() } else { words.join(" ") }
}

/// A text with its language.
fn text(tag: &str, words: &str) -> String {
    holding(tag, &with_attributes("dcc:content", &[("lang", "en")], &crate::markup::escape(words)))
}
