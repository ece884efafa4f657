//! The main job through real ports: virtual probes and controller, real drivers, recording, diagnosis.

use super::page_status::ask;
use super::shop::until;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

#[test]
fn the_demo_finds_the_hidden_sag_and_replay_repeats_its_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("demo").display().to_string();
    let trunnion = |args: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_trunnion")).args(args).output().unwrap();
        (done.status.code(), String::from_utf8(done.stdout).unwrap(), String::from_utf8(done.stderr).unwrap())
    };
    let (code, stdout, stderr) =
        trunnion(&["demo", "--hidden", "gravity-sag:B", "--seed", "7", "--json", "--output", &output]);
    // A busy machine may lose samples: that is reported (exit 3) and is no failure of the diagnosis.
    assert!(matches!(code, Some(0 | 3)), "{stderr}");
    let reported: Value = serde_json::from_str(&stdout).unwrap();
    let losses: Vec<&str> = reported["losses"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(code == Some(0), losses.is_empty(), "{losses:?}");
    // The reason is said with the pause that was measured.
    let why_lost = reported["why_lost"].as_str().unwrap();
    assert_eq!(why_lost.is_empty(), losses.is_empty(), "{why_lost}");
    assert!(
        losses.is_empty() || (why_lost.starts_with("Data loss") && why_lost.contains(" ms")),
        "{why_lost}"
    );
    // While the ball is mounted again the probes are out of range, and before the program starts nothing is asked.
    assert!(losses.iter().all(|loss| !loss.contains("range") && !loss.contains("from -")), "{losses:?}");
    assert_eq!(reported["diagnosis"]["candidates"][0]["effect"], "gravity-sag:B", "{reported}");
    let step = &reported["ladder"][0];
    let number = |key: &str| step[key].as_f64().unwrap();
    assert!(number("error_after_um") < 0.5 * number("error_before_um"), "{step}");
    assert!(number("holdout_after_um") < 0.7 * number("holdout_before_um"), "{step}");

    // The page of a recording looks for its model here.
    let files = |name: &str| folder.path().join("demo").join(name).exists();
    assert!(files("static.model.toml") && !files("model.toml"));

    // From the file alone comes what the live run said.
    let run = format!("{output}/static.mcap");
    let (_, replayed, _) = trunnion(&["diagnose", &run, "--json"]);
    let replayed: Value = serde_json::from_str(&replayed).unwrap();
    assert_eq!(replayed, reported["diagnosis"]);
    let page = std::fs::read_to_string(format!("{output}/report.html")).unwrap();
    assert!(page.contains("gravity-sag:B") && page.contains("<svg"));
}

/// With a page the terminal proposes and the person adds: nothing is in the model, and the truth is sealed, until then.
#[test]
fn with_a_page_the_person_adds_and_then_the_seal_is_broken() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("static.model.toml");
    let mut demo = Command::new(env!("CARGO_BIN_EXE_trunnion"));
    demo.args(["demo", "--page", "--static-only", "--hidden", "gravity-sag:B", "--seed", "7", "--output"]);
    let mut demo = demo.arg(folder.path()).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(demo.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut said_until = |word: &str| {
        let mut said = Vec::new();
        for line in lines.by_ref() {
            said.push(line);
            if said.last().is_some_and(|line| line.contains(word)) {
                return said;
            }
        }
        panic!("the demo ended without {word}: {said:#?}")
    };
    let watch = said_until("Watch it at").pop().unwrap();
    let page = watch.split("http://").nth(1).unwrap().to_owned();
    let said = said_until("The page stays at").join("\n");
    assert!(said.contains("gravity-sag:B") && said.contains("Add it on the page"), "{said}");
    assert!(!said.contains("Added ") && !said.contains("Hidden: "), "{said}");
    assert!(!model.exists(), "the demo adds by itself");

    // A slow computer answers 504 first: the analysis goes on.
    let answer = |call: &str, body: &str| {
        until("an answer", || ask(&page, call, body).filter(|(status, _)| *status != 504))
    };
    assert_eq!(answer("GET /api/runs/static", "").0, 200);
    let (status, story) = answer("POST /api/runs/static/model/gravity-sag:B", r#"{"by":"Ada"}"#);
    assert_eq!(status, 200, "{story}");
    assert!(Command::new("kill").args(["-INT", &demo.id().to_string()]).status().unwrap().success());
    let said = said_until("Hidden: ").join("\n");
    assert!(said.contains("gravity-sag:B. Found: gravity-sag:B, added by Ada."), "{said}");
    assert!(std::fs::read_to_string(&model).unwrap().contains("by = \"Ada\""), "the person's model is kept");
    // A busy machine may lose samples.
    assert!(matches!(demo.wait().unwrap().code(), Some(0 | 3)));
}
