//! The service end to end: virtual devices on real ports, a probe unplugged in the middle of the cycle; delays found on the fly.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion::results::Verdict;
use trunnion_acquire::config::channels;
use trunnion_core::{Clock, Quality};
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::Experiment;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::devices::mtconnect::Shown;
use trunnion_hil_sim::devices::{Fault, ScheduledFault, World, cell};
use trunnion_hil_sim::scenario::{Pace, Station};
use trunnion_hil_sim::{HiddenChoice, Truth, VirtualMachine, scenario};
use trunnion_machine::shipped;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::Cycles;
use trunnion_service::daemon::{Texts, serve};
use trunnion_service::live::Plan;
use trunnion_tests::pauses::Pauses;
use trunnion_tests::{mounted, reports, show_log, three_probes};

const CYCLE: &str = include_str!("../../../config/cycles/demo-static.toml");
pub const SWEEP: &str = include_str!("../../../config/cycles/demo-sweep-c.toml");

/// Two shop floors at once are more than a small computer simulates in real time.
pub static ONE_FLOOR: tokio::sync::Mutex<()> = tokio::sync::Mutex::const_new(());

/// Longest wait for a report: no promise of speed, which unoptimised code on a busy computer cannot keep, but an end of the wait.
pub const REPORT_LIMIT: Duration = Duration::from_secs(600);
/// The probes send every few milliseconds: after so long a probe is silent.
pub const SILENCE_MS: u32 = 250;
/// A computer that pauses for so long makes devices silent by itself.
const TOO_LONG: Duration = Duration::from_millis(200);
/// Attempts on a computer that pauses; one must be judged.
const ATTEMPTS: usize = 4;

/// Measures until the computer kept time meanwhile; the folder and the recordings, so many, of that attempt.
pub async fn measured<W: World + 'static>(
    cycle_text: &str,
    count: usize,
    mut shop: impl FnMut(&Path) -> (W, CellConfig),
) -> (tempfile::TempDir, Vec<PathBuf>) {
    let _floor = ONE_FLOOR.lock().await;
    show_log();
    for _ in 0..ATTEMPTS {
        let folder = tempfile::tempdir().expect("a folder");
        let pauses = Pauses::watch();
        let (world, floor) = shop(folder.path());
        let recordings = measure(folder.path(), world, floor, (cycle_text, count)).await;
        if pauses.longest() < TOO_LONG {
            return (folder, recordings.unwrap_or_else(|| panic!("no report after {REPORT_LIMIT:?}")));
        }
        println!("not judged: this computer paused {} ms", pauses.longest().as_millis());
    }
    panic!("this computer paused in each of {ATTEMPTS} attempts: nothing could be judged")
}

/// Lets the service measure so many cycles on this floor until their reports are there; the paths of the recordings.
async fn measure(
    folder: &Path,
    world: impl World + 'static,
    mut floor: CellConfig,
    (cycle_text, count): (&str, usize),
) -> Option<Vec<PathBuf>> {
    let cycle = Cycle::parse("c.toml", cycle_text).expect("the cycle is good");
    let machine = shipped::machine(&cycle.machine).expect("it is shipped");
    let machine_text = shipped::FILES.iter().find(|(name, _)| *name == cycle.machine).map(|(_, text)| *text);
    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    if let Some((agent, _)) = &mut floor.controller {
        agent.filters_duplicates = false;
        agent.wall_ns_at_origin = clock.wall_ns();
    }
    let begin = tokio::time::Instant::now() + Duration::from_secs(1);
    let cell = cell::start(Arc::new(world), floor, begin).await.expect("the floor starts");
    let url = cell.controller.as_ref().and_then(|agent| agent.url()).expect("an agent").to_string();
    let agent = format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n");
    let text = match &cell.can {
        None => three_probes(folder, SILENCE_MS, "", &agent),
        Some(_) => bar(folder, &agent),
    };
    let config = Config::parse(&folder.join("trunnion.toml"), &text).expect("the configuration is good");
    let base = Model::base(&cycle.machine);
    let plan = Plan { machine, cycle, nest: config.nest, channels: channels(&config.devices) };
    let texts =
        Texts { machine: machine_text.unwrap_or_default().into(), cycle: cycle_text.into(), config: text };
    let cycles = Cycles::one(plan, texts, base.into()).expect("it can be measured");
    let runs = config.recordings.clone();
    let cancel = CancellationToken::new();
    // Before its time 0 the floor is silent, and the supervisor would try again at longer and longer intervals.
    tokio::time::sleep_until(begin).await;
    let service = tokio::spawn(serve(config, cycles, clock, cancel.clone()));

    let recordings = reports(&runs, count, REPORT_LIMIT).await;
    cancel.cancel();
    service.await.expect("no panic").expect("no failure");
    cell.shutdown().await;
    recordings
}

