//! An answer says what it leaves open: what comes back next to an all-clear, what a band does not hold.

use trunnion_report::{correction_text, diagnosis_text, prediction_text};
use trunnion_results::{Comparison, Correction, Diagnosis, LearnedNoise, Prediction, Taken, Verdict};

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
