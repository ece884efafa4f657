//! The work of numerics, each piece in a process of its own: processor time, largest memory, and the time as a ratio to a yardstick that
//! the same process runs, so that computers compare.
//!
//! Yardstick: XᵀX of a dense 4096 × 64 matrix, one triangle, plain loops over rows, no threads: 2·n·k(k+1)/2 FLOP.
//! A ratio of 3 means as much processor time as 3 GFLOP of it.
//!
//! `cargo bench -p trunnion-cli --bench numerics [-- NAME …]`; `-- --markdown FILE` writes `docs/measured/numerics.md`.

#![expect(clippy::unwrap_used, reason = "a bench may panic")]

mod material;
mod measure;
mod questions;

use material::{at_rest, laps_at_rest, on_the_fly, run};
use measure::{cpu_s, peak_mib, yardstick_s};
use std::path::{Path, PathBuf};
use std::process::Command;
use trunnion_core::{AxisSample, HostTime, Point, ProbeSample, Stamp};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, identify};
use trunnion_hil_sim::physics::grid;
use trunnion_machine::shipped;
use trunnion_record::{Item, Recorder, RunHeader, RunWriter, export, points_csv};
use trunnion_sync::blocks::Limits;

/// One piece of work.
struct Work {
    name: &'static str,
    about: &'static str,
    /// Writes what it reads into a folder, in a process of its own, so that the memory is that of the work.
    write: fn(&Path),
    /// Takes what was written, and returns what is measured.
    prepare: fn(&Path) -> Box<dyn FnOnce() -> String>,
}

