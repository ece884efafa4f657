//! One service, many cycles: the program that the controller runs, or the number of its signal, says which; one that has none is refused.

use crate::service::{ONE_FLOOR, REPORT_LIMIT, SILENCE_MS, SWEEP, Staged, staged};
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::config::channels;
use trunnion_core::Clock;
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_effects::Model;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::{Later, cell};
use trunnion_hil_sim::scenario;
use trunnion_machine::shipped;
use trunnion_service::analysis::Analyst;
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::{Config, ProgramCycle};
use trunnion_service::cycles::{Choice, Cycles};
use trunnion_service::daemon::{Texts, serve_on};
use trunnion_service::live::Plan;
use trunnion_tests::in_turn::InTurn;
use trunnion_tests::page_status::{free_address, status};
use trunnion_tests::{reports, show_log, three_probes};

/// What says which cycle is measured.
struct By {
    /// Tables of the configuration.
    tables: &'static str,
    /// Keys of the controller.
    keys: &'static str,
    /// In the refusal of the program without a cycle.
    words: &'static [&'static str],
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_program_is_measured_by_its_cycle_and_an_unknown_one_is_refused() {
    measured_by(By {
        tables: "[[program]]\nname = \"*rtest*\"\ncycle = \"s.toml\"\n[[program]]\nname = \"sweep*\"\ncycle = \"w.toml\"\n",
        keys: "",
        words: &["\"WARMUP\"", "allowed: ", "*rtest* (cycle demo-static)", "sweep* (cycle demo-sweep-c)"],
    })
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_number_of_one_signal_is_measured_by_its_cycle_and_an_unknown_one_is_refused() {
    measured_by(By {
        tables: "[[program]]\nsignal = 1\ncycle = \"s.toml\"\n[[program]]\nsignal = 4\ncycle = \"w.toml\"\n\
                 [cycle_start]\nby = \"signal\"\n",
        keys: "signal = \"cycle\"\n",
        words: &["signal = 3", "allowed: signal 1 (cycle demo-static), signal 4 (cycle demo-sweep-c)"],
    })
    .await;
}

async fn measured_by(By { tables: programs, keys, words }: By) {
    let Staged { cycle_text, machine, stations, pace, virtual_machine, .. } = staged();
    let sweep_text = SWEEP.replace("[5400, 7200]", "[7200]");
    let sweep = Cycle::parse("c.toml", &sweep_text).unwrap();
    let Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } = &sweep.motion else {
        panic!("the cycle is on the fly")
    };
    let _floor = ONE_FLOOR.lock().await;
    show_log();
    let folder = tempfile::tempdir().unwrap();
    let at_rest = |program: &str, count: usize| {
        scenario::static_cycle(Arc::clone(&virtual_machine), program, &stations[..count], pace).unwrap()
    };
    let turning = scenario::sweep_cycle(
        Arc::clone(&virtual_machine),
        "SWEEP-C",
        *axis,
        *from_to_rad,
        feeds_rad_per_s,
        others,
    );
    let worlds = vec![at_rest("RTEST", stations.len()), at_rest("WARMUP", 20), turning.unwrap()];
    let (board, cancel) = (Board::default(), CancellationToken::new());
    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    let mut floor = CellConfig { can: None, ..CellConfig::new(folder.path(), clock.wall_ns()) };
    let controller = &mut floor.controller.as_mut().unwrap().0;
    controller.filters_duplicates = false;
    controller.numbers =
        [("RTEST", 1), ("WARMUP", 3), ("SWEEP-C", 4)].map(|(name, n)| (name.into(), n)).into();
    let world = Later { world: InTurn { worlds, pause_s: 1.5 }, by_s: 3.0 };
    let cell = cell::start(Arc::new(world), floor, tokio::time::Instant::now()).await.unwrap();
    let url = cell.controller.as_ref().and_then(|agent| agent.url()).unwrap().to_string();
    let agent = format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n{keys}");
    let page = free_address();
    let tables = format!("{programs}[page]\nlisten = \"{page}\"\n");
    let text = three_probes(folder.path(), SILENCE_MS, &tables, &agent).replace("cycle = \"c.toml\"\n", "");
    let config = Config::parse(&folder.path().join("trunnion.toml"), &text).unwrap();
    let choice = |of: &ProgramCycle, text: &str| {
        let cycle = Cycle::parse("c.toml", text).unwrap();
        let plan =
            Plan { machine: machine.clone(), cycle, nest: config.nest, channels: channels(&config.devices) };
        let machine = shipped::FILES[0].1.into();
        let texts = Texts { machine, cycle: text.into(), config: config.text.clone() };
        Choice {
            begun_by: of.begun_by.clone(),
            plan,
            texts,
            model: Model::base("table-bc").into(),
            model_file: None,
        }
    };
    let choices = [&cycle_text, &sweep_text];
    let choices = config.programs.iter().zip(choices).map(|(of, text)| choice(of, text)).collect();
    let cycles = Cycles::new(choices).unwrap();
    let runs = config.recordings.clone();
    let service = tokio::spawn(serve_on(config, cycles, clock, cancel.clone(), board.clone(), Analyst::Here));

    // The states in order, as a reader of the topic sees them.
    let mut seen: Vec<(String, String)> = Vec::new();
    let mut refused = None;
    let ended = tokio::time::timeout(REPORT_LIMIT, async {
        loop {
            // Nothing is on the board before the service's first word.
            let Some(now) = board.get("cycle") else {
                tokio::time::sleep(Duration::from_millis(1)).await;
                continue;
            };
            let text = |key: &str| now[key].as_str().unwrap_or_default().to_owned();
            let state = (text("state"), text("program"));
            if seen.last() != Some(&state) {
                seen.push(state.clone());
                if state.0 == "refused" {
                    let page = page.clone();
                    let shown = tokio::task::spawn_blocking(move || status(&page)).await.unwrap();
                    refused = Some((text("why"), shown.unwrap()));
                }
            }
            if state == ("done".into(), "SWEEP-C".into()) {
                return now;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    });
    let last = ended.await.unwrap_or_else(|_| panic!("{seen:?}"));
    let recordings = reports(&runs, 2, REPORT_LIMIT).await.unwrap();
    cancel.cancel();
    service.await.unwrap().unwrap();
    cell.shutdown().await;
    let at = |state: &str, program: &str| {
        let is_it = |seen: &(String, String)| (seen.0.as_str(), seen.1.as_str()) == (state, program);
        seen.iter().position(is_it).unwrap_or_else(|| panic!("no {state} of {program}: {seen:?}"))
    };
    assert_eq!(seen[0].0, "ready");
    let order = [
        at("measuring", "RTEST"),
        at("refused", "WARMUP"),
        at("measuring", "SWEEP-C"),
        at("done", "SWEEP-C"),
    ];
    assert!(order.is_sorted() && at("analysing", "RTEST") < order[2], "{seen:?}");
    assert_eq!(last["cycle"], "demo-sweep-c");
    let (why, shown) = refused.unwrap();
    assert!(words.iter().all(|words| why.contains(words)), "{why}");
    let cycle = &shown["topics"]["cycle"];
    assert_eq!((&cycle["state"], &cycle["why"]), (&"refused".into(), &why.into()), "{shown:#}");
    let names: Vec<String> =
        recordings.iter().map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert!(names[0].starts_with("demo-static-") && names[1].starts_with("demo-sweep-c-"), "{names:?}");
    let first = trunnion_record::read_run(&recordings[0], &|_| Some(machine.clone())).unwrap();
    assert_eq!(first.run.points.len(), stations.len(), "every pose is accounted for");
}
