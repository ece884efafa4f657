//! A report as a digital calibration certificate: DCC 3.3.0 of the Physikalisch-Technische Bundesanstalt, quantities in D-SI
//! [DCC 3.3.0].
//!
//! What the schema asks for and nobody recorded says so in words; day and country cannot, and have to be given. Settings of ball and
//! nest are of the measurement and not of the machine: they are left out.

mod administrative;
mod issuer;
mod quantity;
mod results;
mod xml;

pub use issuer::{DccError, Issuer};

use sha2::{Digest, Sha256};
use trunnion_results::Report;
use xml::with_attributes;

/// Digits of a digest in the name of a certificate: 64 bits, of which no two of the certificates of a laboratory agree by chance.
const SHORT_DIGEST: usize = 16;

/// The certificate as XML. Its unique identifier is a digest of all else that it says: whatever differs is another certificate.
///
/// # Errors
/// A report that cannot be one.
pub fn dcc_xml(report: &Report, issuer: &Issuer) -> Result<String, DccError> {
    let results = results::data(report)?;
    let named = |name: &str| administrative::data(report, issuer, name).map(|data| data + &results);
    let digest = format!("{:x}", Sha256::digest(named("")?));
    let body = named(&format!("trunnion-{}-{}", report.identity.written, &digest[..SHORT_DIGEST]))?;
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
