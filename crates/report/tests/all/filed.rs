//! The report to be filed: complete, in three languages, and as a certificate.

use crate::certificate::{in_germany, measured_on};
use crate::pages::{check_page, fitted, model};
use quick_xml::events::Event;
use trunnion_report::{Language, compare_html, dcc_xml, report_html, report_text};
use trunnion_results::{
    Candidate, Comparison, Conformity, Decision, Diagnosis, Doubt, DoubtReason, ExcludedPoints, Identity,
    Judged, Ladder, LeftOutEffect, Parameter, Report, RunIdentity, TemperatureRange, Verdict,
};

pub fn report() -> Report {
    let (_, comparison) = fitted();
    let judged = |largest_um, decision| Judged {
        largest_um,
        u_um: 0.4,
        at: "setup low <b>, B 45°".into(),
        decision,
        excluded: None,
    };
    let run = RunIdentity {
        run: "grid <&\"'".into(),
        file: "grid.mcap".into(),
        sha256: "9f86d081884c7d65".repeat(4),
        began: Some("2026-03-01 08:00 UTC".into()),
        day: Some("2026-03-01".into()),
        setups: vec!["low <b>: R-test, ball at X 150 mm, Y 0 mm, Z 60 mm".into()],
        temperatures: vec![TemperatureRange {
            channel: "bed".into(),
            lowest_degc: 20.1,
            mean_degc: 20.4,
            highest_degc: 20.9,
        }],
        recorded_with: "0.1.0".into(),
        ..RunIdentity::default()
    };
    Report {
        identity: Identity {
            machine: "table-bc".into(),
            serial: Some("SN <17>".into()),
            operator: Some("Ada".into()),
            program: "Trunnion 0.1.0".into(),
            written: "2026-03-02".into(),
            runs: vec![run],
        },
        conformity: Some(Conformity {
            tolerance_um: 10.0,
            tolerance_of: "given with the command".into(),
            as_measured: judged(12.3, Decision::Fail),
            corrected: judged(1.2, Decision::Pass),
            not_corrected: vec![LeftOutEffect {
                effect: "backlash:C".into(),
                why: "it depends on the direction of C".into(),
            }],
            why_not_corrected: String::new(),
        }),
        comparison: Comparison {
            ladder: Ladder::from(&model()),
            diagnosis: Some(Diagnosis { verdict: Verdict::NoiseFloor, ..Diagnosis::default() }),
            ..comparison
        },
        ..Report::default()
    }
}

/// Texts inside the elements that a person reads before any sentence, and in drawings.
fn labels(page: &str) -> Vec<String> {
    let mut reader = quick_xml::Reader::from_str(page);
    let (mut inside, mut labels, mut label) = (Vec::<String>::new(), Vec::new(), String::new());
    let wanted = ["h1", "h2", "h3", "th", "dt", "caption", "summary", "text", "small"];
    loop {
        let event = reader.read_event().unwrap();
        match &event {
            Event::Text(text) => label += text.as_ref(),
            // Only names have characters that must be escaped.
            Event::GeneralRef(_) => label += "<",
            _ => {
                if inside.last().is_some_and(|tag| wanted.contains(&tag.as_str())) {
                    labels.push(label.trim().to_string());
                }
                label.clear();
            }
        }
        match event {
            Event::Eof => return labels,
            Event::Start(start) => inside.push(start.name().as_ref().to_string()),
            Event::End(_) => _ = inside.pop(),
            _ => {}
        }
    }
}

/// Texts that are the same in every language: names, ids, numbers with units.
fn stays(label: &str) -> bool {
    let names = ["EX0C −3.20 → −1.10 µm, 8 u", "+ backlash:B", "rms", "high"];
    let words = label.split(|c: char| !c.is_alphabetic()).filter(|word| word.chars().count() > 2);
    names.contains(&label) || words.count() == 0 || label.contains("low") && label.contains('<')
}

#[test]
fn every_report_is_well_formed_and_needs_nothing_from_outside() {
    for (_, language) in Language::NAMES {
        check_page(&report_html(&report(), language));
    }
}

