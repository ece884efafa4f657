//! Gross mistakes of users are named before any physics is blamed, and good runs raise no doubt.

use crate::mistakes::{Files, READINGS, warmed_k};
use std::path::PathBuf;
use trunnion::results::{Decision, Doubt, DoubtReason, Verdict};

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

/// A table that turns without an axial error larger than a step of the display leaves the probe along its axis at one value, at two heights
/// alike; one that tilts there and back comes through its zero position, and the probe along the axis back to its largest value.
#[test]
fn a_coarse_display_of_a_quiet_machine_raises_no_doubt() {
    for (step_um, tilts) in [(0.5, false), (1.0, false), (1.0, true), (2.0, true)] {
        let mut files = Files::committed("points-nothing-hidden");
        let [b, c] = ["b_deg", "c_deg"].map(|name| files.column(name));
        let angle = |row: &[String], column: usize| row[column].parse::<f64>().unwrap();
        files.rows.retain(|row| angle(row, b) == 0.0 || tilts && angle(row, c) == 0.0);
        let columns = READINGS.map(|name| files.column(name));
        for (k, row) in files.rows.iter_mut().enumerate() {
            let [b, c] = [b, c].map(|column| angle(row, column).to_radians());
            // A ball 30 µm off the table's axis and 20 µm off the tilting one, and what else no fit can know.
            let read = [30.0 * c.cos() - 20.0 * b.sin(), -30.0 * c.sin(), 20.0 * b.cos() - 18.0];
            for (channel, (column, um)) in columns.into_iter().zip(read).enumerate() {
                let noise = 0.15 * ((k * 3 + channel) as f64 * 12.9898).sin();
                row[column] = format!("{:.2}", ((um + noise) / step_um).round() * step_um);
            }
        }
        assert_eq!(files.open().check().plausibility, [], "{step_um} µm, {tilts}");
    }
}

/// A table that turns there and back once, while a ball works loose: nothing of the readings comes back, and none was sorted.
#[test]
fn a_drift_larger_than_all_that_one_turn_does_is_no_sorted_column() {
    let mut files = Files::committed("points-nothing-hidden");
    let [b, dz] = ["b_deg", "dz_um"].map(|name| files.column(name));
    files.rows.retain(|row| row[b].parse::<f64>().unwrap() == 0.0);
    for (k, row) in files.rows.iter_mut().enumerate() {
        row[dz] = format!("{:.2}", row[dz].parse::<f64>().unwrap() + 20.0 * k as f64);
    }
    let found = files.open().check().plausibility;
    assert!(found.iter().all(|one| !one.finding.contains("from row to row")), "{found:?}");
}

/// A sensor that never moved, a display in steps of 0.1 K, a motor that settles for the larger part of the run, a change that takes several
/// readings, and one that two sensors show.
#[test]
fn what_a_machine_does_to_its_temperatures_raises_no_doubt() {
    let coarse = |degc: f64| (10.0 * degc).round() / 10.0;
    let switched_k = |row: usize| if row < 150 { 0.0 } else { 5.0 * (1.0 - (-(row as f64 - 149.0)).exp()) };
    let wave_k = |row: usize| 0.8 * (row as f64 / 60.0).sin();
    type Warmed<'a> = &'a dyn Fn(usize) -> f64;
    let cases: [(&str, Warmed, Option<Warmed>); 6] = [
        ("constant", &|_| 0.0, None),
        ("constant in steps of a coarse display", &|row| coarse(0.05 + 0.06 * wave_k(row)), None),
        ("coarse", &|row| coarse(warmed_k(row) + wave_k(row)), None),
        ("settles", &|row| 8.0 * (1.0 - (-(row as f64) / 2.5).exp()), None),
        ("switched on", &|row| wave_k(row) + switched_k(row), None),
        (
            "a door",
            &|row| wave_k(row) + if row < 150 { 0.0 } else { 2.0 },
            Some(&|row| warmed_k(row) - if row < 150 { 0.0 } else { 0.5 }),
        ),
    ];
    for (name, warmed, of_another) in cases {
        let mut files = Files::committed("points-gravity");
        files.warm("bed_degc", warmed);
        of_another.into_iter().for_each(|warmed| files.warm("column_degc", warmed));
        assert_eq!(files.open().check().plausibility, [], "{name}");
    }
}

