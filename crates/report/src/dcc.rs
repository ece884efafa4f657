//! A report as a digital calibration certificate: DCC 3.3.0 of the Physikalisch-Technische Bundesanstalt, quantities in D-SI
//! [DCC 3.3.0].
//!
//! What the schema asks for and nobody recorded says so in words; a country that is not known is `ZZ`, which ISO 3166-1 leaves to
//! users. Settings of ball and nest are of the measurement and not of the machine: they are left out.

mod administrative;
mod issuer;
mod quantity;
mod results;
mod xml;

pub use issuer::{DccError, Issuer};

use trunnion_results::Report;
use xml::with_attributes;

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