/// A table of many columns is wider than a phone: it scrolls in a box of its own, or wraps its cells.
#[test]
fn no_table_of_a_report_makes_the_page_wider_than_the_screen() {
    for (_, language) in Language::NAMES {
        let page = report_html(&report(), language);
        let tables: Vec<usize> = page.match_indices("<table").map(|(at, _)| at).collect();
        assert!(tables.len() > 5, "{}", tables.len());
        for at in tables {
            // By keyboard too, and a screen reader says what it is.
            let tag = page[..at].rsplit('<').next().unwrap();
            let named = tag.split("aria-label=\"").nth(1).is_some_and(|name| name.len() > 3);
            let scrolls = named && tag.starts_with("div class=\"scroll\" tabindex=\"0\" role=\"region\"");
            let wraps = page[at..].starts_with("<table class=\"identity\"");
            assert!(scrolls || wraps, "{}", page[at..].chars().take(200).collect::<String>());
        }
    }
}

#[test]
fn no_label_of_a_report_stays_english() {
    let english = report_html(&report(), Language::English);
    let known = labels(&english);
    assert!(known.len() > 80, "{} labels", known.len());
    for language in [Language::German, Language::Japanese] {
        let missing: Vec<&String> =
            known.iter().filter(|label| !stays(label) && language.say(label).is_none()).collect();
        assert!(missing.is_empty(), "no entry in crates/report/src/language/table: {missing:#?}");
    }
    for effect in trunnion_effects::catalogue::REGISTRY {
        let name = format!("{} (an:ID)", effect.about.title);
        let [german, japanese] = [Language::German, Language::Japanese].map(|language| language.say(&name));
        assert!(
            german.is_some() && japanese.is_some(),
            "no entry in crates/report/src/language/table: {name}"
        );
    }
    let german = report_html(&report(), Language::German);
    assert!(german.contains("nicht bestanden") && german.contains("<html lang=\"de\">"), "the verdict too");
}

/// After its adding a run is clear: what was found in it is still the answer.
#[test]
fn what_was_added_is_said_with_its_cause_its_size_and_who_added_it() {
    let mut report = report();
    let size = Parameter {
        effect: "backlash:B".into(),
        name: "windup".into(),
        value: Some(10.93),
        u: Some(0.31),
        unit: "urad".into(),
        observable: true,
        ..Parameter::default()
    };
    report.comparison.identification.parameters.push(size);
    let first_page = |language| {
        let page = report_html(&report, language);
        let end = page.find("<section class=\"page\">").unwrap();
        page[..end].to_owned()
    };
    let english = first_page(Language::English);
    for said in [
        "On passes left out of the fit the error falls from 2.40 µm to 1.20 µm. Its size: windup = 10.93 µrad, u = 0.31 µrad.</li>",
        "<p>Likely cause: ",
        "<th scope=\"col\">added by</th>",
        "<td>Ada</td><td>2026-03-01</td>",
    ] {
        assert!(english.contains(said), "{said}: {english}");
    }
    let german = first_page(Language::German);
    for said in
        ["(Durchgänge) fällt der Fehler von 2.40 µm auf 1.20 µm. Seine Größe: windup", "hinzugefügt von"]
    {
        assert!(german.contains(said), "{said}: {german}");
    }
    let story = trunnion_report::story(&report.comparison);
    assert!(story.sure.iter().any(|said| said.contains("Its size: windup")), "{:?}", story.sure);
    assert!(!compare_html(&report.comparison, "").contains("No effect explains the residual"));
}

#[test]
fn a_number_to_doubt_is_doubted_on_the_first_page() {
    let mut report = report();
    let words = "ambient.z exceeds 50 µm/K: no part of a machine moves as much.".into();
    let reason = DoubtReason::BeyondPhysical;
    report.comparison.identification.doubts =
        vec![Doubt { effect: None, names: vec!["ambient.z".into()], reason, words }];
    for (language, said) in
        [(Language::English, "Doubt: ambient.z"), (Language::German, "Zweifel: ambient.z")]
    {
        let page = report_html(&report, language);
        let (doubt, to_do) = (page.find(said), page.find("<ol>"));
        assert!(doubt.is_some() && doubt < to_do, "{page}");
    }
}

