//! The work of numerics, each piece in a process of its own: processor time, largest memory, and the time as a ratio to a yardstick that
//! the same process runs, so that computers compare.
//!
//! Yardstick: XᵀX of a dense 4096 × 64 matrix, one triangle, plain loops over rows, no threads: 2·n·k(k+1)/2 FLOP.
//! A ratio of 3 means as much processor time as 3 GFLOP of it.
//!
//! `cargo bench -p trunnion-cli --bench numerics [-- NAME …]`; `-- --markdown FILE` writes `docs/measured/numerics.md`.

#![expect(clippy::unwrap_used, reason = "a bench may panic")]

use nalgebra::Point3;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use trunnion_core::{
    AxisSample, HostTime, InstrumentKind, NestSide, Point, ProbeSample, Quality, Setup, Stamp, State,
};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, identify};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine, grid};
use trunnion_hil_sim::{HiddenChoice, Instrument, NestOn, SimSetup, Truth};
use trunnion_machine::shipped;
use trunnion_record::{Item, Recorder, RunHeader, RunWriter, export, points_csv};
use trunnion_sync::blocks::Limits;

/// One piece of work: prepares in a folder, and returns what is measured.
struct Work {
    name: &'static str,
    about: &'static str,
    prepare: fn(&Path) -> Box<dyn FnOnce() -> String>,
}

const WORKS: [Work; 12] = [
    Work {
        name: "fit-1e5",
        about: "fit of the base model to 10⁵ samples on the fly, each a point",
        prepare: |_| fit(100_000),
    },
    Work { name: "fit-1e6", about: "the same of 10⁶ samples", prepare: |_| fit(1_000_000) },
    Work {
        name: "recording-1e6",
        about: "recording of 10⁶ points on the fly to its identification, as `identify` does: read, blocks, fit",
        prepare: |folder| identify_recording(folder, on_the_fly(1_000_000)),
    },
    Work { name: "diagnose-336", about: "diagnosis of 336 points at rest", prepare: |_| diagnosis(7, 12) },
    Work { name: "diagnose-3000", about: "diagnosis of 3000 points at rest", prepare: |_| diagnosis(25, 30) },
    Work {
        name: "journal-1e7",
        about: "10⁷ readings of three probes with stamps into the journal",
        prepare: |folder| journal(folder, false),
    },
    Work {
        name: "finish-1e7",
        about: "the same, and the journal rewritten, compressed and verified",
        prepare: |folder| journal(folder, true),
    },
    Work { name: "read-1e7", about: "reading the finished 10⁷ readings", prepare: read_samples },
    Work { name: "read-points-1e6", about: "reading 10⁶ points on the fly", prepare: read_points },
    Work { name: "import-1e6", about: "import of a table of 10⁶ rows as a recording", prepare: import },
    Work {
        name: "export-1e6",
        about: "export of 10⁶ points at rest as a table",
        prepare: |_| export_table(),
    },
    Work {
        name: "static-1e6",
        about: "recording of 10⁶ points at rest to its identification: read, means of neighbours, fit",
        prepare: |folder| identify_recording(folder, at_rest(on_the_fly(1_000_000))),
    },
];

/// What one process measured.
struct Figures {
    cpu_s: f64,
    peak_mib: f64,
    /// Processor time of one GFLOP of the yardstick, s.
    yardstick_s: f64,
    result: String,
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [part, name] = args.as_slice()
        && part == "--alone"
    {
        return alone(name);
    }
    let markdown = args.iter().position(|argument| argument == "--markdown").map(|at| args[at + 1].clone());
    let wanted: Vec<&String> =
        args.iter().filter(|argument| WORKS.iter().any(|work| work.name == **argument)).collect();
    let mut text = String::from(HEAD);
    for work in WORKS {
        if !wanted.is_empty() && !wanted.iter().any(|name| *name == work.name) {
            continue;
        }
        let Figures { cpu_s, peak_mib, yardstick_s, result } = in_a_process(work.name);
        let ratio = cpu_s / yardstick_s;
        let row = format!("| {} | {cpu_s:.2} | {ratio:.2} | {peak_mib:.0} | {result} |\n", work.about);
        print!("{row}");
        text += &row;
    }
    if let Some(path) = markdown {
        // Benches run in the folder of their crate.
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
        std::fs::write(&path, text).unwrap();
    }
}

