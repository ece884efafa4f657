//! `trunnion daemon` that is killed, and analyses that hang or take too much: every recording gets a report, or says why not.

use super::json_schema::{differences, schema_of_topic};
use super::page_status::{ask, free_address, status};
use super::program::{json, output, refused};
use super::shop::{Floor, Service, agent, config, floor, journal, record, until};
use std::path::Path;
use std::process::Command;
use trunnion::results::RunState;
use trunnion_hil_sim::scenario::Pace;
use trunnion_machine::shipped;

const CYCLE: &str = include_str!("../../config/cycles/demo-static.toml");
/// A journal of this size holds some seconds of three probes at 1 kHz.
const SECONDS_OF_A_JOURNAL: u64 = 400_000;

/// Holds the topics against their schemas; their names.
fn as_schemas_say(topics: &serde_json::Value) -> Vec<&str> {
    let topics = topics.as_object().unwrap();
    for (name, value) in topics {
        let schema = schema_of_topic(name);
        assert_eq!(differences(value, &schema), Vec::<String>::new(), "{name}: {value}");
    }
    topics.keys().map(String::as_str).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_run_killed_in_mid_cycle_is_recovered_analysed_and_reported_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let Floor { cell, url, cycle } =
        floor(folder.path(), 60, Pace { move_s: 0.1, dwell_s: 0.3 }, |_| {}).await;
    let (file, runs) = (folder.path().join("trunnion.toml"), folder.path().join("runs"));
    let page = free_address();
    let tables = format!("[page]\nlisten = \"{page}\"\n");
    std::fs::write(&file, config(folder.path(), "runs", &agent(&url), &tables)).unwrap();
    std::fs::write(folder.path().join("c.toml"), &cycle).unwrap();

    tokio::task::spawn_blocking(move || {
        let service = Service::start(&file);
        let journal = journal(&runs, SECONDS_OF_A_JOURNAL);
        service.kill();
        assert!(journal.exists());

        let again = Service::start(&file);
        let recording = journal.with_extension("");
        let state = recording.with_extension("state.json");
        let first = until("a report", || record(&state).filter(|record| record.state.has_report()));
        // Too little of the cycle was read for a verdict.
        assert_eq!((first.state, first.tries, first.cycle.as_str()), (RunState::NotJudged, 1, "demo-static"));
        assert!(first.why.contains("planned points were read"), "{first:?}");
        assert!(recording.exists() && !journal.exists());
        assert!(recording.with_extension("html").exists());
        let answer = first.answer.unwrap();
        assert!(answer.result.complete.read > 3, "{:?}", answer.result);
        let events = trunnion_record::read_run(&recording, &shipped::machine).unwrap().events;
        assert!(events.iter().any(|event| event.kind == "recovered"));

        // The program went on: its second part is recorded, and both are judged as one cycle.
        let stem = recording.file_stem().unwrap().to_string_lossy().into_owned();
        let joined = recording.with_file_name(format!("{stem}-joined.state.json"));
        let whole = until("the whole cycle", || record(&joined).filter(|record| record.state.has_report()));
        let first = recording.file_name().unwrap().to_string_lossy().into_owned();
        assert_eq!((whole.joined_from.len(), &whole.joined_from[0]), (2, &first));
        assert_eq!(whole.state, RunState::Done, "{whole:?}");
        // Neither part is a run of its own any more, and every topic names the whole.
        for part in &whole.joined_from {
            let part = record(&recording.with_file_name(part).with_extension("state.json")).unwrap();
            assert_eq!(part.state, RunState::Joined, "{part:?}");
            assert_eq!(part.joined_into, Some(format!("{stem}-joined.mcap")));
        }
        let topics = until("the cycle", || {
            let topics = status(&page)?["topics"].take();
            (topics["cycle"]["state"] == "done" && topics["status"]["cycle"]["state"] == "done")
                .then_some(topics)
        });
        assert_eq!(topics["cycle"]["run"], format!("{stem}-joined"), "{topics}");
        assert_eq!(topics["cycle"]["recording"], topics["result"]["run"], "{topics}");
        assert_eq!(topics["status"]["cycle"]["run"], topics["cycle"]["run"], "{topics}");
        assert_eq!(
            as_schemas_say(&topics),
            ["alarms", "cycle", "live", "quality", "ready", "result", "set-up", "status", "storage"]
        );
        // One answer over the page and on the command line, which ends with 3 for what is missing.
        let call = format!("GET /api/runs/{stem}-joined/identification");
        let (_, of_page) = until("the fit", || ask(&page, &call, "").filter(|(status, _)| *status == 200));
        let file = recording.with_file_name(format!("{stem}-joined.mcap")).display().to_string();
        let (_, of_command, _) = output(&["identify", &file, "--json"]);
        let of_page: serde_json::Value = serde_json::from_str(&of_page).unwrap();
        assert!(of_page["time_quality"].is_array(), "{of_page}");
        assert_eq!(of_page, serde_json::from_str::<serde_json::Value>(&of_command).unwrap());
        let complete = whole.answer.unwrap().result.complete;
        assert_eq!(complete.planned, answer.result.complete.planned);
        assert!(complete.read > answer.result.complete.read + 20, "{complete:?}");
        let events = trunnion_record::read_run(
            &recording.with_file_name(format!("{stem}-joined.mcap")),
            &shipped::machine,
        );
        assert!(events.unwrap().events.iter().any(|event| event.kind == "joined"));
        drop(again);

        // By hand the parts give the same.
        let by_hand = recording.with_file_name("by-hand.mcap").display().to_string();
        let parts: Vec<String> = whole
            .joined_from
            .iter()
            .map(|name| recording.with_file_name(name).display().to_string())
            .collect();
        let joined = json(&["join", &parts[0], &parts[1], "-o", &by_hand, "--json"]);
        assert_eq!(joined["read"], complete.read, "{joined}");
        let read = |part: usize| joined["parts"][part]["read"].as_u64().unwrap();
        assert!(read(0).max(read(1)) < complete.read as u64, "{joined}");
        // As text, for what has no value is not equal to itself.
        let points = |run: &Path| {
            format!("{:?}", trunnion_record::read_run(run, &shipped::machine).unwrap().run.points)
        };
        let of_service = recording.with_file_name(format!("{stem}-joined.mcap"));
        assert!(points(Path::new(&by_hand)) == points(&of_service), "other points than those of the service");
        let again = recording.with_file_name("again.mcap").display().to_string();
        let said = refused(&["join", &parts[1], &parts[0], "-o", &again]);
        assert!(said.contains("in order of time") && !Path::new(&again).exists(), "{said}");
    })
    .await
    .unwrap();
    cell.shutdown().await;
}