#[test]
fn a_diagnosis_that_failed_accuses_no_run() {
    let mut failed = report();
    failed.comparison.diagnosis =
        Some(Diagnosis { why: "The diagnosis failed: too few.".into(), ..Diagnosis::default() });
    failed.comparison.left_out =
        vec!["A trial of backlash:C is left out, because it failed: too few.".into()];
    failed.comparison.places.clear();
    let page = report_html(&failed, Language::English);
    for said in [
        "<h1>Not judged: the diagnosis failed</h1>",
        "Not looked for, because the diagnosis failed.",
        "No effect was judged, because the diagnosis failed.",
        "Whether an effect is missing is not known, because the diagnosis failed.",
        "Mend what made the diagnosis fail, and diagnose again.",
    ] {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("was not asked"), "it was asked");
    assert!(!page.contains("plausible") && !page.contains("what they say they are"), "the runs are good");
    let german = report_html(&failed, Language::German);
    for said in [
        "<h1>Nicht beurteilt: Die Diagnose ist gescheitert</h1>",
        "In diesem Bericht fehlt:",
        "Eine Probe mit backlash:C fehlt; gescheitert: too few.",
        "Ob ein Effekt fehlt, ist nicht bekannt, weil die Diagnose gescheitert ist.",
    ] {
        assert!(german.contains(said), "{said}");
    }
    let all_clear = "A usual effect of 1.2 µm rms or more would have been noticed. Not so backlash or a slip of the setup: passes \
                     differ by some 2.4 µm, and these data do not say why. Repeat one pass to know.";
    assert!(Language::German.say(all_clear).is_some_and(|said| said.contains("um etwa 2.4 µm, und")));
}

#[test]
fn each_remark_about_the_first_candidate_is_said_in_the_language_of_the_report() {
    let mut found = report();
    let waves = [
        "It repeats every 5.00 mm, u = 0.02 mm (lead/2), amplitude 1.20 µm.",
        "It repeats 2.0 times per turn, u = 0.1 per turn. On this even grid a wave 6.0 times per turn gives the same readings, and so do others without end, the next 10.0 times per turn.",
    ];
    let best = Candidate {
        effect: "ballscrew-pitch:Z".into(),
        remarks: waves.map(String::from).into(),
        ..Candidate::default()
    };
    found.comparison.diagnosis =
        Some(Diagnosis { verdict: Verdict::MissingEffect, candidates: vec![best], ..Diagnosis::default() });
    let german = report_html(&found, Language::German);
    for said in [
        "<li>Es wiederholt sich alle 5.00 mm, u = 0.02 mm (lead/2), Amplitude 1.20 µm.</li>",
        "<li>Es wiederholt sich 2.0 Mal je Umdrehung, u = 0.1 je Umdrehung. Auf diesem gleichmäßigen Raster gibt eine Welle 6.0 Mal je \
         Umdrehung dieselben Ablesungen, ebenso endlos viele andere, die nächste 10.0 Mal je Umdrehung.</li>",
    ] {
        assert!(german.contains(said), "{said}");
    }
    let say = |text: &str| Language::German.say(text).unwrap_or_default();
    assert_eq!(
        say("Y, B 60° and above, C 210° to 330°, both directions, setup low:"),
        "Y, B 60° und darüber, C 210° bis 330°, beide Richtungen, Aufstellung low:"
    );
    assert_eq!(
        say(
            "C: a wave of 0.23 µm rms. It repeats 1.94 times per turn, u = 0.13 per turn (2 per turn). With it in the model 1.16 µm rms \
             remain."
        ),
        "C: eine Welle von 0.23 µm rms. Es wiederholt sich 1.94 Mal je Umdrehung, u = 0.13 je Umdrehung (2 je Umdrehung). Mit ihr im Modell \
         bleiben 1.16 µm rms."
    );
    let title = say("X, setup low, B forward, C forward — before");
    assert!(
        title.starts_with("X, Aufstellung low, B vorwärts, C vorwärts") && title.ends_with("vorher"),
        "{title}"
    );
    assert_eq!(Language::German.say("a, b, which no table knows"), None);
    let japanese = report_html(&found, Language::Japanese);
    assert!(japanese.contains("<li>5.00 mm ごとに繰り返す（u = 0.02 mm (lead/2)、振幅 1.20 µm）。</li>"));
}