const HEAD: &str = "# Numerics\n\n\
    Written by `cargo bench -p trunnion-cli --bench numerics -- --markdown docs/measured/numerics.md`. Each row is a process of its own. \
    The yardstick is one triangle of XᵀX of a dense 4096 × 64 matrix in plain loops, without threads; the ratio is processor time over \
    that of one GFLOP (10⁹ floating-point operations) of it in the same process. Preparing the data is not counted in the time; it is in \
    the memory.\n\n\
    | work | processor time, s | ratio, GFLOP | memory at most, MiB | result |\n|---|---:|---:|---:|---|\n";

fn in_a_process(name: &str) -> Figures {
    let program = std::env::current_exe().unwrap();
    let output = Command::new(program).args(["--alone", name]).output().unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let line = String::from_utf8(output.stdout).unwrap();
    let mut fields = line.trim().splitn(4, '\t');
    let mut number = || fields.next().unwrap().parse::<f64>().unwrap();
    let (cpu_s, peak_mib, yardstick_s) = (number(), number(), number());
    Figures { cpu_s, peak_mib, yardstick_s, result: fields.next().unwrap().into() }
}

fn alone(name: &str) {
    let work = WORKS.iter().find(|work| work.name == name).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let measured = (work.prepare)(folder.path());
    let before = yardstick_s();
    let begun_s = cpu_s();
    let result = measured();
    let cpu_s = cpu_s() - begun_s;
    let yardstick_s = f64::midpoint(before, yardstick_s());
    println!("{cpu_s}\t{}\t{yardstick_s}\t{result}", peak_mib());
}

/// Processor time of one GFLOP of the yardstick, s.
fn yardstick_s() -> f64 {
    const ROWS: usize = 4096;
    const COLUMNS: usize = 64;
    let rows: Vec<[f64; COLUMNS]> =
        (0..ROWS).map(|i| std::array::from_fn(|j| ((i * 31 + j * 17) % 101) as f64 - 50.0)).collect();
    let begun_s = cpu_s();
    let mut flop = 0.0;
    while cpu_s() - begun_s < 0.5 {
        let mut gram = [[0.0; COLUMNS]; COLUMNS];
        for row in black_box(&rows) {
            for (j, of_row) in gram.iter_mut().enumerate() {
                for (sum, x) in of_row[..=j].iter_mut().zip(row) {
                    *sum += row[j] * x;
                }
            }
        }
        black_box(gram);
        flop += (ROWS * COLUMNS * (COLUMNS + 1)) as f64;
    }
    (cpu_s() - begun_s) / flop * 1e9
}

/// Processor time of this process with all its threads, s (Linux: fields 14 and 15 of `stat`, in ticks of 10 ms).
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields = stat.rsplit_once(") ").unwrap().1.split_whitespace().skip(11).take(2);
    fields.map(|ticks| ticks.parse::<f64>().unwrap() / 100.0).sum()
}

/// Largest resident memory, MiB (Linux).
fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1024.0
}

fn setups() -> Vec<SimSetup> {
    let placed =
        |(name, z)| SimSetup::new(name, NestOn::Table, Point3::new(150.0, 0.0, z), Instrument::R_TEST);
    [("low", 60.0), ("high", 160.0)].map(placed).into()
}

/// The run that measures these states on a machine with this hidden effect.
fn run(kind: RunKind, hidden: &str, states: impl FnOnce(&[SimSetup]) -> Vec<State>) -> Run {
    let machine = shipped::machine("table-bc").unwrap();
    let placed = setups();
    let hidden = [HiddenChoice { id: hidden.into(), sigma: 1.0 }];
    let truth = Truth::draw(&machine, &placed, &hidden, 1200.0, 7).unwrap();
    let virtual_machine = VirtualMachine::new(machine.clone(), truth).unwrap();
    let mut sampler = Sampler::new(&virtual_machine, 0);
    let samples = u32::from(kind == RunKind::OnTheFly);
    let read = |state: State| {
        let reading_mm = sampler.read_mm(&virtual_machine, &state);
        Point { state, reading_mm, spread_mm: [0.0; 3], samples, quality: Quality::Good }
    };
    let points = states(&placed).into_iter().map(read).collect();
    let setups = placed.iter().map(|placed| {
        Setup::new(placed.name.clone(), InstrumentKind::RTest, NestSide::Table, placed.ball_in_table_mm)
    });
    Run { name: "bench".into(), machine, kind, setups: setups.collect(), channels: Vec::new(), points }
}

