//! What a certificate needs in addition to a report, and why there may be none.

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
    /// No country. The rules of the schema's publisher take none that ISO 3166-1 leaves to users, such as `ZZ`.
    #[error(
        "a certificate names the country of the laboratory; give --country, two capital letters such as DE"
    )]
    NoCountry,
    /// No day of measurement.
    #[error(
        "a recording does not say when it was measured, and a certificate must; give --measured YYYY-MM-DD"
    )]
    NoDay,
    /// Nothing to certify.
    #[error("no parameter of the machine is observable in these runs, so there is nothing to certify")]
    NoResult,
    /// The runs are not plausible or not whole, or the diagnosis failed.
    #[error("the runs were not judged, and what was not judged is not certified")]
    NotJudged,
}
