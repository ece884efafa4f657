//! The runs of one machine through the binary.

use crate::program::{data, json, output, trunnion};
use crate::{dated, one_line};
use serde_json::Value;
use std::path::Path;

const TRUTH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/truths/table-bc.toml");

/// Run number `number` of a machine whose axis B leans by `ea0b_urad`.
fn simulate(folder: &Path, name: &str, number: usize, ea0b_urad: f64) {
    let truth = std::fs::read_to_string(TRUTH).unwrap();
    let truth = truth.replace("EA0B_urad = 25.0", &format!("EA0B_urad = {ea0b_urad:.1}"));
    let file = folder.join("truth.toml").display().to_string();
    std::fs::write(&file, truth).unwrap();
    let run = folder.join(name).display().to_string();
    trunnion(&["simulate", &file, "--run", &number.to_string(), "-o", &run]);
}

fn history(folder: &Path, more: &[&str]) -> Value {
    let folder = folder.display().to_string();
    json(&[&["history", "--folder", &folder, "--json"], more].concat())
}

#[test]
fn a_machine_that_leans_is_alarmed_about_with_how_much_and_where() {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..=5 {
        simulate(folder.path(), &format!("day-{number}.mcap"), number, 25.0);
    }
    let unchanged = history(folder.path(), &[]);
    assert_eq!(unchanged["runs"].as_array().unwrap().len(), 5);
    for run in unchanged["runs"].as_array().unwrap() {
        assert_eq!(run["alarms"].as_array().unwrap().len(), 0, "{run}");
    }
    let words = unchanged["change"]["words"].to_string();
    assert!(words.contains("Nothing changed"), "{words}");
    assert!(folder.path().join("day-5.history.jsonl").exists(), "it is kept next to its run");
    let name = folder.path().display().to_string();
    let (_, kept, error) = output(&["history", "--folder", &name, "--json"]);
    assert_eq!(serde_json::from_str::<Value>(&kept).unwrap(), unchanged);
    assert_eq!(error, "", "how far it is stands on a terminal alone");

    simulate(folder.path(), "day-6.mcap", 6, 75.0);
    let leaning = history(folder.path(), &[]);
    let changed: Vec<&Value> = leaning["change"]["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|one| one["changed"] == true)
        .collect();
    assert_eq!(changed.len(), 1, "{changed:?}");
    assert_eq!(changed[0]["name"], "EA0B");
    let number = |value: &Value| value.as_f64().unwrap();
    let (difference, u) = (number(&changed[0]["difference"]), number(&changed[0]["u"]));
    assert!((difference - 50.0).abs() < 4.0 * u, "{difference} ± {u}");
    assert!(
        number(&leaning["change"]["rms_with_old_um"]) > 2.0 * number(&leaning["change"]["rms_with_new_um"])
    );
    assert_eq!(leaning["runs"][5]["alarms"], serde_json::json!(["EA0B"]), "{}", leaning["runs"][5]);

    // A repair before it: nothing to compare with yet.
    let since = history(folder.path(), &["--since", "day-6"]);
    assert_eq!(since["runs"][5]["alarms"].as_array().unwrap().len(), 0, "{}", since["runs"][5]);
    let text = trunnion(&["history", "--folder", &folder.path().display().to_string()]);
    assert!(
        text.starts_with("day-6: outside its control limits: direction of axis B about X (EA0B)"),
        "{text}"
    );
    assert!(text.contains("direction of axis B about X by +") && text.contains(" ± "), "{text}");
}

#[test]
fn a_correction_that_was_entered_is_kept_and_said() {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), "day-1.mcap", 1, 25.0);
    let name = folder.path().display().to_string();
    let enter = ["history", "--folder", &name, "--corrected", "lines of B and C", "--by", "Ada"];
    let text = trunnion(&enter);
    assert!(
        text.contains("Before and after a correction") && text.contains("Ada entered a correction"),
        "{text}"
    );
    let again = history(folder.path(), &[]);
    assert_eq!(again["corrections"][0]["machine"], "table-bc", "{again}");
    assert_eq!(again["around_corrections"][0]["correction"]["what"], "lines of B and C", "{again}");
    let (done, _, error) = output(&["history", "--folder", &name, "--corrected", "lines of B and C"]);
    assert!(!done && error.contains("--by"), "{error}");
}

