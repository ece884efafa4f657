//! The page over a real socket: what a browser gets, and what an attacker gets.

use serde_json::Value;
use std::net::SocketAddr;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio_util::sync::CancellationToken;
use trunnion::Filing;
use trunnion::cycles::RunKind;
use trunnion::report::{Language, report_html};
use trunnion::results::{PageCycle, RunRecord, Serves};
use trunnion_core::Clock;
use trunnion_service::analysis::{AnalysisLimits, Analyst};
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::page::{Access, AddressError, PageAnalyst, Runs, Shared, address, serve};

/// Longest wait for an answer of unoptimised code on a busy computer.
const LIMIT: Duration = Duration::from_secs(300);

pub struct Page {
    pub at: SocketAddr,
    pub board: Board,
    pub folder: tempfile::TempDir,
    cancel: CancellationToken,
}

impl Page {
    /// A page with one run, `points-gravity`, whose files are copies, for this computer.
    pub async fn open() -> Self {
        Self::open_for(Access::this_computer()).await
    }

    /// The same for whom `access` lets in.
    pub async fn open_for(access: Access) -> Self {
        Self::serving(Serves::Recordings, &[], access).await
    }

    /// The page of something that serves cycles of these names.
    pub async fn serving(serves: Serves, cycles: &[&str], access: Access) -> Self {
        Self::analysed_by(here(), serves, cycles, access).await
    }

    async fn analysed_by(analyst: PageAnalyst, serves: Serves, cycles: &[&str], access: Access) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("points-gravity");
        std::fs::create_dir(&run).unwrap();
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-gravity");
        for file in ["points.csv", "setup.toml"] {
            std::fs::copy(data.join(file), run.join(file)).unwrap();
        }
        std::fs::write(folder.path().join("secret.mcap"), "secret").unwrap();
        let runs = Runs::of_files(vec![run.join("points.csv")], None, analyst);
        Self::over(runs, folder, serves, cycles, access).await
    }

    /// The page of these runs, whose files are in this folder.
    pub async fn over(
        runs: Runs,
        folder: tempfile::TempDir,
        serves: Serves,
        cycles: &[&str],
        access: Access,
    ) -> Self {
        let (listener, board) = (TcpListener::bind("127.0.0.1:0").await.unwrap(), Board::default());
        let at = listener.local_addr().unwrap();
        board.operator().offer(cycles.iter().copied());
        let shared = Shared {
            serves,
            name: "test".into(),
            runs: Arc::new(runs),
            board: board.clone(),
            cycles: cycles.iter().map(|name| cycle(name)).collect(),
            set_up: None,
            clock: Arc::new(SystemClock::start()),
        };
        let cancel = CancellationToken::new();
        tokio::spawn(serve(listener, Arc::new(shared), access, cancel.clone()));
        Self { at, board, folder, cancel }
    }

    /// Status and answer of a request; `Host` is ours unless `headers` has one.
    pub async fn ask(&self, line: &str, headers: &str, body: &str) -> (u16, String) {
        let host = if headers.contains("Host:") { String::new() } else { format!("Host: {}\r\n", self.at) };
        let text = format!(
            "{line} HTTP/1.1\r\n{host}{headers}Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        self.ask_over(TcpStream::connect(self.at).await.unwrap(), &text).await
    }

    /// The same from another address of this computer.
    pub async fn ask_from(&self, ip: [u8; 4], line: &str) -> u16 {
        let socket = TcpSocket::new_v4().unwrap();
        socket.bind((ip, 0).into()).unwrap();
        let text = format!("{line} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", self.at);
        self.ask_over(socket.connect(self.at).await.unwrap(), &text).await.0
    }

    async fn ask_over(&self, mut stream: TcpStream, text: &str) -> (u16, String) {
        // A refusal may come, and the connection end, before all of a large body is taken.
        stream.write_all(text.as_bytes()).await.ok();
        let mut answer = Vec::new();
        tokio::time::timeout(LIMIT, stream.read_to_end(&mut answer)).await.unwrap().ok();
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        (status, answer)
    }

    pub async fn json(&self, line: &str, headers: &str, body: &str) -> Value {
        let (status, answer) = self.ask(line, headers, body).await;
        assert_eq!(status, 200, "{line}: {answer}");
        serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
    }
}