#[test]
fn an_analysis_that_hangs_or_takes_too_much_memory_is_ended_and_tried_only_so_often() {
    let folder = tempfile::tempdir().unwrap();
    let (file, runs) = (folder.path().join("trunnion.toml"), folder.path().join("runs"));
    std::fs::create_dir(&runs).unwrap();
    std::fs::write(folder.path().join("c.toml"), CYCLE).unwrap();
    let run = super::program::import("points-gravity", &runs);
    let state = Path::new(&run).with_extension("state.json");
    let with = |limits: &str| {
        let limits = format!("[analysis]\n{limits}\n");
        std::fs::write(&file, config(folder.path(), "runs", &agent("http://127.0.0.1:9"), &limits)).unwrap();
        Service::start(&file)
    };
    let failed = |tries: u32| {
        until("a failure", || {
            record(&state).filter(|record| (record.state, record.tries) == (RunState::Failed, tries))
        })
    };

    let service = with("time_s = 10");
    let id = until("a process", || service.analyses().first().copied());
    let stopped = Command::new("kill").args(["-STOP", &id.to_string()]).status().unwrap();
    assert!(stopped.success());
    assert_eq!(failed(1).why, "it took more than 10 s (time_s of [analysis]) and was ended");
    assert!(!Path::new(&format!("/proc/{id}")).exists(), "the process is still there");
    drop(service);

    let service = with("memory_mb = 64\ntries = 2");
    let why = failed(2).why;
    assert_eq!(why, "it needed more than 64 MB (memory_mb of [analysis])");
    drop(service);

    // Two failures are enough; a third start leaves it alone until it may be tried again.
    let page = free_address();
    let service = with(&format!("tries = 2\n[page]\nlisten = \"{page}\""));
    until("the page", || status(&page));
    assert_eq!(failed(2).why, why);
    drop(service);

    let service = with("tries = 3");
    let done = until("a report", || record(&state).filter(|record| record.state.has_report()));
    assert_eq!((done.state, done.tries, done.why.as_str()), (RunState::Done, 3, ""));
    drop(service);

    // What was found last is there again for whoever asks.
    let service = with(&format!("tries = 3\n[page]\nlisten = \"{page}\""));
    let shown = until("the result", || status(&page).filter(|shown| shown["topics"]["result"].is_object()));
    assert_eq!(shown["topics"]["result"]["run"], "run.mcap");
    assert_eq!(shown["topics"]["result"]["verdict"], "missing-effect");
    let shown =
        until("the alarms", || status(&page).filter(|shown| shown["topics"]["alarms"]["run"] == "run"));
    assert_eq!(shown["topics"]["alarms"], serde_json::json!({ "run": "run", "watched": 0, "alarms": [] }));
    drop(service);
}
