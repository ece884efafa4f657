//! The allowed dependency edges between our crates (ARCHITECTURE.md), read from the manifests.

use std::collections::BTreeSet;
use trunnion_tests::workspace_root;

/// Who may depend on whom, directly; `&name` stands for everything `name` may use, and itself. The estimator and the
/// simulator never meet: no inverse crime.
const ALLOWED: [(&str, &[&str]); 19] = [
    ("core", &[]),
    ("machine", &["core"]),
    ("effects", &["core", "machine"]),
    ("cycles", &["core", "machine"]),
    ("instruments", &["core", "machine", "cycles"]),
    ("sync", &["core", "machine", "cycles"]),
    ("engine", &["core", "machine", "cycles", "effects", "instruments", "sync"]),
    ("methods", &["&engine"]),
    ("results", &["&methods"]),
    ("report", &["core", "cycles", "results"]),
    ("protocol", &["core"]),
    ("acquire", &["core", "protocol"]),
    ("record", &["core", "machine", "cycles"]),
    ("trunnion", &["&results", "report", "record"]),
    ("service", &["core", "sync", "record", "trunnion", "acquire", "protocol"]),
    ("cli", &["core", "trunnion", "acquire", "protocol", "service", "hil-sim"]),
    ("python", &["trunnion"]),
    ("hil-sim", &["core", "machine", "protocol"]),
    ("tests", &["*"]),
];

/// Outside crates that only one of ours may use.
const SOLE_USERS: [(&str, &str); 5] = [
    ("axum", "service"),
    ("mcap", "record"),
    ("pyo3", "python"),
    ("rumqttc", "service"),
    ("socketcan", "acquire"),
];

/// Crates that touch no socket, file or runtime.
const PURE: [&str; 11] = [
    "core",
    "machine",
    "effects",
    "cycles",
    "instruments",
    "sync",
    "engine",
    "methods",
    "results",
    "report",
    "protocol",
];

/// The names that `crate_name` may depend on, references followed.
fn allowed(crate_name: &str) -> BTreeSet<&'static str> {
    let (_, listed) = ALLOWED.iter().find(|(name, _)| *name == crate_name).expect("every crate is listed");
    let mut names = BTreeSet::new();
    for entry in *listed {
        match entry.strip_prefix('&') {
            Some(other) => {
                names.insert(other);
                names.extend(allowed(other));
            }
            None => {
                names.insert(*entry);
            }
        }
    }
    names
}

fn members() -> Vec<(String, toml::Table)> {
    let root = workspace_root();
    let mut folders: Vec<_> =
        std::fs::read_dir(root.join("crates")).unwrap().map(|e| e.unwrap().path()).collect();
    folders.extend([root.join("hil-sim"), root.join("tests")]);
    folders
        .into_iter()
        .filter(|folder| folder.is_dir())
        .map(|folder| {
            let name = folder.file_name().unwrap().to_str().unwrap().to_string();
            let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
            (name, manifest.parse().unwrap())
        })
        .collect()
}

fn dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    table(manifest, "dependencies").into_iter().map(|(name, _)| name).collect()
}

/// The same with those of tests and build scripts, and of single platforms.
fn every_dependency(manifest: &toml::Table) -> BTreeSet<String> {
    let platforms = table(manifest, "target").into_iter().filter_map(|(_, value)| value.as_table().cloned());
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let of_kinds = |manifest: toml::Table| kinds.map(|kind| table(&manifest, kind)).into_iter().flatten();
    platforms.chain([manifest.clone()]).flat_map(of_kinds).map(|(name, _)| name).collect()
}

fn table(manifest: &toml::Table, key: &str) -> toml::Table {
    manifest.get(key).and_then(|table| table.as_table()).cloned().unwrap_or_default()
}

