//! Software, identification, machine, laboratory, people, statements.

use super::issuer::{DccError, Issuer};
use super::xml::{holding, plain, stated, text};
use crate::filed::conformity::places;
use trunnion_results::sentences::{ALL_CLEAR, doubts, inadequate};
use trunnion_results::{Conformity, Decision, Report, Verdict};

pub fn data(report: &Report, issuer: &Issuer, name: &str) -> Result<String, DccError> {
    let country = issuer.country.as_deref().ok_or(DccError::NoCountry)?;
    let place = holding("dcc:location", &plain("dcc:countryCode", country));
    let contact = |tag: &str, name: Option<&str>| holding(tag, &(text("dcc:name", &stated(name)) + &place));
    let operator = stated(report.identity.operator.as_deref());
    let person = holding("dcc:person", &text("dcc:name", &operator))
        + &plain("dcc:role", "operator")
        + &plain("dcc:mainSigner", "true");
    let body = holding("dcc:dccSoftware", &software(report))
        + &core(report, issuer, country, name)?
        + &items(report)
        + &holding("dcc:calibrationLaboratory", &contact("dcc:contact", issuer.laboratory.as_deref()))
        + &holding("dcc:respPersons", &holding("dcc:respPerson", &person))
        + &contact("dcc:customer", issuer.customer.as_deref())
        + &statements(report);
    Ok(holding("dcc:administrativeData", &body))
}

/// This program. The rules of the schema's publisher want a letter before the numbers of a release.
pub fn software(report: &Report) -> String {
    let program = &report.identity.program;
    let (name, release) = program.rsplit_once(' ').unwrap_or((program, "0"));
    let body = text("dcc:name", name)
        + &plain("dcc:release", &format!("v{release}"))
        + &plain("dcc:type", "application");
    holding("dcc:software", &body)
}

fn core(report: &Report, issuer: &Issuer, country: &str, name: &str) -> Result<String, DccError> {
    let runs = &report.identity.runs;
    let days = runs.iter().map(|run| run.day.as_deref().or(issuer.measured.as_deref()));
    let mut days: Vec<&str> = days.collect::<Option<_>>().ok_or(DccError::NoDay)?;
    days.sort_unstable();
    let (first, last) = days.first().zip(days.last()).ok_or(DccError::NoDay)?;
    let identifications: String = runs
        .iter()
        .map(|run| identification("other", &run.sha256, &format!("SHA-256 of the recording {}", run.file)))
        .collect();
    let body = plain("dcc:countryCodeISO3166_1", country)
        + &plain("dcc:usedLangCodeISO639_1", "en")
        + &plain("dcc:mandatoryLangCodeISO639_1", "en")
        + &plain("dcc:uniqueIdentifier", name)
        + &holding("dcc:identifications", &identifications)
        + &plain("dcc:beginPerformanceDate", first)
        + &plain("dcc:endPerformanceDate", last)
        + &plain("dcc:performanceLocation", "customer")
        + &plain("dcc:issueDate", &report.identity.written);
    Ok(holding("dcc:coreData", &body))
}

pub fn identification(issuer: &str, value: &str, name: &str) -> String {
    let body = plain("dcc:issuer", issuer) + &plain("dcc:value", value) + &text("dcc:name", name);
    holding("dcc:identification", &body)
}

fn items(report: &Report) -> String {
    let serial = stated(report.identity.serial.as_deref());
    let item = text("dcc:name", &format!("Machine tool {}", report.identity.machine))
        + &holding("dcc:identifications", &identification("manufacturer", &serial, "Serial number"));
    holding("dcc:items", &holding("dcc:item", &item))
}

fn statements(report: &Report) -> String {
    let fit = &report.comparison.identification;
    let verdict = report.comparison.diagnosis.as_ref().map_or(Verdict::NotJudged, |d| d.verdict);
    let complete = match verdict {
        Verdict::NoiseFloor => ALL_CLEAR,
        Verdict::Undecided => {
            "These data cannot say whether an effect is missing: the values are those of this model alone."
        }
        _ => "The model is not complete: its values are those of this model alone.",
    };
    let mut remarks = vec![
        "This certificate was written by a program; nobody has accredited it.".to_owned(),
        "The calibration of the probes is not part of the uncertainties.".to_owned(),
        complete.to_owned(),
    ];
    remarks.extend(inadequate(fit));
    remarks.extend(doubts(fit));
    let remarks: String =
        remarks.iter().map(|remark| holding("dcc:statement", &text("dcc:declaration", remark))).collect();
    let conformity = report.conformity.as_ref().map_or_else(String::new, conformity);
    holding("dcc:statements", &(remarks + &conformity))
}

/// Between the limits a result inside the tolerance passes conditionally, one outside fails conditionally [ILAC-G8].
fn conformity(conformity: &Conformity) -> String {
    let judged = &conformity.as_measured;
    let word = match judged.decision {
        Decision::Pass => "pass",
        Decision::Fail => "fail",
        Decision::NotDecidable if judged.is_within(conformity.tolerance_um) => "conditionalPass",
        Decision::NotDecidable => "conditionalFail",
    };
    let declaration = format!(
        "Largest deviation of the tool against the table {:.2} µm (u {:.2} µm) at {}; tolerance {} µm.",
        judged.largest_um,
        judged.u_um,
        places(judged).join("; "),
        conformity.tolerance_um
    );
    let body = text("dcc:name", "Conformity")
        + &plain("dcc:norm", "ISO 14253-1")
        + &text("dcc:declaration", &declaration)
        + &plain("dcc:conformity", word);
    holding("dcc:statement", &body)
}