const WORKS: [Work; 16] = [
    Work {
        name: "fit-1e5",
        about: "fit of the base model to 10⁵ samples on the fly, each a point",
        write: |_| {},
        prepare: |_| fit(100_000),
    },
    Work { name: "fit-1e6", about: "the same of 10⁶ samples", write: |_| {}, prepare: |_| fit(1_000_000) },
    Work {
        name: "recording-1e6",
        about: "recording of 10⁶ points on the fly to its identification, as `identify` does: read, blocks, fit",
        write: |folder| write(folder, &on_the_fly(1_000_000)),
        prepare: identify_recording,
    },
    Work {
        name: "recording-diagnose-1e6",
        about: "the same to its diagnosis, as `diagnose` does",
        write: |folder| write(folder, &on_the_fly(1_000_000)),
        prepare: diagnose_recording,
    },
    Work {
        name: "diagnose-336",
        about: "diagnosis of 336 points at rest",
        write: |_| {},
        prepare: |_| diagnosis(grid_336()),
    },
    Work {
        name: "diagnose-3000",
        about: "diagnosis of 3000 points at rest",
        write: |_| {},
        prepare: |_| diagnosis(grid_run(25, 30)),
    },
    Work {
        name: "diagnose-laps",
        about: "diagnosis of a circle of three laps each way at rest, 5400 points of which no place comes back",
        write: |_| {},
        prepare: |_| diagnosis(laps_at_rest()),
    },
    Work {
        name: "questions-336",
        about: "commands `compare`, `compare --try` and `add` of 336 points at rest, where nothing is kept",
        write: |folder| write(folder, &grid_336()),
        prepare: questions::asked,
    },
    Work {
        name: "questions-336-kept",
        about: "the same commands once more, where what they worked out was kept",
        write: |folder| {
            write(folder, &grid_336());
            questions::kept(folder)();
        },
        prepare: questions::kept,
    },
    Work {
        name: "journal-1e7",
        about: "10⁷ readings of three probes with stamps into the journal",
        write: |_| {},
        prepare: |folder| journal(folder, false),
    },
    Work {
        name: "finish-1e7",
        about: "the same, and the journal rewritten, compressed and verified",
        write: |_| {},
        prepare: |folder| journal(folder, true),
    },
    Work {
        name: "read-1e7",
        about: "reading the finished 10⁷ readings",
        write: write_samples,
        prepare: read_samples,
    },
    Work {
        name: "read-points-1e6",
        about: "reading 10⁶ points on the fly",
        write: |folder| write(folder, &on_the_fly(1_000_000)),
        prepare: read_points,
    },
    Work {
        name: "import-1e6",
        about: "import of a table of 10⁶ rows as a recording",
        write: write_table,
        prepare: import,
    },
    Work {
        name: "export-1e6",
        about: "export of 10⁶ points at rest as a table",
        write: |_| {},
        prepare: |_| export_table(),
    },
    Work {
        name: "static-1e6",
        about: "recording of 10⁶ points at rest to its identification: read, means of neighbours, fit",
        write: |folder| write(folder, &at_rest(on_the_fly(1_000_000))),
        prepare: identify_recording,
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
    if let [part, name, folder] = args.as_slice()
        && part == "--alone"
    {
        return alone(name, Path::new(folder));
    }
    if let [part, name, folder] = args.as_slice()
        && part == "--write"
    {
        return (work(name).write)(Path::new(folder));
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
    that of one GFLOP (10⁹ floating-point operations) of it in the same process. Preparing the data is not counted in the time. What \
    is read from files is written by another process; other data are in the memory.\n\n\
    | work | processor time, s | ratio, GFLOP | memory at most, MiB | result |\n|---|---:|---:|---:|---|\n";

fn in_a_process(name: &str) -> Figures {
    let program = std::env::current_exe().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let process = |part: &str| {
        let output = Command::new(&program).args([part, name]).arg(folder.path()).output().unwrap();
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    process("--write");
    let line = process("--alone");
    let mut fields = line.trim().splitn(4, '\t');
    let mut number = || fields.next().unwrap().parse::<f64>().unwrap();
    let (cpu_s, peak_mib, yardstick_s) = (number(), number(), number());
    Figures { cpu_s, peak_mib, yardstick_s, result: fields.next().unwrap().into() }
}

fn work(name: &str) -> Work {
    WORKS.into_iter().find(|work| work.name == name).unwrap()
}

fn alone(name: &str, folder: &Path) {
    let measured = (work(name).prepare)(folder);
    let before = yardstick_s();
    let begun_s = cpu_s();
    let result = measured();
    let cpu_s = cpu_s() - begun_s;
    let yardstick_s = f64::midpoint(before, yardstick_s());
    println!("{cpu_s}\t{}\t{yardstick_s}\t{result}", peak_mib());
}

fn fit(samples: u32) -> Box<dyn FnOnce() -> String> {
    let run = on_the_fly(samples);
    Box::new(move || {
        let experiment = Experiment::of_points(std::slice::from_ref(&run)).unwrap();
        let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
        format!("{} points, rms {:.3} µm", run.points.len(), 1e3 * fit.rms_mm)
    })
}

/// The recording in a folder.
fn recording(folder: &Path) -> PathBuf {
    folder.join("run.mcap")
}

fn write(folder: &Path, run: &Run) {
    let text = shipped::FILES.iter().find(|(name, _)| *name == "table-bc").unwrap().1;
    trunnion_record::write_run(&recording(folder), &RunHeader::of_run(run, text, "bench", 0), run).unwrap();
}

/// As commands read it.
fn read(path: &Path) -> Run {
    trunnion::recording::read(path, &shipped::machine, Some(Limits::default())).unwrap().run
}

fn diagnose_recording(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let path = recording(folder);
    Box::new(move || {
        let run = read(&path);
        format!("{} means of neighbours, first: {}", run.points.len(), first_found(&run))
    })
}

fn identify_recording(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let path = recording(folder);
    Box::new(move || {
        let run = read(&path);
        let experiment = Experiment::new(std::slice::from_ref(&run)).unwrap();
        let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
        format!("{} means of neighbours, rms {:.3} µm", run.points.len(), 1e3 * fit.rms_mm)
    })
}

fn read_points(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let path = recording(folder);
    Box::new(move || {
        let mut points = 0_u32;
        trunnion_record::visit_points(&path, &shipped::machine, &mut |_, _, _| points += 1).unwrap();
        format!("{points} points")
    })
}

/// A grid of so many stations of B and C, both ways, in two setups.
fn diagnosis(run: Run) -> Box<dyn FnOnce() -> String> {
    Box::new(move || format!("{} points, first: {}", run.points.len(), first_found(&run)))
}

fn grid_336() -> Run {
    grid_run(7, 12)
}

fn grid_run(tilts: u32, turns: u32) -> Run {
    let machine = shipped::machine("table-bc").unwrap();
    let stations = |first_deg: f64, last_deg: f64, count: u32| grid::Stations {
        first_deg,
        step_deg: (last_deg - first_deg) / f64::from(count - 1),
        count,
        ends_deg: [first_deg, last_deg],
    };
    let (tilts, turns) = (stations(-90.0, 90.0, tilts), stations(0.0, 330.0, turns));
    run(RunKind::Static, "gravity-sag:B", |setups| grid::stations_bc(&machine, setups, tilts, turns))
}

/// The effect that a diagnosis puts first.
fn first_found(run: &Run) -> String {
    let experiment = Experiment::new(std::slice::from_ref(run)).unwrap();
    let model = Model::base(&run.machine.name);
    let found = trunnion_engine::diagnose(&experiment, &model, &Default::default()).unwrap();
    found.candidates.first().map_or("nothing".into(), |candidate| candidate.effect.clone())
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

fn write_samples(folder: &Path) {
    let mut recorder = record(folder);
    let end = fill(&mut recorder);
    let path = recorder.finish(end).unwrap().files.swap_remove(0).path;
    std::fs::rename(path, recording(folder)).unwrap();
}

fn read_samples(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let path = recording(folder);
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

const SETUP: &str = "format = \"trunnion-points/1\"\nmachine = \"table-bc\"\n\
    [[setup]]\nname = \"low\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [150, 0, 60]\n\
    [[setup]]\nname = \"high\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [150, 0, 160]\n";

/// The table in a folder.
fn table(folder: &Path) -> PathBuf {
    folder.join("points.csv")
}

fn write_table(folder: &Path) {
    std::fs::write(table(folder), export::points_csv(&at_rest(on_the_fly(1_000_000)))).unwrap();
}

fn import(folder: &Path) -> Box<dyn FnOnce() -> String> {
    let table = std::fs::read_to_string(table(folder)).unwrap();
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
