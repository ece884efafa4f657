//! What to do after a run is what its data allow, for every verdict.

use crate::filed::report;
use trunnion_report::{Language, compare_text, diagnosis_text, report_html, story};
use trunnion_results::{
    Candidate, Comparison, ConfoundedErrors, Correctable, Diagnosis, FormulaProposal, Identification,
    LeftOutEffect, Parameter, Plausibility, Question, Residual, Together, Verdict,
};

const ENTER: &str = "Enter the errors of the axes into the control";

fn to_do(diagnosis: Diagnosis, correctable: Correctable) -> Vec<String> {
    let (diagnosis, correctable) = (Some(diagnosis), Some(correctable));
    story(&Comparison { diagnosis, correctable, ..Comparison::default() }).to_do
}

fn verdict(verdict: Verdict) -> Diagnosis {
    Diagnosis { verdict, ..Diagnosis::default() }
}

fn seen() -> Correctable {
    Correctable { clear: vec!["EX0C".into()], ..Correctable::default() }
}

fn combination() -> ConfoundedErrors {
    ConfoundedErrors { entered: vec!["EX0C".into()], zero: vec!["EX0B".into()] }
}

/// Two that were found together, and a third that lost to them.
fn two_together() -> Diagnosis {
    let candidate = |effect: &str, u: f64| Candidate {
        effect: effect.into(),
        rms_um_after: 3.0,
        parameters: vec![size(effect, u)],
        ..Candidate::default()
    };
    Diagnosis {
        candidates: vec![
            candidate("backlash:C", 0.5),
            candidate("gravity-sag:B", 0.5),
            candidate("backlash:B", 0.5),
        ],
        set: vec!["gravity-sag:B".into(), "backlash:C".into()],
        together: Some(Together {
            rms_um_after: 0.31,
            holdout_rms_um_after: Some(0.33),
            explains_fraction: 1.0,
            parameters: vec![size("backlash:C", 0.1), size("gravity-sag:B", 0.1)],
            adequate: true,
            explains_all: true,
        }),
        ..verdict(Verdict::MissingEffect)
    }
}

fn size(effect: &str, u: f64) -> Parameter {
    Parameter {
        name: "h".into(),
        effect: effect.into(),
        value: Some(2.0),
        u: Some(u),
        unit: "um".into(),
        observable: true,
        ..Parameter::default()
    }
}

#[test]
fn effects_found_together_are_named_together_with_what_they_leave_and_their_common_sizes() {
    let diagnosis = two_together();
    let input = Comparison { diagnosis: Some(diagnosis.clone()), ..Comparison::default() };
    let said = story(&input);
    assert!(
        said.headline.contains("(backlash:C)") && said.headline.contains("(gravity-sag:B)"),
        "{}",
        said.headline
    );
    assert!(!said.headline.contains("(backlash:B)"), "{}", said.headline);
    assert!(said.wrong.iter().any(|sentence| sentence.contains("to 0.31 µm")), "{:?}", said.wrong);
    assert!(
        said.to_do.iter().any(|step| step.contains("together") && step.contains("gravity-sag:B")),
        "{:?}",
        said.to_do
    );
    let found: Vec<bool> = said.candidates.iter().map(|one| one.found).collect();
    assert_eq!(found, [true, true, false]);
    let uncertainties: Vec<&str> = said.candidates.iter().map(|one| one.sizes[0][2].as_str()).collect();
    assert_eq!(uncertainties, ["0.10 µm", "0.10 µm", "0.50 µm"], "sizes as fitted together");
    let text = diagnosis_text(&input);
    assert!(text.contains("Its size, as fitted with all that was found together:"), "{text}");
    let row = text.lines().find(|line| line.starts_with("all found together")).unwrap();
    assert!(row.contains("0.31 µm") && row.contains("0.33 µm") && row.ends_with("yes"), "{row}");

    // An expression among what was found: the figures are not of the named ones alone.
    let with_expression = Diagnosis { set: vec!["backlash:C".into(), "formula:ball-dx".into()], ..diagnosis };
    assert!(with_expression.found_together().is_none());
}

