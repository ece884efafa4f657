//! Runs of a service on its page: one line for a run in parts, the verdict of the service, and its story at once.

use crate::page::{Page, here, script};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use trunnion::Model;
use trunnion::cycles::{Cycle, Run};
use trunnion::history::{Keeper, Wanted, history};
use trunnion::results::{RunRecord, RunState, Serves};
use trunnion_core::{Channel, Role};
use trunnion_record::{RunHeader, write_run};
use trunnion_service::begun_by::BegunBy;
use trunnion_service::cycles::{Choice, Cycles};
use trunnion_service::daemon::{Texts, write_report};
use trunnion_service::live::Plan;
use trunnion_service::page::{Access, Runs};
use trunnion_service::run_record;
use trunnion_sync::NestCalibration;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv");
const STATIC: &str = include_str!("../../../../config/cycles/demo-static.toml");
const SWEEP: &str = include_str!("../../../../config/cycles/demo-sweep-c.toml");

/// The points of a committed set.
fn points() -> Run {
    trunnion::read(Path::new(DATA), None).unwrap().run
}

fn record(path: &Path, run: Run) -> PathBuf {
    let machine_text = trunnion::files::machine_text(&run.machine.name).unwrap();
    let name = path.file_stem().unwrap().to_string_lossy().into_owned();
    let header = RunHeader { name, ..RunHeader::of_run(&run, &machine_text, "0", 0) };
    write_run(path, &header, &run).unwrap();
    path.into()
}

/// The cycle of this text, whose runs are judged by this model file.
fn choice(text: &str, model_file: Option<PathBuf>) -> Choice {
    let cycle = Cycle::parse("c.toml", text).unwrap();
    let machine = trunnion::files::machine(&cycle.machine).unwrap();
    let channel = |k: u8| Channel { device: 0, name: format!("probe-{k}"), role: Role::Probe(k) };
    let nest = NestCalibration::orthogonal();
    let model =
        model_file.as_ref().map_or_else(|| Model::base(&machine.name), |file| Model::load(file).unwrap());
    let plan = Plan { machine, cycle, nest, channels: (0..3).map(channel).collect() };
    let texts = Texts { machine: String::new(), cycle: text.into(), config: String::new() };
    Choice { begun_by: BegunBy::Every, plan, texts, model, model_file }
}

/// A model with the effect that the points show.
fn with_gravity(folder: &Path) -> PathBuf {
    let (run, file) = (trunnion::open(DATA).unwrap(), folder.join("with-gravity.toml"));
    let step = run.fit(&run.base_model()).unwrap().add("gravity-sag:B").unwrap();
    step.model().save(&file).unwrap();
    file
}