/// Names in the first column of the table of outside crates, without those that have no reason in the second.
fn reasoned(architecture: &str) -> BTreeSet<String> {
    let section = architecture.split("\n## ").find(|section| section.starts_with("Outside crates")).unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let cells = rows.map(|row| row.split('|').map(str::trim).collect::<Vec<_>>());
    let names = |cells: Vec<&str>| {
        let names = cells[1].split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
        if cells[2].is_empty() { Vec::new() } else { names }
    };
    cells.flat_map(names).collect()
}

#[test]
fn every_outside_crate_has_its_reason_in_architecture() {
    let architecture = std::fs::read_to_string(workspace_root().join("ARCHITECTURE.md")).unwrap();
    let used: BTreeSet<String> = members()
        .iter()
        .flat_map(|(_, manifest)| every_dependency(manifest))
        .filter(|name| !name.starts_with("trunnion"))
        .collect();
    let reasoned = reasoned(&architecture);
    let without: Vec<_> = used.difference(&reasoned).collect();
    assert!(without.is_empty(), "no line in ARCHITECTURE.md, Outside crates: {without:?}");
    let unused: Vec<_> = reasoned.difference(&used).collect();
    assert!(unused.is_empty(), "ARCHITECTURE.md has a line for what no crate uses: {unused:?}");
}

#[test]
fn dependencies_of_every_kind_and_reasons_are_found() {
    let manifest = "[dependencies]\na = \"1\"\n[dev-dependencies]\nb.workspace = true\n[build-dependencies]\nc = \"1\"\n\
                    [target.'cfg(unix)'.dependencies]\nd = \"1\"\n";
    let found = every_dependency(&manifest.parse().unwrap());
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["a", "b", "c", "d"]);
    let text = "\n## Crates\n| `no` | x |\n## Outside crates\n| crate | why |\n|---|---|\n| `a`, `b` | x |\n| `c` | |\n\n## Next\n| `no` | x |";
    assert_eq!(reasoned(text).into_iter().collect::<Vec<_>>(), ["a", "b"]);
}

#[test]
fn our_crates_depend_only_on_what_the_map_allows() {
    for (name, manifest) in members() {
        assert!(
            ALLOWED.iter().any(|(listed, _)| *listed == name),
            "crate {name} is not on the map; add it to ARCHITECTURE.md and to this list"
        );
        let allowed = allowed(&name);
        for dependency in dependencies(&manifest) {
            let ours = match dependency.strip_prefix("trunnion") {
                Some("") => "trunnion",
                Some(rest) => rest.trim_start_matches('-'),
                None => continue,
            };
            assert!(allowed.contains(ours) || allowed.contains("*"), "{name} must not depend on {ours}");
        }
    }
}

#[test]
fn the_outside_world_is_reached_through_one_crate_each() {
    for (name, manifest) in members() {
        let dependencies = dependencies(&manifest);
        for (outside, user) in SOLE_USERS {
            match name == user {
                true => assert!(dependencies.contains(outside), "{name} does not use {outside} any more"),
                false => assert!(name == "tests" || !dependencies.contains(outside), "{name} uses {outside}"),
            }
        }
        if PURE.contains(&name.as_str()) {
            for runtime in ["tokio", "hyper", "nix", "tempfile", "tokio-serial"] {
                assert!(!dependencies.contains(runtime), "{name} is pure but uses {runtime}");
            }
        }
    }
}

/// Pure crates read no clock, file, environment or socket: their sources never name the modules for it.
#[test]
fn pure_crates_touch_no_clock_file_or_environment() {
    for name in PURE {
        let mut stack = vec![workspace_root().join("crates").join(name).join("src")];
        while let Some(folder) = stack.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    stack.push(path);
                    continue;
                }
                let text = std::fs::read_to_string(&path).unwrap();
                let code = text.split("#[cfg(test)]\nmod").next().unwrap();
                if path.ends_with("tests.rs") || path.components().any(|c| c.as_os_str() == "tests") {
                    continue;
                }
                for word in ["std::fs", "std::net", "std::env::", "SystemTime::now", "Instant::now"] {
                    assert!(!code.contains(word), "{}: pure crate names {word}", path.display());
                }
            }
        }
    }
}