#[test]
fn an_effect_that_is_new_is_named_and_other_parameters_do_not_take_its_place() {
    let folder = tempfile::tempdir().unwrap();
    for (name, set) in [("1", "points-nothing-hidden"), ("2", "points-gravity")] {
        let file = |name: &str| data(set).join(name).display().to_string();
        let run = folder.path().join(format!("{name}.mcap")).display().to_string();
        trunnion(&["import", &file("points.csv"), "--setup", &file("setup.toml"), "-o", &run]);
    }
    let history = history(folder.path(), &[]);
    assert_eq!(
        history["change"]["new_effects"],
        serde_json::json!(["gravity-sag:B"]),
        "{}",
        history["change"]
    );
    let words = history["change"]["words"].to_string();
    assert!(words.contains("New since 1: Sag of the tilting frame"), "{words}");
}

#[test]
fn two_runs_that_cannot_be_compared_are_named_and_the_list_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..=2 {
        simulate(folder.path(), &format!("day-{number}.mcap"), number, 25.0);
    }
    // The machine file was corrected in between.
    let second = folder.path().join("day-2.mcap");
    let recording = trunnion_record::read_run(&second, &trunnion_machine::shipped::machine).unwrap();
    let machine_text = recording.header.machine_text.replacen("gear_teeth = 72", "gear_teeth = 90", 1);
    assert_ne!(machine_text, recording.header.machine_text);
    let header = trunnion_record::RunHeader { machine_text, ..recording.header };
    std::fs::remove_file(&second).unwrap();
    trunnion_record::write_run(&second, &header, &recording.run).unwrap();

    let name = folder.path().display().to_string();
    let (done, text, error) = output(&["history", "--folder", &name]);
    assert!(!done, "no verdict on what changed");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("What changed is not known day-1 and day-2 cannot be compared: "),
        "{text}{error}"
    );
    assert!(words.contains("Last value against") || words.contains("Machine table-bc; model:"), "{text}");
    let (_, json, _) = output(&["history", "--folder", &name, "--json"]);
    let answer: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(answer["runs"].as_array().unwrap().len(), 2);
    assert!(answer["change"].is_null() && answer["why_no_change"] != "", "{answer}");
}

#[test]
fn what_cannot_be_read_is_listed_and_an_unknown_run_is_refused_with_those_there_are() {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), "day-1.mcap", 1, 25.0);
    std::fs::write(folder.path().join("torn.mcap"), b"not a recording").unwrap();
    let name = folder.path().display().to_string();
    let (done, text, _) = output(&["history", "--folder", &name]);
    assert!(!done && text.contains("torn") && text.contains("day-1"), "{text}");
    let (done, _, error) = output(&["history", "--folder", &name, "--since", "day-9"]);
    assert!(!done && error.contains("day-9") && error.contains("day-1"), "{error}");
    let (done, _, error) = output(&["history", "tabel-bc", "--folder", &name]);
    assert!(!done && error.contains("tabel-bc") && error.contains("did you mean table-bc?"), "{error}");
}

