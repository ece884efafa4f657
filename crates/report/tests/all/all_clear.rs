//! An answer says what it leaves open: what comes back next to an all-clear, what a band does not hold.

use trunnion_report::{correction_text, diagnosis_text, prediction_text};
use trunnion_results::{
    Comparison, Correction, CorrectionValues, Diagnosis, LearnedNoise, Prediction, RunPrediction, Taken,
    Verdict,
};

fn on_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn an_all_clear_states_the_pattern_that_comes_back() {
    let said = |pattern_um: f64| {
        let noise = LearnedNoise { pattern_um, ..LearnedNoise::default() };
        let all_clear = Diagnosis {
            verdict: Verdict::NoiseFloor,
            noticeable_um: Some(0.13),
            noise,
            ..Diagnosis::default()
        };
        on_one_line(&diagnosis_text(&Comparison { diagnosis: Some(all_clear), ..Comparison::default() }))
    };
    assert!(said(0.25).contains("A pattern over the positions of some 0.25 µm comes back"), "{}", said(0.25));
    assert!(!said(0.1).contains("pattern"), "smaller than what would have been noticed");
}

#[test]
fn a_correction_says_no_more_than_the_verdict() {
    let answer = Correction { verdict: Verdict::NoiseFloor, ..Correction::default() };
    let text = on_one_line(&correction_text(&answer));
    assert!(text.contains("No effect is missing from the model that these data can show."), "{text}");
    assert!(!text.contains("noise"), "{text}");
}

#[test]
fn a_band_says_what_it_does_not_hold() {
    let of =
        |taken: Vec<Taken>| on_one_line(&prediction_text(&Prediction { taken, ..Prediction::default() }));
    let one = Taken { effect: "location-errors".into(), name: "EX0B".into(), unit: "um".into(), value: 1.5 };
    let said = of(vec![one]);
    assert!(said.contains("taken as: EX0B = 1.50 µm. The 95 % band does not hold"), "{said}");
    assert!(!of(Vec::new()).contains("does not hold what other values"));
}

#[test]
fn a_prediction_says_whether_the_values_hold() {
    let run = |name: &str, inside_95_fraction, was_fitted| RunPrediction {
        run: name.into(),
        inside_95_fraction,
        was_fitted,
        ..RunPrediction::default()
    };
    let of = |runs: Vec<RunPrediction>| {
        on_one_line(&prediction_text(&Prediction { runs, ..Prediction::default() }))
    };
    let holds = of(vec![run("tuesday", 0.96, false)]);
    assert!(holds.starts_with("The fitted values predict these runs. Change nothing"), "{holds}");
    let said = of(vec![run("monday", 0.96, true), run("tuesday", 0.96, false), run("after", 0.05, false)]);
    assert!(
        said.starts_with("These runs differ from what the fitted values predict. Ask what changed since")
            && said.contains("trunnion history"),
        "{said}"
    );
    assert!(
        !of(vec![run("monday", 0.96, true)]).contains("values predict these"),
        "of what was fitted nothing is predicted"
    );
}

#[test]
fn tables_of_errors_are_not_called_corrections() {
    let of = |control: &str, values| {
        let answer = Correction { control: control.into(), values, ..Correction::default() };
        on_one_line(&correction_text(&answer))
    };
    let errors = of("csv", CorrectionValues::Error);
    assert!(errors.contains("holds the errors of") && errors.contains("must apply the opposite"), "{errors}");
    for text in [of("csv", CorrectionValues::Correction), of("siemens", CorrectionValues::Error)] {
        assert!(text.contains("holds the corrections of") && !text.contains("opposite"), "{text}");
    }
}
