//! The certificate of a report: what it needs, what it holds, what it is called.

use crate::filed::report;
use quick_xml::events::Event;
use trunnion_report::{DccError, Issuer, dcc_xml};
use trunnion_results::{Diagnosis, Doubt, DoubtReason, Report, RunIdentity, Shape, Verdict};

/// Who issues a certificate: no more than it needs.
pub fn in_germany() -> Issuer {
    Issuer { country: Some("DE".into()), ..Issuer::default() }
}

/// Of a run whose day was not recorded.
pub fn measured_on(day: &str) -> Issuer {
    Issuer { measured: Some(day.into()), ..in_germany() }
}

#[test]
fn a_certificate_holds_the_numbers_of_the_fit_and_its_decision() {
    let report = report();
    let xml = dcc_xml(&report, &in_germany()).unwrap();
    let mut reader = quick_xml::Reader::from_str(&xml);
    while !matches!(reader.read_event().unwrap(), Event::Eof) {}
    let parameter = report.comparison.identification.parameter("EX0C").unwrap();
    let value = format!("{:.6e}", parameter.value.unwrap() * 1e-6);
    assert!(xml.contains(&format!("<si:value>{value}</si:value>")), "{value} in {xml}");
    assert!(xml.contains("<dcc:conformity>fail</dcc:conformity>"), "{xml}");
    assert!(!xml.contains("low &lt;b&gt;.x"), "how the ball was set is no error of the machine");

    let mut not_judged = report;
    not_judged.comparison.diagnosis = Some(Diagnosis::default());
    assert_eq!(dcc_xml(&not_judged, &in_germany()), Err(DccError::NotJudged));
}

#[test]
fn a_certificate_without_a_country_or_a_day_of_each_run_is_refused() {
    let mut report = report();
    assert_eq!(dcc_xml(&report, &Issuer::default()), Err(DccError::NoCountry));
    report.identity.runs.push(RunIdentity { day: None, ..report.identity.runs[0].clone() });
    assert_eq!(dcc_xml(&report, &in_germany()), Err(DccError::NoDay));
    let xml = dcc_xml(&report, &measured_on("2026-02-20")).unwrap();
    assert!(xml.contains("<dcc:beginPerformanceDate>2026-02-20<"), "{xml}");
    assert!(xml.contains("<dcc:endPerformanceDate>2026-03-01<"), "{xml}");
}

#[test]
fn certificates_that_say_different_things_have_different_identifiers() {
    let identifier = |report: &Report, issuer: &Issuer| {
        let xml = dcc_xml(report, issuer).unwrap();
        let (_, after) = xml.split_once("<dcc:uniqueIdentifier>").unwrap();
        after.split_once('<').unwrap().0.to_owned()
    };
    let first = identifier(&report(), &in_germany());
    assert!(first.starts_with("trunnion-2026-03-02-"), "{first}");
    assert_eq!(identifier(&report(), &in_germany()), first);
    let customer = Issuer { customer: Some("Example Ltd".into()), ..in_germany() };
    assert_ne!(identifier(&report(), &customer), first);
    let mut wider = report();
    wider.conformity.as_mut().unwrap().tolerance_um = 10.5;
    assert_ne!(identifier(&wider, &in_germany()), first);
}

#[test]
fn a_certificate_has_the_shape_numbers_of_what_was_found() {
    let mut report = report();
    let fit = &mut report.comparison.identification;
    let effect = fit.parameter("EX0C").unwrap().effect.clone();
    let unseen = Shape {
        effect: "ballscrew-pitch:X".into(),
        names: vec!["period_mm".into()],
        values: vec![5.0],
        ..Shape::default()
    };
    fit.effects.push(unseen.effect.clone());
    let found = Shape { effect, names: vec!["tau_s".into()], values: vec![1234.5], ..Shape::default() };
    fit.shapes = vec![unseen, found];
    let xml = dcc_xml(&report, &in_germany()).unwrap();
    let of_shape = "<si:value>1.234500e3</si:value>\n<si:unit>\\second</si:unit>";
    assert!(xml.contains("tau_s (of its shape") && xml.contains(of_shape), "{xml}");
    assert!(!xml.contains("period_mm"), "of an effect without a number: {xml}");
}

#[test]
fn a_certificate_says_what_its_data_cannot_decide_and_what_is_doubted() {
    let mut report = report();
    report.comparison.diagnosis = Some(Diagnosis { verdict: Verdict::Undecided, ..Diagnosis::default() });
    let words = "ambient.z does not hold: 2 of 3.".to_owned();
    report.comparison.identification.doubts =
        vec![Doubt { effect: None, names: Vec::new(), reason: DoubtReason::BeyondPhysical, words }];
    let xml = dcc_xml(&report, &in_germany()).unwrap();
    assert!(xml.contains("These data cannot say whether an effect is missing"), "{xml}");
    assert!(!xml.contains("The model is not complete"), "nothing says so: {xml}");
    assert!(xml.contains("Doubt: ambient.z does not hold"), "{xml}");
}
