//! The history of a machine over the page of the service: a correction that is entered is kept next to the runs and shown with what it
//! did; the next day is forecast as the command does.

use super::dated::simulate;
use super::page_status::{ask, free_address, status};
use super::program::json;
use super::shop::{Service, agent, config, until};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{SystemTime, UNIX_EPOCH};

const CYCLE: &str = include_str!("../../config/cycles/demo-static.toml");
const CALL: &str = "POST /api/history/corrections";
const HOUR_NS: i64 = 3_600_000_000_000;

/// The service over the folder `runs` of this one, and the address of its page; its devices are absent.
fn served(folder: &Path) -> (Service, String) {
    std::fs::write(folder.join("c.toml"), CYCLE).unwrap();
    let page = free_address();
    let nobody = agent("http://127.0.0.1:9");
    let listen = format!("[page]\nlisten = \"{page}\"\n");
    let file = folder.join("trunnion.toml");
    std::fs::write(&file, config(folder, "runs", &nobody, &listen)).unwrap();
    let service = Service::start(&file);
    until("the page", || status(&page));
    (service, page)
}

fn asked(page: &str, call: &str, body: &str) -> (u16, Value) {
    let (status, answer) = until(call, || ask(page, call, body));
    (status, serde_json::from_str(&answer).unwrap_or(Value::String(answer)))
}

/// Waits for the analysis of a run.
fn analysed(page: &str, name: &str) {
    until(name, || {
        Some(asked(page, &format!("GET /api/runs/{name}"), "")).filter(|(status, _)| *status == 200)
    });
}

#[test]
fn open_takes_the_limits_of_a_configuration_and_ends_well_when_it_is_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let run = super::program::import("points-gravity", folder.path());
    for (limit, allowed) in [("--memory-mb=1", "64..=1000000"), ("--time-s=0", "1..=86400")] {
        let said = super::program::refused(&["open", &run, limit]);
        assert!(said.contains(allowed), "{said}");
    }
    let page = free_address();
    let mut open = crate::program::command();
    let mut open = open.args(["open", &run, "--listen", &page]).stdout(Stdio::null()).spawn().unwrap();
    analysed(&page, "run");
    let children = || -> Vec<String> {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", open.id())).unwrap().flatten();
        let of = |task: std::fs::DirEntry| {
            std::fs::read_to_string(task.path().join("children")).unwrap_or_default()
        };
        tasks.map(of).collect::<String>().split_whitespace().map(String::from).collect()
    };
    let started = children();
    assert!(!started.is_empty(), "nothing analyses");
    assert!(Command::new("kill").arg(open.id().to_string()).status().unwrap().success());
    assert!(open.wait().unwrap().success(), "as Ctrl-C ends it");
    for id in started {
        until("the end of what analyses", || (!Path::new(&format!("/proc/{id}")).exists()).then_some(()));
    }
}

#[test]
fn a_correction_entered_over_the_page_is_kept_and_the_runs_around_it_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let runs = folder.path().join("runs");
    std::fs::create_dir(&runs).unwrap();
    let now_ns = i64::try_from(SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos()).unwrap();
    let leans =
        |urad: f64| move |truth: String| truth.replace("EA0B_urad = 25.0", &format!("EA0B_urad = {urad:.1}"));
    simulate(&runs, "before.mcap", 1, now_ns - 24 * HOUR_NS, leans(25.0));
    let (_service, page) = served(folder.path());
    let call = |call: &str, body: &str| asked(&page, call, body);
    let analysed = |name: &str| analysed(&page, name);
    analysed("before");

    for wrong in [r#"{"by":" ","what":"lines of B"}"#, r#"{"by":"Ada","what":""}"#] {
        let (status, answer) = call(CALL, wrong);
        assert_eq!(status, 400, "{wrong}: {answer}");
    }
    assert!(!runs.join("corrections.jsonl").exists(), "what is refused is not kept");

    let (status, history) = call(CALL, r#"{"by":"Ada","what":"lines of B"}"#);
    assert_eq!(status, 200, "{history}");
    let words = history["around_corrections"][0]["words"].to_string();
    assert!(
        words.contains("Ada entered a correction") && words.contains("measure the same cycle again"),
        "{words}"
    );
    let kept = std::fs::read_to_string(runs.join("corrections.jsonl")).unwrap();
    assert!(kept.lines().count() == 1 && kept.contains("table-bc") && kept.contains("lines of B"), "{kept}");

    simulate(&runs, "after.mcap", 2, now_ns + HOUR_NS, leans(0.0));
    analysed("after");
    let (_, history) = call("GET /api/history", "");
    let around = &history["around_corrections"][0];
    assert_eq!(
        (&around["before"], &around["after"]),
        (&Value::from("before"), &Value::from("after")),
        "{around}"
    );
    let words = around["words"].to_string();
    assert!(words.contains("direction of axis B about X from 25.") && words.contains("(EA0B)"), "{words}");
    let changed: Vec<&Value> =
        around["parameters"].as_array().unwrap().iter().filter(|one| one["changed"] == true).collect();
    assert!(changed.len() == 1 && changed[0]["name"] == "EA0B", "{changed:?}");

    // The command says the same of the same folder.
    let printed = json(&["history", "--folder", &runs.display().to_string(), "--json"]);
    assert_eq!(printed["around_corrections"][0]["words"], around["words"]);
}

#[test]
fn the_page_forecasts_the_next_day_as_the_command_does() {
    let folder = tempfile::tempdir().unwrap();
    let runs = folder.path().join("runs");
    std::fs::create_dir(&runs).unwrap();
    for day in 1..=5_usize {
        let began_ns = (20_500 + day as i64) * 24 * HOUR_NS;
        simulate(&runs, &format!("day-{day}.mcap"), day, began_ns, |truth| truth);
    }
    let (_service, page) = served(folder.path());
    let next_day = || asked(&page, "GET /api/history/next-day", "");
    (1..=5).for_each(|day| analysed(&page, &format!("day-{day}")));
    let (status, forecast) = next_day();
    assert_eq!((status, &forecast["why_not"]), (200, &Value::from("")), "{forecast}");
    let printed = json(&["history", "--folder", &runs.display().to_string(), "--json"]);
    assert_eq!(forecast, printed["forecast"]);
    // A correction: what was measured before it says nothing of the next day.
    assert_eq!(asked(&page, CALL, r#"{"by":"Ada","what":"lines of B"}"#).0, 200);
    let why_not = next_day().1["why_not"].to_string();
    assert!(why_not.contains("0 of 5 days were measured since the last correction"), "{why_not}");
}
