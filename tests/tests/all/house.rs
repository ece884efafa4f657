//! The lines of docs/measured/house.md: before and now, counted. What keeps the program of a release small.

use std::path::Path;
use trunnion_tests::section::is_writing;
use trunnion_tests::{section, workspace_root};

/// An area, its crates before with their lines, its crates now.
type Area = (&'static str, &'static [(&'static str, usize)], &'static [&'static str]);

/// Lines of Rust at commit 0f1fa37, before the present layout of the crates; what stands for each area now.
const AREAS: [Area; 15] = [
    ("units, nouns, readers", &[("units", 658)], &["crates/core"]),
    ("machines", &[("machine", 1496)], &["crates/machine"]),
    ("effects", &[("effects", 6875)], &["crates/effects"]),
    ("instruments", &[("instruments", 781)], &["crates/instruments"]),
    ("cycles, samples to points", &[("measurement", 4249)], &["crates/cycles", "crates/sync"]),
    (
        "fit, diagnosis, recipes",
        &[("identify", 13984), ("diagnose", 6885)],
        &["crates/engine", "crates/methods"],
    ),
    ("answers and their pages", &[("report", 6035)], &["crates/results", "crates/report"]),
    ("codecs", &[("protocol", 7263)], &["crates/protocol"]),
    ("devices", &[("acquire", 13377)], &["crates/acquire"]),
    ("recordings", &[("record", 3832)], &["crates/record"]),
    ("service", &[("daemon", 2186)], &["crates/service"]),
    ("commands, library", &[("cli", 2899)], &["crates/cli", "crates/trunnion"]),
    ("Python", &[], &["crates/python"]),
    ("virtual machine and devices", &[("hil-sim", 9628)], &["hil-sim"]),
    ("tests above the crates", &[("tests", 9686)], &["tests"]),
];
/// The table is of its day. A crate that grew or shrank by more than this share asks for it to be written again.
const MOVED: f64 = 0.1;

#[test]
fn the_lines_of_each_crate_are_those_counted() {
    let root = workspace_root();
    let now: Vec<(&str, usize)> =
        AREAS.iter().flat_map(|area| area.2).map(|folder| (*folder, lines(&root.join(folder)))).collect();
    let of = |folder: &str| now.iter().find(|(name, _)| *name == folder).unwrap().1;
    let mut table =
        "| area | crates before | lines | crates now | lines |\n|---|---|---:|---|---:|\n".to_string();
    let mut sums = [0, 0];
    for (area, before, after) in AREAS {
        let then: usize = before.iter().map(|(_, lines)| lines).sum();
        let here: usize = after.iter().map(|folder| of(folder)).sum();
        sums = [sums[0] + then, sums[1] + here];
        let names =
            before.iter().map(|(name, lines)| format!("{name} {lines}")).collect::<Vec<_>>().join(", ");
        let folders =
            after.iter().map(|folder| format!("{} {}", folder.trim_start_matches("crates/"), of(folder)));
        table +=
            &format!("| {area} | {names} | {then} | {} | {here} |\n", folders.collect::<Vec<_>>().join(", "));
    }
    table += &format!("| **all** | | **{}** | | **{}** |\n", sums[0], sums[1]);
    if is_writing() {
        section::write_or_compare("docs/measured/house.md", "lines", &table);
        return;
    }
    let document = std::fs::read_to_string(root.join("docs/measured/house.md")).unwrap();
    let written = section::Section::of(&document, "lines").unwrap().inside;
    for (folder, lines) in now {
        let name = folder.trim_start_matches("crates/");
        let stated = stated(written, name).unwrap_or_else(|| panic!("{name} is not in the table"));
        let share = (lines as f64 / stated as f64 - 1.0).abs();
        assert!(
            share < MOVED,
            "{name}: {stated} lines stated, {lines} counted; TRUNNION_WRITE_DOCS=1 writes it"
        );
    }
}

/// A program with its symbols is a third larger. Cargo takes `strip` from the profile, and drops it for a package that has one of its own.
#[test]
fn the_program_of_a_release_is_stripped() {
    let manifest = std::fs::read_to_string(workspace_root().join("Cargo.toml")).unwrap();
    let release = &manifest.parse::<toml::Table>().unwrap()["profile"]["release"];
    assert_eq!(release["strip"].as_bool(), Some(true));
    let has_its_own = release["package"].get("trunnion-cli").is_some();
    assert!(!has_its_own, "[profile.release.package.trunnion-cli] leaves the program unstripped");
}

/// Lines of the Rust files below a folder.
fn lines(folder: &Path) -> usize {
    let of = |path: std::path::PathBuf| match path.extension() {
        _ if path.is_dir() => lines(&path),
        Some(extension) if extension == "rs" => std::fs::read_to_string(&path).unwrap().lines().count(),
        _ => 0,
    };
    std::fs::read_dir(folder).unwrap().map(|entry| of(entry.unwrap().path())).sum()
}

/// The lines that the table states of a crate of today, in its fourth column.
fn stated(table: &str, name: &str) -> Option<usize> {
    let cells = table.lines().filter_map(|row| row.split('|').nth(4));
    let mut parts = cells.flat_map(|cell| cell.split(','));
    parts.find_map(|part| part.trim().strip_prefix(name)?.strip_prefix(' ')?.parse().ok())
}
