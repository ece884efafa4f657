//! Gross mistakes of users are named before any physics is blamed, and good runs raise no doubt.

use crate::mistakes::{Files, READINGS};
use std::path::PathBuf;
use trunnion::results::{DoubtReason, Verdict};

const SETS: [&str; 4] =
    ["points-gravity", "points-backlash-and-drift", "points-nothing-hidden", "points-unnamed"];

/// A stretch of one value is no stuck probe where the display is coarse: each channel rests for a while where it turns round.
#[test]
fn a_coarse_display_is_not_taken_for_a_stuck_probe() {
    for step_um in [0.1, 0.5, 1.0, 2.0, 5.0] {
        for set in SETS {
            let mut files = Files::committed(set);
            READINGS.into_iter().for_each(|c| files.change(c, |v| (v / step_um).round() * step_um));
            let found = files.open().check().plausibility;
            let of_display = ["same value", "never beyond"];
            assert!(
                found.iter().all(|one| of_display.iter().all(|words| !one.finding.contains(words))),
                "{set}, {step_um} µm: {found:?}"
            );
        }
    }
}

#[test]
fn good_runs_raise_no_doubt() {
    for set in SETS {
        assert_eq!(Files::committed(set).open().check().plausibility, [], "{set}");
    }
}

#[test]
fn what_is_not_plausible_is_not_judged_and_says_why_on_every_surface() {
    let mut files = Files::committed("points-gravity");
    files.change("c_deg", |angle| -angle);
    let run = files.open();
    let fit = run.fit(&run.base_model()).unwrap();
    let diagnosed = fit.diagnose().unwrap();
    let answer = diagnosed.results();
    assert_eq!((answer.verdict, answer.candidates.len()), (Verdict::NotJudged, 0));
    assert_eq!(diagnosed.best(), None);
    let page = fit.compare().page();
    for surface in [answer.why.as_str(), &diagnosed.summary(), &fit.summary(), &page] {
        let words = surface.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("the sense of C reversed"), "{surface}");
    }
}

/// Only weight knows where down is: a frame that gives way more upright than lying down may be one whose readings are all reversed.
#[test]
fn weight_that_acts_the_other_way_asks_for_the_sign_test() {
    let mut files = Files::committed("points-gravity");
    let diagnosed = |files: &Files| {
        let run = files.open();
        run.fit(&run.base_model()).unwrap().diagnose().unwrap()
    };
    let good = diagnosed(&files).results();
    assert_eq!((good.candidates[0].effect.as_str(), good.why.as_str()), ("gravity-sag:B", ""));
    READINGS.into_iter().for_each(|column| files.change(column, |value| -value));
    let reversed = diagnosed(&files);
    let (answer, text) = (reversed.results(), reversed.summary());
    assert_eq!((answer.verdict, answer.candidates[0].effect.as_str()), (good.verdict, "gravity-sag:B"));
    let said = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("Readings whose signs are all reversed look so"), "{said}");
    assert!(reversed.compare().page().contains("Make the sign test before anything is changed"));
}

/// In a random order no pass goes the other way; every pose may have been approached from below.
#[test]
fn one_direction_of_an_axis_that_went_both_ways_is_doubted() {
    let mut files = Files::committed("points-nothing-hidden");
    let times = files.rows.iter().map(|row| row[files.column("time_s")].clone()).collect::<Vec<_>>();
    files.shuffle(3);
    let column = files.column("time_s");
    files.rows.iter_mut().zip(times).for_each(|(row, time)| row[column] = time);
    let doubts = |files: &Files| {
        let run = files.open();
        assert_eq!(run.check().plausibility, []);
        run.fit(&run.base_model()).unwrap().results().doubts
    };
    assert_eq!(doubts(&files), []);
    files.change("direction_b", |_| 1.0);
    let [doubt] = &doubts(&files)[..] else { panic!("one doubt") };
    assert_eq!(
        (doubt.reason, &doubt.names[..]),
        (DoubtReason::OneDirection, &["direction_b".to_owned()][..])
    );
    assert!(
        doubt.words.contains("direction_b is always +1, although B moved the opposite way in"),
        "{}",
        doubt.words
    );
}

#[test]
fn readings_ten_times_too_large_are_doubted_where_they_repeat() {
    let mut files = Files::committed("points-gravity");
    let doubts = |files: &Files| {
        let run = files.open();
        run.fit(&run.base_model()).unwrap().results().doubts
    };
    assert_eq!(doubts(&files), []);
    READINGS.into_iter().for_each(|column| files.change(column, |value| 10.0 * value));
    let [doubt] = &doubts(&files)[..] else { panic!("one doubt") };
    assert_eq!(doubt.reason, DoubtReason::Scatter);
    assert!(
        doubt.words.contains("2.95 µm") && doubt.words.contains("units of the readings"),
        "{}",
        doubt.words
    );
}

#[test]
fn a_recording_given_twice_is_noticed() {
    let run = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-gravity/points.csv");
    let found = trunnion::open_all([&run, &run]).unwrap().check().plausibility;
    assert!(found.iter().any(|one| one.finding.contains("identical, reading by reading")), "{found:?}");
}

/// Three points determine no model: identification and page are there all the same.
#[test]
fn a_diagnosis_that_fails_costs_no_report() {
    let mut files = Files::committed("points-gravity");
    files.rows.truncate(3);
    let run = files.open();
    let fit = run.fit(&run.base_model()).unwrap();
    assert!(fit.diagnose().is_err(), "asked for a diagnosis alone, it fails");
    let analysed = run.analyse(&run.base_model(), "2026-01-01").unwrap();
    let answer = analysed.first().results();
    assert_eq!(answer.verdict, Verdict::NotJudged);
    assert!(answer.why.contains("The diagnosis failed") && answer.why.contains("readings"), "{}", answer.why);
    assert_eq!(analysed.before().results().points, 3);
    assert!(analysed.first().compare().with_best().page().contains("The diagnosis failed"));
}

#[test]
fn a_named_method_states_the_doubt_above_its_numbers() {
    let mut files = Files::committed("points-gravity");
    READINGS.into_iter().for_each(|column| files.change(column, |value| value / 1e3));
    let run = files.open();
    let possible = run.methods().methods.into_iter().find(|method| method.problem.is_empty());
    let name = possible.expect("a method for these points").name;
    let found = run.by_method(&name, &trunnion::MethodOptions::default()).unwrap();
    assert_eq!(found.plausibility, run.plausibility());
    for surface in [trunnion::report::findings_text(&found), trunnion::report::findings_html(&found, "")] {
        let words = surface.split_whitespace().collect::<Vec<_>>().join(" ");
        let (doubt, value) = (words.find("not to be relied on"), words.find(&found.values[0].name));
        assert!(doubt.is_some() && doubt < value && words.contains("too small"), "{surface}");
    }
    let good = Files::committed("points-gravity").open();
    assert_eq!(good.by_method(&name, &trunnion::MethodOptions::default()).unwrap().plausibility, []);
}
