//! The allowed dependency edges between our crates (ARCHITECTURE.md), read from the manifests.

use std::collections::BTreeSet;
use trunnion_tests::workspace_root;

/// Who may depend on whom, directly; `&name` stands for everything `name` may use, and itself. The estimator and the
/// simulator never meet: no inverse crime.
const ALLOWED: [(&str, &[&str]); 18] = [
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
    ("hil-sim", &["core", "machine", "protocol"]),
    ("tests", &["*"]),
];

/// Outside crates that only one of ours may use.
const SOLE_USERS: [(&str, &str); 4] =
    [("mcap", "record"), ("rumqttc", "service"), ("socketcan", "acquire"), ("serialport", "acquire")];

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
    let table = |key: &str| manifest.get(key).and_then(|t| t.as_table()).cloned().unwrap_or_default();
    table("dependencies").keys().cloned().collect()
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
            assert!(
                name == user || name == "tests" || !dependencies.contains(outside),
                "{name} uses {outside}"
            );
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