pub fn here() -> PageAnalyst {
    PageAnalyst::new(Analyst::Here, AnalysisLimits::default(), Arc::new(SystemClock::start()))
}

fn cycle(name: &str) -> PageCycle {
    PageCycle { name: name.into(), ..PageCycle::default() }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

pub const OWN: &str = "x-trunnion: page\r\nContent-Type: application/json\r\n";
pub const ADD: &str = "POST /api/runs/points-gravity/model/gravity-sag:B";

#[tokio::test]
async fn every_answer_has_the_headers_that_keep_scripts_of_others_out() {
    let page = Page::open().await;
    for line in ["GET /", "GET /assets/main.js", "GET /api/status", "GET /nothing"] {
        let (_, answer) = page.ask(line, "", "").await;
        let head = answer.split_once("\r\n\r\n").unwrap().0.to_lowercase();
        for header in ["script-src 'self'", "frame-ancestors 'none'", "nosniff", "no-referrer", "same-origin"]
        {
            assert!(head.contains(header), "{line}: no {header} in {head}");
        }
        assert!(!head.contains("unsafe"), "{line}: {head}");
    }
    let (status, index) = page.ask("GET /", "", "").await;
    assert_eq!(status, 200);
    assert!(!index.contains("http://") && !index.contains("https://"), "nothing comes from elsewhere");
    assert!(!index.contains("<style") && !index.contains(" style="), "{index}");
    for asset in index.split("/assets/").skip(1).map(|rest| rest.split('"').next().unwrap()) {
        assert_eq!(page.ask(&format!("GET /assets/{asset}"), "", "").await.0, 200, "{asset}");
    }
}

#[tokio::test]
async fn a_call_by_another_method_is_refused_as_every_other() {
    let page = Page::open().await;
    for line in ["PUT /api/runs", "GET /api/login", "DELETE /api/status", "GET /api/cycle/begin"] {
        let (status, answer) = page.ask(line, OWN, "").await;
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        let refusal: Value = serde_json::from_str(body).unwrap_or_else(|_| panic!("{line}: {answer}"));
        assert!(refusal["error"].is_string() && head.contains("application/json"), "{line}: {answer}");
        assert!(status == 405 && head.to_lowercase().contains("allow: "), "{line}: {answer}");
    }
}

#[tokio::test]
async fn floods_and_silence_leave_room_for_others() {
    let page = Page::open().await;
    // More connections than are served at once say nothing; the calls after them wait in the queue until those are let go.
    let mut silent = Vec::new();
    for _ in 0..80 {
        silent.push(TcpStream::connect(page.at).await.unwrap());
    }
    assert_eq!(page.ask("GET /api/status", "", "").await.0, 200);
    drop(silent);
    let mut counts = std::collections::BTreeMap::new();
    for _ in 0..400 {
        *counts.entry(page.ask("GET /api/status", "", "").await.0).or_insert(0) += 1;
    }
    println!("400 calls as fast as they go: {counts:?}");
    assert!(counts.keys().all(|status| [200, 429].contains(status)), "{counts:?}");
    assert!(counts[&200] >= 200, "{counts:?}");
    // Another computer does not notice.
    assert_eq!(page.ask_from([127, 0, 0, 2], "GET /api/status").await, 200);
}

#[tokio::test]
async fn who_is_refused_locks_nobody_out() {
    let page = Page::open().await;
    for _ in 0..260 {
        let (status, _) = page.ask("GET /api/status", "Host: attacker.example\r\n", "").await;
        assert_eq!(status, 421);
    }
    assert_eq!(page.ask("GET /api/status", "", "").await.0, 200);
}

#[tokio::test]
async fn an_effect_is_added_and_removed_and_both_browsers_see_it() {
    let page = Page::open().await;
    let mut watcher = TcpStream::connect(page.at).await.unwrap();
    let watch = format!("GET /api/live HTTP/1.1\r\nHost: {}\r\n\r\n", page.at);
    watcher.write_all(watch.as_bytes()).await.unwrap();
    page.board.set("status", &serde_json::json!({ "state": "online" }));

    let list = page.json("GET /api/runs", "", "").await;
    assert_eq!(list["runs"][0]["name"], "points-gravity");
    assert!(list["runs"][0]["found"].is_null());
    assert_eq!(page.json("GET /api/history", "", "").await["runs"], serde_json::json!([]));
    let story = page.json("GET /api/runs/points-gravity", "", "").await;
    assert_eq!(story["candidates"][0]["effect"], "gravity-sag:B", "{story}");
    let list = page.json("GET /api/runs", "", "").await;
    assert_eq!(list["runs"][0]["found"]["verdict"], story["verdict"]);
    let history = page.json("GET /api/history", "", "").await;
    assert_eq!(history["runs"][0]["rms_um"], list["runs"][0]["found"]["rms_um"], "{history}");
    assert!(
        history["change"].is_null() && history["watched"][1]["points"][0]["limits"].is_null(),
        "{history}"
    );

    let corrected = "POST /api/history/corrections";
    // A points file does not say of which machine it is.
    let (status, answer) = page.ask(corrected, OWN, r#"{"by":"Ada","what":"lines of B and C"}"#).await;
    assert!(status == 409 && answer.contains("which machine was corrected"), "{status} {answer}");
    assert_eq!(page.ask(corrected, "", r#"{"by":"Ada","what":"all"}"#).await.0, 403, "from another site");

    let added = page.json(ADD, OWN, r#"{"by":"Ada"}"#).await;
    let model = page.folder.path().join("points-gravity/points.model.toml");
    let text = std::fs::read_to_string(&model).unwrap();
    assert!(text.contains("gravity-sag:B") && text.contains("by = \"Ada\""), "{text}");
    let step = added["ladder"]["rows"].as_array().unwrap().last().unwrap();
    assert_eq!(step["ladder"]["by"], "Ada");
    let at = step["ladder"]["date"].as_str().unwrap();
    assert!(at.len() == "2026-11-23 14:10 UTC".len() && at.ends_with(" UTC"), "to the minute: {at}");
    let um = |value: &Value| value.as_f64().unwrap();
    assert!(um(&step["ladder"]["error_after_um"]) < um(&step["ladder"]["error_before_um"]), "{step}");
    let (status, twice) = page.ask(ADD, OWN, r#"{"by":"Ada"}"#).await;
    assert_eq!(status, 422, "{twice}");
    // What the page says is what the library says.
    let run = trunnion::open(model.with_file_name("points.csv")).unwrap();
    let fit = run.fit(&trunnion::Model::load(&model).unwrap()).unwrap();
    let identification = page.json("GET /api/runs/points-gravity/identification", "", "").await;
    assert_eq!(identification, serde_json::to_value(fit.identified()).unwrap());

    let removed =
        page.json("DELETE /api/runs/points-gravity/model/gravity-sag:B", OWN, r#"{"by":"Bea"}"#).await;
    assert_eq!(removed["headline"], story["headline"]);
    let gone = &removed["ladder"]["removed"][0];
    assert_eq!((&gone["effect"], &gone["by"]), (&"gravity-sag:B".into(), &"Bea".into()), "{removed}");
    assert_eq!(removed["ladder"]["rows"].as_array().unwrap().len(), 2, "{removed}");

    let mut seen = String::new();
    let mut buffer = [0; 4096];
    while !(seen.contains("\"added\"") && seen.contains("\"removed\"") && seen.contains("online")) {
        let read = tokio::time::timeout(LIMIT, watcher.read(&mut buffer)).await.unwrap().unwrap();
        assert!(read > 0, "the events ended: {seen}");
        seen += &String::from_utf8_lossy(&buffer[..read]);
    }
}

#[tokio::test]
async fn a_report_is_filed_as_the_command_files_it() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/points-gravity");
    let run = folder.path().join("run.mcap");
    let [points, setup] = ["points.csv", "setup.toml"].map(|file| data.join(file));
    trunnion::tables::import(RunKind::Static, &points, &setup, &run).unwrap();
    // What the service knows and the recording does not say.
    let losses = vec!["7 samples could not be written to disk".to_string()];
    let state = RunRecord { losses: losses.clone(), ..RunRecord::default() };
    trunnion_service::run_record::write(&run, &state).unwrap();
    let runs = Runs::of_folder(folder.path(), None, here());
    let page = Page::over(runs, folder, Serves::Recordings, &[], Access::this_computer()).await;
    let (file, pdf) = ("POST /api/runs/run/filed", "POST /api/runs/run/filed/pdf");
    assert_eq!(page.ask("GET /api/runs/run/filed", "", "").await.0, 404, "nothing is filed");
    assert_eq!(page.ask(pdf, OWN, "").await.0, 409, "a PDF is printed from the page");
    assert_eq!(page.ask(file, "", "{}").await.0, 403, "from another site");
    for body in [r#"{"language":"xx"}"#, r#"{"by":"a\nb"}"#, r#"{"path":"/tmp/x"}"#] {
        assert_eq!(page.ask(file, OWN, body).await.0, 400, "{body}");
    }
    let other = file.replace("/run/", "/..%2frun/");
    assert_eq!(page.ask(&other, OWN, "{}").await.0, 404);

    for headers in [OWN, "x-trunnion: page\r\n"] {
        assert_eq!(page.json(file, headers, "").await["run"], "run", "nothing need be said");
    }
    let filed = page.json(file, OWN, r#"{"by":"Ada","language":"de"}"#).await;
    let html = page.folder.path().join("run.report.html");
    assert_eq!((filed["html"].as_str(), &filed["pdf"]), (html.to_str(), &Value::Null));
    let written = std::fs::read_to_string(&html).unwrap();
    let experiment = trunnion::open(&run).unwrap();
    let filing = Filing {
        operator: Some("Ada".into()),
        written: trunnion_service::daemon::day(SystemClock::start().wall_ns()),
        ..Filing::default()
    };
    let compared = experiment.fit(&experiment.base_model()).unwrap().compare();
    let compared = compared.with_losses(&losses).with_best();
    assert!(written.contains(&losses[0]), "it says less than the page");
    let report = compared.report(&[run], &filing).unwrap();
    assert!(written == report_html(&report, Language::German), "another report than the command's");
    let (status, shown) = page.ask("GET /api/runs/run/filed", "", "").await;
    assert!(status == 200 && shown.ends_with(&written) && shown.contains("sandbox"), "{status}");
    assert_eq!(page.ask("GET /api/runs/run/filed/pdf", "", "").await.0, 404, "nothing is printed");
}

#[tokio::test]
async fn what_two_browsers_add_at_once_is_both_in_the_model() {
    let page = Page::open().await;
    page.json("GET /api/runs/points-gravity", "", "").await;
    let other = ADD.replace("gravity-sag:B", "backlash:C");
    let (first, second) =
        tokio::join!(page.json(ADD, OWN, r#"{"by":"Ada"}"#), page.json(&other, OWN, r#"{"by":"Bea"}"#));
    let model = page.folder.path().join("points-gravity/points.model.toml");
    let text = std::fs::read_to_string(model).unwrap();
    assert!(text.contains("gravity-sag:B") && text.contains("backlash:C"), "{text}");
    let steps = [first, second].map(|story| story["ladder"]["rows"].as_array().unwrap().len());
    assert_eq!(steps[0].abs_diff(steps[1]), 1, "the later one sees both");
}

/// Analyses by this script.
pub fn script(folder: &Path, script: &str, time: Duration) -> PageAnalyst {
    let program = folder.join("program");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let limits = AnalysisLimits { time, ..AnalysisLimits::default() };
    PageAnalyst::new(Analyst::Program(program), limits, Arc::new(SystemClock::start()))
}

/// A page whose analyses are this script.
async fn analysed_by_script(text: &str, time: Duration) -> (Page, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let analyst = script(folder.path(), text, time);
    let page = Page::analysed_by(analyst, Serves::Recordings, &[], Access::this_computer()).await;
    (page, folder)
}

#[tokio::test]
async fn an_analysis_that_takes_too_much_is_ended_and_the_page_says_so() {
    let ask = "GET /api/runs/points-gravity";
    let (page, _program) = analysed_by_script("exec sleep 100", Duration::from_secs(1)).await;
    let (status, answer) = page.ask(ask, "", "").await;
    assert_eq!(status, 422, "{answer}");
    assert!(answer.contains("it took more than 1 s (time_s of [analysis]) and was ended"), "{answer}");
    let (page, _program) =
        analysed_by_script("echo memory allocation of 9 bytes failed >&2; kill -ABRT $$", LIMIT).await;
    let (status, answer) = page.ask(ask, "", "").await;
    assert_eq!(status, 422, "{answer}");
    assert!(answer.contains("it needed more than 4096 MB (memory_mb of [analysis])"), "{answer}");
    // The next question starts another process; one that answers once and ends is started again.
    let head = r#"{"no-answer":{"failed":"no"}}"#;
    let (page, _program) = analysed_by_script(&format!("read line; echo '{head}'"), LIMIT).await;
    for _ in 0..2 {
        let (status, answer) = page.ask(ask, "", "").await;
        assert_eq!((status, answer.contains("the analysis failed: no")), (422, true), "{answer}");
    }
}

#[test]
fn a_run_whose_samples_were_removed_stays_on_the_list_with_its_report() {
    let folder = tempfile::tempdir().unwrap();
    let name = "low-20261123T141058Z";
    let recording = folder.path().join(format!("{name}.mcap"));
    let why = "2026-12-24T00:00:00Z: it was older than 30 days (keep_days of [storage])";
    let record = RunRecord { removed: Some(why.into()), ..RunRecord::default() };
    trunnion_service::run_record::write(&recording, &record).unwrap();
    std::fs::write(recording.with_extension("html"), "<h1>the report</h1>").unwrap();
    let runs = Runs::of_folder(folder.path(), None, here());
    let list = runs.list();
    let [line] = list.runs.as_slice() else { panic!("{list:?}") };
    assert_eq!((line.name.as_str(), line.removed.as_str()), (name, why));
    assert_eq!(line.began, "2026-11-23 14:10 UTC");
    assert_eq!(runs.left_report(name).unwrap(), "<h1>the report</h1>");
    assert!(runs.left_report("../low").is_none());
    // Put back, it is a run like any other.
    std::fs::write(&recording, "").unwrap();
    assert!(runs.list().runs[0].removed.is_empty() && runs.left_report(name).is_none());
}

#[test]
fn only_addresses_of_this_computer_are_listened_on() {
    assert!(address("127.0.0.1:8460").is_ok() && address("[::1]:0").is_ok());
    for (text, refused) in [("0.0.0.0:8460", false), ("192.168.1.20:8460", false), ("localhost", true)] {
        let expected = |error: &AddressError| matches!(error, AddressError::NoAddress(_)) == refused;
        assert!(address(text).is_err_and(|error| expected(&error)), "{text}");
    }
    let config = include_str!("../../../../config/trunnion.toml");
    let parsed = |text: &str| Config::parse(Path::new("trunnion.toml"), text);
    assert_eq!(parsed(config).unwrap().page.unwrap().listen, "127.0.0.1:8460".parse().unwrap());
    let problems = parsed(&config.replace("127.0.0.1:8460", "0.0.0.0:8460")).unwrap_err().to_string();
    assert!(problems.contains("page.listen 0.0.0.0:8460 can be reached from other computers"), "{problems}");
}