#[test]
fn the_next_day_is_forecast_from_frozen_values_once_five_days_were_measured() {
    let folder = tempfile::tempdir().unwrap();
    let day_ns = |day: i64| (20_500 + day) * 86_400_000_000_000;
    let day = |number: usize| {
        let name = format!("day-{number}.mcap");
        dated::simulate(folder.path(), &name, number, day_ns(number as i64), |truth| truth);
        folder.path().join(name).display().to_string()
    };
    let four: Vec<String> = (1..=4).map(day).collect();
    let forecast = &history(folder.path(), &[])["forecast"];
    assert_eq!(forecast["why_not"], "4 of 5 days were measured");
    assert!(
        forecast["band_95_um"].is_null() && forecast["values"].as_array().unwrap().is_empty(),
        "{forecast}"
    );

    let five: Vec<String> = four.into_iter().chain([day(5)]).collect();
    let forecast = history(folder.path(), &[])["forecast"].clone();
    assert_eq!(forecast["why_not"], "", "{forecast}");
    assert_eq!(forecast["checked"]["run"], "day-5", "the last day was predicted by those before it");
    let number = |value: &Value| value.as_f64().unwrap();
    let leans = forecast["values"].as_array().unwrap().iter().find(|one| one["name"] == "EA0B").unwrap();
    assert!((number(&leans["value"]) - 25.0).abs() < 3.0 * number(&leans["u"]), "{leans}");

    // The next day comes, and is what `trunnion predict` makes of the same days: inside the band.
    let next = day(6);
    let model = folder.path().join("base.toml").display().to_string();
    let base = "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n[[effect]]\nid = \"ball-setting\"\n";
    std::fs::write(&model, base).unwrap();
    let days: Vec<&str> = five.iter().map(String::as_str).collect();
    let args = [&["predict", &next, "--model", &model, "--json", "--fitted"], days.as_slice()].concat();
    let come = &json(&args)["runs"][0];
    let (band, expected) = (number(&come["band_95_um"]), number(&forecast["band_95_um"]));
    assert!((band / expected - 1.0).abs() < 1e-6, "{band} µm, forecast {expected} µm");
    assert!(number(&come["inside_95_fraction"]) > 0.9, "{come}");

    // A machine that leans since has no forecast.
    dated::simulate(folder.path(), "day-7.mcap", 7, day_ns(7), |truth| {
        truth.replace("EA0B_urad = 25.0", "EA0B_urad = 75.0")
    });
    let why_not = history(folder.path(), &[])["forecast"]["why_not"].to_string();
    assert!(why_not.contains("day-7 is outside its control limits"), "{why_not}");
    let text = trunnion(&["history", "--folder", &folder.path().display().to_string()]);
    assert!(text.contains("No forecast of the next day: day-7 is outside"), "{text}");
}

#[test]
fn other_machines_of_the_folder_are_named_and_how_to_ask_for_them() {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), "day-1.mcap", 1, 25.0);
    for number in 1..=2 {
        let truth = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/truths/table-ac.toml");
        let run = folder.path().join(format!("other-{number}.mcap")).display().to_string();
        trunnion(&["simulate", truth, "--run", &number.to_string(), "-o", &run]);
    }
    let name = folder.path().display().to_string();
    let text =
        |more: &[&str]| one_line(trunnion(&[&["history", "--folder", &name], more].concat()).as_bytes());
    let of_newest = text(&[]);
    assert!(of_newest.contains("Machine table-bc; model:") || of_newest.contains("Machine table-ac; model:"));
    let of_other = text(&["table-ac"]);
    let note = "The folder also has runs of table-bc (1 run). Name a machine to see its runs: `trunnion history table-bc` with the same --folder.";
    assert!(of_other.contains(note), "{of_other}");
    let of_first = text(&["table-bc"]);
    assert!(of_first.contains("The folder also has runs of table-ac (2 runs)."), "{of_first}");
}

#[test]
fn a_history_without_a_run_to_compare_has_no_empty_model() {
    let folder = tempfile::tempdir().unwrap();
    simulate(folder.path(), "day-1.mcap", 1, 25.0);
    let run = folder.path().join("day-1.mcap");
    let header = trunnion_record::read_header(&run).unwrap();
    std::fs::remove_file(&run).unwrap();
    // A run without points.
    trunnion_record::RunWriter::create(&run, &header).unwrap().finish().unwrap();
    let (_, text, _) = output(&["history", "--folder", &folder.path().display().to_string()]);
    assert!(text.contains("Machine table-bc\n") && !text.contains("model:"), "{text}");
}