/// A configuration of a ball bar behind a serial CAN adapter; it has no nest. No test of a bar judges silence.
fn bar(ports: &Path, controller: &str) -> String {
    format!(
        "format = \"trunnion-config/1\"\nname = \"m\"\ncycle = \"c.toml\"\nrecordings = \"runs\"\n\
         [[device]]\nname = \"bus\"\ndriver = \"canopen-slcan\"\nport = '{}/can'\nbitrate = 1000000\n\
         sync_ms = 5\nnodes = [{{ id = 5, role = \"bar\", zero_mm = 10 }}]\nsilence_ms = {}\n{controller}",
        ports.display(),
        trunnion_tests::SILENCE_MS
    )
}

/// The small cycle with every second pose, and a machine to measure in it.
pub struct Staged {
    pub cycle_text: String,
    pub machine: trunnion_machine::Machine,
    pub stations: Vec<Station>,
    pub pace: Pace,
    pub duration_s: f64,
    pub virtual_machine: Arc<VirtualMachine>,
}

pub fn staged() -> Staged {
    let cycle_text = CYCLE.replace("step_deg = 30", "step_deg = 60");
    let cycle = Cycle::parse("c.toml", &cycle_text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let stations: Vec<Station> = cycle
        .poses(&machine)
        .unwrap()
        .iter()
        .map(|pose| Station { setup: pose.setup, position: pose.position })
        .collect();
    let pace = Pace { move_s: 0.06, dwell_s: 0.1 };
    let duration_s = scenario::duration_s(stations.len(), pace);
    let truth = Truth::draw(&machine, &mounted(&cycle), &[], duration_s, 3).unwrap();
    let virtual_machine = Arc::new(VirtualMachine::new(machine.clone(), truth).unwrap());
    Staged { cycle_text, machine, stations, pace, duration_s, virtual_machine }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn probes_unplugged_for_a_while_or_for_good_leave_gaps_and_the_cycle_goes_on_to_its_report() {
    let Staged { cycle_text, machine, stations, pace, duration_s, virtual_machine } = staged();
    let last_s = duration_s - 4.0;
    let shop = |folder: &Path| {
        let world = scenario::static_cycle(Arc::clone(&virtual_machine), "c", &stations, pace).unwrap();
        let mut floor = CellConfig { can: None, ..CellConfig::new(folder, 0) };
        floor.probes[1].1.push(ScheduledFault { at_s: 4.0, fault: Fault::Unplug { duration_s: 3.0 } });
        // The third is unplugged towards the end and does not come back.
        floor.probes[2].1.push(ScheduledFault { at_s: last_s, fault: Fault::Unplug { duration_s: 600.0 } });
        (world, floor)
    };
    let (_folder, paths) = measured(&cycle_text, 1, shop).await;
    let path = &paths[0];

    let recording = trunnion_record::read_run(path, &|_| Some(machine.clone())).unwrap();
    let gap =
        recording.gaps.iter().find(|gap| gap.source.contains("probe-2") && gap.to_s > 3.0).expect("a gap");
    assert!(gap.to_s - gap.from_s > 2.5 && gap.to_s - gap.from_s < 8.0, "{gap:?}");
    let is_open = |gap: &&trunnion_core::Gap| gap.source == "probe-3" && gap.from_s > last_s - 2.0;
    let open = recording.gaps.iter().find(is_open).expect("a gap at the end");
    assert!(open.reason.contains("until the end"), "{open:?}");
    assert_eq!(recording.run.points.len(), stations.len(), "every pose is accounted for");
    let good = recording.run.points.iter().filter(|point| point.quality == Quality::Good).count();
    assert!(good > stations.len() / 3 && good < stations.len(), "{good} of {}", stations.len());
    let page = std::fs::read_to_string(path.with_extension("html")).unwrap();
    assert!(page.contains("Time quality") && page.contains("probe-2"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stop_in_the_program_cuts_nothing_and_a_restart_loses_no_begin() {
    let Staged { cycle_text, machine, stations, pace, duration_s, virtual_machine } = staged();
    // M0 for a second, then a reset, and a start 0.4 s later; the machine goes on meanwhile.
    let (stop_s, reset_s) = (4.0, 9.0);
    let shop = |folder: &Path| {
        let world = scenario::static_cycle(Arc::clone(&virtual_machine), "c", &stations, pace).unwrap();
        let mut floor = CellConfig { can: None, ..CellConfig::new(folder, 0) };
        let (agent, _) = floor.controller.as_mut().unwrap();
        agent.shown = vec![
            Shown { from_s: stop_s, to_s: stop_s + 1.0, execution: "PROGRAM_STOPPED" },
            Shown { from_s: reset_s, to_s: reset_s + 0.2, execution: "STOPPED" },
            Shown { from_s: reset_s + 0.2, to_s: reset_s + 0.4, execution: "READY" },
        ];
        (world, floor)
    };
    let (_folder, paths) = measured(&cycle_text, 2, shop).await;

    let read = |path: &PathBuf| -> Vec<usize> {
        let run = trunnion_record::read_run(path, &|_| Some(machine.clone())).unwrap().run;
        assert_eq!(run.points.len(), stations.len(), "every pose is accounted for");
        (0..run.points.len()).filter(|&k| run.points[k].quality == Quality::Good).collect()
    };
    let (first, second) = (read(&paths[0]), read(&paths[1]));
    // Poses a second, from where the program begins to move.
    let per_s = stations.len() as f64 / duration_s;
    let after_stop = ((stop_s + 1.0) * per_s) as usize;
    assert!(first.iter().any(|k| *k > after_stop + 10), "M0 cut the cycle: {first:?}");
    assert!(second[0] <= first[first.len() - 1] + 5, "{first:?} {second:?}");
    assert!(first.len() + second.len() + 8 > stations.len(), "{first:?} {second:?}");
    let diagnosis = std::fs::read_to_string(paths[0].with_extension("diagnosis.json")).unwrap();
    let diagnosis: serde_json::Value = serde_json::from_str(&diagnosis).unwrap();
    assert_eq!(diagnosis["complete"]["planned"], stations.len());
    assert_eq!(diagnosis["complete"]["read"], first.len());
    let both = trunnion::open_all(&paths).unwrap().check();
    assert!(both.plausibility.is_empty(), "{both:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn on_the_fly_the_delays_of_probes_and_axes_are_found_and_taken_out() {
    let cycle = Cycle::parse("c.toml", SWEEP).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    // The rotary axes come later than the linear ones; the second and the third probe answer 10 and 20 ms late.
    let hidden = [HiddenChoice { id: "sync-delay".into(), sigma: 4.0 }];
    let truth = Truth::draw(&machine, &mounted(&cycle), &hidden, 30.0, 5).unwrap();
    let late_s = truth.hidden[0].amplitude * truth.hidden[0].shape[0];
    let virtual_machine = Arc::new(VirtualMachine::new(machine.clone(), truth).unwrap());
    let Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } = &cycle.motion else {
        panic!("the cycle is on the fly")
    };
    let shop = |folder: &Path| {
        let machine = Arc::clone(&virtual_machine);
        let world =
            scenario::sweep_cycle(machine, "c", *axis, *from_to_rad, feeds_rad_per_s, others).unwrap();
        let mut floor = CellConfig { can: None, ..CellConfig::new(folder, 0) };
        for (k, (probe, _)) in floor.probes.iter_mut().enumerate() {
            probe.latency_s += 0.010 * k as f64;
        }
        (world, floor)
    };
    let (_folder, paths) = measured(SWEEP, 1, shop).await;
    let path = &paths[0];

    let recording = trunnion::recording::read(path, &|_| Some(machine.clone()), None).unwrap();
    let timing = recording.timing.expect("a live recording has stamps");
    assert_eq!(timing.sync_moves.len(), 2, "{timing:?}");
    let delays: Vec<f64> = timing.streams[..3].iter().map(|stream| stream.delay_s.unwrap().0).collect();
    // A busy computer delays a stream by some ms at most times; the least delays are what counts.
    for k in 1..3 {
        let more_s = delays[k] - delays[0];
        assert!((more_s - 0.010 * k as f64).abs() < 0.004, "{delays:?}");
    }
    let experiment = Experiment::new(std::slice::from_ref(&recording.run)).unwrap();
    let mut model = Model::base("table-bc");
    model.effects.push(ModelEffect { id: "sync-delay".into(), ..ModelEffect::default() });
    let fit = trunnion_engine::identify(&experiment, &model, &Default::default()).unwrap();
    let rotary = fit.parameters.iter().find(|p| p.effect == "sync-delay").unwrap();
    let (found_s, u_s) = (rotary.value.unwrap(), rotary.u.unwrap());
    assert!((found_s - late_s).abs() < 6.0 * u_s + 0.1 * late_s.abs(), "{found_s} ± {u_s} of {late_s}");
    let reported = trunnion::timing::delay_by_feeds(&experiment).unwrap().expect("two feeds, both ways");
    assert!(reported.contains("rotary axes come later than the linear axes"), "{reported}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "two minutes: tests/peers/run --long"]
async fn a_live_sweep_of_a_good_machine_at_three_feeds_names_nothing() {
    let text = SWEEP.replace("[5400, 7200]", "[3600, 5400, 7200]");
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let truth = Truth::draw(&machine, &mounted(&cycle), &[], 40.0, 11).unwrap();
    let virtual_machine = Arc::new(VirtualMachine::new(machine, truth).unwrap());
    let Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } = &cycle.motion else {
        panic!("the cycle is on the fly")
    };
    assert_eq!(feeds_rad_per_s.len(), 3);
    // The ramps lie outside the span, as in the programs that the product writes.
    let run_in_rad = 0.3 * feeds_rad_per_s[2];
    let span_rad = (from_to_rad.0 - run_in_rad, from_to_rad.1 + run_in_rad);
    let shop = |folder: &Path| {
        let machine = Arc::clone(&virtual_machine);
        let world = scenario::sweep_cycle(machine, "c", *axis, span_rad, feeds_rad_per_s, others).unwrap();
        (world, CellConfig { can: None, ..CellConfig::new(folder, 0) })
    };
    let (_folder, paths) = measured(&text, 1, shop).await;

    let check = trunnion::open(&paths[0]).unwrap().check();
    let samples = &check.complete.samples[0];
    assert!(check.plausibility.is_empty() && samples.share_used > 0.95, "{check:?}");
    let diagnosis = std::fs::read_to_string(paths[0].with_extension("diagnosis.json")).unwrap();
    let diagnosis: trunnion::results::Diagnosis = serde_json::from_str(&diagnosis).unwrap();
    println!("{}: {:?}, {samples:?}", diagnosis.verdict.as_str(), diagnosis.residual);
    assert!(
        !matches!(diagnosis.verdict, Verdict::MissingEffect | Verdict::UnnamedStructure),
        "{diagnosis:?}"
    );
}