/// Sweeps of C both ways: two setups, three tilts, three feeds.
fn on_the_fly(samples: u32) -> Run {
    let machine = shipped::machine("table-bc").unwrap();
    run(RunKind::OnTheFly, "servo-lag:X", |setups| {
        let (mut states, mut start_s) = (Vec::new(), 0.0);
        for (setup, placed) in setups.iter().enumerate() {
            for tilt_deg in [-45.0_f64, 0.0, 45.0] {
                for feed_deg in [10.0_f64, 20.0, 40.0] {
                    let (tilt_rad, feed_rad_per_s) = (tilt_deg.to_radians(), feed_deg.to_radians());
                    let sweep =
                        grid::Sweep { setup, tilt_rad, feed_rad_per_s, samples: samples / 36, start_s };
                    states.extend(grid::c_sweep(&machine, &placed.ball_in_table_mm, &sweep));
                    start_s += 2.0 * 360.0 / feed_deg + 20.0;
                }
            }
        }
        states
    })
}

fn fit(samples: u32) -> Box<dyn FnOnce() -> String> {
    let run = on_the_fly(samples);
    Box::new(move || {
        let experiment = Experiment::of_points(std::slice::from_ref(&run)).unwrap();
        let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
        format!("{} points, rms {:.3} µm", run.points.len(), 1e3 * fit.rms_mm)
    })
}

fn write(folder: &Path, run: &Run) -> std::path::PathBuf {
    let path = folder.join("run.mcap");
    let text = shipped::FILES.iter().find(|(name, _)| *name == "table-bc").unwrap().1;
    trunnion_record::write_run(&path, &RunHeader::of_run(run, text, "bench", 0), run).unwrap();
    path
}

fn identify_recording(folder: &Path, run: Run) -> Box<dyn FnOnce() -> String> {
    let path = write(folder, &run);
    Box::new(move || {
        let limits = Some(Limits::default());
        let recording = trunnion::recording::read(&path, &shipped::machine, limits).unwrap();
        let experiment = Experiment::new(std::slice::from_ref(&recording.run)).unwrap();
        let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
        format!("{} means of neighbours, rms {:.3} µm", recording.run.points.len(), 1e3 * fit.rms_mm)
    })
}

fn read_points(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let path = write(folder, &on_the_fly(1_000_000));
    Box::new(move || {
        let mut points = 0_u32;
        trunnion_record::visit_points(&path, &shipped::machine, &mut |_, _, _| points += 1).unwrap();
        format!("{points} points")
    })
}

/// A grid of so many stations of B and C, both ways, in two setups.
fn diagnosis(tilts: u32, turns: u32) -> Box<dyn FnOnce() -> String> {
    let machine = shipped::machine("table-bc").unwrap();
    let stations = |first_deg: f64, last_deg: f64, count: u32| grid::Stations {
        first_deg,
        step_deg: (last_deg - first_deg) / f64::from(count - 1),
        count,
        ends_deg: [first_deg, last_deg],
    };
    let (tilts, turns) = (stations(-90.0, 90.0, tilts), stations(0.0, 330.0, turns));
    let run =
        run(RunKind::Static, "gravity-sag:B", |setups| grid::stations_bc(&machine, setups, tilts, turns));
    Box::new(move || {
        let experiment = Experiment::new(std::slice::from_ref(&run)).unwrap();
        let model = Model::base("table-bc");
        let found = trunnion_engine::diagnose(&experiment, &model, &Default::default()).unwrap();
        let first = found.candidates.first().map_or("nothing", |candidate| candidate.effect.as_str());
        format!("{} points, first: {first}", run.points.len())
    })
}

/// So many readings of three probes at 4 kHz.
const READINGS: u64 = 10_000_000;