#[test]
fn errors_are_entered_only_where_the_model_explains_the_readings_and_an_error_is_clear() {
    let candidate = Candidate { effect: "backlash:C".into(), adequate: true, ..Candidate::default() };
    let missing = Diagnosis { candidates: vec![candidate], ..verdict(Verdict::MissingEffect) };
    assert!(to_do(verdict(Verdict::NoiseFloor), seen())[0].starts_with(ENTER));
    let small = Correctable { small: vec!["EX0C".into()], ..Correctable::default() };
    let confounded = Correctable { confounded: vec![combination()], ..Correctable::default() };
    let at_rest = Correctable { at_rest: vec!["EX0C".into(), "EB0C".into()], ..Correctable::default() };
    let legs = Correctable::nothing("controls move legs in parallel by tables that are not public");
    let measured = |noise_um| Residual {
        rms_um: 0.35,
        noise_um,
        unexplained_fraction: Some(0.75),
        ..Residual::default()
    };
    let with = |noise_um| Diagnosis { residual: measured(noise_um), ..missing.clone() };
    let others = [
        (with(Some(0.3)), seen(), "Entering the errors of the axes into the control need not wait"),
        (with(Some(0.3)), Correctable::default(), "Enter nothing into the control before"),
        (with(Some(0.1)), seen(), "Enter nothing into the control before"),
        (with(None), seen(), "Enter nothing into the control before"),
        (
            verdict(Verdict::NoiseFloor),
            Correctable::default(),
            "Enter nothing into the control: these runs give",
        ),
        (verdict(Verdict::NoiseFloor), small, "Enter nothing into the control: no error of an axis"),
        (verdict(Verdict::NoiseFloor), confounded, "Enter nothing into the control yet"),
        (
            verdict(Verdict::NoiseFloor),
            at_rest,
            "Enter nothing into the control yet: EX0C, EB0C hold what an axis at rest",
        ),
        (verdict(Verdict::NoiseFloor), legs, "Enter nothing into the control: controls move legs"),
        (verdict(Verdict::Undecided), seen(), "Change nothing"),
        (verdict(Verdict::NotJudged), seen(), "Change nothing"),
        (verdict(Verdict::UnnamedStructure), seen(), "Enter nothing into the control before"),
        (missing, seen(), "Enter nothing into the control before"),
    ];
    for (diagnosis, correctable, expected) in others {
        let input = Comparison {
            diagnosis: Some(diagnosis.clone()),
            correctable: Some(correctable.clone()),
            ..Comparison::default()
        };
        let said = to_do(diagnosis, correctable);
        assert!(said.iter().any(|item| item.starts_with(expected)), "{expected}: {said:?}");
        for text in [diagnosis_text(&input), compare_text(&input)] {
            for step in &said {
                assert!(
                    text.contains(step.as_str()),
                    "the terminal says the steps of the page: {step}\n{text}"
                );
            }
        }
        assert!(!said.iter().any(|item| item.starts_with(ENTER)), "{said:?}");
    }
}

#[test]
fn nobody_is_left_without_the_next_step() {
    let open = Diagnosis { why: "Something speaks for backlash:C.".into(), ..verdict(Verdict::Undecided) };
    assert!(to_do(open, seen())[1].starts_with("Measure again"));
    let formula = Some(FormulaProposal { name: "axis-b-ec".into(), ..FormulaProposal::default() });
    let unnamed = Diagnosis { formula, ..verdict(Verdict::UnnamedStructure) };
    let said = to_do(unnamed, seen());
    assert!(
        said[0].starts_with("Add the expression to the model") && said[0].ends_with("(formula:axis-b-ec).")
    );
    let nothing_to_add = to_do(verdict(Verdict::UnnamedStructure), seen());
    assert!(
        nothing_to_add[0].starts_with("Measure again with the ball in another place"),
        "{nothing_to_add:?}"
    );
    let mut part = Comparison { diagnosis: Some(verdict(Verdict::NotJudged)), ..Comparison::default() };
    assert!(story(&part).to_do[1].starts_with("Mend what made the diagnosis fail"));
    part.identification.plausibility = vec![Plausibility::default()];
    assert!(story(&part).to_do[1].starts_with("Undo the mistake named above"));
    part.identification.plausibility =
        vec![Plausibility { question: Question::Whole, ..Plausibility::default() }];
    assert!(story(&part).to_do[1].starts_with("Measure the whole cycle again"));
    assert!(story(&Comparison::default()).to_do[0].starts_with("Ask which effect is missing"));
}

#[test]
fn a_cause_is_not_looked_for_alone_where_others_are_confounded_with_it_or_a_part_remains() {
    let candidate = Candidate {
        effect: "backlash:B".into(),
        confused_with: vec!["backlash:C".into()],
        ..Candidate::default()
    };
    let missing = Diagnosis { candidates: vec![candidate], ..verdict(Verdict::MissingEffect) };
    let said = to_do(missing, seen());
    assert!(said[0].contains("do not separate from it") && said[0].contains("backlash:C"), "{said:?}");
    assert!(said.iter().any(|item| item.contains("a part remains")), "{said:?}");
}