/// With a long tool in a swivelling head a free angle of the nest makes nearly as little of the readings as the scale of Y that they hold. No
/// model holds a nest turned so far either, so that it does not stand in the answer.
#[test]
fn a_scale_of_an_axis_of_a_head_is_no_nest_mounted_turned() {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/own-machine/scale-on-a-head");
    let mut files = Files::committed("own-machine/scale-on-a-head");
    files.replace("\"m.toml\"", &format!("{:?}", data.join("machine.toml")));
    let run = files.open();
    assert_eq!(run.check().plausibility, []);
    let found = run.fit(&run.base_model()).unwrap().diagnose().unwrap().results();
    assert_eq!(found.named(), ["linear-scale:Y"]);
    assert_eq!(found.set, ["linear-scale:Y"]);
    assert!(found.candidates[0].adequate && found.why.is_empty(), "{}", found.why);
}

/// What a pause never gives is said; a pause, a night and a clock that begins again at each setup are no doubt.
#[test]
fn a_clock_that_was_set_forward_or_stands_is_said_and_a_pause_is_not() {
    let with = |change: &dyn Fn(usize, f64) -> f64| {
        let mut files = Files::committed("points-gravity");
        let column = files.column("time_s");
        for (k, row) in files.rows.iter_mut().enumerate() {
            row[column] = format!("{:.3}", change(k, row[column].parse().unwrap()));
        }
        let check = files.open().check();
        assert_eq!(check.plausibility, []);
        check.doubts.into_iter().map(|doubt| (doubt.reason, doubt.words)).collect::<Vec<_>>()
    };
    let from =
        |row: usize, by_s: f64| move |k: usize, time_s: f64| if k >= row { time_s + by_s } else { time_s };
    let set = with(&from(112, 3600.0));
    let [(DoubtReason::Clock, words)] = &set[..] else { panic!("{set:?}") };
    assert!(words.contains("by 3604 s from row 112 to row 113, by 4.0 s otherwise"), "{words}");
    assert_eq!(with(&from(112, 7194.0)), [], "a pause shorter than two hours and the way to the next pose");
    let stands = with(&|_, _| 0.0);
    let [(DoubtReason::Clock, words)] = &stands[..] else { panic!("{stands:?}") };
    assert!(words.contains("has the time 0 s") && words.contains("out of reach"), "{words}");
    assert_eq!(with(&from(112, 2400.0)), [], "a pause within a pass");
    assert_eq!(with(&from(168, 15.0 * 3600.0)), [], "a night between two setups");
    assert_eq!(
        with(&|k, time_s| if k < 168 { time_s } else { time_s - 672.0 }),
        [],
        "a clock for each setup"
    );
}

/// A corrected machine: the ball slips, an axis has play, or one direction alone still has an error. Where nothing else is as large, a slip
/// looks like a sign that changed.
#[test]
fn what_a_corrected_machine_still_does_is_no_mistake_of_the_readings() {
    fn one_way(files: &Files, row: usize) -> bool {
        files.rows[row][files.column("direction_c")] == "1"
    }
    type Read = fn(&Files, usize) -> [f64; 3];
    let cases: [(&str, Read); 4] = [
        ("slip", |_, row| [0.0, if row < 200 { 0.0 } else { 8.0 }, 0.0]),
        ("slip through the middle", |_, row| [0.0, if row < 252 { -12.0 } else { 12.0 }, 0.0]),
        ("play", |files, row| [0.0, if one_way(files, row) { 4.0 } else { -4.0 }, 0.0]),
        ("one direction", |_, row| [0.0, 0.0, 5.0 * (row as f64 * 0.524).cos()]),
    ];
    for (name, read) in cases {
        let mut files = Files::committed("points-nothing-hidden");
        let columns = READINGS.map(|name| files.column(name));
        for row in 0..files.rows.len() {
            for (channel, (column, um)) in columns.into_iter().zip(read(&files, row)).enumerate() {
                let noise = 0.15 * ((row * 3 + channel) as f64 * 12.9898).sin();
                files.rows[row][column] = format!("{:.2}", um + noise);
            }
        }
        assert_eq!(files.open().check().plausibility, [], "{name}");
    }
}

