//! What is written where something cannot be read or written: nothing half done, nothing lost, one sentence why.

use super::program::{answer, data, import, trunnion, written};
use super::shop::{self, Service, until};
use super::{one_line, three_probes};
use std::path::Path;
use std::process::Command;

fn names(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap().flatten();
    let mut names: Vec<String> = files.map(|file| file.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_table_stays_where_none_of_the_recordings_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (run, table, gone) = (import("points-gravity", folder.path()), path("t.parquet"), path("nope.mcap"));
    let shown = trunnion(&["export", "parquet", &run, "--what", "runs", "-o", &table]);
    assert!(shown.starts_with("1 row of 1 recording: "), "{shown}");
    let before = std::fs::read(&table).unwrap();
    let refused = answer(&["export", "parquet", &gone, "-o", &table]);
    let said = one_line(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(
        said.contains("none of the recordings can be read") && said.contains("t.parquet was not written"),
        "{said}"
    );
    assert_eq!(std::fs::read(&table).unwrap(), before);
    // One that can be read is worth a table, and the other is named.
    let part = answer(&["export", "parquet", &run, &gone, "--what", "runs", "-o", &table]);
    assert_eq!(part.status.code(), Some(3));
    assert!(one_line(&part.stderr).contains("left out: "), "{}", one_line(&part.stderr));
    assert!(one_line(&part.stdout).starts_with("1 row of 1 recording: "), "{}", one_line(&part.stdout));
    assert_eq!(names(folder.path()), ["run.mcap", "t.parquet"]);
}

#[test]
fn an_import_that_the_disk_refuses_leaves_nothing_and_says_it_once() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("a.mcap").display().to_string();
    let from = data("points-gravity");
    let import = |before: &str| {
        Command::new("bash")
            .args(["-c", &format!("{before}; exec \"$@\""), "bash", env!("CARGO_BIN_EXE_trunnion"), "import"])
            .arg(from.join("points.csv"))
            .arg("--setup")
            .arg(from.join("setup.toml"))
            .args(["-o", &run])
            .env("COLUMNS", "1000")
            .output()
            .unwrap()
    };
    // Blocks of 1 kB: the journal of these points takes more, as on a disk that fills up on the way, and right at the beginning.
    for blocks in [16, 0] {
        let refused = import(&format!("trap '' XFSZ; ulimit -f {blocks}"));
        let said = one_line(&refused.stderr);
        assert_eq!(refused.status.code(), Some(1), "{said}");
        assert!(said.starts_with(&format!("trunnion: cannot write {run}: File too large")), "{said}");
        assert_eq!(said.matches("cannot write").count(), 1, "{said}");
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
    assert!(import("true").status.success(), "the name is free");
}

#[test]
fn a_file_that_cannot_be_read_is_named_once() {
    let folder = tempfile::tempdir().unwrap();
    let check = |file: &str, cause: &str| {
        let said = one_line(&answer(&["identify", file]).stderr);
        assert_eq!(said, format!("trunnion: cannot read the recording {file}: {cause}"));
    };
    let gone = folder.path().join("x.mcap").display().to_string();
    check(&gone, "No such file or directory (os error 2)");
    let text = written(folder.path(), "text.mcap", "no recording at all, but a text of some length");
    let said = one_line(&answer(&["identify", &text]).stderr);
    assert!(
        said.starts_with(&format!("trunnion: cannot read the recording {text}: it is no recording: ")),
        "{said}"
    );
}

#[test]
fn an_unknown_effect_is_named_with_its_nearest_and_an_effect_comes_before_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let model = folder.path().join("m.toml").display().to_string();
    let said = one_line(&answer(&["add", "gravity-sagg:B", &run, "--model", &model]).stderr);
    let expected =
        "trunnion: there is no effect \"gravity-sagg:B\" on machine table-bc; allowed: gravity-sag:B";
    assert!(said.starts_with(expected) && said.contains("did you mean gravity-sag:B?"), "{said}");
    let said = one_line(&answer(&["add", &run, "gravity-sag:B", "--model", &model]).stderr);
    assert!(said.contains("the effect comes first: trunnion add EFFECT RUN.mcap"), "{said}");
    assert_eq!(names(folder.path()), ["run.mcap"]);
}

#[test]
fn a_log_that_is_no_screen_has_no_colours() {
    let folder = tempfile::tempdir().unwrap();
    let config = [
        &three_probes::head("runs"),
        &three_probes::nest(),
        &three_probes::devices(folder.path(), three_probes::SILENCE_MS),
        "[cycle_start]\nby = \"motion\"\n",
    ];
    let file = written(folder.path(), "trunnion.toml", &config.concat());
    let cycle = include_str!("../../config/cycles/demo-static.toml");
    written(folder.path(), "c.toml", cycle);
    let log = folder.path().join("log.txt");
    let service = Service::start_by(
        Command::new(env!("CARGO_BIN_EXE_trunnion"))
            .args(["daemon", "--config", &file])
            .stderr(std::fs::File::create(&log).unwrap()),
    );
    let said = until("a line of the log", || {
        std::fs::read_to_string(&log).ok().filter(|text| text.contains("not ready for a cycle"))
    });
    service.kill();
    assert!(!said.contains('\u{1b}'), "{said:?}");
    assert!(shop::files(folder.path(), ".mcap").is_empty());
}