#[test]
fn the_first_page_says_what_is_wrong_what_to_do_and_pass_or_fail_before_the_annex() {
    let page = report_html(&report(), Language::English);
    let order = [
        "<h1>The model now explains",
        "<h2>Tolerance",
        "<b class=\"fail-mark\">fail",
        "<h2>What to do",
        "<h2>How sure this is",
        "<h2>What was not seen<",
        "<h2>Before and after",
        "<h2>Machine and measurement",
        "9f86d081884c7d65",
        "<h2>Where the model fails most",
        "<h2>What was not seen, in full",
        "Annex: every table",
        "<h2>Readings",
    ];
    let places: Vec<_> =
        order.iter().map(|part| page.find(part).unwrap_or_else(|| panic!("{part}"))).collect();
    assert!(places.is_sorted(), "{places:?}");
    // What is closed on a screen is open on paper, and every reading is there.
    assert!(!page.contains("<details>") && !page.contains("<details class"), "closed lists");
    let rows = page[places[12]..].matches("<tr>").count();
    assert_eq!(rows, report().comparison.residuals.points.len() + 1, "a row each, and the head");
}

#[test]
fn what_nobody_recorded_is_said_and_not_invented() {
    let mut unknown = report();
    unknown.identity.serial = None;
    unknown.identity.operator = None;
    unknown.identity.runs[0].day = None;
    unknown.identity.runs[0].temperatures.truncate(1);
    let constant = &mut unknown.identity.runs[0].temperatures[0];
    (constant.lowest_degc, constant.mean_degc, constant.highest_degc) = (20.01, 20.02, 20.04);
    let page = report_html(&unknown, Language::English);
    assert!(page.contains("<div>bed: 20.0 °C</div>"), "a temperature that stays is one number");
    assert!(
        page.contains("<title>Trunnion report: table-bc · 2026-03-02</title>"),
        "no dash for a number that nobody gave"
    );
    unknown.identity.runs[0].temperatures.clear();
    unknown.conformity = None;
    let page = report_html(&unknown, Language::English);
    assert!(page.matches("not recorded").count() >= 7, "{}", page.matches("not recorded").count());
    assert!(page.contains("neither the machine file nor the command gives a tolerance"));
    let xml = dcc_xml(&unknown, &measured_on("2026-03-01")).unwrap();
    assert!(xml.contains("<dcc:beginPerformanceDate>2026-03-01<"), "{xml}");
    assert!(xml.contains("not recorded"), "{xml}");
}

#[test]
fn what_a_correction_leaves_in_and_what_was_excluded_are_named_in_every_form() {
    let mut report = report();
    let conformity = report.conformity.as_mut().unwrap();
    let excluded = ExcludedPoints { count: 1, largest_um: 15.2, at: "setup low, B 30°".into() };
    let measured = Judged { largest_um: 1.4, excluded: Some(excluded), ..conformity.as_measured.clone() };
    conformity.as_measured = measured.decided(conformity.tolerance_um);
    let in_lines = report_text(&report).split_whitespace().collect::<Vec<_>>().join(" ");
    let page = report_html(&report, Language::English);
    for said in [
        "1 point excluded from the fit: 15.2 µm at setup low, B 30°",
        "Not decidable: a point that was excluded from the fit is not within the tolerance. Measure its pose again.",
        "expected after a correction",
        "Left in: Backlash of the drive (backlash:C).",
    ] {
        assert!(in_lines.contains(said), "{said} in {in_lines}");
        assert!(page.contains(said), "{said} in the page");
    }
    let german = report_html(&report, Language::German);
    assert!(german.contains("1 Punkt aus der Anpassung ausgeschlossen: 15.2 µm bei Aufstellung low, B 30°"));
    assert!(german.contains("Nicht enthalten: "), "{german}");
    let xml = dcc_xml(&report, &in_germany()).unwrap();
    assert!(xml.contains("<dcc:conformity>conditionalFail</dcc:conformity>"), "no pass with it: {xml}");
    assert!(xml.contains("1 point excluded from the fit"), "{xml}");

    let conformity = report.conformity.as_mut().unwrap();
    conformity.why_not_corrected = "controls move legs in parallel by tables that are not public".into();
    let page = report_html(&report, Language::English);
    assert!(page.contains("No correction is expected: controls move legs"));
    assert!(!page.contains("expected after a correction"));
}