/// A course in time that explains all, alone or with another effect, on a line that was measured one way.
#[test]
fn where_an_error_along_an_axis_would_read_the_same_nobody_says_that_a_part_remains() {
    let drift = Candidate { effect: "thermal-drift".into(), explains_all: true, ..Candidate::default() };
    let alone = Diagnosis { candidates: vec![drift], ..verdict(Verdict::MissingEffect) };
    let mut with_another = two_together();
    with_another.together.as_mut().unwrap().adequate = false;
    let remark =
        story(&Comparison { diagnosis: Some(with_another), ..Comparison::default() }).wrong.join(" ");
    assert!(remark.contains("goes one way would read the same as one of them"), "{remark}");
    assert!(!remark.contains("part remains"), "{remark}");
    let input = Comparison { diagnosis: Some(alone), ..Comparison::default() };
    let said = story(&input);
    for text in [said.wrong.join(" "), said.to_do.join(" "), diagnosis_text(&input), compare_text(&input)] {
        assert!(text.contains("an error along an axis that goes one way would read the same"), "{text}");
        assert!(!text.contains("part remains"), "{text}");
    }
    for language in [Language::German, Language::Japanese] {
        let of_axis = said.wrong.iter().chain(&said.to_do).filter(|one| one.contains("goes one way"));
        for sentence in of_axis {
            assert!(language.say(sentence).is_some(), "{sentence}");
        }
    }
}

#[test]
fn an_effect_that_no_table_takes_is_looked_for_at_the_machine() {
    let left = LeftOutEffect { effect: "backlash:C".into(), why: "it depends on the direction of C".into() };
    let said = to_do(verdict(Verdict::NoiseFloor), Correctable { left_out: vec![left], ..seen() });
    assert!(said[1].contains("Backlash of the drive (backlash:C)"), "{said:?}");
}

#[test]
fn the_first_page_says_what_was_not_seen() {
    let mut report = report();
    let diagnosis = report.comparison.diagnosis.as_mut().unwrap();
    diagnosis.not_visible = ["backlash:X", "backlash:Y", "thermal-drift"].map(String::from).to_vec();
    report.comparison.identification.parameters.clear();
    for name in ["EX0B", "EZ0B", "EA0B", "EB0B"] {
        report.comparison.identification.parameters.push(Parameter {
            name: name.into(),
            effect: "location-errors".into(),
            ..Parameter::default()
        });
    }
    let page = report_html(&report, Language::English);
    let first = &page[..page.find("Machine and measurement").unwrap()];
    for part in [
        "<h2>What was not seen</h2>",
        "place of axis B along X/Z; direction of axis B about X; zero of B",
        "Backlash of the drive (X Y); Thermal drift of the tool side (thermal-drift)",
    ] {
        assert!(first.contains(part), "{part} in {first}");
    }
    let german = report_html(&report, Language::German);
    let first = &german[..german.find("Maschine und Messung").unwrap()];
    assert!(
        first.contains("Ort der Achse B entlang X/Z; Richtung der Achse B um X; Nullpunkt von B"),
        "{first}"
    );
    assert!(first.contains("Umkehrspiel des Antriebs (X Y)"), "{first}");
}

#[test]
fn nothing_found_explains_no_share_of_anything() {
    let mut diagnosis = verdict(Verdict::NoiseFloor);
    diagnosis.residual.unexplained_fraction = Some(1.0);
    let input = Comparison { diagnosis: Some(diagnosis), ..Comparison::default() };
    let story = story(&input);
    assert!(story.sure[0].starts_with("Nothing significant was found"), "{:?}", story.sure);
    let text = diagnosis_text(&input);
    for said in story.sure.iter().chain(story.facts.iter().map(|fact| &fact.value)).chain([&text]) {
        assert!(!said.contains("0 %"), "{said}");
    }
}

#[test]
fn a_run_that_is_not_judged_states_no_location_error() {
    let place = Parameter { name: "EX0C".into(), value: Some(13.7), ..size("location-errors", 0.2) };
    let said = |question: Option<Question>, judged: Verdict| {
        let plausibility = question.map(|question| Plausibility { question, ..Plausibility::default() });
        let identification = Identification {
            parameters: vec![place.clone()],
            plausibility: plausibility.into_iter().collect(),
            ..Identification::default()
        };
        let diagnosis = Some(verdict(judged));
        story(&Comparison { identification, diagnosis, ..Comparison::default() }).wrong.join(" ")
    };
    let stated = said(None, Verdict::NoiseFloor);
    assert!(stated.contains("axes have location errors") && stated.contains("13.7"), "{stated}");
    for question in [Some(Question::Whole), Some(Question::Plausible), None] {
        let silent = said(question, Verdict::NotJudged);
        assert!(!silent.contains("location errors"), "{question:?}: {silent}");
    }
}