fn record(folder: &Path) -> Recorder {
    let run = run(RunKind::OnTheFly, "servo-lag:X", |_| Vec::new());
    let text = shipped::FILES.iter().find(|(name, _)| *name == "table-bc").unwrap().1;
    let mut header = RunHeader::of_run(&run, text, "bench", 0);
    header.probes = (1..=3).map(|k| format!("probe-{k}")).collect();
    Recorder::create(folder, "bench", &header).unwrap()
}

/// Readings of a millisecond as a driver hands them over: noise of 16 counts on a slow swing.
fn fill(recorder: &mut Recorder) -> HostTime {
    let (tick_s, mut now) = (1.0 / 4000.0, HostTime(0));
    for first in (0..READINGS / 3).step_by(4) {
        now = HostTime((first as f64 * tick_s * 1e9) as i64 + 4_000_000);
        for channel in 0..3 {
            let sample = |ticks: u64| {
                let time_s = ticks as f64 * tick_s;
                let swing = 20_000.0 * (0.3 * time_s + f64::from(channel)).sin();
                let raw = 130_000 + swing as i64 + (noise(3 * ticks + u64::from(channel)) >> 60) as i64;
                let stamp = Stamp { epoch: 1, ticks, tick_s, arrival_s: now.seconds_since(HostTime(0)) };
                ProbeSample { channel, time_s, stamp, raw, value_mm: raw as f64 * 7.6e-6 }
            };
            (first..first + 4).map(sample).for_each(|sample| recorder.append(Item::Probe(sample), now));
        }
    }
    now
}

/// Splitmix64: the same on every computer.
fn noise(seed: u64) -> u64 {
    let z = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

fn journal(folder: &Path, finishes: bool) -> Box<dyn FnOnce() -> String> {
    let mut recorder = record(folder);
    Box::new(move || {
        let end = fill(&mut recorder);
        let lost =
            if finishes { recorder.finish(end).unwrap().lost_samples } else { recorder.lost_samples() };
        format!("{READINGS} readings, {lost} lost")
    })
}

fn read_samples(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let mut recorder = record(folder);
    let end = fill(&mut recorder);
    let path = recorder.finish(end).unwrap().files.swap_remove(0).path;
    Box::new(move || {
        let mut readings = 0;
        let count = &mut |item| {
            readings += usize::from(matches!(item, Item::Probe(_)));
            true
        };
        trunnion_record::visit(&path, count).unwrap();
        let bytes = std::fs::metadata(&path).unwrap().len() as f64 / readings as f64;
        format!("{readings} readings of {bytes:.1} bytes")
    })
}

/// The same points as if each had been read at rest.
fn at_rest(mut run: Run) -> Run {
    run.kind = RunKind::Static;
    for point in &mut run.points {
        (point.state.velocity, point.state.acceleration) = Default::default();
    }
    run
}

const SETUP: &str = "format = \"trunnion-points/1\"\nmachine = \"table-bc\"\n\
    [[setup]]\nname = \"low\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [150, 0, 60]\n\
    [[setup]]\nname = \"high\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [150, 0, 160]\n";

fn import(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let table = export::points_csv(&at_rest(on_the_fly(1_000_000)));
    let path = folder.join("import.mcap");
    Box::new(move || {
        let (mut writer, mut points) = (None, 0_u32);
        let mut on_row = |run: &Run, point: Point, _: Option<AxisSample>| {
            let header = || RunHeader::of_run(run, "", "bench", 0);
            let writer = writer.get_or_insert_with(|| RunWriter::create(&path, &header()).unwrap());
            writer.point(point);
            points += 1;
        };
        let (table_file, setup_file) = (("points.csv", table.as_str()), ("setup.toml", SETUP));
        let machine = &shipped::machine;
        let kind = RunKind::Static;
        points_csv::visit_files(kind, "bench", table_file, setup_file, machine, &mut on_row).unwrap();
        writer.unwrap().finish().unwrap();
        format!("{points} points of {:.1} MB", table.len() as f64 / 1e6)
    })
}

fn export_table() -> Box<dyn FnOnce() -> String> {
    let run = at_rest(on_the_fly(1_000_000));
    Box::new(move || format!("{:.1} MB", export::points_csv(&run).len() as f64 / 1e6))
}