#[tokio::test]
async fn a_run_in_parts_is_one_run_judged_by_the_model_of_its_cycle() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let all = points();
    let count = all.points.len();
    let (first, second) = all.points.split_at(count / 2);
    let recording = record(&at("run.mcap"), Run { points: first.to_vec(), ..all.clone() });
    record(&at("run-2.mcap"), Run { points: second.to_vec(), ..all.clone() });
    record(&at("before-joining.mcap"), all.clone());
    let state = RunRecord {
        state: RunState::Done,
        cycle: "demo-static".into(),
        parts: vec!["run-2.mcap".into()],
        joined_from: vec!["before-joining.mcap".into()],
        losses: vec!["the folder was removed".into()],
        ..RunRecord::default()
    };
    run_record::write(&recording, &state).unwrap();
    let model = with_gravity(folder.path());
    let cycles = Cycles::new(vec![choice(SWEEP, None), choice(STATIC, Some(model))]).unwrap();
    let runs = Runs::of_folder(folder.path(), None, here()).judged_by(cycles);
    let page = Page::over(runs, folder, Serves::Service, &[], Access::this_computer()).await;

    let list = page.json("GET /api/runs", "", "").await;
    let names: Vec<&str> =
        list["runs"].as_array().unwrap().iter().map(|run| run["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["run"]);
    let comparison = page.json("GET /api/runs/run/comparison", "", "").await;
    let fit = &comparison["identification"];
    assert_eq!(fit["points"], count, "both parts");
    let effects = fit["effects"].as_array().unwrap();
    assert!(effects.contains(&"gravity-sag:B".into()), "{effects:?}");
    assert_eq!(comparison["losses"][0], "the folder was removed");
}

#[tokio::test]
async fn the_story_of_the_service_is_shown_without_a_second_analysis_until_something_changes() {
    let (folder, program) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut warm = Run { channels: vec!["room".into()], ..points() };
    warm.points.iter_mut().for_each(|point| point.state.temperature_degc = vec![20.5]);
    let recording = record(&folder.path().join("run.mcap"), warm);
    write_report(&recording, None, "2026-11-23").unwrap();
    // The history of the command line takes what the service found.
    let mut worked_out = 0;
    let mut keeper = Keeper::new(|_| worked_out += 1);
    let history = history(&[vec![recording.clone()]], &Wanted::default(), &mut keeper).unwrap();
    drop(keeper);
    assert_eq!((history.runs[0].temperature_degc, worked_out), (Some(20.5), 0));
    // Whoever asks for an analysis gets none.
    let runs =
        Runs::of_folder(folder.path(), None, script(program.path(), "exit 1", Duration::from_secs(60)));
    let page = Page::over(runs, folder, Serves::Service, &[], Access::this_computer()).await;
    let story = page.json("GET /api/runs/run", "", "").await;
    // It is what the page would have found by itself.
    let run = trunnion::open(&recording).unwrap();
    let asked = run.fit(&run.base_model()).unwrap().compare().story();
    assert_eq!(story, serde_json::to_value(asked).unwrap());

    let history = page.json("GET /api/history", "", "").await;
    assert_eq!(history["runs"][0]["temperature_degc"], 20.5, "{history}");

    // A model of its own, or another recording: it is analysed, which this program cannot.
    let own = recording.with_extension("model.toml");
    std::fs::copy(with_gravity(program.path()), &own).unwrap();
    assert_eq!(page.ask("GET /api/runs/run", "", "").await.0, 422);
    std::fs::remove_file(&own).unwrap();
    assert_eq!(page.ask("GET /api/runs/run", "", "").await.0, 200);
    let later = SystemTime::now() + Duration::from_secs(1);
    std::fs::File::options().append(true).open(&recording).unwrap().set_modified(later).unwrap();
    assert_eq!(page.ask("GET /api/runs/run", "", "").await.0, 422);
}

#[tokio::test]
async fn the_list_shows_what_was_found_in_this_recording_and_nothing_of_one_that_it_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("run.mcap"), points());
    write_report(&recording, None, "2026-11-23").unwrap();
    let analysed = std::fs::read(&recording).unwrap();
    let other = Run { points: points().points.split_off(points().points.len() / 2), ..points() };
    let replaced = std::fs::read(record(&folder.path().join("other.mcap"), other)).unwrap();
    std::fs::remove_file(folder.path().join("other.mcap")).unwrap();
    let runs = Runs::of_folder(folder.path(), None, here());
    let page = Page::over(runs, folder, Serves::Service, &[], Access::this_computer()).await;
    let listed = || async { page.json("GET /api/runs", "", "").await["runs"][0]["found"].clone() };

    let found = listed().await;
    assert_eq!(found["verdict"], "missing-effect", "{found}");
    std::fs::write(&recording, replaced).unwrap();
    assert_eq!(listed().await, serde_json::Value::Null);
    // Asked, it is analysed, and the list has its figures.
    page.json("GET /api/runs/run", "", "").await;
    let of_other = listed().await;
    assert!(of_other["rms_um"].is_number() && of_other != found, "{of_other}");
    // A copy of what was analysed is written at another time.
    std::fs::write(&recording, analysed).unwrap();
    assert_eq!(listed().await, found);
}

#[tokio::test]
async fn a_story_of_an_earlier_version_is_of_a_copy_of_the_same_length_and_of_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&folder.path().join("run.mcap"), points());
    write_report(&recording, None, "2026-11-23").unwrap();
    let story = recording.with_extension("story.jsonl");
    let text = std::fs::read_to_string(&story).unwrap();
    let (head, rest) = text.split_once('\n').unwrap();
    let mut head: serde_json::Value = serde_json::from_str(head).unwrap();
    head.as_object_mut().unwrap().remove("contents").unwrap();
    std::fs::write(&story, format!("{head}\n{rest}")).unwrap();
    let runs = Runs::of_folder(folder.path(), None, here());
    let page = Page::over(runs, folder, Serves::Service, &[], Access::this_computer()).await;
    let listed = || async { page.json("GET /api/runs", "", "").await["runs"][0]["found"].clone() };

    // A copy is written at another time.
    let later = SystemTime::now() + Duration::from_secs(1);
    let file = std::fs::File::options().append(true).open(&recording).unwrap();
    file.set_modified(later).unwrap();
    assert_eq!(listed().await["verdict"], "missing-effect");
    file.set_len(file.metadata().unwrap().len() - 1).unwrap();
    assert_eq!(listed().await, serde_json::Value::Null);
}