/// It is left out of the fit, and says nothing of the other readings.
#[test]
fn one_wrong_reading_is_no_mistake_of_all() {
    for row in [0, 100, 335] {
        let mut files = Files::committed("points-nothing-hidden");
        let column = files.column("dx_um");
        let read: f64 = files.rows[row][column].parse().unwrap();
        files.rows[row][column] = format!("{:.2}", read + 2000.0);
        let run = files.open();
        assert_eq!(run.check().plausibility, [], "row {row}");
        let fit = run.fit(&run.base_model()).unwrap();
        assert_eq!(fit.results().outliers, 1, "row {row}");
        let conformity = fit.conformity(80.0, "a test").unwrap();
        assert_eq!(conformity.as_measured.decision, Decision::NotDecidable, "row {row}");
        let excluded = conformity.as_measured.excluded.as_ref().unwrap();
        assert!(excluded.count == 1 && excluded.largest_um > 1900.0, "row {row}: {excluded:?}");
    }
}

/// What comes back at one pose in every visit is the machine, however far it is from the rest.
#[test]
fn an_error_of_one_pose_that_comes_back_is_neither_left_out_nor_passed() {
    let mut files = Files::committed("points-nothing-hidden");
    let [b, c, dx] = ["b_deg", "c_deg", "dx_um"].map(|name| files.column(name));
    let at = |row: &[String], column: usize| row[column].parse::<f64>().unwrap();
    for row in files.rows.iter_mut().filter(|row| at(row, b) == 60.0 && at(row, c) == 90.0) {
        row[dx] = format!("{:.2}", at(row, dx) + 90.0);
    }
    let run = files.open();
    let fit = run.fit(&run.base_model()).unwrap();
    assert_eq!(fit.results().outliers, 0);
    let conformity = fit.conformity(60.0, "a test").unwrap();
    assert_eq!(
        [conformity.as_measured.decision, conformity.corrected.decision],
        [Decision::Fail; 2],
        "{conformity:?}"
    );
    assert_eq!(fit.diagnose().unwrap().results().verdict, Verdict::UnnamedStructure);
}

/// Every pose may have been approached from one side: a doubt. Where the readings know the way, play would be taken for something else.
#[test]
fn directions_that_were_never_filled_in_are_named_where_the_readings_know_the_way() {
    let found = |set: &str| {
        let mut files = Files::committed(set);
        ["direction_b", "direction_c"].into_iter().for_each(|column| files.change(column, |_| 1.0));
        files.open().check().plausibility
    };
    assert_eq!(found("points-nothing-hidden"), []);
    let of_play = found("points-backlash-and-drift");
    assert!(of_play.iter().any(|one| one.finding.contains("the readings know the way")), "{of_play:?}");
}

#[test]
fn good_runs_raise_no_doubt() {
    for set in SETS {
        assert_eq!(Files::committed(set).open().check().plausibility, [], "{set}");
    }
}

/// A drift of two repeatabilities from row to row hides no pose: what depends on the pose comes back all the same.
#[test]
fn a_drift_through_the_whole_run_is_no_order_of_the_readings() {
    let mut files = Files::committed("points-nothing-hidden");
    for row in 0..files.rows.len() {
        let drift_um = 0.6 * row as f64;
        for name in READINGS {
            let column = files.column(name);
            files.rows[row][column] =
                format!("{:.2}", files.rows[row][column].parse::<f64>().unwrap() + drift_um);
        }
    }
    assert_eq!(files.open().check().plausibility, []);
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
        assert!(!words.contains("diagnosis failed") && !words.contains("have location errors"), "{surface}");
    }
    assert!(diagnosed.summary().starts_with("Not judged: these runs cannot be what they say they are"));
    // Too few readings to ask anything of them.
    files.rows.truncate(11);
    files.change("c_deg", |angle| -angle);
    let few = trunnion::report::check_text(&files.open().check());
    assert!(few.contains("The readings were not asked: that needs 12 points or more."), "{few}");
}

