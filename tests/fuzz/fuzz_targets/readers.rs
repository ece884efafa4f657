//! No file panics its reader. Each is seeded with files of the repository.

#![no_main]

mod chosen;

use libfuzzer_sys::fuzz_target;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use trunnion_cycles::RunKind;
use trunnion_effects::formula::Expression;
use trunnion_machine::{Machine, shipped};
use trunnion_record::{Item, Recorder, RunHeader, points_csv};

const POINTS: &str = include_str!("../../data/points-gravity/points.csv");
const SETUP: &str = include_str!("../../data/points-gravity/setup.toml");

struct Reader {
    name: &'static str,
    read: fn(&[u8]),
    seeds: fn() -> Vec<Vec<u8>>,
}

const READERS: &[Reader] = &[
    Reader {
        name: "machine file",
        read: |bytes| drop(Machine::parse("m", "m.toml", &text(bytes))),
        seeds: || files(&["config/machines", "config/robots"]),
    },
    Reader {
        name: "cycle file",
        read: |bytes| drop(trunnion_cycles::Cycle::parse("c.toml", &text(bytes))),
        seeds: || files(&["config/cycles"]),
    },
    Reader {
        name: "model file",
        read: |bytes| drop(trunnion_effects::Model::parse("m.toml", &text(bytes))),
        seeds: || files(&["config/models"]),
    },
    Reader {
        name: "devices of a configuration",
        read: |bytes| drop(trunnion_acquire::parse_devices("d.toml", &text(bytes))),
        seeds: || {
            let config = include_str!("../../../config/trunnion.toml");
            let devices = config.find("[[device]]").map_or("", |at| &config[at..]);
            vec![devices.into()]
        },
    },
    Reader {
        name: "setup file",
        read: |bytes| {
            drop(points_csv::import_files("r", ("p.csv", &FEW), ("s.toml", &text(bytes)), &machine))
        },
        seeds: || vec![SETUP.into()],
    },
    Reader {
        name: "points at rest",
        read: |bytes| table(RunKind::Static, bytes),
        seeds: || vec![FEW.clone().into()],
    },
    Reader {
        name: "points on the fly",
        read: |bytes| table(RunKind::OnTheFly, bytes),
        seeds: || vec![FEW.clone().into()],
    },
    Reader {
        name: "expression",
        read: |bytes| {
            if let Ok(read) = Expression::parse(&text(bytes)) {
                read.value(&|_| 0.5);
            }
        },
        seeds: || {
            ["a * sin(2 * B + f) * X / 300", "-(a + b * t) ^ 2 * dirB", "a * exp(-t / tau) * cos(C)"]
                .map(|text| text.as_bytes().to_vec())
                .into()
        },
    },
    Reader {
        name: "state of a run",
        read: |bytes| drop(serde_json::from_slice::<trunnion_results::RunRecord>(bytes)),
        seeds: || vec![include_bytes!("../../data/state-removed.json").to_vec()],
    },
    Reader {
        name: "MTConnect document",
        read: |bytes| drop(trunnion_protocol::mtconnect::parse(bytes)),
        seeds: || files(&["config/mtconnect"]),
    },
    Reader { name: "recording", read: recording, seeds: || vec![written(true)] },
    Reader { name: "journal of a recording", read: journal, seeds: || vec![written(false)] },
];

static CHOSEN: LazyLock<&Reader> = LazyLock::new(|| {
    let names: Vec<&str> = READERS.iter().map(|reader| reader.name).collect();
    let name = chosen::name(&names);
    READERS.iter().find(|reader| reader.name == name).expect("it is in the table")
});

/// In memory, where the system has such a folder: a file is written for each execution.
static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder")
});

fuzz_target!(
    init: chosen::seed(&(CHOSEN.seeds)()),
    |data: &[u8]| (CHOSEN.read)(data)
);

/// The first rows: a short seed is changed everywhere, and little is read again at each execution.
static FEW: LazyLock<String> =
    LazyLock::new(|| POINTS.lines().take(6).flat_map(|line| [line, "\n"]).collect());

/// The machine of the seeds, read once: files of machines have a row of their own.
static MACHINE: LazyLock<Machine> = LazyLock::new(|| shipped::machine("table-bc").expect("a shipped machine"));

fn machine(name: &str) -> Option<Machine> {
    if name == MACHINE.name { Some(MACHINE.clone()) } else { shipped::machine(name) }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn table(kind: RunKind, bytes: &[u8]) {
    let text = text(bytes);
    drop(points_csv::visit_files(kind, "r", ("p.csv", &text), ("s.toml", SETUP), &machine, &mut |_, _, _| {}));
}

fn files(folders: &[&str]) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let of = |folder: &&str| std::fs::read_dir(root.join(folder)).expect("a folder of the repository");
    let files = folders.iter().flat_map(of).map(|entry| entry.expect("an entry").path());
    files.map(|path| std::fs::read(path).expect("a file of the repository")).collect()
}

fn recording(bytes: &[u8]) {
    read("run.mcap", bytes);
}

fn journal(bytes: &[u8]) {
    read("run.mcap.active", bytes);
}

fn read(name: &str, bytes: &[u8]) {
    let path = FOLDER.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    drop(trunnion_record::read_run(&path, &machine));
}

/// A small recording, finished or as a kill leaves it.
fn written(is_finished: bool) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let run = points_csv::import_files(
        "r",
        ("p.csv", &FEW),
        ("s.toml", SETUP),
        &machine,
    )
    .expect("points of the repository");
    let header = RunHeader { probes: vec!["px".into()], ..RunHeader::of_run(&run, "", "0.1.0", 0) };
    let mut recorder = Recorder::create(folder.path(), "run", &header).expect("a recorder");
    for point in run.points {
        recorder.append(Item::Point(point), trunnion_core::HostTime(0));
    }
    for raw in 0..50 {
        let sample = trunnion_core::ProbeSample {
            time_s: raw as f64 * 1e-3,
            raw,
            value_mm: raw as f64 * 1e-3,
            ..Default::default()
        };
        recorder.append(Item::Probe(sample), trunnion_core::HostTime(raw * 1_000_000));
    }
    recorder.flush_aged(trunnion_core::HostTime(i64::MAX));
    let path: PathBuf = folder.path().join(if is_finished { "run.mcap" } else { "run.mcap.active" });
    if is_finished {
        recorder.finish(trunnion_core::HostTime(0)).expect("a finished recording");
    }
    std::fs::read(path).expect("a recording")
}
