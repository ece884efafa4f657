//! Files that people and other programs write, and recordings.

use super::entry::{Entry, text, without_comments};
use super::recordings::{as_chunk, small};
use std::path::Path;
use std::sync::LazyLock;
use trunnion_core::secret::redacted;
use trunnion_cycles::{Cycle, Run, RunKind};
use trunnion_effects::Model;
use trunnion_effects::formula::Expression;
use trunnion_machine::{Machine, NamePlate, shipped};
use trunnion_record::b5r::BarResult;
use trunnion_record::{points_csv, read_run_of_bytes};
use trunnion_results::{CorrectionEntered, RunRecord};

const POINTS: &str = include_str!("../../../data/points-gravity/points.csv");
const SETUP: &str = include_str!("../../../data/points-gravity/setup.toml");

/// All of them.
pub const FILES: &[Entry] = &[
    Entry {
        name: "machine file",
        read_in: &["machine/src/file.rs", "machine/src/plate.rs"],
        read: |bytes| {
            drop(Machine::parse("m", "m.toml", &text(bytes)));
            drop(NamePlate::parse("m.toml", &text(bytes)));
        },
        seeds: || files(&["config/machines", "config/robots"]),
    },
    Entry {
        name: "cycle file",
        read_in: &["cycles/src/cycle/read.rs"],
        read: |bytes| drop(Cycle::parse("c.toml", &text(bytes))),
        seeds: || files(&["config/cycles"]),
    },
    Entry {
        name: "model file",
        read_in: &["effects/src/model.rs", "effects/src/model/on_machine.rs"],
        read: |bytes| {
            if Model::parse("m.toml", &text(bytes)).is_ok() {
                drop(Model::check("m.toml", &text(bytes), &MACHINE));
            }
        },
        seeds: || files(&["config/models"]),
    },
    Entry {
        name: "devices of a configuration",
        read_in: &["acquire/src/config.rs"],
        read: |bytes| drop(trunnion_acquire::parse_devices("d.toml", &text(bytes))),
        seeds: || {
            let config = include_str!("../../../../config/trunnion.toml");
            let devices = config.find("[[device]]").map_or("", |at| &config[at..]);
            vec![without_comments(devices.as_bytes())]
        },
    },
    Entry {
        name: "configuration without its secrets",
        read_in: &["core/src/secret.rs", "core/src/spans.rs"],
        read: |bytes| drop(redacted(&text(bytes))),
        seeds: || {
            let secrets = b"[mqtt]\nhost = \"cell:hunter2@broker\" # cell:hunter2\npassword = \"hunter2\"\n";
            vec![secrets.to_vec(), without_comments(include_bytes!("../../../../config/trunnion.toml"))]
        },
    },
    Entry {
        name: "setup file",
        read_in: &["core/src/setup.rs"],
        read: |bytes| drop(table(RunKind::Static, &FEW, &text(bytes))),
        seeds: || vec![without_comments(SETUP.as_bytes())],
    },
    Entry {
        name: "points at rest",
        read_in: &["record/src/rows.rs"],
        read: |bytes| drop(table(RunKind::Static, &text(bytes), SETUP)),
        seeds: || vec![FEW.clone().into()],
    },
    Entry {
        name: "points on the fly",
        read_in: &["record/src/rows.rs"],
        read: |bytes| drop(table(RunKind::OnTheFly, &text(bytes), SETUP)),
        seeds: || vec![FEW.clone().into()],
    },
    Entry {
        name: "result of a ball bar",
        read_in: &["record/src/b5r.rs"],
        read: |bytes| drop(BarResult::parse(&text(bytes))),
        seeds: || {
            let features = [("BACKLASH_A_POS", "UT_LENGTH_MM", "0.0123"), ("RANK", "UT_RANKING", "3")];
            let feature =
                |(name, unit, number)| format!("<FEATURE NAME=\"{name}\" DT=\"{unit}\">{number}</FEATURE>");
            let features = features.map(feature).concat();
            let head = "<OPERATOR>J&amp;J</OPERATOR><PLANE TEST_PLANE=\"XY\"/>";
            vec![format!("<?xml version=\"1.0\"?><A><TEST_SPEC NAME=\"t\"/>{head}{features}</A>").into()]
        },
    },
    Entry {
        name: "expression",
        read_in: &["effects/src/formula/parser.rs"],
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
    Entry {
        name: "state of a run",
        read_in: &["service/src/run_record.rs", "service/src/page/runs/list.rs"],
        read: |bytes| drop(serde_json::from_slice::<RunRecord>(bytes)),
        seeds: || vec![include_bytes!("../../../data/state-removed.json").to_vec()],
    },
    Entry {
        name: "corrections entered",
        read_in: &["results/src/corrected.rs"],
        read: |bytes| drop(CorrectionEntered::of_lines(&text(bytes))),
        seeds: || {
            let entered = CorrectionEntered { at_s: 1, by: "J. Doe".into(), ..CorrectionEntered::default() };
            let line = serde_json::to_string(&entered).expect("texts and a number");
            vec![format!("{line}\n\n{line}\n").into()]
        },
    },
    Entry {
        name: "MTConnect document",
        read_in: &["protocol/src/mtconnect/xml.rs"],
        read: |bytes| drop(trunnion_protocol::mtconnect::parse(bytes)),
        seeds: || files(&["config/mtconnect"]),
    },
    Entry {
        name: "recording",
        read_in: &["record/src/wire.rs"],
        read: |bytes| drop(read_run_of_bytes(Path::new("run.mcap"), bytes, &machine)),
        seeds: || vec![small(true, &run()), as_chunk(&small(false, &run()))],
    },
    Entry {
        name: "journal of a recording",
        read_in: &["record/src/wire.rs"],
        read: |bytes| drop(read_run_of_bytes(Path::new("run.mcap.active"), bytes, &machine)),
        seeds: || vec![small(false, &run())],
    },
];

/// The first rows: a short seed is changed everywhere, and little is read again at each execution.
static FEW: LazyLock<String> =
    LazyLock::new(|| POINTS.lines().take(6).flat_map(|line| [line, "\n"]).collect());

/// The machine of the seeds, read once: files of machines have an entry of their own.
static MACHINE: LazyLock<Machine> =
    LazyLock::new(|| shipped::machine("table-bc").expect("a shipped machine"));

fn machine(name: &str) -> Option<Machine> {
    (name == MACHINE.name).then(|| MACHINE.clone())
}

fn table(kind: RunKind, points: &str, setup: &str) -> Option<Run> {
    points_csv::visit_files(kind, "r", ("p.csv", points), ("s.toml", setup), &machine, &mut |_, _, _| {}).ok()
}

fn run() -> Run {
    points_csv::import_files("r", ("p.csv", &FEW), ("s.toml", SETUP), &machine)
        .expect("points of the repository")
}

/// The files of folders of the repository.
fn files(folders: &[&str]) -> Vec<Vec<u8>> {
    let root =
        Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().find(|folder| folder.join("config").is_dir());
    let root = root.expect("the repository");
    let of = |folder: &&str| std::fs::read_dir(root.join(folder)).expect("a folder of the repository");
    let mut paths: Vec<_> =
        folders.iter().flat_map(of).map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let read = |path: &_| without_comments(&std::fs::read(path).expect("a file of the repository"));
    paths.iter().map(read).collect()
}