/// Only weight knows where down is: what its sag says of the frame, a person can see.
#[test]
fn the_sign_of_a_sag_says_what_reversed_readings_turn_round() {
    let mut files = Files::committed("points-gravity");
    let diagnosed = |files: &Files| {
        let run = files.open();
        run.fit(&run.base_model()).unwrap().diagnose().unwrap()
    };
    let good = diagnosed(&files).results();
    assert_eq!(good.candidates[0].effect.as_str(), "gravity-sag:B");
    assert!(good.why.contains("more upright than lying on its side"), "{}", good.why);
    READINGS.into_iter().for_each(|column| files.change(column, |value| -value));
    let reversed = diagnosed(&files);
    let (answer, text) = (reversed.results(), reversed.summary());
    assert_eq!((answer.verdict, answer.candidates[0].effect.as_str()), (good.verdict, "gravity-sag:B"));
    let said = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("more lying on its side than upright"), "{said}");
    let warning = "make the sign test then, before anything is changed";
    assert!(reversed.compare().page().contains(warning));
    // In the model it says so still, on every surface.
    let added = reversed.fit().add("gravity-sag:B").unwrap().diagnose().unwrap();
    assert_eq!(added.results().verdict, Verdict::NoiseFloor);
    for surface in [added.summary(), added.compare().summary(), added.compare().page()] {
        let words = surface.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("more lying on its side than upright") && words.contains(warning), "{words}");
    }
    assert!(added.compare().story().wrong.iter().any(|said| said.ends_with(&format!("{warning}."))));
}

/// What to doubt in plausible readings: said by `check` and with a fit.
fn doubts(files: &Files) -> Vec<Doubt> {
    let run = files.open();
    assert_eq!(run.check().plausibility, []);
    let found = run.fit(&run.base_model()).unwrap().results().doubts;
    assert_eq!(run.check().doubts, found);
    found
}

/// In a random order no pass goes the other way; every pose may have been approached from below.
#[test]
fn one_direction_of_an_axis_that_went_both_ways_is_doubted() {
    let mut files = Files::committed("points-nothing-hidden");
    let times = files.rows.iter().map(|row| row[files.column("time_s")].clone()).collect::<Vec<_>>();
    files.shuffle(3);
    let column = files.column("time_s");
    files.rows.iter_mut().zip(times).for_each(|(row, time)| row[column] = time);
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

/// A method that cannot use doubted runs says what is wrong with them, not what it lacks because of that.
#[test]
fn every_named_method_answers_doubted_runs_with_the_doubt() {
    let mut files = Files::committed("points-gravity");
    files.change("c_deg", |deg| -deg);
    let run = files.open();
    let doubt = run.plausibility();
    assert!(doubt[0].hypothesis.contains("sense of C reversed"), "{doubt:?}");
    for method in trunnion::EVERY_METHOD {
        let found = run.by_method(method.name, &trunnion::MethodOptions::default());
        let found = found.unwrap_or_else(|refused| panic!("{}: {refused}", method.name));
        assert_eq!(found.plausibility, doubt, "{}", method.name);
    }
    // What is asked wrongly is still refused, and so are good runs that lack what the method needs.
    let axis = Some(run.rotary_joint("B").unwrap());
    let options = trunnion::MethodOptions { axis, ..trunnion::MethodOptions::default() };
    assert!(run.by_method("circular", &options).is_err());
    let good = Files::committed("points-gravity").open();
    assert!(good.by_method("circular", &trunnion::MethodOptions::default()).is_err());
}
